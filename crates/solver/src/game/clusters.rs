//! Combines conjuncts into clusters up to a number of nodes: a compromise between one large
//! relation and one relation per formula, each of which is good for some specifications and bad for
//! others.

use crate::symbolic::{BitSet, Kernel, Limit};

/// How conjuncts are combined.
#[derive(Debug, Clone, Copy)]
pub enum Clustering {
    /// In file order, up to this number of nodes per cluster.
    InOrder(usize),
    /// Like [`Self::InOrder`], but first combines neighbors that together contain all mentions of a
    /// bit. That bit can then be quantified together with the new cluster. Otherwise two clusters
    /// could mention nearly the same bits, and the intermediate result would be larger than the
    /// final one.
    ByBits(usize),
}

/// Maximum node count of the pieces that are built before bits are considered.
const PIECE_NODES: usize = 1_000;

impl Clustering {
    /// Combines `parts` into clusters. `gone` are the bits that will be quantified.
    pub fn cluster<K: Kernel>(
        self,
        kernel: &K,
        parts: Vec<K::Function>,
        gone: &BitSet,
    ) -> Result<Vec<K::Function>, Limit> {
        match self {
            Self::InOrder(bound) => in_order(kernel, parts, bound),
            Self::ByBits(bound) => {
                let mut pieces = in_order(kernel, parts, PIECE_NODES.min(bound))?;
                while join_neighbors(kernel, &mut pieces, gone, bound)? {}
                in_order(kernel, pieces, bound)
            }
        }
    }
}

/// Combines consecutive conjuncts into clusters of at most `bound` nodes.
fn in_order<K: Kernel>(
    kernel: &K,
    parts: Vec<K::Function>,
    bound: usize,
) -> Result<Vec<K::Function>, Limit> {
    let mut result: Vec<(K::Function, usize)> = Vec::new();
    for part in parts.into_iter().filter(|p| !kernel.is_true(p)) {
        let size = kernel.size(&part);
        if let Some((last, last_size)) = result.last_mut()
            && *last_size + size <= bound
        {
            let both = kernel.and(last, &part)?;
            let both_size = kernel.size(&both);
            if both_size <= bound {
                (*last, *last_size) = (both, both_size);
                continue;
            }
        }
        result.push((part, size));
    }
    Ok(result.into_iter().map(|(f, _)| f).collect())
}

/// Joins the shortest run of neighbors that contains all mentions of some bit of `gone` and whose
/// conjunction has at most `bound` nodes. Returns whether any neighbors were joined.
fn join_neighbors<K: Kernel>(
    kernel: &K,
    pieces: &mut Vec<K::Function>,
    gone: &BitSet,
    bound: usize,
) -> Result<bool, Limit> {
    let supports: Vec<BitSet> = pieces
        .iter()
        .map(|piece| BitSet::new(kernel.support(piece)))
        .collect();
    let mut ranges: Vec<(usize, usize)> = Vec::new();
    for bit in gone.iter() {
        let mention: Vec<usize> = (0..pieces.len())
            .filter(|piece| supports[*piece].contains(bit))
            .collect();
        if let [first, .., last] = mention[..]
            && last - first + 1 == mention.len()
        {
            ranges.push((mention.len(), first));
        }
    }
    ranges.sort_unstable();
    ranges.dedup();
    for (length, first) in ranges {
        let range = first..first + length;
        if let Some(joined) = conjunction(kernel, &pieces[range.clone()], bound)? {
            pieces.splice(range, [joined]);
            return Ok(true);
        }
    }
    Ok(false)
}

/// Returns the conjunction, or `None` if it or an intermediate result has more than `bound` nodes.
pub fn conjunction<K: Kernel>(
    kernel: &K,
    pieces: &[K::Function],
    bound: usize,
) -> Result<Option<K::Function>, Limit> {
    let mut all = kernel.constant(true);
    for piece in pieces {
        all = kernel.and(&all, piece)?;
        if kernel.size(&all) > bound {
            return Ok(None);
        }
    }
    Ok(Some(all))
}
