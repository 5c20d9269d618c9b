//! Expansion of inner machines.
//!
//! A machine is first resolved with each inner machine as one component. The outputs of this
//! component are what the outer machine can read ([`Nested`]). This module then replaces the
//! component in one of two ways:
//!
//! - *flat*, for execution: by the inner machine's components, with names such as `left.pick`;
//! - *abstracted*, for proofs: by one component with the contract that the inner machine refines.
//!   Wires that are read outside of the inner machine, but do not occur in the contract, become
//!   unconstrained outputs of that component. An inner machine without such a contract is replaced
//!   by its components.
//!
//! Both use the same traversal: wires are renumbered, and every expression is converted to the new
//! numbers.

use super::nested::{Level, Nested, VisibleItem};
use crate::contract::machine::{
    Component, InnerMachine, Layers, Machine, PlantInput, RealExpr, RefinedContract, Role, Rules,
    SkillOrders,
};
use linewright_core::gr1::{
    Expr, Formula, Owner, Side, Specification, Time, Timing, VarId, Variable,
};
use std::collections::BTreeSet;
use std::sync::Arc;

/// How inner machines are replaced.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum NestedTreatment {
    /// Each inner machine is replaced by all of its components.
    Flat,
    /// Each inner machine is replaced by the contract that it refines or, if it refines none, by
    /// its components.
    Abstracted,
}

/// A machine after expansion.
pub(super) struct FlatMachine {
    /// Resulting machine.
    pub machine: Machine,
    /// Value of every wire of the [`Level`], over the wires of `machine`; `None` for a wire that
    /// was not requested.
    pub values: Vec<Option<Expr>>,
}

/// What replaces a component of a [`Level`].
enum Piece<'l> {
    /// The component itself, because it is not an inner machine.
    Own(&'l Component),
    /// An inner machine, as one component with the contract that it refines.
    Contract {
        /// The component.
        component: Box<Component>,
        /// For each output of the view, the index of the component's output with the same value;
        /// `None` if the output is not read.
        outputs: Vec<Option<usize>>,
    },
    /// An inner machine, replaced by its components.
    Parts {
        inner: &'l Nested,
        expanded: Box<FlatMachine>,
    },
}

impl Piece<'_> {
    fn components(&self) -> &[Component] {
        match self {
            Self::Own(component) => std::slice::from_ref(component),
            Self::Contract { component, .. } => std::slice::from_ref(&**component),
            Self::Parts { expanded, .. } => &expanded.machine.components,
        }
    }
}

/// Expands a level to a flat machine, and adds its abstraction. A machine without inner machines is
/// unchanged.
pub(super) fn finish(level: Level) -> Machine {
    if level.nested.iter().all(Option::is_none) {
        return level.machine;
    }
    let mut flat = expand(&level, NestedTreatment::Flat, &BTreeSet::new()).machine;
    let abstraction = expand(&level, NestedTreatment::Abstracted, &BTreeSet::new()).machine;
    let spans: Vec<_> = level.machine.components.iter().map(|c| c.span).collect();
    let nested = level.nested.into_iter().zip(spans);
    let inner = nested.filter_map(|(nested, span)| {
        let nested = nested?;
        Some(InnerMachine {
            name: nested.name,
            machine: Arc::new(finish(nested.level)),
            span,
        })
    });
    flat.layers = Layers {
        inner: inner.collect(),
        abstraction: Some(Arc::new(abstraction)),
    };
    flat
}

