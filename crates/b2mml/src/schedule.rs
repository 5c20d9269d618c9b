//! Schedules: what is to be done, in order.

use crate::linear::linear_recipe;
use linewright_recipe::controller::{Controller, Move, Subject, Vector};
use linewright_recipe::model::{Action, Layout, OperationCall, Part, Recipe, Step, Transition};
use linewright_recipe::replay::{self, Fault};
use rustc_hash::{FxHashMap, FxHashSet};

/// A schedule: requests in the order in which they are to be carried out. Requests of different
/// branches of a recipe follow each other, too.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Schedule {
    /// Name of the schedule.
    pub name: String,
    /// Parts that the requests name, with their types, in the order of their first mention.
    pub parts: Vec<Part>,
    /// Requests.
    pub requests: Vec<Request>,
}

/// A request: one operation or one transfer.
#[derive(Debug, Clone, PartialEq)]
pub struct Request {
    /// Identifier, unique in the schedule.
    pub id: String,
    /// Name of the recipe that it belongs to.
    pub recipe: String,
    /// What is to be done.
    pub activity: Activity,
    /// Duration in s, if it is known.
    pub seconds: Option<f64>,
    /// Where a controller does it.
    pub place: Option<PlanPlace>,
}

/// Place of a request in a controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct PlanPlace {
    /// Index of the position where the leg begins.
    pub position: usize,
    /// Index of the transition of the recipe.
    pub transition: usize,
    /// Index of the vector in the leg. Requests with the same vector are carried out together.
    pub vector: usize,
}

/// What a resource does, or two.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Activity {
    /// Operation of a recipe.
    Operation {
        /// Name of the resource, if it is known.
        resource: Option<String>,
        /// The operation and its parts.
        call: OperationCall,
        /// Identifier of the operation in the recipe, such as `T1.S2.O1`.
        segment: String,
    },
    /// Internal operation of a resource.
    Internal {
        /// Name of the resource.
        resource: String,
        /// Name of the operation.
        name: String,
    },
    /// Transfer of a part.
    Transfer {
        /// Name of the resource that gives it.
        from: String,
        /// Name of the resource that takes it.
        to: String,
        /// Label of the transfer.
        label: String,
        /// Name of the part, if it is known.
        part: Option<String>,
    },
}

/// Reason why a schedule is no sequence of steps.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NoSequence {
    /// It has requests of several transitions of a recipe, of which some are alternatives.
    #[error(
        "the schedule has the choices of recipe `{0}`; read its OperationsDefinition or its \
         WorkflowSpecification"
    )]
    Choices(String),
    /// A part has several types.
    #[error("part `{0}` has several types")]
    Types(String),
}

/// Returns the identifier of an operation of a recipe, from its indices.
pub(crate) fn segment_id(transition: usize, step: usize, operation: usize) -> String {
    format!("T{}.S{}.O{}", transition + 1, step + 1, operation + 1)
}

impl Schedule {
    /// Returns the schedule of a controller. Its name is that of the recipe. Each vector gives a
    /// request for each operation and for each transfer, in the order of the resources; the time of
    /// a transfer is the longer one of those of its two resources.
    ///
    /// Takes time proportional to the size of the controller and the layout.
    ///
    /// # Errors
    /// What the replay of the controller finds. Then it is not one of this layout and recipe.
    pub fn of(layout: &Layout, recipe: &Recipe, controller: &Controller) -> Result<Self, Fault> {
        replay::verify(layout, recipe, controller)?;
        let mut scheduler = Scheduler {
            layout,
            recipe,
            kinds: (recipe.parts.iter())
                .map(|p| (p.name.as_str(), p))
                .collect(),
            schedule: Self {
                name: recipe.name.clone(),
                ..Self::default()
            },
            known: FxHashSet::default(),
        };
        for (position, from) in controller.positions.iter().enumerate() {
            for leg in &from.legs {
                let mut step = 0;
                for (vector, moves) in leg.vectors.iter().enumerate() {
                    let place = PlanPlace {
                        position,
                        transition: leg.transition,
                        vector,
                    };
                    step += usize::from(scheduler.add_vector(place, step, moves));
                }
            }
        }
        Ok(scheduler.schedule)
    }

