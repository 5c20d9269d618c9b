//! Lowers rules to GR(1) safety formulas over conditions that express when a skill is called.
//!
//! A skill is *called* in the step in which its condition becomes true: in step 0 if it holds
//! there, later if it holds and did not hold in the step before. A condition can also restart: it
//! then counts as a new call although it held in the step before. This is needed for an operation
//! that can follow itself. Each rule is lowered to a variable for the state of the rule's automaton
//! (omitted if there is only one state), the formulas that define this variable step by step, and
//! the formulas of the rule. The skills called in one step form one call. The call is looked up in
//! the automaton over sets that [`super::serial`] builds, so every order of the skills has to be
//! allowed.

use super::rule::{self, Alphabet};
use super::serial::{Serial, StateSetId};
use super::strongest::recall;
use super::{Level, Rule, Serialisation, Skills};
use linewright_automata::bound::BoundExceeded;
use linewright_core::deadline::Deadline;
use linewright_core::gr1::{Domain, Expr, Formula, Owner, Side, Time, VarId, Variable};

/// Maximum number of combinations of a state of a rule and a set of skills.
const MAX_CASES: usize = 1 << 14;

/// Suffix in the name of a formula about step 0.
pub const INITIAL_SUFFIX: &str = " at first";

/// Returns the name of the rule to which a formula of this name belongs; `None` for other formulas.
/// The names cannot clash with names in a file, which contain no blanks.
pub fn rule_name(formula: &str) -> Option<&str> {
    let name = formula.strip_suffix(INITIAL_SUFFIX).unwrap_or(formula);
    name.strip_prefix("order ")
}

/// Lowered form of one rule.
#[derive(Debug, Clone)]
pub struct LoweredRule {
    /// Indices of the skills that the rule depends on.
    pub mentioned_skills: Vec<usize>,
    /// State of the rule's automaton, with the requested id; `None` if there is only one state.
    pub variable: Option<Variable>,
    /// Definition of the variable.
    pub definitions: Side,
    /// Formulas that express the rule.
    pub rule: Side,
}

/// When a skill is called: expressions over the current values of the variables.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Condition {
    /// The skill is being called.
    pub holds: Expr,
    /// If this is true, `holds` in the next step is a new call even if `holds` is true in this
    /// step, too.
    pub restarts: Expr,
}

impl Condition {
    /// Creates a condition that is a call only when it becomes true.
    pub fn rising(holds: Expr) -> Self {
        Self {
            holds,
            restarts: Expr::FALSE,
        }
    }

    /// Returns a formula that is true if the call begins in the next step.
    pub fn begins(&self) -> Expr {
        let next = self.holds.substitute(&mut |v, _| Expr::Var(v, Time::Next));
        let before = self.holds.clone().not().or(self.restarts.clone());
        next.and(before).simplify()
    }
}

/// Conditions, one per skill.
pub type Conditions<'a> = &'a [Condition];

/// Returns the rules that apply at a level. At the level reasonable, they include one implicit rule
/// for each skill with a target situation, which forbids recalls of the skill.
pub fn rules_of(skills: &Skills, level: Level) -> Vec<Rule> {
    let own = skills.rules.iter().filter(|r| r.level <= level);
    let mut rules: Vec<Rule> = own.cloned().collect();
    if level >= Level::Reasonable {
        for skill in 0..skills.skills.len() {
            rules.extend(recall(skills, skill, level).map(|rule| {
                Rule {
                    span: skills.skills[skill].span,
                    // The text without `order NAME at LEVEL: `.
                    text: rule
                        .text
                        .split_once(": ")
                        .map_or_else(String::new, |(_, body)| body.to_owned()),
                    ..rule
                }
            }));
        }
    }
    rules
}

