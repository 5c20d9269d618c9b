//! Skill sets that a machine calls, with one condition over wires per skill.
//!
//! The rules of a set are used twice. Rules about the calls of one coordinator become guarantees of
//! its contract, so that its synthesized controller satisfies them ([`guarantee`]). All rules
//! become assumptions of a component that only observes ([`watches`]), so that they are proved like
//! any other assumption, and checked at run time in every step.

use super::Parts;
use super::component::scope_of_wires;
use crate::contract::elaborate::{Elaborator, Findings};
use crate::contract::machine::{Component, Machine, PlantSource, RealExpr, Role, SkillOrders};
use crate::contract::scope::Scope;
use crate::contract::skills::{level, listed, near_or_all};
use crate::order::lower::{Condition, INITIAL_SUFFIX, lower, rules_of};
use crate::order::{Level, Skills};
use linewright_automata::bound::BoundExceeded;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::gr1::{
    Domain, Expr, Formula, Owner, Side, Specification, Time, Timing, VarId, Variable, eval,
};
use linewright_core::source::Span;
use linewright_syntax::ast::{self, MachineItem};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Resolves the skill sets that the machine calls, with the condition of each skill.
pub(super) fn orders<'a>(
    wires: &mut Elaborator<'a>,
    parts: &Parts<'a>,
    scope: &Scope<'_>,
) -> Vec<SkillOrders> {
    let decls = parts.machine.items.iter().filter_map(|item| match item {
        MachineItem::Skills(decl) => Some(decl),
        _ => None,
    });
    let mut sets: BTreeMap<&str, Span> = BTreeMap::new();
    let mut orders = Vec::new();
    for decl in decls {
        let set = &decl.set;
        if let Some(first) = sets.insert(&set.text, set.span) {
            wires.findings.push(
                Diagnostic::error(
                    codes::NAME_DUPLICATE,
                    set.span,
                    format!("the skill set `{}` appears twice", set.text),
                )
                .with_label(first, "first here")
                .with_help("remove one of the two"),
            );
        }
        let level = level(decl.level.as_ref(), &Level::ALL, &mut wires.findings.list);
        // Conditions are resolved before the set, so that their errors are reported in any case.
        let called = bound_skills(wires, decl);
        let Some(skills) = skills(&mut wires.findings, scope, set) else {
            continue;
        };
        let when = conditions(&mut wires.findings, decl, &skills, called);
        let (Some(level), Some(when)) = (level, when) else {
            wires.findings.tainted = true;
            continue;
        };
        orders.push(SkillOrders {
            skills,
            level,
            when,
            caller: String::new(),
            span: set.span,
        });
    }
    orders
}

/// Returns the skill set with this name. A set with errors has been reported at its declaration.
fn skills(findings: &mut Findings, scope: &Scope<'_>, name: &ast::Name) -> Option<Arc<Skills>> {
    match scope.skills.get(name.text.as_str()) {
        Some(Some(skills)) => Some(Arc::clone(skills)),
        Some(None) => {
            findings.tainted = true;
            None
        }
        None => {
            let known = scope.skills.keys().copied();
            let help = match known.len() {
                0 => "import the file that declares it".to_owned(),
                _ => near_or_all(&name.text, known, "the skill sets in scope are"),
            };
            findings.error_with(
                codes::NAME_UNKNOWN,
                name.span,
                format!("there is no skill set `{}`", name.text),
                help,
            );
            None
        }
    }
}

/// Bindings by the name of the skill. Each consists of its position and the condition, which is
/// `None` if it has an error.
type BoundSkills<'a> = BTreeMap<&'a str, (Span, Option<Expr>)>;

/// Resolves the conditions of skills; reports skills that are bound twice.
fn bound_skills<'a>(wires: &mut Elaborator<'a>, decl: &'a ast::SkillCalls) -> BoundSkills<'a> {
    let mut called = BoundSkills::new();
    for call in &decl.calls {
        let term = wires.boolean(&call.value, Time::Now);
        let expr = term.and_then(|t| wires.formula(&t, call.value.span));
        let name = &call.name;
        if let Some((first, _)) = called.get(name.text.as_str()) {
            wires.findings.push(
                Diagnostic::error(
                    codes::NAME_DUPLICATE,
                    name.span,
                    format!("`{}` is bound twice", name.text),
                )
                .with_label(*first, "first here")
                .with_help("join the two with `or`"),
            );
            continue;
        }
        called.insert(&name.text, (name.span, expr));
    }
    called
}

