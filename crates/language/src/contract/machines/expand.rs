//! Expansion of layers to one flat machine.
//!
//! A machine is first resolved as written: an inner machine is a component whose outputs are
//! everything visible of it ([`Nested`]). This module replaces such components, in one of two ways:
//!
//! - *flat*, for execution: by the inner machine's components, called `left.pick`;
//! - *abstracted*, for proofs: by one component with the contract that the inner machine refines.
//!   Wires that others read and that the contract does not mention become unconstrained outputs of
//!   that component. An inner machine that refines nothing is replaced by its components here, too.
//!
//! Both use the same traversal: wires are renumbered, and every expression is converted to the new
//! numbers.

use super::nested::{Level, Nested, VisibleItem};
use crate::contract::machine::{
    Component, Inner, Layers, Machine, Orders, RealExpr, RefinedContract, Role, Rules,
};
use linewright_core::gr1::{
    Expr, Formula, Owner, Side, Specification, Time, Timing, VarId, Variable,
};
use std::collections::BTreeSet;
use std::sync::Arc;

/// How inner machines are replaced.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum NestedTreatment {
    /// By all their components.
    Flat,
    /// By the contracts that they refine.
    Abstracted,
}

/// A machine without layers.
pub(super) struct FlatMachine {
    /// Resulting machine.
    pub machine: Machine,
    /// Value of every wire of the level, over the machine's wires; `None` if it was not requested.
    pub values: Vec<Option<Expr>>,
}

/// Replacement of a component.
enum Piece<'l> {
    /// The component itself.
    Own(&'l Component),
    /// A machine, as the contract that it refines.
    Promise {
        component: Box<Component>,
        /// Output of the component for each output of the view.
        outputs: Vec<Option<usize>>,
    },
    /// A machine, as its components.
    Parts {
        inner: &'l Nested,
        expanded: Box<FlatMachine>,
    },
}

impl Piece<'_> {
    fn components(&self) -> &[Component] {
        match self {
            Self::Own(component) => std::slice::from_ref(component),
            Self::Promise { component, .. } => std::slice::from_ref(&**component),
            Self::Parts { expanded, .. } => &expanded.machine.components,
        }
    }
}

/// Returns the machine of a level with its layers expanded; a machine without inner ones is
/// unchanged.
pub(super) fn finish(level: Level) -> Machine {
    if level.nested.iter().all(Option::is_none) {
        return level.machine;
    }
    let mut flat = expand(&level, NestedTreatment::Flat, &BTreeSet::new()).machine;
    let abstracted = expand(&level, NestedTreatment::Abstracted, &BTreeSet::new()).machine;
    let spans: Vec<_> = level.machine.components.iter().map(|c| c.span).collect();
    let nested = level.nested.into_iter().zip(spans);
    let inner = nested.filter_map(|(nested, span)| {
        let nested = nested?;
        Some(Inner {
            name: nested.name,
            machine: Arc::new(finish(nested.level)),
            span,
        })
    });
    flat.layers = Layers {
        inner: inner.collect(),
        abstracted: Some(Arc::new(abstracted)),
    };
    flat
}

/// Expands the layers. `wanted` are wires of the level that are read from outside.
pub(super) fn expand(level: &Level, how: NestedTreatment, wanted: &BTreeSet<usize>) -> FlatMachine {
    let mut read = mentioned(&level.machine, how);
    read.extend(wanted);
    let components = level.machine.components.iter().zip(&level.nested);
    let pieces: Vec<Piece<'_>> = components
        .enumerate()
        .map(|(index, (component, nested))| match nested {
            None => Piece::Own(component),
            Some(inner) => {
                let first = level.machine.first_wire(index);
                let outputs = 0..inner.seen.len();
                let read = outputs.filter(|o| read.contains(&(first + o))).collect();
                piece(inner, component, how, &read)
            }
        })
        .collect();
    let places = Places::new(level, &pieces);
    let count = level.machine.wire_count();
    let values: Vec<Option<Expr>> = (0..count).map(|w| places.wire(w)).collect();
    FlatMachine {
        machine: assemble(level, how, &places, &values),
        values,
    }
}

