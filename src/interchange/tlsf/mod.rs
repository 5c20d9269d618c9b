//! Reads `.tlsf` files: the Temporal Logic Synthesis Format, basic and full.
//!
//! Source: Jacobs, Klein and Schirmer, "A High-Level LTL Synthesis Format: TLSF v1.1", SYNT 2016.
//!
//! ```text
//! text ─lexer→ words ─parser→ ast::File ─expand→ ltl::Formulas ─normal→ parts ─classify→ pieces of GR(1) ─meaning→ Specification
//! ```
//!
//! The format is that of LTL synthesis, so not every file is one of GR(1): what is left over after the equivalences of [`normal`] and
//! [`classify`] is refused, at the smallest part that has none. A bus becomes a Boolean variable an element, `HBURST[0]`.
//!
//! The parser bounds the nesting of expressions, the expansion its depth, its steps and the size of what it makes. Definitions may call
//! themselves thousands of times, so all of it runs on a stack of its own.

mod ast;
mod automaton;
mod classify;
mod expand;
mod expression;
mod lexer;
mod ltl;
mod meaning;
mod normal;
mod parser;
mod report;
mod value;

use crate::diagnostics::{Diagnostic, codes, has_errors};
use crate::gr1::interval::{Interval, interval};
use crate::gr1::monitors::Monitors;
use crate::gr1::{Domain, Owner, Side, Specification, Timing, VarId, Variable};
use crate::interchange::names::quoted;
use crate::source::{FileId, Span};
use ast::{File, Section, Semantics, Shape};
use classify::Classifier;
use expand::{Expander, Globals};
pub(super) use expression::is_reserved;
use ltl::{Op, Place};
use meaning::{Meaning, Wish};
use report::Report;
use std::collections::BTreeMap;
use std::rc::Rc;
use value::Value;

/// Bytes of stack: the expansion's bound on depth times what a level needs, generously.
const STACK: usize = 256 << 20;
/// So many signals may be declared, buses counted by their elements.
const MAX_SIGNALS: usize = 4096;

/// Reads a text. What could not be understood is in the findings.
pub(super) fn read(name: &str, file: FileId, text: &str) -> (Specification, Vec<Diagnostic>) {
    std::thread::scope(|scope| {
        let builder = std::thread::Builder::new().stack_size(STACK);
        let reader = builder.spawn_scoped(scope, || read_here(name, file, text));
        match reader.map(std::thread::ScopedJoinHandle::join) {
            Ok(Ok(found)) => found,
            Ok(Err(panic)) => std::panic::resume_unwind(panic),
            Err(error) => {
                let finding = Diagnostic::error(
                    codes::GAVE_UP,
                    Span::new(file, 0, 0),
                    format!("there is no room to read this file: {error}"),
                );
                (empty(name), vec![finding])
            }
        }
    })
}

fn empty(name: &str) -> Specification {
    Specification {
        name: name.to_owned(),
        timing: Timing::Mealy,
        variables: Vec::new(),
        assumptions: Side::default(),
        guarantees: Side::default(),
    }
}

fn read_here(name: &str, file: FileId, text: &str) -> (Specification, Vec<Diagnostic>) {
    let mut report = Report::new(file);
    let tokens = lexer::words(text, &mut report);
    let tree = parser::Parser::new(text, &tokens, &mut report).file();
    if has_errors(&report.findings) {
        return (empty(name), report.findings);
    }
    let specification = understood(name, &tree, text, &mut report);
    (
        specification.unwrap_or_else(|| empty(name)),
        report.findings,
    )
}

/// What the file says; `None` where that was reported.
fn understood(name: &str, file: &File, text: &str, report: &mut Report) -> Option<Specification> {
    let Some(semantics) = file.semantics else {
        report.syntax(
            0..0,
            "INFO does not say which semantics is meant",
            "write `SEMANTICS: Mealy`, or Moore, or one of them with `,Strict` behind it",
        );
        return None;
    };
    let globals = declared(file, report);
    let mut expander = Expander::new(globals, report);
    let variables = signals(file, &mut expander)?;
    let mut wishes = domains(file, &mut expander);
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for entry in &file.entries {
        let count = counts.entry(&entry.heading).or_default();
        *count += 1;
        if let Ok(formula) = expander.formula(&entry.tree) {
            wishes.push(Wish {
                section: entry.section,
                name: format!("{} {count}", entry.heading),
                formula,
            });
        }
        if expander.formulas.too_large {
            let range = entry.tree.range.clone();
            expander.report.error(
                codes::TOO_LARGE,
                range,
                "this formula becomes too large once its definitions are written out",
                "give the parameters smaller values, or split it",
            );
            return None;
        }
    }
    let Expander {
        mut formulas,
        sites,
        report,
        ..
    } = expander;
    if has_errors(&report.findings) {
        return None;
    }
    let moore = file.target.unwrap_or(semantics.moore);
    let wishes = moved(wishes, &mut formulas, semantics, moore, &variables);
    // The variable for broken promises stands between signals and monitors.
    let broken = VarId(variables.len() as u32);
    let first = VarId(broken.0 + 1);
    let names = variables.iter().map(|v| v.name.clone());
    let monitors = Monitors::new(first, names);
    let mut classifier = Classifier::new(&mut formulas, monitors, first.0, broken);
    let timing = if moore { Timing::Moore } else { Timing::Mealy };
    let sides = Meaning {
        classifier: &mut classifier,
        report,
        sites: &sites,
        text,
        variables: &variables,
        timing,
        strict: semantics.strict,
    }
    .sides(wishes);
    if has_errors(&report.findings) {
        return None;
    }
    let span = report.span(&(0..0));
    let specification = meaning::specification(name, timing, variables, sides, &classifier, span);
    bounded(&specification, report).then_some(specification)
}

