//! Instantiation: converts the syntax tree of a contract and its arguments to a specification.

use super::elaborate::{Elaborator, Findings, fitted};
use super::formula::{Label, classify};
use super::scope::{self, Decl, Scope, duplicate_name};
use super::shape::measured;
use super::value::{Term, Type, Value};
use super::{Contract, TaxonomyCode};
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::gr1::monitors::Monitors;
use linewright_core::gr1::{Domain, Owner, Side, Specification, Timing, VarId, Variable};
use linewright_core::source::{SourceMap, Span};
use linewright_core::taxonomy;
use linewright_syntax::ast::{self, ContractItem, Ownership};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Argument values and their positions, by name.
pub(super) type Arguments = BTreeMap<String, (Value, Span)>;

/// Evaluates the arguments of a machine in the caller's scope, as [`arguments`] does. A parameter
/// of the machine's operations is no parameter of the machine; the finding says where to set it.
pub(super) fn machine_arguments<'a>(
    caller: &mut Elaborator<'a>,
    machine: &ast::Machine,
    given: &'a [ast::Argument],
) -> Arguments {
    let of_operations = |name: &str| {
        let mut properties = machine.items.iter().filter_map(|item| match item {
            ast::MachineItem::Parameter(p) => Some(p),
            _ => None,
        });
        properties.any(|p| p.name.text == name).then(|| {
            format!("it is set where an operation is performed: `perform OPERATION({name} = ...)`")
        })
    };
    let header = &machine.header;
    evaluate(
        caller,
        &header.parameters,
        given,
        &header.name.text,
        &of_operations,
    )
}

/// Evaluates arguments in the caller's scope. A label is looked up in the type of the parameter.
/// Reports unknown and duplicate arguments.
pub(super) fn arguments<'a>(
    caller: &mut Elaborator<'a>,
    parameters: &[ast::Parameter],
    given: &'a [ast::Argument],
    callee: &str,
) -> Arguments {
    evaluate(caller, parameters, given, callee, &|_| None)
}

/// Evaluates arguments. `help` returns the way out for an unknown name, if there is a better one
/// than to list the parameters.
fn evaluate<'a>(
    caller: &mut Elaborator<'a>,
    parameters: &[ast::Parameter],
    given: &'a [ast::Argument],
    callee: &str,
    help: &dyn Fn(&str) -> Option<String>,
) -> Arguments {
    let mut result = Arguments::new();
    for argument in given {
        let name = &argument.name;
        if !parameters.iter().any(|p| p.name.text == name.text) {
            let known = parameters.iter().map(|p| p.name.text.as_str());
            let near = super::elaborate::nearest(&name.text, known.clone());
            let help = match near {
                _ if let Some(better) = help(&name.text) => better,
                Some(near) => format!("did you mean `{near}`?"),
                None if parameters.is_empty() => format!("`{callee}` has no parameters"),
                None => format!(
                    "its parameters are {}",
                    known.collect::<Vec<_>>().join(", ")
                ),
            };
            caller.findings.error_with(
                codes::ARGUMENT,
                name.span,
                format!("`{callee}` has no parameter `{}`", name.text),
                help,
            );
            continue;
        }
        if let Some((_, first)) = result.get(&name.text) {
            let first = *first;
            caller.findings.push(duplicate_name(name, first));
            continue;
        }
        // A label is looked up in the type of the parameter.
        let declared = parameters.iter().find(|p| p.name.text == name.text);
        let expected = declared.and_then(|p| match &p.domain.kind {
            ast::DomainKind::Labels(labels) => {
                Some(Type::Enum(labels.iter().map(|l| l.text.clone()).collect()))
            }
            ast::DomainKind::Named(ty) => caller.names.types.get(&ty.text).cloned(),
            _ => None,
        });
        if let Some(value) = caller.value(
            &argument.value,
            expected.as_ref(),
            linewright_core::gr1::Time::Now,
        ) {
            result.insert(name.text.clone(), (value, argument.value.span));
        }
    }
    result
}

