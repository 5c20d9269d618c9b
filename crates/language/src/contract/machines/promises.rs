//! Contracts that a machine is declared to refine, and its guarantees over all wires.

use super::component::binding;
use super::{Parts, instance};
use crate::contract::elaborate::{Elaborator, Findings, nearest};
use crate::contract::formula::{Label, classify};
use crate::contract::machine::{RefinedContract, Rules};
use crate::contract::scope::Scope;
use crate::contract::shape::leaf_path;
use linewright_core::diagnostics::codes;
use linewright_core::gr1::monitors::Monitors;
use linewright_core::gr1::{Domain, Expr, Owner, Side, Specification, VarId, Variable};
use linewright_core::source::SourceMap;
use linewright_syntax::ast::{self, MachineItem};

/// Resolves the contracts that the machine is declared to refine, with the values of their
/// variables.
pub(super) fn refined_contracts<'a>(
    e: &mut Elaborator<'a>,
    wires: &mut Elaborator<'a>,
    parts: &Parts<'a>,
    scope: &Scope<'_>,
    sources: &SourceMap,
) -> Vec<RefinedContract> {
    let machine = parts.machine;
    let decls = machine.items.iter().filter_map(|item| match item {
        MachineItem::Refines(decl) => Some(decl),
        _ => None,
    });
    let mut refined = Vec::new();
    for decl in decls {
        let Some(specification) = instance(e, scope, sources, decl) else {
            continue;
        };
        check_names(&mut wires.findings, decl, &specification);
        let bindings = bindings(wires, parts, decl, &specification);
        refined.extend(bindings.map(|bindings| RefinedContract {
            contract: decl.contract.text.clone(),
            specification,
            bindings,
            span: decl.contract.span,
        }));
    }
    refined
}

/// Reports bindings of unknown variables.
fn check_names(findings: &mut Findings, decl: &ast::Component, specification: &Specification) {
    let mut known: Vec<&str> = specification
        .variables
        .iter()
        .map(|v| leaf_path(&v.name).0)
        .collect();
    known.dedup();
    for b in &decl.bindings {
        if !known.contains(&leaf_path(&b.name.text).0) {
            let help = match nearest(&b.name.text, known.iter().copied()) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("its variables are {}", known.join(", ")),
            };
            findings.error_with(
                codes::NAME_UNKNOWN,
                b.name.span,
                format!("`{}` has no variable `{}`", decl.contract.text, b.name.text),
                help,
            );
        }
    }
}

/// Returns the value of every variable of the contract: the value to which it is bound, otherwise
/// the wire of the same name. The value is `None` for a variable of a monitor. The whole result is
/// `None` if an error was reported.
fn bindings<'a>(
    wires: &mut Elaborator<'a>,
    parts: &Parts<'a>,
    decl: &'a ast::Component,
    specification: &Specification,
) -> Option<Vec<Option<Expr>>> {
    // `binding` resolves only inputs, so all variables are treated as inputs.
    let mut all = specification.clone();
    for variable in &mut all.variables {
        variable.owner = Owner::Environment;
    }
    let names = wire_names(parts);
    let mut missing = Vec::new();
    let mut complete = true;
    let mut bound = Vec::new();
    for (i, variable) in specification.variables.iter().enumerate() {
        if specification.is_auxiliary(VarId(i as u32)) {
            bound.push(None);
            continue;
        }
        let root = leaf_path(&variable.name).0;
        let has_binding = decl
            .bindings
            .iter()
            .any(|b| leaf_path(&b.name.text).0 == root);
        if has_binding {
            let expr = binding(wires, parts, decl, &all, &all.variables[i]);
            complete &= expr.is_some();
            bound.push(expr);
        } else if let Some(wire) = wire_of(&names, &variable.name, &variable.domain) {
            bound.push(Some(Expr::now(wire)));
        } else {
            missing.push(variable.name.clone());
            continue;
        }
        if variable.owner == Owner::Environment {
            complete &= check_input(&mut wires.findings, parts, decl, variable, bound.last());
        }
    }
    if decl.broken {
        wires.findings.tainted = true;
        return None;
    }
    if !missing.is_empty() {
        wires.findings.error_with(
            codes::INPUT_UNBOUND,
            decl.contract.span,
            format!(
                "{} of `{}` {} not bound in this machine",
                listed(&missing),
                decl.contract.text,
                if missing.len() == 1 { "is" } else { "are" },
            ),
            format!(
                "write `{} = ...` after `refines {}`, where `...` is a wire of the machine, such as `component.output`",
                missing[0], decl.contract.text
            ),
        );
        return None;
    }
    complete.then_some(bound)
}

