//! Reads the whole Spectra language (Maoz, Ringert: Spectra: a specification language for reactive
//! systems, Software and Systems Modeling 2021).
//!
//! Its meaning is strict GR(1) with Mealy timing. These modules lower the constructs other than
//! variables and formulas:
//!
//! | construct | module |
//! |---|---|
//! | `import` | `import`, `lookup` |
//! | `type`, arrays, `.all .any .sum .prod .min .max` | `types`, `array` |
//! | comparisons, also of enumerations | `comparison` |
//! | `define`, `predicate` | `evaluate`, `array`, `predicate` |
//! | `forall`, `exists`, `in {..}` | `quantifier`, `membership` |
//! | `PREV ONCE HISTORICALLY SINCE TRIGGERED` | `past` |
//! | `monitor`, `counter` | `statement`, `counter`, `definition` |
//! | `pattern`, the published patterns | `pattern`, `dwyer`, `automata::ltl` |
//! | `trig`, `regexp` | `trigger`, `regexp`, `automata::derivative` |
//! | `ini`, `G`, `alw`, `GF` | `statement`, `initial` |
//!
//! Weights (an energy objective) and existential guarantees are outside GR(1). The reader ignores
//! weights with a note and refuses existential guarantees.
//!
//! Declarations can appear in any order, so a file is read in three passes: parsing ([`parser`]),
//! names and types, and formulas. Imported files take part in the first two passes.

mod array;
mod automaton;
mod comparison;
mod counter;
mod definition;
pub(super) mod dwyer;
mod evaluate;
mod import;
mod initial;
mod lookup;
mod membership;
mod parser;
mod past;
mod pattern;
mod predicate;
mod quantifier;
mod reader;
mod regexp;
mod scope;
mod statement;
mod syntax;
mod trigger;
mod types;
mod value;

use super::Loader;
use import::{Source, Sources};
use linewright_core::diagnostics::{Diagnostic, codes, has_errors};
use linewright_core::gr1::{Owner, Specification, VarId};
use linewright_core::source::FileId;
pub(super) use parser::is_keyword;
use reader::Reader;
use scope::Symbol;
use std::rc::Rc;
use syntax::{Base, Declaration, Name, TypeName};

/// Reads a file and its imports.
pub(super) fn read(
    name: &str,
    file: FileId,
    text: &str,
    loader: &mut Loader<'_>,
) -> (Specification, Vec<Diagnostic>) {
    let Sources {
        files, findings, ..
    } = import::parse_with_imports(file, text, loader);
    let taken = files[0]
        .declarations
        .iter()
        .filter_map(import::state_name)
        .map(|n| n.text.clone());
    let length = files.iter().map(|s| s.text.len()).sum();
    let mut reader = Reader::new(name, file, length, taken.collect());
    // After a syntax error, undeclared names are not reported, because their declarations might be
    // unreadable.
    let broken = has_errors(&findings);
    reader.findings = findings;
    let before = reader.findings.len();
    for source in &files {
        reader.types(source);
        reader.definitions(&source.declarations);
        reader.imports(source);
    }
    reader.state_declarations(&files[0].declarations);
    reader.formulas(&files[0].declarations, text);
    let mut others = reader.findings.split_off(before);
    if broken {
        others.retain(|f| f.code != codes::NAME_UNKNOWN);
    }
    reader.findings.extend(others);
    reader.finish()
}