/// Brings parameters into scope, with the values of the arguments or the defaults, and returns
/// their values. A wrong value is reported and replaced by the smallest value of the domain, so
/// that the rest can be checked. Returns `None` if a parameter has no value or no valid domain.
pub(super) fn bind<'a>(
    e: &mut Elaborator<'a>,
    parameters: &'a [ast::Parameter],
    given: &Arguments,
    call: Option<Span>,
) -> Option<Vec<(String, i64)>> {
    let mut values = Vec::new();
    let mut complete = true;
    for p in parameters {
        let Some((domain, unit, length)) = e.measured_domain(&p.domain) else {
            complete = false;
            continue;
        };
        if length.is_some() {
            e.findings.error_with(
                codes::TYPE_MISMATCH,
                p.domain.span,
                "a parameter has to be a number, a truth value or a label",
                "declare a constant array, or one parameter for each element",
            );
        }
        let ty = measured(&domain, unit);
        let (value, place) = match (given.get(&p.name.text), &p.default) {
            (Some((value, span)), _) => (Some(value.clone()), *span),
            (None, Some(default)) => (
                e.value(default, Some(&ty), linewright_core::gr1::Time::Now),
                default.span,
            ),
            (None, None) => {
                e.findings.push(missing(p, call));
                complete = false;
                continue;
            }
        };
        let number = value
            .and_then(|v| checked(&mut e.findings, p, &v, &ty, &domain, place))
            .unwrap_or(domain.low());
        e.names
            .constants
            .insert(p.name.text.clone(), Value::Scalar(Term::Int(number), ty));
        values.push((p.name.text.clone(), number));
    }
    complete.then_some(values)
}

fn missing(parameter: &ast::Parameter, call: Option<Span>) -> Diagnostic {
    let name = &parameter.name;
    let message = format!("the parameter `{}` has no value", name.text);
    match call {
        Some(call) => Diagnostic::error(codes::ARGUMENT, call, message)
            .with_help(format!("add `{} = ...`", name.text)),
        None => Diagnostic::note(codes::ARGUMENT, name.span, message).with_help(
            "give it a default: without one, the declaration is checked only where it is used",
        ),
    }
}

/// Returns the value of a parameter; reports a value of the wrong type or outside the domain.
fn checked(
    findings: &mut Findings,
    parameter: &ast::Parameter,
    value: &Value,
    ty: &Type,
    domain: &Domain,
    place: Span,
) -> Option<i64> {
    let name = &parameter.name.text;
    match value {
        Value::Scalar(Term::Int(i), found) if found == ty => {
            if domain.contains(*i) {
                return Some(*i);
            }
            findings.error_with(
                codes::ARGUMENT,
                place,
                format!("{i} is outside the range of `{name}`"),
                format!("its range is {}", domain.describe()),
            );
        }
        Value::Scalar(
            term @ (Term::Int(_) | Term::Real(_)),
            found @ (Type::Number(_) | Type::Measured(_)),
        ) if found != ty && matches!(ty, Type::Measured(_)) => {
            let term = fitted(place, (term.clone(), found.clone()), ty, findings)?;
            let value = Value::Scalar(term, ty.clone());
            return checked(findings, parameter, &value, ty, domain, place);
        }
        Value::Scalar(Term::Int(_) | Term::Real(_), found) if found != ty => findings.error_with(
            codes::ARGUMENT,
            place,
            format!("`{name}` is {}, not {}", ty.describe(), found.describe()),
            format!("its values are {}", domain.describe()),
        ),
        _ => findings.error_with(
            codes::NOT_CONSTANT,
            place,
            format!("the value of `{name}` has to be constant"),
            "use numbers, constants and parameters only",
        ),
    }
    None
}

/// Converts taxonomy codes, and reports unknown ones.
pub(super) fn taxonomy_codes(
    names: &[ast::Name],
    findings: &mut Vec<Diagnostic>,
) -> Vec<TaxonomyCode> {
    names
        .iter()
        .map(|name| {
            if let Err(help) = taxonomy::lookup(&name.text) {
                findings.push(
                    Diagnostic::error(
                        codes::TAXONOMY_UNKNOWN,
                        name.span,
                        format!("`{}` is not in the taxonomy", name.text),
                    )
                    .with_help(help),
                );
            }
            TaxonomyCode {
                text: name.text.clone(),
                span: name.span,
            }
        })
        .collect()
}

/// Returns the taxonomy codes of a contract or machine, without checking them.
pub(super) fn stated_codes(header: &ast::Header) -> Vec<TaxonomyCode> {
    header
        .codes
        .iter()
        .map(|c| TaxonomyCode {
            text: c.text.clone(),
            span: c.span,
        })
        .collect()
}

