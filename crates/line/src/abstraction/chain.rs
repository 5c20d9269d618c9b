//! Explains a state of the abstraction: follows who waits for whom until a cycle closes or the
//! chain ends at something that never comes.

use super::Abstraction;
use super::shape::PlaceKind;
use super::vocabulary::{Phase, Queue};
use super::words::an;
use linewright_core::gr1::eval::{eval, holds};
use linewright_core::gr1::{Expr, VarId};

/// A chain of reasons.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Chain {
    /// The places; each waits for the next one.
    pub(super) places: Vec<usize>,
    /// The reason for each place, in words.
    pub(super) texts: Vec<String>,
    /// By place: the type of the part that waits there, if any.
    pub(super) waiting: Vec<Option<usize>>,
    /// Whether the last place waits for the first.
    pub(super) cycle: bool,
}

/// Why a place does not proceed.
#[derive(Debug, Default)]
struct Reason {
    text: String,
    /// Type of the part that waits in the place, if any.
    waiting: Option<usize>,
    /// The place that it waits for, if any.
    next: Option<usize>,
}

/// A state of an abstraction.
pub(super) struct View<'a> {
    pub(super) abstraction: &'a Abstraction,
    pub(super) state: &'a [i64],
}

impl View<'_> {
    fn is(&self, expr: &Expr) -> bool {
        holds(expr, self.state, &[])
    }

    fn value(&self, variable: VarId) -> i64 {
        eval(&Expr::now(variable), self.state, &[])
    }

    fn name(&self, place: usize) -> &str {
        &self.abstraction.shape.places[place].name
    }

    /// Returns the first cycle reachable from these places, or else the longest chain.
    pub(super) fn chain(&self, starts: impl IntoIterator<Item = usize>) -> Chain {
        let mut open = Chain::default();
        for start in starts {
            let chain = self.follow(start);
            if chain.cycle {
                return chain;
            }
            if chain.texts.len() > open.texts.len() {
                open = chain;
            }
        }
        open
    }

    fn follow(&self, start: usize) -> Chain {
        let mut chain = Chain {
            places: vec![start],
            ..Chain::default()
        };
        let mut at = start;
        while let Some(reason) = self.reason(at) {
            chain.texts.push(reason.text);
            chain.waiting.push(reason.waiting);
            let Some(next) = reason.next else { break };
            if let Some(first) = chain.places.iter().position(|p| *p == next) {
                chain.places.drain(..first);
                chain.texts.drain(..first);
                chain.waiting.drain(..first);
                chain.cycle = true;
                break;
            }
            chain.places.push(next);
            at = next;
        }
        chain
    }

    /// Why a place does not proceed.
    fn reason(&self, place: usize) -> Option<Reason> {
        let model = self.abstraction.model();
        let shape = model.shape;
        let name = self.name(place);
        for to in shape.after(place) {
            let Some(part) = shape
                .between(place, to)
                .find(|part| self.is(&model.offers(place, *part, to)))
            else {
                continue;
            };
            let kind = &shape.types[part];
            let room = match shape.places[to].kind {
                PlaceKind::Conveyor { .. } => "room on ",
                PlaceKind::Room { .. } => "room in ",
                _ => "",
            };
            return Some(Reason {
                text: format!(
                    "{name} has {} that waits for {room}{}",
                    an(kind),
                    self.name(to)
                ),
                waiting: Some(part),
                next: Some(to),
            });
        }
        let vars = model.vars(place);
        let PlaceKind::Station { tasks } = &shape.places[place].kind else {
            return match (&shape.places[place].kind, vars.in_line) {
                (PlaceKind::Supply { part, .. }, Some((in_line, most)))
                    if self.value(in_line) >= i64::from(most) =>
                {
                    let kind = &shape.types[*part];
                    Some(Reason {
                        text: format!("{name} releases no {kind} while {most} are in the line"),
                        ..Reason::default()
                    })
                }
                _ => None,
            };
        };
        let begun = |task: &usize| {
            vars.bills[*task]
                .iter()
                .any(|(there, _)| self.value(*there) > 0)
        };
        let mut joining: Vec<usize> = (0..tasks.len())
            .filter(|t| !vars.bills[*t].is_empty())
            .collect();
        joining.sort_by_key(|task| !begun(task));
        for task in joining {
            for (line, (there, count)) in vars.bills[task].iter().enumerate() {
                if self.value(*there) >= i64::from(*count) {
                    continue;
                }
                let part = tasks[task].bill[line].0;
                let text = format!("{name} waits for {}", an(&shape.types[part]));
                // Prefers a place that holds such a part (which is not in front there) to one that
                // would bring it.
                let mut from = shape.places[place].from.clone();
                from.retain(|from| shape.between(*from, place).any(|p| p == part));
                from.sort_by_key(|from| !self.contains(*from, part));
                let next = from.first().copied();
                let source = next.map(|from| format!(" from {}", self.name(from)));
                return Some(Reason {
                    text: text + &source.unwrap_or_default(),
                    waiting: None,
                    next,
                });
            }
        }
        // Nothing is here, and nothing comes from the place that would supply it.
        let from = shape.places[place].from.first()?;
        Some(Reason {
            text: format!("{name} waits for a part from {}", self.name(*from)),
            waiting: None,
            next: Some(*from),
        })
    }

    fn contains(&self, place: usize, part: usize) -> bool {
        let model = self.abstraction.model();
        match &model.vars(place).queue {
            Some(Queue::Count(held, _)) => self.value(*held) > 0,
            Some(Queue::Slots(slots, types)) => slots.iter().any(|slot| {
                let label = self.value(*slot);
                label > 0 && types.get(label as usize - 1) == Some(&part)
            }),
            None => false,
        }
    }

    /// Contents of a place in words; `None` if it is empty.
    pub(super) fn contents(&self, place: usize) -> Option<String> {
        let model = self.abstraction.model();
        let shape = model.shape;
        let vars = model.vars(place);
        let mut found: Vec<(usize, i64)> = Vec::new();
        let mut add = |part: usize, count: i64| {
            if let Some(entry) = found.iter_mut().find(|(p, _)| *p == part) {
                entry.1 += count;
            } else if count > 0 {
                found.push((part, count));
            }
        };
        match &vars.queue {
            Some(Queue::Count(held, _)) => {
                for ways in &shape.places[place].ways {
                    add(ways.part, self.value(*held));
                }
            }
            Some(Queue::Slots(slots, types)) => {
                for slot in slots {
                    if let Some(part) = types.get((self.value(*slot) - 1) as usize) {
                        add(*part, 1);
                    }
                }
            }
            None => {}
        }
        if let PlaceKind::Station { tasks } = &shape.places[place].kind {
            let at = vars.phase.map_or(0, |phase| self.value(phase));
            if let Some(Phase::Work(part) | Phase::Done(part, _)) =
                vars.phases.get((at - 1) as usize)
            {
                add(*part, 1);
            }
            for (task, bill) in vars.bills.iter().enumerate() {
                for (line, (there, _)) in bill.iter().enumerate() {
                    add(tasks[task].bill[line].0, self.value(*there));
                }
            }
        }
        let texts: Vec<String> = found
            .iter()
            .map(|(part, n)| format!("{n} {}", shape.types[*part]))
            .collect();
        (!texts.is_empty()).then(|| format!("{} has {}", self.name(place), texts.join(" and ")))
    }
}