/// Returns one condition per skill, in the order of the skills; `None` if an error was reported.
fn conditions(
    findings: &mut Findings,
    decl: &ast::SkillCalls,
    skills: &Skills,
    mut called: BoundSkills<'_>,
) -> Option<Vec<Expr>> {
    let name = &decl.set.text;
    let bound: Vec<_> = skills
        .skills
        .iter()
        .map(|skill| called.remove(skill.name.as_str()))
        .collect();
    let missing: Vec<&str> = skills
        .skills
        .iter()
        .zip(&bound)
        .filter(|(_, bound)| bound.is_none())
        .map(|(skill, _)| skill.name.as_str())
        .collect();
    for (unknown, (span, _)) in &called {
        // The skills without a binding are suggested first, because an unknown name is probably a
        // misspelling of one of them.
        let known = missing.iter().copied();
        let all = skills.skills.iter().map(|s| s.name.as_str());
        let help = match linewright_core::diagnostics::nearest(unknown, known) {
            Some(near) => format!("did you mean `{near}`?"),
            None => near_or_all(unknown, all, "its skills are"),
        };
        findings.error_with(
            codes::NAME_UNKNOWN,
            *span,
            format!("`{name}` has no skill `{unknown}`"),
            help,
        );
    }
    if decl.broken {
        // The text that could not be parsed might contain the missing bindings.
        findings.tainted = true;
        return None;
    }
    if let Some(first) = missing.first() {
        findings.error_with(
            codes::INPUT_UNBOUND,
            decl.set.span,
            format!(
                "{} of `{name}` {} not bound in this machine",
                listed(missing.iter().copied()),
                if missing.len() == 1 { "is" } else { "are" },
            ),
            format!("write `{first} = ...`, where `...` is a condition over the machine's wires, such as `component.output = value`, or `false` if the machine never calls the skill"),
        );
        return None;
    }
    bound.into_iter().map(|b| b?.1).collect()
}

/// Maximum number of combinations of values that are tried to find out whether a condition can
/// hold.
const MAX_TRIED: u64 = 1 << 12;

/// Adds the rules about the calls of one coordinator to the guarantees of its contract. Does not
/// report errors; [`orders`] reports them later.
pub(super) fn guarantee<'a>(e: &Elaborator<'a>, parts: &mut Parts<'a>, scope: &Scope<'_>) {
    let mut wires = scope_of_wires(&e.names, parts);
    let orders = orders(&mut wires, parts, scope);
    if e.findings.has_errors() || wires.findings.has_errors() {
        return;
    }
    let mut first = parts.plant.len();
    for index in 0..parts.components.len() {
        let (decl, specification) = &parts.components[index];
        let outputs: Vec<VarId> = specification.outputs().collect();
        let wire = first;
        first += outputs.len();
        if !decl.is_coordinator() {
            continue;
        }
        let mut kept = Specification::clone(specification);
        for orders in &orders {
            // Converts a condition over wires to the coordinator's variables; `None` if it depends
            // on other wires than the coordinator's outputs.
            let own = |expr: &Expr| {
                let mut all = true;
                let over = expr.substitute(&mut |v, time| {
                    let output = v.index().checked_sub(wire).and_then(|o| outputs.get(o));
                    all &= output.is_some();
                    Expr::Var(output.copied().unwrap_or(VarId(0)), time)
                });
                all.then_some(over)
            };
            let when = orders.when.iter();
            let when: Vec<Option<Condition>> =
                when.map(|w| own(w).map(Condition::rising)).collect();
            // The error is ignored here, because `watches` reports a rule that is too large.
            let _ = add_rules(&mut kept, orders, &when, Party::Machine);
        }
        parts.components[index].1 = Arc::new(kept);
    }
}

/// The party that has to satisfy the rules.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Party {
    /// The rules are guarantees.
    Machine,
    /// The rules are assumptions.
    Plant,
}