/// Expands the inner machines of a level. `requested` contains the wires of the level that are read
/// from outside.
pub(super) fn expand(
    level: &Level,
    how: NestedTreatment,
    requested: &BTreeSet<usize>,
) -> FlatMachine {
    let mut read = mentioned(&level.machine, how);
    read.extend(requested);
    let components = level.machine.components.iter().zip(&level.nested);
    let pieces: Vec<Piece<'_>> = components
        .enumerate()
        .map(|(index, (component, nested))| match nested {
            None => Piece::Own(component),
            Some(inner) => {
                let first = level.machine.first_wire(index);
                let outputs = 0..inner.visible.len();
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

/// Returns the replacement of an inner machine. `read` contains the outputs of its view that are
/// read.
fn piece<'l>(
    inner: &'l Nested,
    component: &Component,
    how: NestedTreatment,
    read: &BTreeSet<usize>,
) -> Piece<'l> {
    if let (NestedTreatment::Abstracted, Some(refined)) = (how, inner.flat.refines.first()) {
        return contract_piece(inner, refined, component, read);
    }
    let mut requested = BTreeSet::new();
    for output in read {
        if let VisibleItem::Wire(wire) = inner.visible[*output] {
            requested.insert(wire);
        }
    }
    Piece::Parts {
        inner,
        expanded: Box::new(expand(&inner.level, how, &requested)),
    }
}

/// Replaces an inner machine by one component with the contract that it refines. Values that are
/// read but do not occur in the contract become additional outputs of the component.
fn contract_piece<'l>(
    inner: &Nested,
    refined: &RefinedContract,
    component: &Component,
    read: &BTreeSet<usize>,
) -> Piece<'l> {
    let mut specification = Specification::clone(&refined.specification);
    let own: Vec<VarId> = specification.outputs().collect();
    let known = |expr: &Expr| {
        let is = |v: &VarId| refined.bindings[v.index()].as_ref() == Some(expr);
        own.iter().position(is)
    };
    let mut outputs = vec![None; inner.visible.len()];
    let mut count = own.len();
    for &output in read {
        let found = match inner.visible[output] {
            VisibleItem::OfContract(v) => own.iter().position(|o| *o == v),
            VisibleItem::Done | VisibleItem::Wire(_) => known(&inner.values[output]),
        };
        outputs[output] = Some(found.unwrap_or_else(|| {
            let variable = &component.specification.variable(inner.output(output));
            specification.variables.push((*variable).clone());
            count += 1;
            count - 1
        }));
    }
    specification.timing = inner.timing(refined);
    // The inputs of the contract are bound to expressions over the wires of the outer machine.
    let inputs = refined.specification.inputs();
    let bindings = inputs.filter_map(|v| {
        let binding = refined.bindings[v.index()].as_ref()?;
        Some(binding.substitute(&mut |w, _| component.bindings[w.index()].clone()))
    });
    Piece::Contract {
        component: Box::new(Component {
            contract: refined.contract.clone(),
            bindings: bindings.collect(),
            specification: Arc::new(specification),
            ..component.clone()
        }),
        outputs,
    }
}

/// Positions of components and wires in the expanded machine.
struct Places<'l> {
    level: &'l Level,
    pieces: &'l [Piece<'l>],
    /// For every component of every piece, its index in the expanded machine.
    indices: Vec<Vec<usize>>,
    /// First wire of every component of the expanded machine.
    firsts: Vec<usize>,
    /// Number of wires.
    count: usize,
}

impl<'l> Places<'l> {
    /// Assigns the positions. Coordinators of all layers come first, because they set their outputs
    /// before all other components. Watches come last, because they read the outputs of all other
    /// components.
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

