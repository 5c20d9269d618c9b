//! Partition refinement: blocks of numbers, split by marking elements.

/// A partition of elements into blocks.
pub(crate) struct Partition {
    /// Elements, block by block; within a block, marked elements come first.
    elements: Vec<u32>,
    /// Position of each element in `elements`.
    place: Vec<u32>,
    /// Block of each element.
    block_of: Vec<u32>,
    /// Start and end of each block in `elements`, and the number of its marked elements.
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

    /// Creates a partition of `0..elements` with one block for each value of `kind`.
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

    /// Splits the blocks that have both marked and unmarked elements; the marked elements become a
    /// new block. Clears all marks. For each split, calls `on_split` with the old block, the new
    /// block, and whether the new block is at most as large as the old one.
    pub fn split(&mut self, mut on_split: impl FnMut(u32, u32, bool)) {
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
            on_split(old, new, marked <= end - begin - marked);
        }
    }
}
