//! Mutants of plans: each has one change that makes it wrong.

use super::random::Random;
use linewright_recipe::model::Layout;
use linewright_recipe::plan::{
    Entry, EntrySubject, HeldPart, Next, PartOwner, Plan, PlanPosition, Progress, Schedule,
};

/// Returns a schedule of a plan: one of a position, or of an outcome of a test.
fn pick<'p>(schedule: &'p mut Schedule, random: &mut Random) -> &'p mut Schedule {
    if let Next::Test { outcomes, .. } = &schedule.then
        && !outcomes.is_empty()
        && random.percent(70)
    {
        let number = random.below(outcomes.len());
        let Next::Test { outcomes, .. } = &mut schedule.then else {
            unreachable!("it was a test");
        };
        return pick(&mut outcomes[number].1, random);
    }
    schedule
}

/// Returns whether a schedule has an operation of a product.
fn performs(schedule: &Schedule, product: usize) -> bool {
    let is_own = |entry: &Entry| matches!(entry.subject, EntrySubject::Operation { product: p, .. } if p == product);
    let rest = match &schedule.then {
        Next::Test { outcomes, .. } => outcomes.as_slice(),
        _ => &[],
    };
    schedule.entries.iter().any(is_own) || rest.iter().any(|o| performs(&o.1, product))
}

/// Returns a mutant of a plan, or nothing if the chosen change cannot be made.
pub fn mutate(layout: &Layout, plan: &Plan, random: &mut Random) -> Option<Plan> {
    let mut mutant = plan.clone();
    let positions = mutant.positions.len();
    let products = mutant.products.len();
    let at = random.below(positions);
    let resource = random.below(layout.resources.len());
    match random.below(9) {
        0 => mutant.value += if random.percent(50) { 1 } else { -1 },
        1 => mutant.lower_bound = mutant.value + 1,
        2 => mutant.products.push(0),
        3 => {
            let state = &mut mutant.positions[at].resource_states[resource];
            let old = *state;
            *state = random.below(layout.resources[resource].states.len() + 1);
            (*state != old).then_some(())?;
        }
        4 => mutant.positions[at].parts[resource].push(HeldPart {
            name: "a".to_owned(),
            owner: PartOwner::Product(random.below(products)),
        }),
        5 => {
            let product = random.below(products);
            // A product whose recipe has no steps is at its end wherever it is said to be.
            let works = |p: &PlanPosition| performs(&p.schedule, product);
            plan.positions.iter().any(works).then_some(())?;
            let progress = &mut mutant.positions[at].progress[product];
            *progress = match progress {
                Progress::Ended => Progress::At(0),
                _ => Progress::Ended,
            };
        }
        change => {
            let schedule = pick(&mut mutant.positions[at].schedule, random);
            if change == 6 {
                change_end(&mut schedule.then, positions, products, random)?;
            } else {
                change_entry(layout, schedule, random)?;
            }
        }
    }
    (mutant != *plan).then_some(mutant)
}

fn change_end(
    next: &mut Next,
    positions: usize,
    products: usize,
    random: &mut Random,
) -> Option<()> {
    match next {
        Next::End { time } => *time += [1, -1][random.below(2)],
        Next::Goto {
            time,
            position,
            closes_loop,
        } => match random.below(3) {
            0 => *time += [1, -1][random.below(2)],
            1 => *position = (*position + 1 + random.below(positions)) % (positions + 1),
            _ => *closes_loop = !*closes_loop,
        },
        Next::Test {
            product, outcomes, ..
        } => match random.below(3) {
            0 => *product = (*product + 1 + random.below(products)) % (products + 1),
            1 => {
                outcomes.pop();
            }
            _ => outcomes.first_mut()?.0 += 1,
        },
    }
    Some(())
}

fn change_entry(layout: &Layout, schedule: &mut Schedule, random: &mut Random) -> Option<()> {
    if schedule.entries.is_empty() {
        return None;
    }
    let number = random.below(schedule.entries.len());
    let entry = &mut schedule.entries[number];
    match random.below(6) {
        0 => entry.start -= 1,
        1 => entry.end += 1,
        2 => {
            let own = &layout.resources[entry.resource].transitions;
            let old = own[entry.transition].clone();
            entry.transition = random.below(own.len() + 1);
            (own.get(entry.transition) != Some(&old)).then_some(())?;
        }
        3 => entry.resource += layout.resources.len(),
        4 => match &mut entry.subject {
            EntrySubject::Operation {
                product,
                transition,
                step,
                call,
            } => *[product, transition, step, call][random.below(4)] += 1,
            EntrySubject::Part(part) => part.name.push('x'),
            EntrySubject::Internal => return None,
        },
        _ => {
            // Without the last operation of a schedule, its product is not finished.
            let is_operation = |s: &EntrySubject| matches!(s, EntrySubject::Operation { .. });
            let last = schedule
                .entries
                .iter()
                .rposition(|e| is_operation(&e.subject))?;
            schedule.entries.remove(last);
        }
    }
    Some(())
}