    /// Returns a recipe without choices for each recipe that the requests name, with their
    /// operations as its steps. Operations of the same vector are one step. What remains is left
    /// over. Transfers and internal operations are no part of it.
    ///
    /// # Errors
    /// If there is more than one sequence.
    pub fn recipes(&self) -> Result<Vec<Recipe>, NoSequence> {
        let mut kinds: FxHashMap<&str, &Part> = FxHashMap::default();
        for part in &self.parts {
            if kinds.insert(&part.name, part).is_some_and(|p| *p != *part) {
                return Err(NoSequence::Types(part.name.clone()));
            }
        }
        let mut order: Vec<(&str, Vec<Step>)> = Vec::new();
        let mut numbers: FxHashMap<&str, (usize, Option<PlanPlace>)> = FxHashMap::default();
        for request in &self.requests {
            let Activity::Operation { call, .. } = &request.activity else {
                continue;
            };
            let count = order.len();
            let (number, last) = numbers.entry(&request.recipe).or_insert((count, None));
            if *number == count {
                order.push((&request.recipe, Vec::new()));
            }
            let leg = |p: PlanPlace| (p.position, p.transition);
            let is_other = last
                .zip(request.place)
                .is_some_and(|(a, b)| leg(a) != leg(b));
            if is_other {
                return Err(NoSequence::Choices(request.recipe.clone()));
            }
            let steps = &mut order[*number].1;
            let is_parallel = request.place.is_some() && *last == request.place;
            match steps.last_mut().filter(|_| is_parallel) {
                Some(step) => step.operations.push(call.clone()),
                None => steps.push(Step::new(vec![call.clone()])),
            }
            *last = request.place;
        }
        let recipes = order.into_iter();
        Ok(recipes
            .map(|(name, steps)| linear_recipe(name, &kinds, steps))
            .collect())
    }
}

struct Scheduler<'a> {
    layout: &'a Layout,
    recipe: &'a Recipe,
    kinds: FxHashMap<&'a str, &'a Part>,
    schedule: Schedule,
    known: FxHashSet<String>,
}

impl<'a> Scheduler<'a> {
    /// Adds the requests of a vector. Returns whether it performs a step.
    fn add_vector(&mut self, place: PlanPlace, step: usize, vector: &'a Vector) -> bool {
        let layout = self.layout;
        let of = |m: &Move| -> &'a Transition {
            &layout.resources[m.resource].transitions[m.transition]
        };
        let mut takers: FxHashMap<&str, &Move> = FxHashMap::default();
        for m in &vector.moves {
            if let Action::In(label) = &of(m).action {
                takers.insert(label, m);
            }
        }
        let mut performs = false;
        for m in &vector.moves {
            let transition = of(m);
            let resource = layout.resources[m.resource].name.clone();
            let mut seconds = transition.seconds;
            let activity = match (&transition.action, &m.subject) {
                (Action::Operation(_), Subject::Operation(number)) => {
                    performs = true;
                    let steps = &self.recipe.transitions[place.transition].steps;
                    let call = steps[step].operations[*number].clone();
                    for part in call.inputs.iter().chain(&call.outputs) {
                        self.add_part(part);
                    }
                    Activity::Operation {
                        resource: Some(resource),
                        call,
                        segment: segment_id(place.transition, step, *number),
                    }
                }
                (Action::Internal(name), _) => Activity::Internal {
                    resource,
                    name: name.clone(),
                },
                (Action::Out(label), Subject::Part(part)) => {
                    let Some(taker) = takers.get(label.as_str()) else {
                        continue;
                    };
                    let times = [seconds, of(taker).seconds];
                    seconds = times.into_iter().flatten().reduce(f64::max);
                    self.add_part(part);
                    Activity::Transfer {
                        from: resource,
                        to: layout.resources[taker.resource].name.clone(),
                        label: label.clone(),
                        part: Some(part.clone()),
                    }
                }
                _ => continue,
            };
            let PlanPlace {
                position,
                transition,
                vector,
            } = place;
            let (position, transition, vector) = (position + 1, transition + 1, vector + 1);
            self.schedule.requests.push(Request {
                id: format!("P{position}-T{transition}-V{vector}-R{}", m.resource + 1),
                recipe: self.recipe.name.clone(),
                activity,
                seconds,
                place: Some(place),
            });
        }
        performs
    }

    /// Adds a part that is mentioned. What is no part of the recipe is stock, named by its type.
    fn add_part(&mut self, name: &str) {
        if self.known.insert(name.to_owned()) {
            let kind = self.kinds.get(name).map_or(name, |p| &p.kind);
            self.schedule.parts.push(Part::new(name, kind));
        }
    }
}
