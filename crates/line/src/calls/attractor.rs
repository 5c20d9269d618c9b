//! Attractor computation on a graph.

/// Returns, by vertex, whether it belongs to the attractor of a goal. The attractor contains the
/// vertices of the goal and, repeatedly, every vertex with at least `wanted` outgoing edges into
/// it. A vertex for which `wanted` is `None` belongs to it only if it is in the goal. `before`
/// holds the incoming edges of each vertex; the run time is linear in their number.
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