/// Adds the orders to a specification, except the rules that mention a skill without a condition.
/// The definitions of the variables that the rules need always become guarantees.
fn add_rules(
    specification: &mut Specification,
    orders: &SkillOrders,
    when: &[Option<Condition>],
    party: Party,
) -> Result<(), BoundExceeded> {
    let never = || Condition::rising(Expr::FALSE);
    let conditions: Vec<Condition> = when
        .iter()
        .map(|w| w.clone().unwrap_or_else(never))
        .collect();
    for rule in rules_of(&orders.skills, orders.level) {
        let variables = &specification.variables;
        let id = VarId(variables.len() as u32);
        let taken = |name: &str| variables.iter().any(|v| v.name == name);
        let mut lowered = lower(&orders.skills, &rule, &conditions, id, taken)?;
        if !lowered.mentioned_skills.iter().all(|s| when[*s].is_some()) {
            continue;
        }
        specification.variables.extend(lowered.variable);
        if party == Party::Machine {
            // Conditions on step 0 that cannot be violated are not needed.
            let violation = |f: &Formula| f.expr.clone().not();
            lowered
                .rule
                .initial
                .retain(|f| !is_never(&violation(f), specification));
        }
        specification.guarantees.append(&lowered.definitions);
        side(specification, party).append(&lowered.rule);
    }
    for pair in at_once(&orders.skills, when, specification) {
        side(specification, party).append(&pair);
    }
    Ok(())
}

fn side(specification: &mut Specification, party: Party) -> &mut Side {
    match party {
        Party::Machine => &mut specification.guarantees,
        Party::Plant => &mut specification.assumptions,
    }
}

/// Returns formulas that forbid calling two skills of the same component at once. Pairs whose
/// conditions exclude each other need no formulas.
fn at_once(
    skills: &Skills,
    when: &[Option<Condition>],
    specification: &Specification,
) -> Vec<Side> {
    let mut found = Vec::new();
    for (b, second) in skills.skills.iter().enumerate() {
        for (a, first) in skills.skills[..b].iter().enumerate() {
            let (Some(x), Some(y)) = (&when[a], &when[b]) else {
                continue;
            };
            let both = x.holds.clone().and(y.holds.clone()).simplify();
            if first.component != second.component || is_never(&both, specification) {
                continue;
            }
            let component = &skills.components[first.component];
            let formula = |expr: Expr, when: &str| Formula {
                defines: false,
                name: format!("one skill of {} at a time{when}", component.name),
                requirement: None,
                expr: expr.simplify(),
                span: component.span,
                text: format!("never {} & {}", first.name, second.name),
            };
            let rising = x.begins().and(y.begins());
            found.push(Side {
                initial: vec![formula(both.not(), INITIAL_SUFFIX)],
                safety: vec![formula(rising.not(), "")],
                ..Side::default()
            });
        }
    }
    found
}

/// Returns whether the expression is never true. Also returns `false` if there are more than
/// [`MAX_TRIED`] combinations of values, because they are not tried then.
fn is_never(expr: &Expr, specification: &Specification) -> bool {
    let mut variables: Vec<VarId> = Vec::new();
    expr.for_each_var(&mut |v, _| {
        if !variables.contains(&v) {
            variables.push(v);
        }
    });
    let size = |v: &VarId| specification.variable(*v).domain.size();
    let count = variables.iter().map(size).try_fold(1_u64, u64::checked_mul);
    if count.is_none_or(|c| c > MAX_TRIED) {
        return false;
    }
    let mut values = vec![0; specification.variables.len()];
    for v in &variables {
        values[v.index()] = specification.variable(*v).domain.low();
    }
    loop {
        if eval::eval(expr, &values, &[]) != 0 {
            return false;
        }
        let next = variables.iter().find(|v| {
            let domain = &specification.variable(**v).domain;
            let value = &mut values[v.index()];
            *value = if *value == domain.high() {
                domain.low()
            } else {
                *value + 1
            };
            *value != domain.low()
        });
        if next.is_none() {
            return true;
        }
    }
}

