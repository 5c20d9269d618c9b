//! Inner machines: their inputs, their visible outputs, and the values of their properties.
//!
//! To the outer machine, an inner machine is a component like any other. Its inputs are its plant
//! wires: the wire `operation`, its signals and its abstractions. Its outputs are the outputs of
//! the contract that it refines (the first one, if there are several), `done`, and all its wires
//! under their own names, such as `left.pick.stage`. If names clash, the output of the contract
//! takes precedence.
//!
//! The `step`, `limit`, `failures` and `write` of a machine have no effect while it is an inner
//! machine. Its `power` and `idle power`, and the times and powers of its actions, apply in the
//! outer machine, too; the powers add up.

use super::expand::{NestedTreatment, expand, is_set_early, view};
use super::properties::{PropertyType, assigned, assigned_array};
use super::{Parts, checked_call, level};
use crate::contract::elaborate::{Elaborator, Findings, nearest};
use crate::contract::instantiate;
use crate::contract::machine::{ActionTime, Machine, RealExpr};
use crate::contract::scope::Scope;
use crate::contract::shape::leaf_path;
use linewright_core::diagnostics::codes;
use linewright_core::gr1::{Expr, Specification, Timing, VarId};
use linewright_core::source::SourceMap;
use linewright_syntax::ast;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// A machine whose inner machines are not yet expanded. Each inner machine is a component of it,
/// whose contract is the inner machine's view.
#[derive(Debug, Clone)]
pub(super) struct Level {
    /// The machine, with its inner machines as components.
    pub machine: Machine,
    /// For every component, the inner machine if the component is one.
    pub nested: Vec<Option<Nested>>,
    /// For every operation, the components that it runs, each with the index of the component's
    /// operation if the component is a machine.
    pub performed: Vec<Vec<(usize, Option<usize>)>>,
    /// Properties by name: index of the first element, and type.
    pub properties: BTreeMap<String, (usize, PropertyType)>,
}

/// A machine as a component of another one.
#[derive(Debug, Clone)]
pub(super) struct Nested {
    /// Name within the outer machine.
    pub name: String,
    /// The machine before expansion.
    pub level: Level,
    /// The machine after expansion of its inner machines.
    pub flat: Machine,
    /// Outputs of the view.
    pub visible: Vec<VisibleItem>,
    /// Value of each output of the view, over the wires of the flat machine.
    pub values: Vec<Expr>,
    /// Value of each property over the properties of the outer machine; `None` if it is not bound.
    pub properties: Vec<Option<RealExpr>>,
}

/// An output of an inner machine's view.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum VisibleItem {
    /// A variable of the contract that the machine refines.
    OfContract(VarId),
    /// Whether the operation of the machine has ended.
    Done,
    /// A wire of [`Level::machine`].
    Wire(usize),
}