fn piece<'l>(
    inner: &'l Nested,
    component: &Component,
    how: NestedTreatment,
    read: &BTreeSet<usize>,
) -> Piece<'l> {
    if let (NestedTreatment::Abstracted, Some(promised)) = (how, inner.flat.refines.first()) {
        return promise(inner, promised, component, read);
    }
    let mut wanted = BTreeSet::new();
    for output in read {
        if let VisibleItem::Wire(wire) = inner.seen[*output] {
            wanted.insert(wire);
        }
    }
    Piece::Parts {
        inner,
        expanded: Box::new(expand(&inner.level, how, &wanted)),
    }
}

/// Returns one component with the contract, and with the additional wires that are read.
fn promise<'l>(
    inner: &Nested,
    promised: &RefinedContract,
    component: &Component,
    read: &BTreeSet<usize>,
) -> Piece<'l> {
    let mut specification = Specification::clone(&promised.specification);
    let own: Vec<VarId> = specification.outputs().collect();
    let known = |expr: &Expr| {
        let is = |v: &VarId| promised.bindings[v.index()].as_ref() == Some(expr);
        own.iter().position(is)
    };
    let mut outputs = vec![None; inner.seen.len()];
    let mut count = own.len();
    for &output in read {
        let found = match inner.seen[output] {
            VisibleItem::Promised(v) => own.iter().position(|o| *o == v),
            VisibleItem::Done | VisibleItem::Wire(_) => known(&inner.values[output]),
        };
        outputs[output] = Some(found.unwrap_or_else(|| {
            let variable = &component.specification.variable(inner.output(output));
            specification.variables.push((*variable).clone());
            count += 1;
            count - 1
        }));
    }
    specification.timing = inner.timing(promised);
    // Inputs that the contract takes from outside, through those of the inner machine.
    let inputs = promised.specification.inputs();
    let bindings = inputs.filter_map(|v| {
        let binding = promised.bindings[v.index()].as_ref()?;
        Some(binding.substitute(&mut |w, _| component.bindings[w.index()].clone()))
    });
    Piece::Promise {
        component: Box::new(Component {
            contract: promised.contract.clone(),
            bindings: bindings.collect(),
            specification: Arc::new(specification),
            ..component.clone()
        }),
        outputs,
    }
}

/// Positions in the new machine.
struct Places<'l> {
    level: &'l Level,
    pieces: &'l [Piece<'l>],
    /// For every component of every piece, its index among the new components.
    indices: Vec<Vec<usize>>,
    /// First wire of every new component.
    firsts: Vec<usize>,
    /// Number of wires.
    count: usize,
}