    /// Returns the value of a wire of the level over the wires of the expanded machine; `None` if
    /// the wire was not requested.
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
            Piece::Contract { outputs, .. } => Some(self.output(index, 0, outputs[output]?)),
            Piece::Parts { inner, expanded } => {
                let expr = match inner.visible[output] {
                    VisibleItem::Wire(wire) => expanded.values[wire].clone()?,
                    VisibleItem::Done => expanded.machine.done.clone()?,
                    VisibleItem::OfContract(v) => {
                        let refined = expanded.machine.refines.first()?;
                        refined.bindings[v.index()].clone()?
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

    /// Converts an expression over the wires of the level to the wires of the expanded machine.
    fn over(&self, expr: &Expr) -> Expr {
        expr.substitute(&mut |w, time| {
            let value = self
                .wire(w.index())
                .expect("a requested wire was not declared; please report this");
            at(&value, time)
        })
    }

    /// Converts an expression over the wires of an expanded inner machine to the wires of the
    /// expanded outer machine.
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
            .expect("the wire is not one of this machine; please report this");
        self.output(index, part, wire - first)
    }
}

fn at(expr: &Expr, time: Time) -> Expr {
    expr.substitute(&mut |w, _| Expr::Var(w, time))
}

/// Returns the wires that are read within a machine.
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
    for refined in &machine.refines {
        refined.bindings.iter().flatten().for_each(&mut see);
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
        RealExpr::of_wires(value.expect("a requested wire was not declared; please report this"))
    };
    let writes = match how {
        NestedTreatment::Flat => old
            .writes
            .iter()
            .map(|(p, x)| (*p, x.substitute(&RealExpr::Property, &wire)))
            .collect(),
        // The abstraction needs no writes, because proofs do not refer to properties of parts.
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
            .map(|refined| RefinedContract {
                bindings: refined
                    .bindings
                    .iter()
                    .map(|b| b.as_ref().map(|b| places.over(b)))
                    .collect(),
                ..refined.clone()
            })
            .collect(),
        guarantees: rules(&old.guarantees, old.wire_count(), places),
        orders: orders(&old.orders, places),
        ..old.clone()
    }
}

/// Returns the skill sets that the machine calls, and those that expanded inner machines call.
fn orders(own: &[SkillOrders], places: &Places<'_>) -> Vec<SkillOrders> {
    let over = |orders: &SkillOrders| SkillOrders {
        when: orders.when.iter().map(|e| places.over(e)).collect(),
        ..orders.clone()
    };
    let mut all: Vec<SkillOrders> = own.iter().map(over).collect();
    for (index, piece) in places.pieces.iter().enumerate() {
        let Piece::Parts { inner, expanded } = piece else {
            continue;
        };
        all.extend(expanded.machine.orders.iter().map(|orders| {
            SkillOrders {
                when: orders
                    .when
                    .iter()
                    .map(|e| places.inside(index, e))
                    .collect(),
                caller: match orders.caller.as_str() {
                    "" => inner.name.clone(),
                    deeper => format!("{}.{deeper}", inner.name),
                },
                ..orders.clone()
            }
        }));
    }
    all
}

/// Converts a component of a piece to its position in the expanded machine. `holder` is the
/// component that the piece replaces.
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
        placed.time = component.time.as_ref().map(|t| inner.outer_time(t));
        placed.watts = inner.over_properties(&component.watts);
        placed.span = holder.span;
    }
    placed
}

/// Returns the components of the expanded machine that run for one element of an operation's
/// sequence.
fn sequence(places: &Places<'_>, (index, operation): (usize, Option<usize>)) -> Vec<usize> {
    let new = &places.indices[index];
    match (&places.pieces[index], operation) {
        (Piece::Parts { expanded, .. }, Some(operation)) => {
            let performed = &expanded.machine.operations[operation].sequence;
            performed.iter().map(|part| new[*part]).collect()
        }
        (Piece::Parts { .. }, None) => Vec::new(),
        (Piece::Own(_) | Piece::Contract { .. }, _) => vec![new[0]],
    }
}

/// Converts the machine's guarantees. The ids of monitor variables follow those of wires; `before`
/// is the number of wires before the expansion.
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
    /// Returns the timing of the component that replaces this machine. It is a Moore component if
    /// the contract is `moore`, and all of its outputs depend only on Moore components of the
    /// machine.
    fn timing(&self, refined: &RefinedContract) -> Timing {
        let specification = &refined.specification;
        let first = specification.outputs().all(|v| {
            let binding = refined.bindings[v.index()].as_ref();
            binding.is_none_or(|b| is_set_early(&self.flat, b))
        });
        match (specification.timing, first) {
            (Timing::Moore, true) => Timing::Moore,
            _ => Timing::Mealy,
        }
    }

    /// Returns the id of an output of the view in the view's specification.
    fn output(&self, output: usize) -> VarId {
        VarId((self.level.machine.plant.len() + output) as u32)
    }
}

/// Returns whether all wires that an expression reads are set at the beginning of the step, by
/// Moore components.
pub(super) fn is_set_early(machine: &Machine, expr: &Expr) -> bool {
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

/// Returns the view of a machine: a contract without formulas, with the machine's plant wires as
/// inputs and the visible items as outputs.
pub(super) fn view(machine: &Machine, visible: &[VisibleItem]) -> Specification {
    let inputs = machine.plant.iter().map(PlantInput::variable);
    let outputs = visible.iter().map(|item| {
        let (name, domain, unit, span) = match item {
            VisibleItem::OfContract(v) => {
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
