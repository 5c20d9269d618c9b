//! Inner machines: their visible outputs, their inputs, and the use of their numbers.
//!
//! From outside, an inner machine is a component like others. Its inputs are its plant wires: the
//! wire `operation`, its signals and its abstractions. Its outputs are the outputs of the contract
//! that it refines (the first, if there are several), `done`, and all its wires under their own
//! names: `left.pick.stage`. If names are equal, the contract's takes precedence.
//!
//! Its `step`, `limit`, `failures`, `write` and `idle power` apply only when it works alone. The
//! times and powers of its actions, and its power in addition to them, apply in the outer machine
//! as well.

use super::expand::{NestedTreatment, answers_first, expand, view};
use super::properties::{PropertyType, assigned, assigned_array};
use super::{Parts, called, level};
use crate::contract::elaborate::{Elaborator, Findings, nearest};
use crate::contract::instantiate;
use crate::contract::machine::{ActionTime, Machine, RealExpr};
use crate::contract::scope::Scope;
use crate::contract::shape::way;
use linewright_core::diagnostics::codes;
use linewright_core::gr1::{Expr, Specification, Timing, VarId};
use linewright_core::source::SourceMap;
use linewright_syntax::ast;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// A machine as written: an inner machine is a component whose contract is its view.
#[derive(Debug, Clone)]
pub(super) struct Level {
    /// Machine of the level.
    pub machine: Machine,
    /// For every component, its inner machine, if it is one.
    pub nested: Vec<Option<Nested>>,
    /// For every operation the components that it runs, each with the operation of that component
    /// if it is a machine.
    pub performed: Vec<Vec<(usize, Option<usize>)>>,
    /// Types of properties by name, with the index of the first element.
    pub properties: BTreeMap<String, (usize, PropertyType)>,
}

/// A machine as a component of another one.
#[derive(Debug, Clone)]
pub(super) struct Nested {
    /// Name within the outer machine.
    pub name: String,
    /// The machine with its layers.
    pub level: Level,
    /// The machine without layers.
    pub flat: Machine,
    /// Meaning of each output of its view.
    pub seen: Vec<VisibleItem>,
    /// Value of each output of its view, over the wires of the flat machine.
    pub values: Vec<Expr>,
    /// Properties over those of the outer machine, where they are bound.
    pub properties: Vec<Option<RealExpr>>,
}

/// An output of a machine's view.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum VisibleItem {
    /// A variable of the contract that it refines.
    Promised(VarId),
    /// Whether its operation is done.
    Done,
    /// A wire of its level.
    Wire(usize),
}

/// Returns the inner machine of a component, with its view as a contract; reports errors of the
/// call.
pub(super) fn nested<'a>(
    e: &mut Elaborator<'a>,
    parts: &Parts<'a>,
    scope: &Scope<'_>,
    sources: &SourceMap,
    c: &'a ast::Component,
) -> Option<(Nested, Arc<Specification>)> {
    let Some(machine) = scope.machines.get(c.contract.text.as_str()) else {
        unknown(&mut e.findings, scope, c);
        return None;
    };
    let name = machine.header.name.text.as_str();
    if let Some(first) = parts.path.iter().position(|p| *p == name) {
        let circle: Vec<&str> = (parts.path[first..].iter().copied())
            .chain([name])
            .collect();
        e.findings.error_with(
            codes::MACHINE_IN_ITSELF,
            c.contract.span,
            format!("`{name}` contains itself: {}", circle.join(" -> ")),
            "a machine is made of smaller ones: leave one of them out, or give it a machine of its own",
        );
        return None;
    }
    let given = instantiate::arguments(
        e,
        &machine.header.parameters,
        &c.arguments,
        &c.contract.text,
    );
    let mut found = Vec::new();
    let inner = level(
        scope,
        sources,
        machine,
        &given,
        Some(c.contract.span),
        &parts.path,
        &mut found,
    );
    let level = called(&mut e.findings, c, found, "machine", inner)?;
    let flat = expand(&level, NestedTreatment::Flat, &BTreeSet::new());
    let seen = seen(&level.machine);
    let specification = Arc::new(view(&level.machine, &seen));
    let value = |seen: &VisibleItem| match seen {
        VisibleItem::Promised(v) => flat.machine.refines[0].bindings[v.index()].clone(),
        VisibleItem::Done => flat.machine.done.clone(),
        VisibleItem::Wire(wire) => flat.values[*wire].clone(),
    };
    let values: Option<Vec<Expr>> = seen.iter().map(value).collect();
    let nested = Nested {
        name: c.name.text.clone(),
        values: values.expect("all that is seen of a flat machine; please report this"),
        flat: flat.machine,
        seen,
        properties: Vec::new(),
        level,
    };
    Some((nested, specification))
}

