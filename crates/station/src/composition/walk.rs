//! Walks the coordinator's reachable states, and answers questions about the wires in each state.

use super::query::{Answer, Question, Values};
use super::{Discharger, over_wires, support};
use linewright_algebra::proof::completions;
use linewright_core::gr1::{BinaryOp, Expr, Formula, Specification, Time, VarId};
use linewright_language::contract::machine::{Machine, PlantSource};
use linewright_solver::game::{Budget, Limits};
use linewright_solver::mealy;
use std::cell::RefCell;
use std::collections::{BTreeSet, HashMap};

/// State of the coordinator before a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Node {
    /// Before step 0.
    Start,
    /// In the state with this index.
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

/// Returns for each component what holds infinitely often by its contract. If a limit is reached
/// before it is known what follows from a contract, only its guarantees count.
fn recurring(machine: &Machine) -> Vec<Vec<Formula>> {
    let limits = Limits::default().with_budget(Budget::MACHINE);
    let of = |specification: &Specification| {
        let mut found = specification.guarantees.justice.clone();
        found.extend(completions(specification, &limits).unwrap_or_default());
        found
    };
    let components = machine.components.iter();
    components.map(|c| of(&c.specification)).collect()
}

/// The walk over a machine's coordinator.
pub struct Walk<'a> {
    /// The machine.
    pub machine: &'a Machine,
    coordinator: &'a mealy::Machine,
    reachable: BTreeSet<Node>,
    /// For each component, the invariants and the safety formulas of its guarantees, over wires.
    invariants: Vec<Vec<Expr>>,
    safeties: Vec<Vec<Expr>>,
    /// For each component, its justice guarantees and what else recurs by its contract.
    recurring: Vec<Vec<Formula>>,
    /// Cached answers: many states lead to the same question about the actions.
    answers: RefCell<HashMap<(Expr, Vec<Expr>), Answer>>,
}