impl<'l> Places<'l> {
    /// Assigns the positions. Coordinators of all layers come first, since they answer before all
    /// others. Watches come last, since they see all others.
    fn new(level: &'l Level, pieces: &'l [Piece<'l>]) -> Self {
        let all = pieces.iter().enumerate().flat_map(|(i, piece)| {
            let components = piece.components().iter().enumerate();
            components.map(move |(k, c)| (c.role, i, k))
        });
        let mut order: Vec<(Role, usize, usize)> = all.collect();
        order.sort_unstable();
        let mut indices: Vec<Vec<usize>> = pieces
            .iter()
            .map(|p| vec![0; p.components().len()])
            .collect();
        let mut firsts = Vec::new();
        let mut count = level.machine.plant.len();
        for (place, (_, i, k)) in order.into_iter().enumerate() {
            indices[i][k] = place;
            firsts.push(count);
            count += pieces[i].components()[k].specification.outputs().count();
        }
        Self {
            level,
            pieces,
            indices,
            firsts,
            count,
        }
    }

    /// Returns a wire of the level.
    fn wire(&self, wire: usize) -> Option<Expr> {
        let machine = &self.level.machine;
        if wire < machine.plant.len() {
            return Some(Expr::now(VarId(wire as u32)));
        }
        let firsts = (0..self.pieces.len()).map(|i| machine.first_wire(i));
        let index = firsts.enumerate().take_while(|(_, f)| *f <= wire).last()?.0;
        let output = wire - machine.first_wire(index);
        match &self.pieces[index] {
            Piece::Own(_) => Some(self.output(index, 0, output)),
            Piece::Promise { outputs, .. } => Some(self.output(index, 0, outputs[output]?)),
            Piece::Parts { inner, expanded } => {
                let expr = match inner.seen[output] {
                    VisibleItem::Wire(wire) => expanded.values[wire].clone()?,
                    VisibleItem::Done => expanded.machine.done.clone()?,
                    VisibleItem::Promised(v) => {
                        let promised = expanded.machine.refines.first()?;
                        promised.bindings[v.index()].clone()?
                    }
                };
                Some(self.inside(index, &expr))
            }
        }
    }

    fn output(&self, index: usize, part: usize, output: usize) -> Expr {
        Expr::now(VarId(
            (self.firsts[self.indices[index][part]] + output) as u32,
        ))
    }

    /// Converts an expression over a level's wires.
    fn over(&self, expr: &Expr) -> Expr {
        expr.substitute(&mut |w, time| {
            let value = self
                .wire(w.index())
                .expect("a wire that was asked for; please report this");
            at(&value, time)
        })
    }

    /// Converts an expression over the wires of an expanded inner machine.
    fn inside(&self, index: usize, expr: &Expr) -> Expr {
        let Piece::Parts { expanded, .. } = &self.pieces[index] else {
            return self.over(expr);
        };
        expr.substitute(&mut |w, time| at(&self.inner_wire(index, &expanded.machine, w), time))
    }

    fn inner_wire(&self, index: usize, machine: &Machine, wire: VarId) -> Expr {
        let wire = wire.index();
        if wire < machine.plant.len() {
            return self.over(&self.level.machine.components[index].bindings[wire]);
        }
        let firsts = (0..machine.components.len()).map(|k| (k, machine.first_wire(k)));
        let (part, first) = firsts
            .take_while(|(_, first)| *first <= wire)
            .last()
            .expect("a wire of this machine; please report this");
        self.output(index, part, wire - first)
    }
}

fn at(expr: &Expr, time: Time) -> Expr {
    expr.substitute(&mut |w, _| Expr::Var(w, time))
}

/// Returns the level's wires that are read within it.
fn mentioned(machine: &Machine, how: NestedTreatment) -> BTreeSet<usize> {
    let mut found = BTreeSet::new();
    let mut see = |expr: &Expr| {
        expr.for_each_var(&mut |v, _| {
            found.insert(v.index());
        });
    };
    for component in &machine.components {
        component.bindings.iter().for_each(&mut see);
        component.active.iter().for_each(&mut see);
    }
    machine.done.iter().for_each(&mut see);
    let rules = [&machine.guarantees.side, &machine.guarantees.definitions];
    for formula in rules.into_iter().flat_map(Side::all) {
        see(&formula.expr);
    }
    for promised in &machine.refines {
        promised.bindings.iter().flatten().for_each(&mut see);
    }
    for orders in &machine.orders {
        orders.when.iter().for_each(&mut see);
    }
    if how == NestedTreatment::Flat {
        for (_, value) in &machine.writes {
            value.for_each(&mut |x| {
                if let RealExpr::Wire(wire) = x {
                    found.insert(*wire);
                }
            });
        }
    }
    found
}

fn assemble(
    level: &Level,
    how: NestedTreatment,
    places: &Places<'_>,
    values: &[Option<Expr>],
) -> Machine {
    let old = &level.machine;
    let mut components: Vec<Option<Component>> = vec![None; places.firsts.len()];
    for (index, piece) in places.pieces.iter().enumerate() {
        for (part, component) in piece.components().iter().enumerate() {
            let place = places.indices[index][part];
            components[place] = Some(placed(
                places,
                index,
                piece,
                component,
                &old.components[index],
            ));
        }
    }
    let wire = |w: usize| {
        let value = values[w].as_ref();
        RealExpr::of_wires(value.expect("a wire that was asked for; please report this"))
    };
    let writes = match how {
        NestedTreatment::Flat => old
            .writes
            .iter()
            .map(|(p, x)| (*p, x.substitute(&RealExpr::Property, &wire)))
            .collect(),
        // Proofs know nothing of a part's numbers.
        NestedTreatment::Abstracted => Vec::new(),
    };
    let nested = || level.nested.iter().flatten();
    Machine {
        components: components.into_iter().flatten().collect(),
        writes,
        operations: old
            .operations
            .iter()
            .zip(&level.performed)
            .map(
                |(operation, performed)| crate::contract::machine::Operation {
                    sequence: performed
                        .iter()
                        .flat_map(|p| sequence(places, *p))
                        .collect(),
                    ..operation.clone()
                },
            )
            .collect(),
        done: old.done.as_ref().map(|done| places.over(done)),
        base_watts: old.base_watts + nested().map(|n| n.flat.base_watts).sum::<f64>(),
        idle_watts: old.idle_watts + nested().map(|n| n.flat.idle_watts).sum::<f64>(),
        refines: old
            .refines
            .iter()
            .map(|promised| RefinedContract {
                bindings: promised
                    .bindings
                    .iter()
                    .map(|b| b.as_ref().map(|b| places.over(b)))
                    .collect(),
                ..promised.clone()
            })
            .collect(),
        guarantees: rules(&old.guarantees, old.wire_count(), places),
        orders: orders(&old.orders, places),
        ..old.clone()
    }
}

/// Returns the skills that the machine calls, and those of the inner machines that were expanded.
fn orders(own: &[Orders], places: &Places<'_>) -> Vec<Orders> {
    let over = |orders: &Orders| Orders {
        when: orders.when.iter().map(|e| places.over(e)).collect(),
        ..orders.clone()
    };
    let mut all: Vec<Orders> = own.iter().map(over).collect();
    for (index, piece) in places.pieces.iter().enumerate() {
        let Piece::Parts { inner, expanded } = piece else {
            continue;
        };
        all.extend(expanded.machine.orders.iter().map(|orders| {
            Orders {
                when: orders
                    .when
                    .iter()
                    .map(|e| places.inside(index, e))
                    .collect(),
                of: match orders.of.as_str() {
                    "" => inner.name.clone(),
                    deeper => format!("{}.{deeper}", inner.name),
                },
                ..orders.clone()
            }
        }));
    }
    all
}

/// Returns a component at its new position. `holder` is the inner machine's own path.
fn placed(
    places: &Places<'_>,
    index: usize,
    piece: &Piece<'_>,
    component: &Component,
    holder: &Component,
) -> Component {
    let over = |expr: &Expr| places.inside(index, expr);
    let mut placed = Component {
        bindings: component.bindings.iter().map(over).collect(),
        active: component.active.as_ref().map(over),
        ..component.clone()
    };
    if let Piece::Parts { inner, .. } = piece {
        placed.name = format!("{}.{}", inner.name, component.name);
        placed.time = component.time.as_ref().map(|t| inner.timed(t));
        placed.watts = inner.over_properties(&component.watts);
        placed.span = holder.span;
    }
    placed
}

/// Returns the components that an operation runs.
fn sequence(places: &Places<'_>, (index, operation): (usize, Option<usize>)) -> Vec<usize> {
    let new = &places.indices[index];
    match (&places.pieces[index], operation) {
        (Piece::Parts { expanded, .. }, Some(operation)) => {
            let performed = &expanded.machine.operations[operation].sequence;
            performed.iter().map(|part| new[*part]).collect()
        }
        (Piece::Parts { .. }, None) => Vec::new(),
        (Piece::Own(_) | Piece::Promise { .. }, _) => vec![new[0]],
    }
}

/// Converts the machine's own guarantees: the variables of monitors follow the wires.
fn rules(rules: &Rules, before: usize, places: &Places<'_>) -> Rules {
    let put = |formulas: &[Formula]| -> Vec<Formula> {
        let moved = formulas.iter().map(|f| Formula {
            expr: f
                .expr
                .substitute(&mut |v, time| match v.index().checked_sub(before) {
                    Some(monitor) => Expr::Var(VarId((places.count + monitor) as u32), time),
                    None => places.over(&Expr::Var(v, time)),
                }),
            ..f.clone()
        });
        moved.collect()
    };
    let side = |side: &Side| Side {
        initial: put(&side.initial),
        invariants: put(&side.invariants),
        safety: put(&side.safety),
        justice: put(&side.justice),
    };
    Rules {
        side: side(&rules.side),
        monitors: rules.monitors.clone(),
        definitions: side(&rules.definitions),
    }
}

impl Nested {
    /// Returns the timing of a contract that replaces a machine. A `moore` contract alone does not
    /// make it a Moore machine: all its outputs must be bound to components that answer first.
    fn timing(&self, promised: &RefinedContract) -> Timing {
        let specification = &promised.specification;
        let first = specification.outputs().all(|v| {
            let binding = promised.bindings[v.index()].as_ref();
            binding.is_none_or(|b| answers_first(&self.flat, b))
        });
        match (specification.timing, first) {
            (Timing::Moore, true) => Timing::Moore,
            _ => Timing::Mealy,
        }
    }

