//! Walks the coordinator's reachable states, with what is known of all other wires in each.

use super::query::{Answer, Question, Values};
use super::{Discharger, over_wires, support};
use linewright_core::gr1::{BinaryOp, Expr, Formula, Time, VarId};
use linewright_language::contract::machine::{Machine, PlantSource};
use linewright_solver::mealy;
use std::cell::RefCell;
use std::collections::{BTreeSet, HashMap};

/// State of the coordinator before it answers: not started, or in a state of its machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Node {
    /// Before step 0.
    Start,
    /// In this state.
    At(usize),
}

/// A step of the coordinator: a node and the index of a transition.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Step {
    /// Source node.
    pub from: Node,
    /// Index of the transition.
    pub transition: usize,
}

/// The walk over a machine's coordinator.
pub struct Walk<'a> {
    /// The machine.
    pub machine: &'a Machine,
    coordinator: &'a mealy::Machine,
    reachable: BTreeSet<Node>,
    /// For each component, its invariants and safety guarantees over wires.
    invariants: Vec<Vec<Expr>>,
    safeties: Vec<Vec<Expr>>,
    /// Cached answers: a coordinator asks the same about its actions in many states.
    answers: RefCell<HashMap<(Expr, Vec<Expr>), Answer>>,
}

impl<'a> Walk<'a> {
    /// Starts a walk of the coordinator, component 0.
    pub fn new(machine: &'a Machine, coordinator: &'a mealy::Machine) -> Self {
        let lists = |formulas: fn(&linewright_core::gr1::Side) -> &Vec<Formula>| -> Vec<Vec<Expr>> {
            (0..machine.components.len())
                .map(|i| {
                    formulas(&machine.components[i].specification.guarantees)
                        .iter()
                        .map(|f| over_wires(machine, i, &f.expr))
                        .collect()
                })
                .collect()
        };
        let mut walk = Self {
            machine,
            coordinator,
            reachable: BTreeSet::from([Node::Start]),
            invariants: lists(|s| &s.invariants),
            safeties: lists(|s| &s.safety),
            answers: RefCell::default(),
        };
        let mut open = vec![Node::Start];
        while let Some(node) = open.pop() {
            for transition in 0..walk.transitions(node).len() {
                let step = Step {
                    from: node,
                    transition,
                };
                if walk.possible(step, &[]) && walk.reachable.insert(walk.target(step)) {
                    open.push(walk.target(step));
                }
            }
        }
        walk
    }