impl Reader {
    /// Collects the types and the values of enumerations.
    fn types(&mut self, source: &Source) {
        for declaration in &source.declarations {
            match declaration {
                Declaration::Type(name, of) => {
                    self.labels_of(of);
                    self.declare_type(name, of, &source.text);
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

    /// Declares a type. A second declaration of a name causes a note if it is the same, otherwise
    /// an error, because Spectra silently uses the first one.
    fn declare_type(&mut self, name: &Name, of: &TypeName, text: &str) {
        let scope = self.scopes.entry(name.span.file).or_default();
        let Some((known, first)) = scope.types.get(&name.text) else {
            let declared = (Rc::new(of.clone()), name.span);
            scope.types.insert(name.text.clone(), declared);
            return;
        };
        let line = |span| parser::one_line(statement::text_of(text, span)).replace(' ', "");
        let (known, first) = (known.span, *first);
        if line(known) == line(of.span) {
            self.note(
                codes::NAME_DUPLICATE,
                name.span,
                format!(
                    "the type `{}` is declared twice, with the same definition",
                    name.text
                ),
                "remove one of the two",
            );
            return;
        }
        let finding = Diagnostic::error(
            codes::NAME_DUPLICATE,
            name.span,
            format!("the type `{}` is declared twice", name.text),
        )
        .with_label(first, "declared here first")
        .with_help("give one of the two another name");
        self.findings.push(finding);
    }

    fn labels_of(&mut self, of: &TypeName) {
        if let Base::Labels(labels) = &of.base {
            self.labels.extend(labels.iter().map(|l| l.text.clone()));
        }
    }

    /// Collects the definitions; variables come later, since array sizes can be defines.
    fn definitions(&mut self, declarations: &[Declaration]) {
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
    }

    /// Declares the variables, monitors and counters.
    fn state_declarations(&mut self, declarations: &[Declaration]) {
        for declaration in declarations {
            match declaration {
                Declaration::Variable(owner, variable) => {
                    let (owner, internal) = *owner;
                    self.declare(&variable.name, &variable.of, owner, internal);
                }
                Declaration::Monitor(monitor) => {
                    let variable = &monitor.variable;
                    self.declare_watcher(&variable.name, &variable.of);
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
                    self.declare_watcher(&counter.name, &of);
                }
                _ => {}
            }
        }
    }

    /// Declares the variable of a monitor or a counter.
    fn declare_watcher(&mut self, name: &Name, of: &TypeName) {
        let first = self.specification.variables.len() as u32;
        self.declare(name, of, Owner::System, true);
        let end = self.specification.variables.len() as u32;
        self.watchers.extend((first..end).map(VarId));
    }

    fn declare(&mut self, name: &Name, of: &TypeName, owner: Owner, internal: bool) {
        // A variable with a refused type is still declared, so that its uses cause no findings.
        let domain = self
            .domain(of)
            .unwrap_or((linewright_core::gr1::Domain::Bool, Vec::new()));
        if let Some(cells) = self.variables(&name.text, owner, internal, domain, name.span) {
            self.define(name, Symbol::Variable(cells));
        }
    }

    /// Records a file's imports, and the names of the file that importing files cannot use.
    fn imports(&mut self, source: &Source) {
        let local = source.declarations.iter().filter_map(import::state_name);
        let scope = self.scopes.entry(source.file).or_default();
        scope.not_exported = local.map(|n| (n.text.clone(), n.span)).collect();
        scope.imports = source.imports.iter().map(|(target, _)| *target).collect();
    }

    fn formulas(&mut self, declarations: &[Declaration], text: &str) {
        let (mut assumptions, mut guarantees) = (0, 0);
        for declaration in declarations {
            match declaration {
                Declaration::Monitor(monitor) => self.monitor(monitor, text),
                Declaration::Counter(counter) => self.counter_formulas(counter, text),
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
                    "weights are ignored: Spectra's tool also requires that their sum, from a bounded start, never falls below zero in a run; a controller found here need not ensure that",
                    "if the sum matters, track it in a counter or a variable, and limit it in a guarantee",
                ),
                Declaration::Ignored(_, span) => self.note(
                    codes::OWN_TOOL,
                    *span,
                    "this `regtest` is ignored: it is a query for Spectra's tool and not part of the specification",
                    "remove it to avoid this note",
                ),
                _ => {}
            }
        }
    }
}