/// Resolves a component that is an inner machine. Returns the machine, and its view as a contract.
/// Reports an unknown machine, wrong arguments, and a machine that contains itself.
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
        let cycle: Vec<&str> = (parts.path[first..].iter().copied())
            .chain([name])
            .collect();
        e.findings.error_with(
            codes::MACHINE_IN_ITSELF,
            c.contract.span,
            format!("`{name}` contains itself: {}", cycle.join(" -> ")),
            "break the cycle: remove one of these components, or use another machine for it",
        );
        return None;
    }
    let given = instantiate::machine_arguments(e, machine, &c.arguments);
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
    let level = checked_call(&mut e.findings, c, found, "machine", inner)?;
    let flat = expand(&level, NestedTreatment::Flat, &BTreeSet::new());
    let visible = visible_items(&level.machine);
    let specification = Arc::new(view(&level.machine, &visible));
    let value = |item: &VisibleItem| match item {
        VisibleItem::OfContract(v) => flat.machine.refines[0].bindings[v.index()].clone(),
        VisibleItem::Done => flat.machine.done.clone(),
        VisibleItem::Wire(wire) => flat.values[*wire].clone(),
    };
    let values: Option<Vec<Expr>> = visible.iter().map(value).collect();
    let nested = Nested {
        name: c.name.text.clone(),
        values: values.expect("a visible item of a flat machine has no value; please report this"),
        flat: flat.machine,
        visible,
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
                "`{1}` is a contract: write `action {0}: {1}`",
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

/// Returns the outputs of a machine's view, each name once.
fn visible_items(machine: &Machine) -> Vec<VisibleItem> {
    let mut found = Vec::new();
    let mut names: BTreeSet<String> = BTreeSet::new();
    if let Some(refined) = machine.refines.first() {
        let specification = &refined.specification;
        for v in specification.outputs() {
            if refined.bindings[v.index()].is_some() {
                names.insert(leaf_path(&specification.variable(v).name).0.to_owned());
                found.push(VisibleItem::OfContract(v));
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
    /// Returns, for each output of the view, whether it is set at the beginning of a step.
    pub fn early_outputs(&self) -> Vec<bool> {
        self.values
            .iter()
            .map(|value| is_set_early(&self.flat, value))
            .collect()
    }

    /// Returns whether an input is read before the end of the step: by a Mealy component, or by the
    /// value of an output of the view.
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

    /// Converts the time of an inner action to the properties of the outer machine.
    pub fn outer_time(&self, time: &ActionTime) -> ActionTime {
        match time {
            ActionTime::PerStep(x) => ActionTime::PerStep(self.over_properties(x)),
            ActionTime::PerExecution(x) => ActionTime::PerExecution(self.over_properties(x)),
        }
    }

    /// Converts an expression over the inner machine's properties to those of the outer machine.
    pub fn over_properties(&self, value: &RealExpr) -> RealExpr {
        let property = |i: usize| {
            let bound = self.properties.get(i).cloned().flatten();
            // An unbound property on which a time or power depends has been reported. Others have
            // no effect.
            bound.unwrap_or(RealExpr::Number(self.flat.properties[i].default))
        };
        value.substitute(&property, &RealExpr::Wire)
    }

    /// Returns the number of elements of a property; 1 for a scalar.
    fn property_length(&self, name: &str) -> Option<usize> {
        let (_, ty) = self.level.properties.get(name)?;
        Some(ty.length.unwrap_or(1))
    }

    /// Returns the properties on which the times and powers of the inner actions depend.
    fn needed_properties(&self) -> BTreeSet<usize> {
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

    /// Returns the operation that an element of a sequence selects: `left.fetch`, or `left` if the
    /// machine has only one operation. Reports an element that selects no operation.
    pub fn operation(&self, findings: &mut Findings, run: &ast::Name) -> Option<usize> {
        let operations = &self.flat.operations;
        let selected = run.text.split_once('.').map(|(_, operation)| operation);
        let names: Vec<&str> = operations.iter().map(|o| o.name.as_str()).collect();
        let known = match names.as_slice() {
            [] => "this machine has no operations".to_owned(),
            names => format!("its operations are {}", names.join(", ")),
        };
        match (selected, operations.len()) {
            (None, 1) => return Some(0),
            (None, _) => findings.error_with(
                codes::OPERATION,
                run.span,
                format!("no operation of `{}` is selected", run.text),
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

/// Returns the values of an inner machine's properties, over the properties of the outer machine. A
/// value is the one to which the property is bound, otherwise the outer property of the same name,
/// type and unit, otherwise `None`.
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
        let bindings = decl.bindings.iter().filter(|b| b.name.text == *name);
        let mut has_binding = false;
        for b in bindings {
            has_binding = true;
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
        if let (false, Some((own, found))) = (has_binding, parts.property_types.get(name))
            && (&found.unit, &found.domain, found.length) == (&ty.unit, &ty.domain, ty.length)
        {
            for i in 0..length {
                bound[first + i] = Some(RealExpr::Property(own + i));
            }
        }
    }
    report_missing(&mut e.findings, decl, nested, &bound);
    bound
}

/// Reports unbound properties on which times and powers depend.
fn report_missing(
    findings: &mut Findings,
    decl: &ast::Component,
    nested: &Nested,
    bound: &[Option<RealExpr>],
) {
    if decl.broken {
        // The text that could not be parsed might contain the binding.
        findings.tainted = true;
        return;
    }
    for i in nested.needed_properties() {
        let name = &nested.flat.properties[i].name;
        let root = leaf_path(name).0;
        // A wrong binding has already been reported.
        let has_binding = decl.bindings.iter().any(|b| b.name.text == root);
        if bound[i].is_some() || has_binding && nested.property_length(root) == Some(1) {
            continue;
        }
        let inner = &decl.name.text;
        findings.error_with(
            codes::INPUT_UNBOUND,
            decl.name.span,
            format!(
                "the property `{name}` of `{inner}` is not bound, but times or powers of its actions depend on it"
            ),
            format!("write `{root} = ...` in `{inner}`, where `...` is a property or parameter of this machine, or a number"),
        );
    }
}

/// Reports settings of an inner machine that are allowed only for actions.
pub(super) fn reject_settings(findings: &mut Findings, decl: &ast::Component) {
    let settings = [
        decl.when.as_ref().map(|x| ("when", x.span)),
        decl.time.as_ref().map(|(x, _)| ("time", x.span)),
        decl.power.as_ref().map(|x| ("power", x.span)),
    ];
    for (word, span) in settings.into_iter().flatten() {
        findings.error_with(
            codes::OPERATION,
            span,
            format!(
                "`{}` is a machine; `{word}` is allowed only for actions",
                decl.name.text
            ),
            format!(
                "remove it; declare it in the actions of `{}`",
                decl.contract.text
            ),
        );
    }
}