/// Checks that an input of the contract is bound only to wires that the plant sets, because the
/// contract's assumptions are about the environment. Reports other bindings, and returns `false`
/// for them.
fn check_input(
    findings: &mut Findings,
    parts: &Parts<'_>,
    decl: &ast::Component,
    variable: &Variable,
    bound: Option<&Option<Expr>>,
) -> bool {
    let mut is_plant = true;
    if let Some(Some(expr)) = bound {
        expr.for_each_var(&mut |v, _| is_plant &= v.index() < parts.plant.len());
    }
    if !is_plant {
        findings.error_with(
            codes::INPUT_UNBOUND,
            decl.contract.span,
            format!(
                "the input `{}` of `{}` is bound to an output of the machine itself",
                variable.name, decl.contract.text
            ),
            "bind it to a signal, an abstraction or `operation`: the plant has to keep the contract's assumptions about its inputs",
        );
    }
    is_plant
}

fn listed(names: &[String]) -> String {
    let quoted: Vec<String> = names.iter().map(|n| format!("`{n}`")).collect();
    quoted.join(", ")
}

/// A wire: its component (`None` for the plant), its name in the component, and its domain.
type Wire<'a> = (Option<&'a str>, &'a str, &'a Domain);

/// Returns all wires in order.
fn wire_names<'a>(parts: &'a Parts<'_>) -> Vec<Wire<'a>> {
    let mut names: Vec<Wire<'_>> = parts
        .plant
        .iter()
        .map(|p| (None, p.name.as_str(), &p.domain))
        .collect();
    for (component, specification) in &parts.components {
        names.extend(specification.outputs().map(|v| {
            let v = specification.variable(v);
            (
                Some(component.name.text.as_str()),
                v.name.as_str(),
                &v.domain,
            )
        }));
    }
    names
}

/// Returns the wire that corresponds to a variable by name and has the same domain. For the
/// variable `pick_a_stage`, it is the plant's wire `pick_a_stage`, otherwise the output `stage` of
/// `pick_a`, otherwise the output `pick_a_stage` if exactly one component has such an output.
fn wire_of(wires: &[Wire<'_>], name: &str, domain: &Domain) -> Option<VarId> {
    let only = |fits: &dyn Fn(&Wire<'_>) -> bool| -> Option<VarId> {
        let mut found = wires.iter().enumerate().filter(|(_, w)| fits(w));
        match (found.next(), found.next()) {
            (Some((i, wire)), None) if wire.2 == domain => Some(VarId(i as u32)),
            _ => None,
        }
    };
    only(&|(of, own, _)| of.is_none() && *own == name)
        .or_else(|| {
            only(&|(of, own, _)| {
                of.is_some_and(|of| {
                    let rest = name.strip_prefix(of).and_then(|r| r.strip_prefix('_'));
                    rest == Some(*own)
                })
            })
        })
        .or_else(|| only(&|(of, own, _)| of.is_some() && *own == name))
}

/// Resolves the guarantees of the machine over all wires.
pub(super) fn guarantees<'a>(
    wires: &mut Elaborator<'a>,
    parts: &Parts<'a>,
    sources: &SourceMap,
) -> Rules {
    let machine = parts.machine;
    let variables: Vec<Variable> = wire_names(parts)
        .into_iter()
        .map(|(of, name, domain)| Variable {
            name: of.map_or_else(|| name.to_owned(), |of| format!("{of}.{name}")),
            owner: match of {
                None => Owner::Environment,
                Some(_) => Owner::System,
            },
            internal: false,
            domain: domain.clone(),
            unit: String::new(),
            span: machine.header.name.span,
        })
        .collect();
    let taken = variables.iter().map(|v| v.name.clone());
    wires.memory.monitors = Some(Monitors::new(VarId(variables.len() as u32), taken));
    wires.dialect.next = true;
    let mut side = Side::default();
    let mut count = 0;
    for item in &machine.items {
        let MachineItem::Guarantee {
            name,
            requirement,
            expr,
        } = item
        else {
            continue;
        };
        count += 1;
        let label = Label {
            name: name
                .as_ref()
                .map_or_else(|| format!("guarantee {count}"), |n| n.text.clone()),
            requirement: requirement.clone(),
            guarantee: true,
            sources,
            variables: &variables,
        };
        classify(wires, expr, &label, &mut side);
    }
    wires.dialect.next = false;
    let mut rules = Rules {
        side,
        ..Rules::default()
    };
    if let Some(monitors) = wires.memory.monitors.take() {
        rules.monitors = monitors.variables().cloned().collect();
        monitors.define(&mut rules.definitions);
    }
    rules
}
