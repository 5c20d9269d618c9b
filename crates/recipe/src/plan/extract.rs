//! From solved segments to schedules with times.
//!
//! The search has bounds of times only. Here each time gets its least value that satisfies all
//! conditions of the segment: a longest path in the graph of the conditions (R. Bellman, "On a
//! routing problem", Quarterly of Applied Mathematics 16, 1958).

use super::search::{Search, Solved, Stop};
use super::shop::{Configuration, Kind, Shop};
use super::state::{Happening, State};
use super::{Entry, EntrySubject, HeldPart, Next, PartOwner, PlanPosition, Progress, Schedule};
use std::rc::Rc;

/// The end of a schedule at which no test takes place.
pub(super) struct Leaf {
    /// State in which all resources are at rest.
    pub state: State,
    /// The product of each slot of the state.
    pub owners: Vec<usize>,
    /// Time from the beginning of the position.
    pub time: i64,
    pub closes_loop: bool,
}

/// The values of variables: the time of a happening, or zero, and an offset.
type Value = (Option<usize>, i64);

/// Returns the times of the happenings of a segment and of its end, from its root.
fn times(
    search: &Search<'_>,
    root: &State,
    solved: &Solved,
    states: &[State],
    end: &State,
) -> Vec<i64> {
    let shop = search.shop;
    let slots = shop.slots.len();
    let ready = shop.ready_variable(0);
    // Slots are renumbered on the way; values are kept by the slot of the root.
    let place = |state: &State, variable: u16| {
        let slot = variable.wrapping_sub(ready) as usize;
        if variable >= ready && slot < slots {
            ready as usize + state.origin[slot] as usize
        } else {
            variable as usize
        }
    };
    let mut values: Vec<Value> = root.zone.low.iter().map(|low| (None, *low)).collect();
    // Conditions: the second time is at least the first plus an offset.
    let mut conditions: Vec<(Option<usize>, usize, i64)> = Vec::new();
    for (number, (happening, state)) in solved.way.iter().zip(states).enumerate() {
        let (shifts, mut after, mut results) = shop.timing(happening);
        after.extend(shop.clock_variable());
        results.extend(shop.clock_variable().map(|clock| (clock, 0)));
        for shift in &shifts {
            let (from, offset) = values[place(state, shift.variable)];
            conditions.push((from, number, offset - shift.begin));
            let is_anchor = state.zone.anchors.binary_search(&shift.variable).is_ok();
            if is_anchor && let Some(from) = from {
                conditions.push((Some(number), from, shift.begin - offset));
            }
        }
        for variable in after {
            let (from, offset) = values[place(state, variable)];
            conditions.push((from, number, offset));
        }
        for shift in &shifts {
            values[place(state, shift.variable)] = (Some(number), shift.end);
        }
        for (variable, offset) in results {
            values[place(state, variable)] = (Some(number), offset);
        }
    }
    let last = solved.way.len();
    let followed: Vec<u16> = match &solved.stop {
        Stop::Test(test) if test.after.is_empty() => Vec::new(),
        Stop::Test(test) => test.after.clone(),
        _ => (0..shop.variables() as u16).collect(),
    };
    for variable in followed {
        let (from, offset) = values[place(end, variable)];
        conditions.push((from, last, offset));
    }
    if let Stop::Test(test) = &solved.stop {
        conditions.push((None, last, test.least));
    }
    for variable in &end.zone.anchors {
        if let (Some(from), offset) = values[*variable as usize] {
            conditions.push((Some(last), from, -offset));
        }
    }
    let mut times = vec![0; last + 1];
    loop {
        let mut changed = false;
        for (from, to, offset) in &conditions {
            let least = from.map_or(0, |f| times[f]) + offset;
            if times[*to] < least {
                times[*to] = least;
                changed = true;
            }
        }
        if !changed {
            return times;
        }
    }
}

/// Returns a part as it is known outside.
fn held_part(shop: &Shop<'_>, kind: &Kind, owners: &[usize]) -> HeldPart {
    let (name, owner) = match kind {
        Kind::Stock(name) => (name.clone(), PartOwner::Stock),
        Kind::Finished { demand, part } => {
            let name = &shop.demands[*demand].recipe.parts[*part].name;
            (name.clone(), PartOwner::LeftOver(*demand))
        }
        Kind::Own { product, part } => {
            let slot = shop.slots.iter().position(|s| s.0 == *product);
            let owner = slot.map_or(*product, |s| owners[s]);
            let demand = super::shop::products(shop.demands)[*product];
            let name = &shop.demands[demand].recipe.parts[*part].name;
            (name.clone(), PartOwner::Product(owner))
        }
    };
    HeldPart { name, owner }
}

/// Returns the states and parts of all resources, as they are known outside.
pub(super) fn describe(
    shop: &Shop<'_>,
    configuration: &Configuration,
    owners: &[usize],
) -> (Vec<usize>, Vec<Vec<HeldPart>>) {
    let mut parts = vec![Vec::new(); shop.resources()];
    for (resource, kind) in &configuration.parts {
        parts[*resource as usize].push(held_part(shop, kind, owners));
    }
    for held in &mut parts {
        held.sort_unstable();
    }
    let states = configuration.states.iter().map(|s| *s as usize).collect();
    (states, parts)
}