/// Returns the condition that an operation has ended, and the skills whose conditions depend on the
/// requested operation. After the end of an operation, the next request is a new call of these
/// skills, even if it requests the same operation. Returns `None` if there are no such skills.
fn by_operation(model: &Machine, orders: &SkillOrders) -> Option<(Expr, Vec<usize>)> {
    let mut plant = model.plant.iter();
    let operation = plant.position(|p| matches!(p.source, PlantSource::Operation))?;
    let depends = |expr: &Expr| {
        let mut depends = false;
        expr.for_each_var(&mut |v, _| depends |= v.index() == operation);
        depends
    };
    let skills: Vec<usize> = (0..orders.when.len())
        .filter(|s| depends(&orders.when[*s]))
        .collect();
    let done = model.done.clone().filter(|_| !skills.is_empty())?;
    Some((done, skills))
}

/// Returns a Boolean input with an unused name, for the condition that the operation has ended.
fn ended_input(specification: &Specification, span: Span) -> Variable {
    let mut name = "operation_ended".to_owned();
    while specification.variables.iter().any(|v| v.name == name) {
        name.push('_');
    }
    Variable {
        name,
        owner: Owner::Environment,
        internal: false,
        domain: Domain::Bool,
        unit: String::new(),
        span,
    }
}

/// Returns one component for each skill set. It observes the calls, and its assumptions are the
/// orders of the set. Reports orders that are too large.
pub(super) fn watches(findings: &mut Findings, model: &Machine) -> Vec<Component> {
    let mut watches = Vec::new();
    for orders in &model.orders {
        let mut specification = Specification {
            name: orders.skills.name.clone(),
            timing: Timing::Mealy,
            variables: Vec::new(),
            assumptions: Side::default(),
            guarantees: Side::default(),
        };
        for skill in &orders.skills.skills {
            specification.variables.push(Variable {
                name: skill.name.clone(),
                owner: Owner::Environment,
                internal: false,
                domain: Domain::Bool,
                unit: String::new(),
                span: skill.span,
            });
        }
        let mut bindings = orders.when.clone();
        let mut when: Vec<Condition> = (0..orders.skills.skills.len() as u32)
            .map(|i| Condition::rising(Expr::now(VarId(i))))
            .collect();
        if let Some((ended, restarts)) = by_operation(model, orders) {
            let id = VarId(specification.variables.len() as u32);
            specification
                .variables
                .push(ended_input(&specification, orders.span));
            bindings.push(ended);
            for skill in restarts {
                when[skill].restarts = Expr::now(id);
            }
        }
        let when: Vec<_> = when.into_iter().map(Some).collect();
        if let Err(error) = add_rules(&mut specification, orders, &when, Party::Plant) {
            findings.error_with(
                codes::TOO_LARGE,
                orders.span,
                format!(
                    "the orders of `{}` are too large: {error}",
                    orders.skills.name
                ),
                "use fewer repetitions in sequences, or split the skill set",
            );
            continue;
        }
        let mut name = orders.skills.name.clone();
        while model.components.iter().any(|c| c.name == name) {
            name.push('_');
        }
        watches.push(Component {
            name,
            contract: orders.skills.name.clone(),
            role: Role::Watch,
            specification: Arc::new(specification),
            bindings,
            active: None,
            time: None,
            watts: RealExpr::Number(0.0),
            span: orders.span,
        });
    }
    watches
}

/// Adds a component after all others. Renumbers the variables of the machine's monitors, because
/// their ids follow those of the wires.
pub(super) fn add(model: &mut Machine, component: Component) {
    let before = model.wire_count();
    let more = component.specification.outputs().count();
    let renumber = |formulas: &mut Vec<Formula>| {
        for formula in formulas {
            formula.expr = formula.expr.substitute(&mut |v, time| {
                let offset = if v.index() < before { 0 } else { more };
                Expr::Var(VarId((v.index() + offset) as u32), time)
            });
        }
    };
    for side in [
        &mut model.guarantees.side,
        &mut model.guarantees.definitions,
    ] {
        for formulas in [
            &mut side.initial,
            &mut side.invariants,
            &mut side.safety,
            &mut side.justice,
        ] {
            renumber(formulas);
        }
    }
    model.components.push(component);
}
