//! Attractor computation on a graph.

/// The vertices of a goal, and repeatedly those with at least `wanted` outgoing edges into the set
/// so far; never those without a `wanted` number. `before` holds the incoming edges, in which the
/// run time is linear.
pub(super) fn attractor(
    before: &[Vec<usize>],
    goal: impl Iterator<Item = usize>,
    wanted: impl Fn(usize) -> Option<usize>,
) -> Vec<bool> {
    let mut reached = vec![false; before.len()];
    let mut leading = vec![0; before.len()];
    let mut open: Vec<usize> = goal.collect();
    for at in &open {
        reached[*at] = true;
    }
    while let Some(at) = open.pop() {
        for &from in &before[at] {
            leading[from] += 1;
            if !reached[from] && wanted(from).is_some_and(|wanted| leading[from] >= wanted) {
                reached[from] = true;
                open.push(from);
            }
        }
    }
    reached
}