impl<'a> Walk<'a> {
    /// Computes the reachable states of the coordinator, which is component 0.
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
            recurring: recurring(machine),
            answers: RefCell::default(),
        };
        let mut open = vec![Node::Start];
        while let Some(node) = open.pop() {
            for transition in 0..walk.transitions(node).len() {
                let step = Step {
                    from: node,
                    transition,
                };
                if walk.is_possible(step, &[]) && walk.reachable.insert(walk.target(step)) {
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
            .filter(|s| self.is_possible(*s, &[]))
    }

    /// Whether a step can occur if additional conditions on the wires hold in that step.
    pub fn is_possible(&self, step: Step, conditions: &[Expr]) -> bool {
        let mut hypotheses = self.guard(step);
        for condition in conditions {
            hypotheses.push(self.fix(condition, step.from, None));
        }
        // The step cannot occur if no values satisfy all conditions, that is, if the negation of
        // their conjunction always holds. All conditions are in the goal, because a hypothesis that
        // shares no wire with the goal would be left out.
        let all = hypotheses.into_iter().fold(Expr::TRUE, Expr::and);
        let question = Question::plain(&all.not());
        self.answer(&question) != Answer::Holds
    }

    /// Condition under which the coordinator takes this transition, over the wires of the step.
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

    /// The coordinator's outputs at a node; `None` if the node has no transition.
    fn outputs(&self, node: Node) -> Option<&'a [i64]> {
        self.transitions(node).first().map(|t| t.output.as_slice())
    }

    /// Substitutes known values: the coordinator's outputs in this step, those in the next step if
    /// its node is given, and signals that never change.
    fn fix(&self, expr: &Expr, now: Node, next: Option<Node>) -> Expr {
        self.put(expr, (Some(now), next))
    }

    /// Like `fix`, with optional nodes for this step and the next.
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

    /// Creates a question about one step.
    pub fn question_at(&self, node: Node, goal: &Expr) -> Question {
        Question {
            hypotheses: Vec::new(),
            goal: self.fix(goal, node, None),
            at: (Some(node), None),
        }
    }

    /// Creates questions about a step and the next one. The first question is about steps within an
    /// operation, in which the operation and the part's values do not change. The second is about
    /// steps between two operations. If the operation cannot continue or cannot end in this step,
    /// the respective question is omitted.
    pub fn questions_for_step(&self, step: Step, goal: &Expr) -> Vec<Question> {
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

    /// Answers a question with only its own hypotheses.
    fn answer(&self, question: &Question) -> Answer {
        let key = (question.goal.clone(), question.hypotheses.clone());
        if let Some(answer) = self.answers.borrow().get(&key) {
            return answer.clone();
        }
        let answer = question.answer(self.machine);
        self.answers.borrow_mut().insert(key, answer.clone());
        answer
    }

    /// Answers a question about component `index`, first with only its own hypotheses, then also
    /// with guarantees of the actions. A component can rely on all guarantees in the previous step.
    /// In the same step, it can rely only on the guarantees of actions that are computed before it.
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

    /// Whether a question's goal depends only on the line: it mentions only the operation and the
    /// part's values.
    pub fn depends_only_on_line(&self, question: &Question) -> bool {
        let wires = support(&question.goal);
        wires.iter().all(|(w, _)| self.is_held(*w))
            && wires.iter().any(|(w, t)| {
                // The line chooses the value at the beginning of an operation.
                *t == Time::Next || self.is_held(*w)
            })
    }

    /// Whether a component's formula follows only from constant signals and bindings in the
    /// machine's file.
    pub fn is_fixed(&self, index: usize, formula: &Formula) -> bool {
        let goal = over_wires(self.machine, index, &formula.expr);
        let known = goal.substitute(&mut |wire, time| {
            self.constant_signal(wire).unwrap_or(Expr::Var(wire, time))
        });
        let question = Question::plain(&known);
        self.answer(&question) == Answer::Holds
    }

    /// Finds a guarantee of another component that by itself implies an assumption.
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

    /// Discharges an action's justice assumption: in every state of the coordinator, it must hold,
    /// or some value in a signal's script must make it hold.
    ///
    /// # Errors
    /// Returns values of a step in which neither is the case.
    pub fn discharge_action_justice(
        &self,
        index: usize,
        goal: &Expr,
    ) -> Result<Discharger, Option<Values>> {
        for node in self.nodes() {
            let question = self.question_at(node, goal);
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
        Ok(if self.is_satisfied_by_script(goal) {
            Discharger::Plant
        } else {
            Discharger::Coordinator
        })
    }

    /// Whether one value in the script of one signal satisfies a goal.
    fn is_satisfied_by_script(&self, goal: &Expr) -> bool {
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

    /// Every value in the script of every signal, with the signal's wire.
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

    /// Discharges a justice assumption of the coordinator. In every state in which the assumption
    /// does not hold, it must hold one step later, or a justice guarantee of an action must imply
    /// it and must still do so in the next state.
    ///
    /// # Errors
    /// Returns values of a step in which neither is the case, or `None` if the implying guarantees
    /// change between two states.
    pub fn discharge_coordinator_justice(
        &self,
        index: usize,
        goal: &Expr,
    ) -> Result<Discharger, Option<Values>> {
        let mut names: BTreeSet<String> = BTreeSet::new();
        for node in self.nodes() {
            let question = self.question_at(node, goal);
            let Answer::Fails(values) = self.ask(index, &question) else {
                continue;
            };
            let implying = self.implying_guarantees(node, goal);
            let waits = goal.clone().not();
            for step in self.steps_from(node) {
                if !self.is_possible(step, std::slice::from_ref(&waits)) {
                    continue;
                }
                let target = self.target(step);
                if self.holds_next(index, step, goal) {
                    continue;
                }
                if implying.is_empty() {
                    return Err(Some(values));
                }
                let later = self.implying_guarantees(target, goal);
                if !later.iter().any(|g| implying.contains(g)) {
                    return Err(None);
                }
            }
            names.extend(implying);
        }
        Ok(match names.into_iter().collect::<Vec<_>>() {
            names if names.is_empty() => Discharger::Coordinator,
            names => Discharger::Guarantee(names.join(", ")),
        })
    }

    /// Whether a goal that does not hold in this step must hold in the next one.
    fn holds_next(&self, index: usize, step: Step, goal: &Expr) -> bool {
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

    /// Returns the names of the actions' justice guarantees, and of what else recurs by their
    /// contracts, that imply the goal at a node, each by itself.
    fn implying_guarantees(&self, node: Node, goal: &Expr) -> Vec<String> {
        let mut found = Vec::new();
        let goal = self.fix(goal, node, None);
        for (i, component) in self.machine.components.iter().enumerate().skip(1) {
            for guarantee in &self.recurring[i] {
                let guaranteed = over_wires(self.machine, i, &guarantee.expr);
                let question = Question {
                    hypotheses: vec![self.fix(&guaranteed, node, None)],
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

    /// Simplifies a condition over the wires of a step with the values known at a node.
    pub fn known(&self, node: Node, condition: &Expr) -> Expr {
        self.fix(condition, node, None)
    }

    /// Whether the coordinator's assumptions allow an operation to begin. At the start, the
    /// relevant assumptions are the initial conditions; after a step, they are the safety
    /// assumptions, with all other values of that step free.
    pub fn can_begin(&self, from: Option<Step>, operation: i64) -> bool {
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
