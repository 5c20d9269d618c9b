//! Spectra's language (Maoz, Ringert: Spectra: a specification language for reactive systems, Software and Systems Modeling
//! 2021), whole.
//!
//! Its meaning is strict GR(1) with Mealy timing. Constructs beyond variables and formulas are lowered, each by its own file:
//!
//! | construct | file |
//! |---|---|
//! | `type`, arrays, `.all .any .sum .prod .min .max` | `types`, `array` |
//! | `define`, `predicate` | `evaluate`, `array`, `predicate` |
//! | `forall`, `exists`, `in {..}` | `quantifier`, `membership` |
//! | `PREV ONCE HISTORICALLY SINCE TRIGGERED` | `past` |
//! | `monitor`, `counter` | `statement`, `counter` |
//! | `pattern`, the published patterns | `pattern`, `dwyer`, `ltl` |
//! | `trig`, `regexp` | `trigger`, `regexp` |
//!
//! What counts weights or asks for the existence of runs has no place in GR(1): the former is ignored with a note, the latter refused.
//!
//! Declarations may stand in any order, so a file is read in three passes: its words into declarations ([`parser`]), names and types,
//! formulas.

mod array;
mod automaton;
mod counter;
pub(super) mod dwyer;
mod evaluate;
mod formulas;
mod ltl;
mod membership;
mod parser;
mod past;
mod pattern;
mod predicate;
mod quantifier;
mod reader;
mod regexp;
mod statement;
mod syntax;
mod trigger;
mod types;
mod value;
mod words;

use crate::diagnostics::{Diagnostic, codes};
use crate::gr1::{Owner, Specification};
use crate::source::FileId;
pub(super) use parser::is_keyword;
use reader::{Reader, Symbol};
use std::rc::Rc;
use syntax::{Base, Declaration, Name, TypeName};

/// The file of the published patterns, by its name.
const PUBLISHED: &str = "DwyerPatterns.spectra";

/// Reads a file.
pub(super) fn read(name: &str, file: FileId, text: &str) -> (Specification, Vec<Diagnostic>) {
    let (declarations, findings) = parser::parse(file, text);
    let taken = declarations.iter().filter_map(name_of).collect();
    let mut reader = Reader::new(name, text, taken);
    reader.findings = findings;
    // A name whose declaration could not be read would be missed at each of its uses.
    let broken = !reader.findings.is_empty();
    let before = reader.findings.len();
    reader.types(&declarations);
    reader.names(&declarations);
    reader.formulas(&declarations, text);
    if broken {
        let (parsed, others) = {
            let others = reader.findings.split_off(before);
            (std::mem::take(&mut reader.findings), others)
        };
        reader.findings = parsed;
        let known = others.into_iter();
        reader
            .findings
            .extend(known.filter(|f| f.code != codes::NAME_UNKNOWN));
    }
    reader.finish()
}

/// The name of a variable, to keep it from helpers.
fn name_of(declaration: &Declaration) -> Option<String> {
    match declaration {
        Declaration::Variable(_, variable) => Some(variable.name.text.clone()),
        Declaration::Monitor(monitor) => Some(monitor.variable.name.text.clone()),
        Declaration::Counter(counter) => Some(counter.name.text.clone()),
        _ => None,
    }
}

impl Reader {
    /// Types, and the values of enumerations.
    fn types(&mut self, declarations: &[Declaration]) {
        for declaration in declarations {
            match declaration {
                Declaration::Type(name, of) => {
                    self.labels_of(of);
                    let known = self.types.insert(name.text.clone(), Rc::new(of.clone()));
                    if known.is_some() {
                        self.error(
                            codes::NAME_DOUBLE,
                            name.span,
                            format!("the type `{}` is declared twice", name.text),
                            "give one of the two another name",
                        );
                    }
                }
                Declaration::Variable(_, variable) => self.labels_of(&variable.of),
                Declaration::Monitor(monitor) => self.labels_of(&monitor.variable.of),
                Declaration::Predicate(predicate) => {
                    for parameter in &predicate.parameters {
                        self.labels_of(&parameter.of);
                    }
                }
                Declaration::Pattern(pattern) => {
                    for variable in &pattern.variables {
                        self.labels_of(&variable.of);
                    }
                }
                Declaration::Statement(statement) => {
                    for parameter in &statement.parameters {
                        self.labels_of(&parameter.of);
                    }
                }
                _ => {}
            }
        }
    }