/// Lowers a rule over these conditions. `variable` is the id for the variable that holds the state
/// of the rule, and `taken` returns whether a variable name is in use.
///
/// # Errors
/// When the rule's automaton is too large, or the product of its number of states and the number of
/// sets of skills.
pub fn lower(
    skills: &Skills,
    rule: &Rule,
    when: Conditions<'_>,
    variable: VarId,
    taken: impl Fn(&str) -> bool,
) -> Result<LoweredRule, BoundExceeded> {
    let alphabet = Alphabet::of(skills);
    let automaton = rule::automaton(rule, skills, &alphabet, Deadline::NONE)?;
    let mut serial = Serial::new(automaton, Serialisation::Every);
    let mentioned = mentioned_skills(skills, &alphabet, &serial);
    let table = Cases::new(skills, &alphabet, &mut serial, &mentioned)?;
    let states = serial.set_count();
    let at = (states > 1).then_some(variable);
    let now = |skill: usize| when[skill].holds.clone();
    let rising = |skill: usize| when[skill].begins();
    let formula = |expr: Expr, when: &str| Formula {
        defines: false,
        name: format!("order {}{when}", rule.name),
        requirement: rule.requirement.clone(),
        expr: expr.simplify(),
        span: rule.span,
        text: rule.text.clone(),
    };
    let mut name = format!("order_{}", identifier(&rule.name));
    while taken(&name) {
        name.push('_');
    }
    let mut lowered = LoweredRule {
        mentioned_skills: mentioned,
        variable: at.map(|_| Variable {
            name,
            owner: Owner::System,
            internal: true,
            domain: Domain::Range {
                low: 0,
                high: states as i64 - 1,
            },
            unit: String::new(),
            span: rule.span,
        }),
        definitions: Side::default(),
        rule: Side::default(),
    };
    if let Some(at) = at {
        let first = table.next(0, &now);
        let first = Expr::now(at).equals(first);
        lowered
            .definitions
            .initial
            .push(formula(first, INITIAL_SUFFIX));
        let mut later = table.next(states as StateSetId - 1, &rising);
        for state in (0..states as StateSetId - 1).rev() {
            let here = Expr::now(at).equals(Expr::Const(i64::from(state)));
            let then = table.next(state, &rising);
            later = Expr::If(Box::new(here), Box::new(then), Box::new(later));
        }
        let later = Expr::next(at).equals(later);
        lowered.definitions.safety.push(formula(later, ""));
    }
    let first = table.allowed(0, &now);
    if first != Expr::TRUE {
        lowered.rule.initial.push(formula(first, INITIAL_SUFFIX));
    }
    let later = (0..states as StateSetId).fold(Expr::TRUE, |all, state| {
        let allowed = table.allowed(state, &rising);
        match at {
            _ if allowed == Expr::TRUE => all,
            None => all.and(allowed),
            Some(at) => {
                let here = Expr::now(at).equals(Expr::Const(i64::from(state)));
                all.and(here.implies(allowed))
            }
        }
    });
    if later != Expr::TRUE {
        lowered.rule.safety.push(formula(later, ""));
    }
    Ok(lowered)
}

/// Converts a name to an identifier: replaces all characters except letters and digits by `_`.
fn identifier(name: &str) -> String {
    let sign = |c: char| if c.is_alphanumeric() { c } else { '_' };
    name.chars().map(sign).collect()
}

/// Returns the skills of all letters that have an influence on the rule.
fn mentioned_skills(skills: &Skills, alphabet: &Alphabet, serial: &Serial) -> Vec<usize> {
    let mut mentioned = vec![false; skills.skills.len()];
    for letter in 0..alphabet.len() {
        if !serial.is_idle(letter) {
            for skill in alphabet.skills_of(letter) {
                mentioned[skill] = true;
            }
        }
    }
    (0..mentioned.len()).filter(|s| mentioned[*s]).collect()
}

/// For every state, the result of calling each set of skills in one step. A set contains at most
/// one skill of each component.
struct Cases {
    /// For each component that the rule mentions, the skills of this component that the rule
    /// mentions.
    components: Vec<Vec<usize>>,
    /// For each state, the sets of skills as masks, smaller sets first. Each has the state after
    /// the call; `None` if the call is refused.
    after: Vec<Vec<(u64, Option<StateSetId>)>>,
}