/// Instantiates a contract with these arguments. Returns `None` if there is an error, which is
/// added to the findings. `call` is the position at which the contract is used with these
/// arguments.
pub(super) fn instantiate(
    scope: &Scope<'_>,
    sources: &SourceMap,
    contract: &ast::Contract,
    given: &Arguments,
    call: Option<Span>,
    findings: &mut Vec<Diagnostic>,
) -> Option<Contract> {
    let mut e = scope.elaborator();
    e.dialect.next = true;
    let arguments = bind(&mut e, &contract.header.parameters, given, call);
    let Some(arguments) = arguments else {
        findings.append(&mut e.findings.list);
        return None;
    };
    let mut variables: Vec<Variable> = Vec::new();
    let mut places: BTreeMap<&str, Span> = contract
        .header
        .parameters
        .iter()
        .map(|p| (p.name.text.as_str(), p.name.span))
        .collect();
    declare(&mut e, contract, &mut variables, &mut places);
    let taken = places.keys().map(|name| (*name).to_owned());
    e.memory.monitors = Some(Monitors::new(VarId(variables.len() as u32), taken));
    let mut sides = [Side::default(), Side::default()];
    let mut counts = [0usize; 2];
    let mut rules: BTreeMap<&str, Span> = BTreeMap::new();
    for item in &contract.items {
        let ContractItem::Formula {
            guarantee,
            name,
            requirement,
            expr,
        } = item
        else {
            continue;
        };
        let side = usize::from(*guarantee);
        counts[side] += 1;
        let word = if *guarantee {
            "guarantee"
        } else {
            "assumption"
        };
        if let Some(name) = name {
            if let Some(first) = rules.get(name.text.as_str()) {
                e.findings.push(duplicate_name(name, *first));
            }
            rules.insert(&name.text, name.span);
        }
        let label = Label {
            name: name
                .as_ref()
                .map_or_else(|| format!("{word} {}", counts[side]), |n| n.text.clone()),
            requirement: requirement.clone(),
            guarantee: *guarantee,
            sources,
            variables: &variables,
        };
        classify(&mut e, expr, &label, &mut sides[side]);
    }
    let broken = e.findings.has_errors();
    findings.append(&mut e.findings.list);
    if broken {
        return None;
    }
    let [assumptions, mut guarantees] = sides;
    if let Some(monitors) = &e.memory.monitors {
        monitors.define(&mut guarantees);
        variables.extend(monitors.variables().cloned());
    }
    Some(Contract {
        name: contract.header.name.text.clone(),
        doc: contract.header.doc.clone(),
        codes: stated_codes(&contract.header),
        arguments,
        specification: Arc::new(Specification {
            name: contract.header.name.text.clone(),
            timing: if contract.moore {
                Timing::Moore
            } else {
                Timing::Mealy
            },
            variables,
            assumptions,
            guarantees,
        }),
        span: contract.header.name.span,
    })
}

/// Brings the types, constants, variables, counters and defines of the contract into scope. Reports
/// duplicate names.
pub(super) fn declare<'a>(
    e: &mut Elaborator<'a>,
    contract: &'a ast::Contract,
    variables: &mut Vec<Variable>,
    places: &mut BTreeMap<&'a str, Span>,
) {
    let mut fresh = |e: &mut Elaborator<'_>, name: &'a ast::Name| {
        if let Some(first) = places.get(name.text.as_str()) {
            e.findings.push(duplicate_name(name, *first));
            return false;
        }
        places.insert(&name.text, name.span);
        true
    };
    let mut decls = Vec::new();
    for item in &contract.items {
        match item {
            ContractItem::Type(decl) if fresh(e, &decl.name) => decls.push(Decl::Type(decl)),
            ContractItem::Const(decl) if fresh(e, &decl.name) => decls.push(Decl::Constant(decl)),
            _ => {}
        }
    }
    scope::evaluate_all(e, &decls);
    for item in &contract.items {
        match item {
            ContractItem::Variables {
                ownership,
                names,
                domain,
            } => {
                let shape = e.shape(domain);
                for name in names {
                    if !fresh(e, name) {
                        continue;
                    }
                    // A variable hides outer declarations of the same name.
                    e.names.hide(&name.text);
                    let Some(shape) = &shape else {
                        e.names.broken.insert(name.text.clone());
                        continue;
                    };
                    // Each leaf counts as 32 nodes, because a variable is much more expensive for
                    // later stages than a node of an expression.
                    if e.expansion
                        .spend(name.span, 32 * shape.leaf_count(), &mut e.findings)
                        .is_none()
                    {
                        continue;
                    }
                    let entry = shape.declare(name.text.clone(), &mut |leaf, domain, unit| {
                        variables.push(Variable {
                            name: leaf,
                            owner: if *ownership == Ownership::Input {
                                Owner::Environment
                            } else {
                                Owner::System
                            },
                            internal: *ownership == Ownership::Internal,
                            domain: domain.clone(),
                            unit: unit.map(|u| u.name().to_owned()).unwrap_or_default(),
                            span: name.span,
                        });
                        e.variables.add(domain.clone(), unit)
                    });
                    e.names.variables.insert(name.text.clone(), entry);
                }
            }
            ContractItem::Counter(counter) if fresh(e, &counter.name) => {
                let name = &counter.name.text;
                e.names.constants.remove(name);
                e.names.counters.insert(name.clone(), counter);
            }
            ContractItem::Define(define) if fresh(e, &define.name) => {
                e.findings.list.extend(scope::duplicate_formals(define));
                let name = &define.name.text;
                e.names.constants.remove(name);
                e.names.defines.insert(name.clone(), define);
            }
            _ => {}
        }
    }
}