    fn labels_of(&mut self, of: &TypeName) {
        if let Base::Labels(labels) = &of.base {
            self.labels.extend(labels.iter().map(|l| l.text.clone()));
        }
    }

    /// What names stand for. Sizes may be defines, so those come first.
    fn names(&mut self, declarations: &[Declaration]) {
        for declaration in declarations {
            match declaration {
                Declaration::Define(define) => {
                    self.define(&define.name, Symbol::Define(Rc::new(define.clone())));
                }
                Declaration::Predicate(predicate) => {
                    let symbol = Symbol::Predicate(Rc::new(predicate.clone()));
                    self.define(&predicate.name, symbol);
                }
                Declaration::Pattern(pattern) => {
                    self.define(&pattern.name, Symbol::Pattern(Rc::new(pattern.clone())));
                }
                Declaration::Regexp(name, regexp) => {
                    self.define(name, Symbol::Regexp(Rc::new(regexp.clone())));
                }
                _ => {}
            }
        }
        for declaration in declarations {
            match declaration {
                Declaration::Variable(owner, variable) => {
                    let (owner, internal) = *owner;
                    self.declare(&variable.name, &variable.of, owner, internal);
                }
                Declaration::Monitor(monitor) => {
                    let variable = &monitor.variable;
                    self.declare(&variable.name, &variable.of, Owner::System, true);
                }
                Declaration::Counter(counter) => {
                    let of = TypeName {
                        base: Base::Int(
                            Box::new(counter.low.clone()),
                            Box::new(counter.high.clone()),
                        ),
                        sizes: Vec::new(),
                        span: counter.low.span.to(counter.high.span),
                    };
                    self.declare(&counter.name, &of, Owner::System, true);
                }
                Declaration::Import(path, span) => self.import(path, *span),
                _ => {}
            }
        }
    }

    fn declare(&mut self, name: &Name, of: &TypeName, owner: Owner, internal: bool) {
        // A variable whose type is refused is still declared: its uses are not the mistake.
        let domain = self
            .domain(of)
            .unwrap_or((crate::gr1::Domain::Bool, Vec::new()));
        if let Some(cells) = self.variables(&name.text, owner, internal, domain, name.span) {
            self.define(name, Symbol::Variable(cells));
        }
    }

    fn import(&mut self, path: &str, span: crate::source::Span) {
        if path.rsplit(['/', '\\']).next() != Some(PUBLISHED) {
            self.error(
                codes::NAME_UNKNOWN,
                span,
                format!("the file `{path}` is not read"),
                format!(
                    "put its declarations into this file; `{PUBLISHED}` is there without a file"
                ),
            );
            return;
        }
        for published in &dwyer::PATTERNS {
            // A file's own pattern of that name is meant where there is one.
            self.symbols
                .entry(published.name.to_owned())
                .or_insert((Symbol::Published(published), span));
        }
    }

    fn formulas(&mut self, declarations: &[Declaration], text: &str) {
        let (mut assumptions, mut guarantees) = (0, 0);
        for declaration in declarations {
            match declaration {
                Declaration::Monitor(monitor) => self.monitor(monitor, text),
                Declaration::Counter(counter) => self.counted_by(counter, text),
                Declaration::Statement(statement) => {
                    let number = match statement.side {
                        Owner::Environment => &mut assumptions,
                        Owner::System => &mut guarantees,
                    };
                    *number += 1;
                    let number = *number;
                    self.statement(statement, text, number);
                }
                Declaration::Ignored("weight", span) => self.note(
                    codes::OWN_TOOL,
                    *span,
                    "weights are ignored: they say which machine Spectra's tool prefers, not which ones are right",
                    "choose between machines with `synth --prefer`",
                ),
                Declaration::Ignored(_, span) => self.note(
                    codes::OWN_TOOL,
                    *span,
                    "a `regtest` asks Spectra's tool about the file and says nothing of the machine: it is ignored",
                    "leave it out to have no note",
                ),
                _ => {}
            }
        }
    }
}