/// Returns the schedule of a solved root whose slots have these products. `offset` is the time of
/// the root, `event` the number of the next event. `leaf` says what follows at the ends.
pub(super) fn schedule(
    search: &Search<'_>,
    root: &State,
    solved: &Solved,
    owners: &[usize],
    (offset, event): (i64, &mut usize),
    leaf: &mut dyn FnMut(Leaf) -> Next,
) -> Schedule {
    let shop = search.shop;
    let (mut end, states) = search.follow(root, &solved.way);
    let times = times(search, root, solved, &states, &end);
    let owners_of = |state: &State| -> Vec<usize> {
        state
            .origin
            .iter()
            .map(|slot| owners[*slot as usize])
            .collect()
    };
    let mut entries = Vec::new();
    for ((happening, state), time) in solved.way.iter().zip(&states).zip(&times) {
        let owners = owners_of(state);
        let (shifts, ..) = shop.timing(happening);
        let taken = match happening {
            Happening::Internal(taken) => vec![(*taken, EntrySubject::Internal)],
            Happening::Transfer {
                giver, taker, kind, ..
            } => {
                let part = held_part(shop, &shop.kinds[*kind as usize], &owners);
                let subject = EntrySubject::Part(part);
                vec![(*giver, subject.clone()), (*taker, subject)]
            }
            Happening::Step { slot, performers } => {
                let slot = *slot as usize;
                let subject = |call| EntrySubject::Operation {
                    product: owners[slot],
                    transition: state.words[2 * slot] as usize,
                    step: state.words[2 * slot + 1] as usize,
                    call,
                };
                let each = performers.iter().enumerate();
                each.map(|(call, taken)| (*taken, subject(call))).collect()
            }
        };
        for ((taken, subject), shift) in taken.into_iter().zip(shifts) {
            entries.push(Entry {
                event: *event,
                start: offset + time + shift.begin,
                end: offset + time + shift.end,
                resource: taken.resource as usize,
                transition: taken.transition as usize,
                subject,
            });
        }
        *event += 1;
    }
    let time = offset + times[solved.way.len()];
    let owners_then = owners_of(&end);
    let then = match &solved.stop {
        Stop::Ended => leaf(Leaf {
            state: end,
            owners: owners_then,
            time,
            closes_loop: false,
        }),
        Stop::Loop(waits) => {
            search.close_loop(&mut end, *waits);
            leaf(Leaf {
                state: end,
                owners: owners_then,
                time,
                closes_loop: true,
            })
        }
        Stop::Test(test) => {
            let outcomes = search
                .outcomes(&end, test)
                .into_iter()
                .map(|(transition, root)| {
                    let owners: Vec<usize> = (root.origin.iter())
                        .map(|slot| owners_then[*slot as usize])
                        .collect();
                    let solved = search.known(&root).expect("the outcomes are solved");
                    let rest = schedule(search, &root, &solved, &owners, (time, event), leaf);
                    (transition, rest)
                });
            Next::Test {
                time,
                product: owners_then[test.slot],
                outcomes: outcomes.collect(),
            }
        }
    };
    Schedule { entries, then }
}

/// Returns the positions of a plan of all products.
pub(super) fn positions(
    search: &Search<'_>,
    root: &State,
    solved: &Rc<Solved>,
) -> Vec<PlanPosition> {
    let shop = search.shop;
    let owners = root
        .origin
        .iter()
        .map(|slot| shop.slots[*slot as usize].0)
        .collect();
    let mut open: Vec<(State, Vec<usize>, Rc<Solved>)> =
        vec![(root.clone(), owners, Rc::clone(solved))];
    let mut positions: Vec<PlanPosition> = Vec::new();
    while let Some((root, owners, solved)) = open.get(positions.len()).cloned() {
        let mut leaf = |leaf: Leaf| {
            if !leaf.closes_loop {
                return Next::End { time: leaf.time };
            }
            let root = search.position(&leaf.state);
            let owners: Vec<usize> = root
                .origin
                .iter()
                .map(|slot| leaf.owners[*slot as usize])
                .collect();
            let same =
                |o: &(State, Vec<usize>, Rc<Solved>)| o.0.words == root.words && o.1 == owners;
            let position = open.iter().position(same).unwrap_or_else(|| {
                let solved = search.known(&root).expect("positions are solved");
                open.push((root, owners, solved));
                open.len() - 1
            });
            Next::Goto {
                time: leaf.time,
                position,
                closes_loop: true,
            }
        };
        let schedule = schedule(search, &root, &solved, &owners, (0, &mut 0), &mut leaf);
        let (of_slots, configuration) = shop.describe(&root.words);
        let (resource_states, parts) = describe(shop, &configuration, &owners);
        let mut progress = vec![Progress::At(0); owners.len()];
        for (owner, of_slot) in owners.iter().zip(of_slots) {
            progress[*owner] = of_slot;
        }
        positions.push(PlanPosition {
            progress,
            resource_states,
            parts,
            schedule,
        });
    }
    positions
}