impl Cases {
    fn new(
        skills: &Skills,
        alphabet: &Alphabet,
        serial: &mut Serial,
        mentioned: &[usize],
    ) -> Result<Self, BoundExceeded> {
        let components = (0..skills.components.len()).map(|c| {
            let own = mentioned.iter().copied();
            own.filter(|s| skills.skills[*s].component == c).collect()
        });
        let components: Vec<Vec<usize>> =
            components.filter(|c: &Vec<usize>| !c.is_empty()).collect();
        let mut sets = vec![0_u64];
        for component in &components {
            let longer = sets.iter().flat_map(|set| {
                let more = component.iter().map(move |s| set | 1 << s);
                [*set].into_iter().chain(more)
            });
            sets = longer.collect();
            if sets.len() > MAX_CASES {
                return Err(too_many());
            }
        }
        sets.sort_by_key(|set| (set.count_ones(), *set));
        let mut after = Vec::new();
        let mut state = 0;
        while state < serial.set_count() {
            let mut row = Vec::with_capacity(sets.len());
            for set in &sets {
                let letters = alphabet.letters(*set);
                row.push((*set, serial.call(state as StateSetId, &letters)?));
            }
            after.push(row);
            state += 1;
            if state * sets.len() > MAX_CASES {
                return Err(too_many());
            }
        }
        Ok(Self { components, after })
    }

    fn to(&self, state: StateSetId, set: u64) -> Option<StateSetId> {
        let row = &self.after[state as usize];
        let found = row.iter().find(|(known, _)| *known == set);
        found.expect("a set was not computed; please report this").1
    }

    /// Returns an expression for the state after a call. A refused call does not change the state.
    fn next(&self, state: StateSetId, called: &impl Fn(usize) -> Expr) -> Expr {
        self.decide(
            0,
            0,
            &|set| {
                let to = self.to(state, set).unwrap_or(state);
                Expr::Const(i64::from(to))
            },
            called,
        )
    }

    /// Builds nested conditionals that distinguish, component by component, which skill is called.
    /// Branches with equal results are merged.
    fn decide(
        &self,
        component: usize,
        set: u64,
        answer: &dyn Fn(u64) -> Expr,
        called: &impl Fn(usize) -> Expr,
    ) -> Expr {
        let Some(skills) = self.components.get(component) else {
            return answer(set);
        };
        let mut result = self.decide(component + 1, set, answer, called);
        for skill in skills.iter().rev() {
            let then = self.decide(component + 1, set | 1 << skill, answer, called);
            if then != result {
                result = Expr::If(Box::new(called(*skill)), Box::new(then), Box::new(result));
            }
        }
        result
    }

    /// Returns the condition that a call is allowed in a state: the call contains no minimal
    /// refused set. A set that contains a refused set is refused, too, because the skills of the
    /// smaller set can come first.
    fn allowed(&self, state: StateSetId, called: &impl Fn(usize) -> Expr) -> Expr {
        let mut least: Vec<u64> = Vec::new();
        for (set, to) in &self.after[state as usize] {
            if to.is_none() && least.iter().all(|l| l & set != *l) {
                least.push(*set);
            }
        }
        least.into_iter().fold(Expr::TRUE, |all, set| {
            let skills = (0..u64::BITS as usize).filter(|s| set >> s & 1 == 1);
            let together = skills.map(called).reduce(Expr::and);
            let none = together.map_or(Expr::FALSE, Expr::not);
            if all == Expr::TRUE {
                none
            } else {
                all.and(none)
            }
        })
    }
}

fn too_many() -> BoundExceeded {
    BoundExceeded::Count {
        what: "combinations of a rule's state and a call",
        limit: MAX_CASES,
    }
}
