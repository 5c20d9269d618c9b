//! Partition refinement: blocks of numbers, split by marking elements.

/// A partition of elements into blocks.
pub(crate) struct Partition {
    /// Elements, block by block; the marked ones of a block come first.
    elements: Vec<u32>,
    /// Position of each element in `elements`.
    place: Vec<u32>,
    block_of: Vec<u32>,
    /// Begin and end of each block, and the number of its marked elements.
    blocks: Vec<[u32; 3]>,
    /// Blocks with marked elements.
    touched: Vec<u32>,
}

impl Partition {
    /// Returns the number of blocks.
    pub fn count(&self) -> usize {
        self.blocks.len()
    }

    /// Returns the block of an element.
    pub fn block_of(&self, element: usize) -> u32 {
        self.block_of[element]
    }

    /// Creates one block for each kind that occurs.
    pub fn new(elements: usize, kind: impl Fn(usize) -> usize) -> Self {
        let mut order: Vec<u32> = (0..elements as u32).collect();
        order.sort_by_key(|e| kind(*e as usize));
        let mut partition = Self {
            place: vec![0; elements],
            block_of: vec![0; elements],
            blocks: Vec::new(),
            touched: Vec::new(),
            elements: order,
        };
        let mut last = None;
        for at in 0..elements {
            let element = partition.elements[at] as usize;
            if last != Some(kind(element)) {
                last = Some(kind(element));
                partition.blocks.push([at as u32, at as u32, 0]);
            }
            let block = partition.blocks.len() - 1;
            partition.blocks[block][1] = at as u32 + 1;
            partition.block_of[element] = block as u32;
            partition.place[element] = at as u32;
        }
        partition
    }

    /// Returns the elements of a block.
    pub fn members(&self, block: u32) -> &[u32] {
        let [begin, end, _] = self.blocks[block as usize];
        &self.elements[begin as usize..end as usize]
    }

    /// Marks an element for the next split.
    pub fn mark(&mut self, element: u32) {
        let number = self.block_of[element as usize];
        let [begin, _, marked] = &mut self.blocks[number as usize];
        let (at, to) = (self.place[element as usize], *begin + *marked);
        if at < to {
            return;
        }
        if *marked == 0 {
            self.touched.push(number);
        }
        *marked += 1;
        let other = self.elements[to as usize];
        self.elements.swap(at as usize, to as usize);
        self.place[element as usize] = to;
        self.place[other as usize] = at;
    }

    /// Splits the blocks that have both marked and unmarked elements; the marked ones become a new
    /// block. Afterwards nothing is marked. `seen` receives the old block, the new one, and whether
    /// the new one is the smaller half.
    pub fn split(&mut self, mut seen: impl FnMut(u32, u32, bool)) {
        for old in std::mem::take(&mut self.touched) {
            let [begin, end, marked] = self.blocks[old as usize];
            self.blocks[old as usize][2] = 0;
            if begin + marked == end {
                continue;
            }
            let new = self.blocks.len() as u32;
            self.blocks[old as usize][0] = begin + marked;
            self.blocks.push([begin, begin + marked, 0]);
            for at in begin..begin + marked {
                self.block_of[self.elements[at as usize] as usize] = new;
            }
            seen(old, new, marked <= end - begin - marked);
        }
    }
}