    fn transitions(&self, node: Node) -> &'a [mealy::Transition] {
        self.coordinator.transitions(match node {
            Node::Start => None,
            Node::At(state) => Some(state),
        })
    }

    /// Target node of a step.
    pub fn target(&self, step: Step) -> Node {
        Node::At(self.transitions(step.from)[step.transition].to)
    }

    /// All reachable nodes.
    pub fn nodes(&self) -> impl Iterator<Item = Node> {
        self.reachable.iter().copied()
    }

    /// All possible steps.
    pub fn steps(&self) -> impl Iterator<Item = Step> {
        self.nodes().flat_map(|n| self.steps_from(n))
    }

    /// The possible steps from a node.
    pub fn steps_from(&self, from: Node) -> impl Iterator<Item = Step> {
        (0..self.transitions(from).len())
            .map(move |transition| Step { from, transition })
            .filter(|s| self.possible(*s, &[]))
    }

    /// Whether a step can occur under additional conditions on the wires of its step.
    pub fn possible(&self, step: Step, conditions: &[Expr]) -> bool {
        let mut hypotheses = self.guard(step);
        for condition in conditions {
            hypotheses.push(self.fix(condition, step.from, None));
        }
        // "It cannot occur" means "its negation holds"; one goal, so that every part of it counts.
        let all = hypotheses.into_iter().fold(Expr::TRUE, Expr::and);
        let question = Question::plain(&all.not());
        self.answer(&question) != Answer::Holds
    }

    /// Conditions under which the coordinator takes this transition, over the wires of the step.
    fn guard(&self, step: Step) -> Vec<Expr> {
        let transition = &self.transitions(step.from)[step.transition];
        let bindings = &self.machine.components[0].bindings;
        let mut any = Expr::FALSE;
        for cube in &transition.guard.0 {
            let mut all = Expr::TRUE;
            for test in &cube.0 {
                let value = &bindings[test.input];
                let low = Expr::binary(BinaryOp::Ge, value.clone(), Expr::Const(test.low));
                let high = Expr::binary(BinaryOp::Le, value.clone(), Expr::Const(test.high));
                all = all.and(low).and(high);
            }
            any = any.or(all);
        }
        vec![self.fix(&any, step.from, None)]
    }

    /// The coordinator's outputs at a node; `None` if it has no transition.
    fn outputs(&self, node: Node) -> Option<&'a [i64]> {
        self.transitions(node).first().map(|t| t.output.as_slice())
    }

    /// Substitutes known values: the coordinator's outputs now, and next if a target is given;
    /// signals that never change.
    fn fix(&self, expr: &Expr, now: Node, next: Option<Node>) -> Expr {
        self.put(expr, (Some(now), next))
    }

    fn put(&self, expr: &Expr, (now, next): (Option<Node>, Option<Node>)) -> Expr {
        let first = self.machine.plant.len();
        let put = |node: Node, wire: usize| -> Option<Expr> {
            let outputs = self.outputs(node)?;
            let place = wire.checked_sub(first)?;
            outputs.get(place).map(|v| Expr::Const(*v))
        };
        expr.substitute(&mut |wire, time| {
            let node = match time {
                Time::Now => now,
                Time::Next => next,
            };
            node.and_then(|node| put(node, wire.index()))
                .or_else(|| self.constant_signal(wire))
                .unwrap_or(Expr::Var(wire, time))
        })
        .simplify()
    }

    fn constant_signal(&self, wire: VarId) -> Option<Expr> {
        match &self.machine.plant.get(wire.index())?.source {
            PlantSource::Signal { script } => {
                let first = *script.first()?;
                script
                    .iter()
                    .all(|v| *v == first)
                    .then_some(Expr::Const(first))
            }
            _ => None,
        }
    }

    /// A question about one step.
    pub fn now(&self, node: Node, goal: &Expr) -> Question {
        Question {
            hypotheses: Vec::new(),
            goal: self.fix(goal, node, None),
            at: (Some(node), None),
        }
    }

    /// Questions about a step and the next one: within an operation, where the operation and the
    /// part's values stay, and, if the operation may end, from one operation to the next.
    pub fn step(&self, step: Step, goal: &Expr) -> Vec<Question> {
        let target = self.target(step);
        let goal = self.fix(goal, step.from, Some(target));
        let guard = self.guard(step);
        let done = match &self.machine.done {
            Some(done) => self.fix(done, step.from, None),
            None => Expr::FALSE,
        };
        let mut questions = Vec::new();
        if done != Expr::TRUE {
            let held = goal.substitute(&mut |wire, time| {
                let time = if self.is_held(wire) { Time::Now } else { time };
                Expr::Var(wire, time)
            });
            let mut hypotheses = guard.clone();
            hypotheses.push(done.clone().not().simplify());
            questions.push(Question {
                hypotheses,
                goal: held.simplify(),
                at: (Some(step.from), Some(target)),
            });
        }
        if done != Expr::FALSE {
            let mut hypotheses = guard;
            hypotheses.push(done);
            questions.push(Question {
                hypotheses,
                goal,
                at: (Some(step.from), Some(target)),
            });
        }
        questions
    }

    /// Whether a plant wire keeps its value during an operation.
    fn is_held(&self, wire: VarId) -> bool {
        self.machine
            .plant
            .get(wire.index())
            .is_some_and(|p| !matches!(p.source, PlantSource::Signal { .. }))
    }

    /// Answers a question as it stands.
    fn answer(&self, question: &Question) -> Answer {
        let key = (question.goal.clone(), question.hypotheses.clone());
        if let Some(answer) = self.answers.borrow().get(&key) {
            return answer.clone();
        }
        let answer = question.answer(self.machine);
        self.answers.borrow_mut().insert(key, answer.clone());
        answer
    }

    /// Answers a question, first with its own hypotheses, then with the guarantees of the actions.
    /// An action may rely on guarantees in the previous step, and in the same step on those of
    /// components that answer before it.
    pub fn ask(&self, index: usize, question: &Question) -> Answer {
        let first = self.answer(question);
        if first == Answer::Holds {
            return first;
        }
        let earlier = if index == 0 {
            1..self.machine.components.len()
        } else {
            1..index
        };
        let mut more = question.clone();
        for i in 1..self.machine.components.len() {
            for invariant in &self.invariants[i] {
                if earlier.contains(&i) || support(&question.goal).iter().any(|w| w.1 == Time::Next)
                {
                    more.hypotheses.push(self.put(invariant, question.at));
                }
                if earlier.contains(&i) {
                    let next = invariant.substitute(&mut |w, _| Expr::Var(w, Time::Next));
                    more.hypotheses.push(self.put(&next, question.at));
                }
            }
            if earlier.contains(&i) {
                let safeties = self.safeties[i].iter();
                more.hypotheses
                    .extend(safeties.map(|s| self.put(s, question.at)));
            }
        }
        match self.answer(&more) {
            Answer::Holds => Answer::Holds,
            _ => first,
        }
    }

    /// Whether a question's goal is up to the line: it mentions only the operation and the part's
    /// values.
    pub fn is_lines_choice(&self, question: &Question) -> bool {
        let wires = support(&question.goal);
        wires.iter().all(|(w, _)| self.is_held(*w))
            && wires.iter().any(|(w, t)| {
                // The line chooses the value at the beginning of an operation.
                *t == Time::Next || self.is_held(*w)
            })
    }

    /// Whether a component's formula holds by what the machine's file fixes alone: constant signals
    /// and bindings.
    pub fn is_fixed(&self, index: usize, formula: &Formula) -> bool {
        let goal = over_wires(self.machine, index, &formula.expr);
        let known = goal.substitute(&mut |wire, time| {
            self.constant_signal(wire).unwrap_or(Expr::Var(wire, time))
        });
        let question = Question::plain(&known);
        self.answer(&question) == Answer::Holds
    }

    /// A guarantee of another component that alone implies an assumption.
    pub fn single_guarantee(&self, index: usize, formula: &Formula) -> Option<String> {
        let goal = over_wires(self.machine, index, &formula.expr).simplify();
        for (i, component) in self.machine.components.iter().enumerate() {
            if i == index {
                continue;
            }
            let side = &component.specification.guarantees;
            for guarantee in side.invariants.iter().chain(&side.safety) {
                let question = Question {
                    hypotheses: vec![over_wires(self.machine, i, &guarantee.expr).simplify()],
                    goal: goal.clone(),
                    at: (None, None),
                };
                if self.answer(&question) == Answer::Holds {
                    return Some(format!("{}: {}", component.name, guarantee.name));
                }
            }
        }
        None
    }

    // ---- justice --------------------------------------------------------------------------------

    /// Whether an action's justice assumption comes true by itself: in every step of the
    /// coordinator it holds, or some value of a signal's script makes it hold. `Err` carries a step
    /// in which neither is so.
    pub fn comes_by_itself(&self, index: usize, goal: &Expr) -> Result<Discharger, Option<Values>> {
        for node in self.nodes() {
            let question = self.now(node, goal);
            let Answer::Fails(values) = self.ask(index, &question) else {
                continue;
            };
            let helped = self.scripted().any(|(wire, value)| {
                let goal = question.goal.substitute(&mut |w, t| {
                    if w == wire {
                        Expr::Const(value)
                    } else {
                        Expr::Var(w, t)
                    }
                });
                let question = Question::plain(&goal);
                self.answer(&question) == Answer::Holds
            });
            if !helped {
                return Err(Some(values));
            }
        }
        Ok(if self.is_plants_business(goal) {
            Discharger::Plant
        } else {
            Discharger::Coordinator
        })
    }

    /// Whether some value of some signal's script alone satisfies a goal.
    fn is_plants_business(&self, goal: &Expr) -> bool {
        self.scripted().any(|(wire, value)| {
            let settled = goal.substitute(&mut |w, t| {
                if w == wire {
                    Expr::Const(value)
                } else {
                    Expr::Var(w, t)
                }
            });
            settled.simplify() == Expr::TRUE
        })
    }

    /// Every value in the script of a signal.
    fn scripted(&self) -> impl Iterator<Item = (VarId, i64)> {
        let signals = self.machine.plant.iter().enumerate();
        signals.flat_map(|(i, p)| {
            let script = match &p.source {
                PlantSource::Signal { script } => script.as_slice(),
                _ => &[],
            };
            script.iter().map(move |v| (VarId(i as u32), *v))
        })
    }

    /// Whether the coordinator's justice assumption is ensured by others: wherever it does not
    /// hold, either it certainly holds one step later, or one action's justice guarantee implies
    /// it, and that action stays the same until it holds.
    pub fn owed(&self, index: usize, goal: &Expr) -> Result<Discharger, Option<Values>> {
        let mut names: BTreeSet<String> = BTreeSet::new();
        for node in self.nodes() {
            let question = self.now(node, goal);
            let Answer::Fails(values) = self.ask(index, &question) else {
                continue;
            };
            let owing = self.owing(node, goal);
            let waits = goal.clone().not();
            for step in self.steps_from(node) {
                if !self.possible(step, std::slice::from_ref(&waits)) {
                    continue;
                }
                let target = self.target(step);
                if self.comes_next(index, step, goal) {
                    continue;
                }
                if owing.is_empty() {
                    return Err(Some(values));
                }
                if !self.owing(target, goal).iter().any(|o| owing.contains(o)) {
                    return Err(None);
                }
            }
            names.extend(owing);
        }
        Ok(match names.into_iter().collect::<Vec<_>>() {
            names if names.is_empty() => Discharger::Coordinator,
            names => Discharger::Guarantee(names.join(", ")),
        })
    }

    /// Whether a goal certainly holds in the step after one in which it did not.
    fn comes_next(&self, index: usize, step: Step, goal: &Expr) -> bool {
        let at = (Some(step.from), Some(self.target(step)));
        let next = goal.substitute(&mut |w, _| Expr::Var(w, Time::Next));
        let mut hypotheses = self.guard(step);
        hypotheses.push(self.put(&goal.clone().not(), at));
        let question = Question {
            hypotheses,
            goal: self.put(&next, at),
            at,
        };
        self.ask(index, &question) == Answer::Holds
    }

    /// The justice guarantees of actions that imply the goal at a node.
    fn owing(&self, node: Node, goal: &Expr) -> Vec<String> {
        let mut found = Vec::new();
        let goal = self.fix(goal, node, None);
        for (i, component) in self.machine.components.iter().enumerate().skip(1) {
            for guarantee in &component.specification.guarantees.justice {
                let owed = over_wires(self.machine, i, &guarantee.expr);
                let question = Question {
                    hypotheses: vec![self.fix(&owed, node, None)],
                    goal: goal.clone(),
                    at: (Some(node), None),
                };
                if self.answer(&question) == Answer::Holds {
                    found.push(format!("{}: {}", component.name, guarantee.name));
                }
            }
        }
        found
    }

    // ---- operations -----------------------------------------------------------------------------

    /// A condition over the wires of a step, as far as it is known at a node.
    pub fn known(&self, node: Node, condition: &Expr) -> Expr {
        self.fix(condition, node, None)
    }

    /// The coordinator's assumptions as conditions on a first step with this operation, coming from
    /// a node where the previous one has ended: the initial conditions, or safety with all earlier
    /// values left open.
    pub fn may_begin(&self, from: Option<Step>, operation: i64) -> bool {
        let side = &self.machine.components[0].specification.assumptions;
        let wire = VarId(0);
        let put = |expr: &Expr, time: Time| {
            expr.substitute(&mut |w, t| {
                if w == wire && t == time {
                    Expr::Const(operation)
                } else {
                    Expr::Var(w, t)
                }
            })
        };
        let conditions: Vec<Expr> = match from {
            None => side
                .initial
                .iter()
                .map(|f| put(&over_wires(self.machine, 0, &f.expr), Time::Now))
                .map(|e| self.fix(&e, Node::Start, None))
                .collect(),
            Some(step) => side
                .safety
                .iter()
                .map(|f| put(&over_wires(self.machine, 0, &f.expr), Time::Next))
                .map(|e| self.fix(&e, step.from, Some(self.target(step))))
                .collect(),
        };
        let all = conditions
            .into_iter()
            .fold(Expr::TRUE, Expr::and)
            .simplify();
        let question = Question::plain(&all.not());
        self.answer(&question) != Answer::Holds
    }
}
