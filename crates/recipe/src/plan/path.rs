//! The critical path of a plan.

use super::{Entry, EntrySubject, Next, Plan, Schedule};

/// An entry of a critical path.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CriticalEntry {
    /// Index of the position.
    pub position: usize,
    /// The entry.
    pub entry: Entry,
}

/// Returns the critical path of a plan: a chain of entries that determines how long it takes when
/// the tests end in the worst way, until all products are finished or a loop is closed. Each entry
/// begins when the one before it ends, and takes the same resource, belongs to the same product or
/// to the same event; if there is none like that, it waits for something else that ends then.
///
/// Takes time proportional to the square of the number of entries.
pub fn critical_path(plan: &Plan) -> Vec<CriticalEntry> {
    let mut path = Vec::new();
    let mut next = (!plan.positions.is_empty()).then_some(0);
    let mut seen = vec![false; plan.positions.len()];
    while let Some(position) = next {
        if std::mem::replace(&mut seen[position], true) {
            break;
        }
        let mut entries = Vec::new();
        let (time, then) = longest(&plan.positions[position].schedule, &mut entries);
        let chain = chain(&entries, time);
        path.extend(chain.into_iter().map(|entry| CriticalEntry {
            position,
            entry: entry.clone(),
        }));
        next = then;
    }
    path
}

/// Collects the entries of the way through a schedule that takes longest. Returns how long it takes,
/// and the position that follows it if the count goes on there.
fn longest<'p>(schedule: &'p Schedule, entries: &mut Vec<&'p Entry>) -> (i64, Option<usize>) {
    entries.extend(&schedule.entries);
    match &schedule.then {
        Next::End { time } => (*time, None),
        Next::Goto {
            time,
            position,
            closes_loop,
        } => (*time, (!closes_loop).then_some(*position)),
        Next::Test { time, outcomes, .. } => {
            let mut best: Option<(i64, Option<usize>, Vec<&Entry>)> = None;
            for (_, outcome) in outcomes {
                let mut own = Vec::new();
                let (time, then) = longest(outcome, &mut own);
                if best.as_ref().is_none_or(|b| time > b.0) {
                    best = Some((time, then, own));
                }
            }
            let Some((time, then, own)) = best else {
                return (*time, None);
            };
            entries.extend(own);
            (time, then)
        }
    }
}

fn product(entry: &Entry) -> Option<usize> {
    match entry.subject {
        EntrySubject::Operation { product, .. } => Some(product),
        _ => None,
    }
}

/// Returns the chain of entries that ends at a time, from its beginning.
fn chain<'p>(entries: &[&'p Entry], end: i64) -> Vec<&'p Entry> {
    let mut chain: Vec<&Entry> = Vec::new();
    let mut at = (0..entries.len()).rev().find(|e| entries[*e].end == end);
    let mut used = vec![false; entries.len()];
    while let Some(number) = at {
        used[number] = true;
        let entry = entries[number];
        chain.push(entry);
        let ends_then = |e: &usize| !used[*e] && entries[*e].end == entry.start;
        let all = || (0..entries.len()).rev().filter(ends_then);
        let partner = all().find(|e| entries[*e].event == entry.event);
        let same = |e: &usize| {
            let other = entries[*e];
            other.resource == entry.resource
                || (product(other).is_some() && product(other) == product(entry))
        };
        at = partner
            .or_else(|| all().find(|e| *e < number && same(e)))
            .or_else(|| all().find(|e| *e < number))
            .filter(|_| entry.start > 0 || entry.end > 0);
    }
    chain.reverse();
    chain
}