fn unknown(findings: &mut Findings, scope: &Scope<'_>, c: &ast::Component) {
    let known = scope.machines.keys().copied();
    let help = match nearest(&c.contract.text, known) {
        _ if scope.contracts.contains_key(c.contract.text.as_str()) => {
            format!(
                "it is a contract: write `action {}: {}`",
                c.name.text, c.contract.text
            )
        }
        Some(near) => format!("did you mean `{near}`?"),
        None => "import the file that declares it".to_owned(),
    };
    findings.error_with(
        codes::NAME_UNKNOWN,
        c.contract.span,
        format!("there is no machine `{}`", c.contract.text),
        help,
    );
}

/// Returns everything visible of a machine, each name once.
fn seen(machine: &Machine) -> Vec<VisibleItem> {
    let mut found = Vec::new();
    let mut names: BTreeSet<String> = BTreeSet::new();
    if let Some(promised) = machine.refines.first() {
        let specification = &promised.specification;
        for v in specification.outputs() {
            if promised.bindings[v.index()].is_some() {
                names.insert(way(&specification.variable(v).name).0.to_owned());
                found.push(VisibleItem::Promised(v));
            }
        }
    }
    if machine.done.is_some() && names.insert("done".to_owned()) {
        found.push(VisibleItem::Done);
    }
    let mut wire = machine.plant.len();
    for component in &machine.components {
        let specification = &component.specification;
        let hidden = names.contains(&component.name);
        for v in specification.outputs() {
            if !hidden && !specification.is_auxiliary(v) {
                found.push(VisibleItem::Wire(wire));
            }
            wire += 1;
        }
    }
    found
}

impl Nested {
    /// Returns which outputs of the view are set from the beginning of a step.
    pub fn early(&self) -> Vec<bool> {
        self.values
            .iter()
            .map(|value| answers_first(&self.flat, value))
            .collect()
    }

    /// Returns whether an input is read before the end of the step: by components that read before
    /// they answer, or by an output of the view itself.
    pub fn is_read_early(&self, input: usize) -> bool {
        let reads = |expr: &Expr| {
            let mut found = false;
            expr.for_each_var(&mut |v, _| found |= v.index() == input);
            found
        };
        let mealy = |timing| timing == Timing::Mealy;
        let components = self
            .flat
            .components
            .iter()
            .filter(|c| mealy(c.specification.timing))
            .flat_map(|c| &c.bindings);
        components.chain(&self.values).any(reads)
    }

    /// Returns a time of one of its actions, over the properties of the outer machine.
    pub fn timed(&self, time: &ActionTime) -> ActionTime {
        match time {
            ActionTime::PerStep(x) => ActionTime::PerStep(self.over_properties(x)),
            ActionTime::PerExecution(x) => ActionTime::PerExecution(self.over_properties(x)),
        }
    }

    /// Converts an expression over its properties to those of the outer machine.
    pub fn over_properties(&self, value: &RealExpr) -> RealExpr {
        let property = |i: usize| {
            let bound = self.properties.get(i).cloned().flatten();
            // Unbound ones were reported.
            bound.unwrap_or(RealExpr::Number(self.flat.properties[i].default))
        };
        value.substitute(&property, &RealExpr::Wire)
    }

    /// Returns the number of elements of a property.
    fn properties_of(&self, name: &str) -> Option<usize> {
        let (_, ty) = self.level.properties.get(name)?;
        Some(ty.length.unwrap_or(1))
    }

    /// Returns the properties that times and powers of its actions depend on.
    fn needed(&self) -> BTreeSet<usize> {
        let mut found = BTreeSet::new();
        let mut see = |x: &RealExpr| {
            x.for_each(&mut |x| {
                if let RealExpr::Property(i) = x {
                    found.insert(*i);
                }
            });
        };
        for component in &self.flat.components {
            see(&component.watts);
            if let Some(ActionTime::PerStep(x) | ActionTime::PerExecution(x)) = &component.time {
                see(x);
            }
        }
        found
    }

