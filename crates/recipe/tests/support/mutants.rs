//! Mutants of controllers: each has one change that makes it wrong.

use super::random::Random;
use linewright_recipe::controller::{Controller, Subject};
use linewright_recipe::model::Layout;

/// Returns a mutant of a controller with the least number of vectors and events, or nothing if the
/// chosen change cannot be made.
pub fn mutate(layout: &Layout, controller: &Controller, random: &mut Random) -> Option<Controller> {
    let mut mutant = controller.clone();
    let positions = mutant.positions.len();
    let at = random.below(positions);
    let position = &mut mutant.positions[at];
    match random.below(12) {
        0 => mutant.worst_case = mutant.worst_case.wrapping_add(1),
        1 => {
            let resource = random.below(layout.resources.len());
            let states = layout.resources[resource].states.len();
            let state = &mut position.resource_states[resource];
            let old = *state;
            *state = random.below(states + 1);
            (*state != old).then_some(())?;
        }
        2 => {
            let resource = random.below(layout.resources.len());
            let parts = &mut position.parts[resource];
            if parts.pop().is_none() {
                parts.push("a".to_owned());
            }
        }
        3 => position.recipe_state += 1,
        4 => {
            mutant.positions.pop();
        }
        change => {
            let legs = position.legs.len();
            if legs == 0 {
                return None;
            }
            let number = random.below(legs);
            if change == 5 {
                position.legs.remove(number);
                return Some(mutant);
            }
            let leg = &mut position.legs[number];
            if change == 6 {
                let old = leg.to;
                leg.to = random.below(positions + 1);
                return (leg.to != old).then_some(mutant);
            }
            if change == 7 {
                leg.transition += 1;
                return Some(mutant);
            }
            if leg.vectors.is_empty() {
                return None;
            }
            let which = random.below(leg.vectors.len());
            if change == 8 {
                leg.vectors.remove(which);
                return Some(mutant);
            }
            let moves = &mut leg.vectors[which].moves;
            let which = random.below(moves.len());
            if change == 9 {
                moves.remove(which);
                return Some(mutant);
            }
            let one = &mut moves[which];
            if change == 10 {
                one.subject = match &one.subject {
                    Subject::Operation(call) => Subject::Operation(call + 1),
                    Subject::Part(part) => Subject::Part(format!("{part}'")),
                    Subject::Internal => Subject::Operation(0),
                };
                return Some(mutant);
            }
            let transitions = &layout.resources[one.resource].transitions;
            let old = one.transition;
            one.transition = random.below(transitions.len() + 1);
            // An equal transition would do as well.
            (transitions.get(one.transition) != transitions.get(old)).then_some(())?;
        }
    }
    Some(mutant)
}
