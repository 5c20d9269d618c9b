//! The critical path of a plan.

use super::{Entry, EntrySubject, Next, Plan, Schedule, value};

/// An entry of a critical path.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CriticalEntry {
    /// Index of the position.
    pub position: usize,
    /// The outcomes of the position's tests up to the entry, as indices into the lists of outcomes.
    pub outcomes: Vec<usize>,
    /// The entry.
    pub entry: Entry,
}

/// Returns the critical path of a plan: a chain of entries that determines how long it takes when
/// the tests end in the way that takes longest, until all products are finished or a loop is
/// closed. Each entry begins when the one before it ends, and takes the same resource, belongs to
/// the same product or to the same event; if there is none like that, it waits for something else
/// that ends then.
///
/// Takes time proportional to the square of the number of entries.
pub fn critical_path(plan: &Plan) -> Vec<CriticalEntry> {
    let times = value::times(plan);
    let mut path = Vec::new();
    let mut next = (!plan.positions.is_empty()).then_some(0);
    // The positions that follow each other without closing a loop form no circle.
    while let Some(position) = next {
        let mut way = Vec::new();
        let (time, then) = longest(&plan.positions[position].schedule, &times, &mut way);
        let entries: Vec<&Entry> = way.iter().map(|(_, entry)| *entry).collect();
        path.extend(chain(&entries, time).into_iter().map(|at| CriticalEntry {
            position,
            outcomes: way[at].0.clone(),
            entry: way[at].1.clone(),
        }));
        next = then;
    }
    path
}

/// Collects the entries of the way through a schedule after which it takes longest until the end,
/// each with the outcomes that lead to it. Returns the time at the end of the way, and the position
/// that follows it if the count goes on there.
fn longest<'p>(
    schedule: &'p Schedule,
    times: &[Option<i64>],
    way: &mut Vec<(Vec<usize>, &'p Entry)>,
) -> (i64, Option<usize>) {
    let mut outcomes = Vec::new();
    let mut schedule = schedule;
    loop {
        way.extend(schedule.entries.iter().map(|e| (outcomes.clone(), e)));
        match &schedule.then {
            Next::End { time } => return (*time, None),
            Next::Goto {
                time,
                position,
                closes_loop,
            } => return (*time, (!closes_loop).then_some(*position)),
            Next::Test {
                time,
                outcomes: all,
                ..
            } => {
                let totals = all.iter().map(|(_, s)| until_end(s, times));
                // Of equal ones, the first.
                let worst = totals.enumerate().rev().max_by_key(|(_, total)| *total);
                let Some((worst, _)) = worst else {
                    return (*time, None);
                };
                outcomes.push(worst);
                schedule = &all[worst].1;
            }
        }
    }
}

/// Returns how long it takes at most from the beginning of the position until the end, after the
/// outcomes that lead to the schedule.
fn until_end(schedule: &Schedule, times: &[Option<i64>]) -> i64 {
    match &schedule.then {
        Next::End { time } => *time,
        Next::Goto {
            time,
            position,
            closes_loop,
        } => {
            let after = times[*position].filter(|_| !closes_loop);
            time + after.unwrap_or(0)
        }
        Next::Test { outcomes, .. } => {
            let each = outcomes.iter().map(|(_, s)| until_end(s, times));
            each.max().unwrap_or(0)
        }
    }
}

fn product(entry: &Entry) -> Option<usize> {
    match entry.subject {
        EntrySubject::Operation { product, .. } => Some(product),
        _ => None,
    }
}

/// Returns the chain of entries that ends at a time, from its beginning, as indices: one that
/// begins at 0, or else as early as possible.
///
/// An entry that ends just when the next one begins may do so because it was made to, such as a
/// transport that leaves late; nothing ends when it begins. So all entries before are tried.
fn chain(entries: &[&Entry], end: i64) -> Vec<usize> {
    let mut used = vec![false; entries.len()];
    let last = (0..entries.len()).filter(|e| entries[*e].end == end);
    // The entries on the way, and for each the ones before it that are still to be tried.
    let mut way: Vec<usize> = Vec::new();
    let mut open: Vec<Vec<usize>> = vec![last.collect()];
    let mut best: Vec<usize> = Vec::new();
    let start = |way: &[usize]| way.last().map_or(i64::MAX, |e| entries[*e].start);
    while let Some(untried) = open.last_mut() {
        let Some(number) = untried.pop() else {
            open.pop();
            way.pop();
            continue;
        };
        if std::mem::replace(&mut used[number], true) {
            continue;
        }
        way.push(number);
        if start(&way) < start(&best) {
            best.clone_from(&way);
        }
        if start(&way) == 0 {
            break;
        }
        open.push(before(entries, number));
    }
    best.reverse();
    best
}

/// Returns the entries that end when an entry begins, the one to try first at the end: that of the
/// same event, then those of the same resource or product, then all others.
fn before(entries: &[&Entry], number: usize) -> Vec<usize> {
    let entry = entries[number];
    let rank = |e: &usize| {
        let other = entries[*e];
        let is_same = other.resource == entry.resource
            || (product(other).is_some() && product(other) == product(entry));
        (other.event == entry.event, is_same, *e)
    };
    let ends_then = |e: &usize| {
        let is_earlier = *e < number || entries[*e].event == entry.event;
        is_earlier && *e != number && entries[*e].end == entry.start
    };
    let mut found: Vec<usize> = (0..entries.len()).filter(ends_then).collect();
    found.sort_by_key(rank);
    found
}