    /// Returns the operation that an element of a sequence names: `left.fetch`, or `left` if there
    /// is only one.
    pub fn operation(&self, findings: &mut Findings, run: &ast::Name) -> Option<usize> {
        let operations = &self.flat.operations;
        let said = run.text.split_once('.').map(|(_, operation)| operation);
        let names: Vec<&str> = operations.iter().map(|o| o.name.as_str()).collect();
        let known = match names.as_slice() {
            [] => "it is a machine without operations".to_owned(),
            names => format!("its operations are {}", names.join(", ")),
        };
        match (said, operations.len()) {
            (None, 1) => return Some(0),
            (None, _) => findings.error_with(
                codes::OPERATION,
                run.span,
                format!("which operation of `{}` runs here is not said", run.text),
                match names.first() {
                    Some(first) => format!("write `{}.{first}`; {known}", run.text),
                    None => known,
                },
            ),
            (Some(operation), _) => {
                if let Some(place) = names.iter().position(|n| *n == operation) {
                    return Some(place);
                }
                findings.error_with(
                    codes::NAME_UNKNOWN,
                    run.span,
                    format!("`{}` has no operation `{operation}`", self.name),
                    match nearest(operation, names.iter().copied()) {
                        Some(near) => format!("did you mean `{}.{near}`?", self.name),
                        None => known,
                    },
                );
            }
        }
        None
    }
}

/// Returns the values of an inner machine's properties in the outer one: as declared, else the
/// property of the same name.
pub(super) fn bind_properties<'a>(
    e: &mut Elaborator<'a>,
    parts: &Parts<'a>,
    decl: &'a ast::Component,
    nested: &Nested,
) -> Vec<Option<RealExpr>> {
    let mut bound = vec![None; nested.flat.properties.len()];
    let count = parts.properties.len();
    for (name, (first, ty)) in &nested.level.properties {
        let length = ty.length.unwrap_or(1);
        let said = decl.bindings.iter().filter(|b| b.name.text == *name);
        let mut is_said = false;
        for b in said {
            is_said = true;
            let element = PropertyType {
                length: None,
                ..ty.clone()
            };
            let (start, terms) = match (ty.length, b.index) {
                (None, None) => (*first, assigned(e, &element, &b.value).map(|t| vec![t])),
                (Some(n), None) => (*first, assigned_array(e, &element, n, &b.value)),
                (Some(n), Some(i)) if (0..n as i64).contains(&i) => {
                    let term = assigned(e, &element, &b.value);
                    (first + i as usize, term.map(|t| vec![t]))
                }
                _ => {
                    e.findings.error_with(
                        codes::INDEX_RANGE,
                        b.name.span,
                        format!("the property `{name}` has no such element"),
                        format!("write `{name} = ...`"),
                    );
                    continue;
                }
            };
            for (i, term) in terms.unwrap_or_default().into_iter().enumerate() {
                bound[start + i] = Some(term.to_real(count));
            }
        }
        if let (false, Some((own, found))) = (is_said, parts.property_types.get(name))
            && (&found.unit, &found.domain, found.length) == (&ty.unit, &ty.domain, ty.length)
        {
            for i in 0..length {
                bound[first + i] = Some(RealExpr::Property(own + i));
            }
        }
    }
    missing(&mut e.findings, decl, nested, &bound);
    bound
}

/// Reports unbound properties that times and powers depend on.
fn missing(
    findings: &mut Findings,
    decl: &ast::Component,
    nested: &Nested,
    bound: &[Option<RealExpr>],
) {
    if decl.broken {
        // A part that could not be parsed may bind it.
        findings.tainted = true;
        return;
    }
    for i in nested.needed() {
        let name = &nested.flat.properties[i].name;
        let root = way(name).0;
        // A wrong binding was reported.
        let said = decl.bindings.iter().any(|b| b.name.text == root);
        if bound[i].is_some() || said && nested.properties_of(root) == Some(1) {
            continue;
        }
        let inner = &decl.name.text;
        findings.error_with(
            codes::INPUT_UNBOUND,
            decl.name.span,
            format!(
                "the property `{name}` of `{inner}` is bound to nothing, and what its actions take depends on it"
            ),
            format!("write `{root} = ...` in `{inner}`: a property or parameter of this machine, or a number"),
        );
    }
}

/// Reports settings that apply to actions and not to machines.
pub(super) fn no_settings(findings: &mut Findings, decl: &ast::Component) {
    let said = [
        decl.when.as_ref().map(|x| ("when", x.span)),
        decl.time.as_ref().map(|(x, _)| ("time", x.span)),
        decl.power.as_ref().map(|x| ("power", x.span)),
    ];
    for (word, span) in said.into_iter().flatten() {
        findings.error_with(
            codes::OPERATION,
            span,
            format!(
                "`{}` is a machine; `{word}` belongs to actions",
                decl.name.text
            ),
            format!(
                "leave it out here; the actions of `{}` say it themselves",
                decl.contract.text
            ),
        );
    }
}