    /// Returns the variable of an output of the view.
    fn output(&self, output: usize) -> VarId {
        VarId((self.level.machine.plant.len() + output) as u32)
    }
}

/// Returns whether all wires that an expression reads are set from the beginning of the step.
pub(super) fn answers_first(machine: &Machine, expr: &Expr) -> bool {
    let mut first = true;
    expr.for_each_var(&mut |v, _| {
        let wire = v.index();
        first &= wire >= machine.plant.len()
            && (0..machine.components.len())
                .rev()
                .find(|c| machine.first_wire(*c) <= wire)
                .is_some_and(|c| machine.components[c].specification.timing == Timing::Moore);
    });
    first
}

/// Returns everything visible of a machine from outside, as a contract without formulas: its plant
/// wires are the inputs.
pub(super) fn view(machine: &Machine, seen: &[VisibleItem]) -> Specification {
    let inputs = machine.plant.iter().map(|input| Variable {
        name: input.name.clone(),
        owner: Owner::Environment,
        internal: false,
        domain: input.domain.clone(),
        unit: input.unit.clone(),
        span: input.span,
    });
    let outputs = seen.iter().map(|seen| {
        let (name, domain, unit, span) = match seen {
            VisibleItem::Promised(v) => {
                let variable = machine.refines[0].specification.variable(*v);
                let Variable {
                    name,
                    domain,
                    unit,
                    span,
                    ..
                } = variable;
                (name.clone(), domain.clone(), unit.clone(), *span)
            }
            VisibleItem::Done => {
                let domain = linewright_core::gr1::Domain::Bool;
                ("done".to_owned(), domain, String::new(), machine.span)
            }
            VisibleItem::Wire(wire) => (
                machine.wire_name(*wire),
                machine.wire_domain(*wire).clone(),
                wire_unit(machine, *wire),
                machine.span,
            ),
        };
        Variable {
            name,
            owner: Owner::System,
            internal: false,
            domain,
            unit,
            span,
        }
    });
    Specification {
        name: machine.name.clone(),
        timing: Timing::Mealy,
        variables: inputs.chain(outputs).collect(),
        assumptions: Side::default(),
        guarantees: Side::default(),
    }
}

fn wire_unit(machine: &Machine, wire: usize) -> String {
    let outputs = machine.components.iter().flat_map(|c| {
        let specification = &c.specification;
        specification.outputs().map(|v| specification.variable(v))
    });
    let mut outputs = outputs.skip(wire - machine.plant.len());
    outputs.next().map_or_else(String::new, |v| v.unit.clone())
}