/// Definitions, enumerations and labels by their names.
fn declared<'f>(file: &'f File, report: &mut Report) -> Globals<'f> {
    let mut globals = Globals {
        definitions: BTreeMap::new(),
        enumerations: &file.enumerations,
        labels: BTreeMap::new(),
        signals: BTreeMap::new(),
    };
    let twice = |report: &mut Report, name: &str, place: &std::ops::Range<usize>| {
        report.error(
            codes::NAME_DOUBLE,
            place.clone(),
            format!("`{}` is declared twice", quoted(name)),
            "give one of the two another name, or another number of arguments",
        );
    };
    for definition in &file.definitions {
        let key = (definition.name.as_str(), definition.arguments.len());
        if globals.definitions.insert(key, definition).is_some() {
            twice(report, &definition.name, &definition.place);
        }
    }
    for (e, enumeration) in file.enumerations.iter().enumerate() {
        let mut others: Vec<(&str, &Vec<Option<bool>>)> = Vec::new();
        for (l, label) in enumeration.labels.iter().enumerate() {
            if globals.labels.insert(&label.name, (e, l)).is_some() {
                twice(report, &label.name, &label.place);
            }
            for code in &label.codes {
                let clash = others.iter().find(|(_, other)| {
                    { code.iter().zip(*other) }.all(|(a, b)| a.is_none() || b.is_none() || a == b)
                });
                if let Some((other, _)) = clash {
                    report.error(
                        codes::TYPE_MISMATCH,
                        label.place.clone(),
                        format!(
                            "`{}` has a code that `{}` has, too",
                            quoted(&label.name),
                            quoted(other)
                        ),
                        "give each value codes of its own",
                    );
                }
                others.push((&label.name, code));
            }
        }
    }
    globals
}

/// Declares the signals: a variable an element.
fn signals<'f>(file: &'f File, expander: &mut Expander<'f, '_>) -> Option<Vec<Variable>> {
    let mut variables: Vec<Variable> = Vec::new();
    for signal in &file.signals {
        let width = match &signal.shape {
            Shape::Single => None,
            Shape::Bus(size) => {
                let Ok(number) = expander.number(size) else {
                    continue;
                };
                if number < 0 || number > MAX_SIGNALS as i64 {
                    expander.report.error(
                        codes::DOMAIN_EMPTY,
                        size.range.clone(),
                        format!("a bus cannot have {number} signals"),
                        format!("it has 0 to {MAX_SIGNALS}"),
                    );
                    continue;
                }
                Some(number as usize)
            }
            Shape::Typed(kind, place) => {
                let known = file.enumerations.iter().find(|e| e.name == *kind);
                let Some(enumeration) = known else {
                    expander.report.error(
                        codes::NAME_UNKNOWN,
                        place.clone(),
                        format!("there is no enumeration `{}`", quoted(kind)),
                        "define it under DEFINITIONS: `enum name = A: 0  B: 1`, or end the signal before it with `;`",
                    );
                    continue;
                };
                Some(enumeration.width)
            }
        };
        let first = variables.len();
        let span = expander.report.span(&signal.place);
        let mut declare = |name: String| {
            variables.push(Variable {
                name,
                owner: if signal.input {
                    Owner::Environment
                } else {
                    Owner::System
                },
                internal: false,
                domain: Domain::Bool,
                unit: String::new(),
                span,
            });
            VarId(variables.len() as u32 - 1)
        };
        let value = match width {
            None => {
                let id = declare(signal.name.clone());
                let place = Place::new(&signal.place, 0);
                Value::Formula(expander.formulas.make(Op::Atom(id), place))
            }
            Some(width) => {
                let bits = (0..width).map(|k| declare(format!("{}[{k}]", signal.name)));
                Value::Bus(Rc::new(bits.collect()))
            }
        };
        let globals = &mut expander.globals;
        let name = signal.name.as_str();
        let double = globals.signals.insert(name, value).is_some()
            || globals.definitions.contains_key(&(name, 0))
            || globals.labels.contains_key(name);
        if double {
            expander.report.error(
                codes::NAME_DOUBLE,
                signal.place.clone(),
                format!("`{}` is declared twice", quoted(name)),
                "give one of the two another name",
            );
        }
        if variables.len() > MAX_SIGNALS {
            expander.report.error(
                codes::TOO_LARGE,
                signal.place.clone(),
                format!("these are more than {MAX_SIGNALS} signals"),
                "give the parameters smaller values",
            );
            variables.truncate(first);
            return None;
        }
    }
    if variables.is_empty() {
        expander.report.syntax(
            0..0,
            "no signal is declared",
            "name at least one in INPUTS or OUTPUTS",
        );
        return None;
    }
    Some(variables)
}

/// A bus of an enumeration shows one of its values: that is required of inputs and asserted of outputs.
fn domains<'f>(file: &'f File, expander: &mut Expander<'f, '_>) -> Vec<Wish> {
    let mut found = Vec::new();
    for signal in &file.signals {
        let Shape::Typed(kind, _) = &signal.shape else {
            continue;
        };
        let known = file.enumerations.iter().find(|e| e.name == *kind);
        let bus = expander.globals.signals.get(signal.name.as_str()).cloned();
        let (Some(enumeration), Some(Value::Bus(bits))) = (known, bus) else {
            continue;
        };
        let codes: Vec<Vec<Option<bool>>> = { enumeration.labels.iter() }
            .flat_map(|l| l.codes.clone())
            .collect();
        // Codes do not overlap, so they cover everything exactly if their numbers add up.
        let free = |code: &Vec<Option<bool>>| code.iter().filter(|b| b.is_none()).count();
        let power = |bits: usize| 1_u128.checked_shl(u32::try_from(bits).unwrap_or(u32::MAX));
        let covered = codes.iter().map(|c| power(free(c)).unwrap_or(u128::MAX));
        let covered = covered.fold(0, u128::saturating_add);
        if power(enumeration.width) == Some(covered) {
            continue;
        }
        let formula = expander.coded(&bits, &codes, Place::new(&signal.place, 0));
        found.push(Wish {
            section: if signal.input {
                Section::Require
            } else {
                Section::Assert
            },
            name: format!("{} is a value of {}", signal.name, enumeration.name),
            formula,
        });
    }
    found
}

/// The formulas for the machine that is wanted, where they were written for the other one.
fn moved(
    wishes: Vec<Wish>,
    formulas: &mut ltl::Formulas,
    semantics: Semantics,
    moore: bool,
    variables: &[Variable],
) -> Vec<Wish> {
    if semantics.moore == moore {
        return wishes;
    }
    let of = |owner: Owner| move |v: VarId| variables[v.index()].owner == owner;
    // The side that is read later, and the other one, which may as well be read earlier.
    let (later, other) = if moore {
        (Owner::System, Owner::Environment)
    } else {
        (Owner::Environment, Owner::System)
    };
    let all = wishes
        .iter()
        .all(|w| formulas.all_delayed(w.formula, &of(other)));
    let moved = wishes.into_iter().map(|w| Wish {
        formula: if all {
            formulas.undelayed(w.formula, &of(other))
        } else {
            formulas.delayed(w.formula, &of(later))
        },
        ..w
    });
    moved.collect()
}

/// Later stages walk formulas by recursion and bound their numbers.
fn bounded(specification: &Specification, report: &mut Report) -> bool {
    let sides = [&specification.assumptions, &specification.guarantees];
    let mut fine = true;
    for formula in sides.into_iter().flat_map(Side::all) {
        let domain = |v: VarId| Interval::of(&specification.variable(v).domain);
        if depth(&formula.expr) > super::terms::MAX_DEPTH
            || interval(&formula.expr, &domain).is_err()
        {
            let finding = Diagnostic::error(
                codes::TOO_LARGE,
                formula.span,
                "this formula nests too deep",
            )
            .with_help("give parts of it outputs of their own");
            report.push(finding);
            fine = false;
        }
    }
    fine
}

/// The recursion is as deep as the expression, on this reader's stack.
fn depth(e: &crate::gr1::Expr) -> u32 {
    use crate::gr1::Expr;
    1 + match e {
        Expr::Const(_) | Expr::Var(..) => 0,
        Expr::Unary(_, a) => depth(a),
        Expr::Binary(_, a, b) => depth(a).max(depth(b)),
        Expr::If(c, a, b) => depth(c).max(depth(a)).max(depth(b)),
    }
}
