//! Expands definitions, big operators and sets; the result has only signals and temporal and
//! Boolean operators.
//!
//! The expansion limits its steps, its depth and the size of the formulas.

mod big;
mod coerce;
mod compare;
mod name;
mod operator;
mod pattern;
mod site;

use super::ast::{Definition, Enumeration, Kind, Tree};
use super::ltl::{FormulaId, Formulas, Op, Place};
use super::report::Report;
use super::value::{ScopeBinding, Value};
use crate::names::quoted;
use linewright_core::diagnostics::{Code, Diagnostic, codes};
pub(super) use site::{Site, bindings, located};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::rc::Rc;

/// Maximum number of expressions evaluated for one file.
const MAX_STEPS: u64 = 4_000_000;
/// Maximum nesting depth of evaluations, on the stack of [`crate::read`].
const MAX_DEPTH: u32 = 4_000;
/// Maximum number of elements of a set.
const MAX_SET: i64 = 1 << 16;
/// Maximum number of steps in `X[n]`, `G[n:m]` and `F[n:m]`.
const MAX_AHEAD: i64 = 256;

/// Marker for an error that is already in the findings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct AlreadyReported;

type Result<T> = std::result::Result<T, AlreadyReported>;

/// Global names and their meanings.
#[derive(Debug)]
pub(super) struct Globals<'f> {
    pub definitions: BTreeMap<(&'f str, usize), &'f Definition>,
    pub enumerations: &'f [Enumeration],
    pub labels: BTreeMap<&'f str, (usize, usize)>,
    /// Values of single signals and buses.
    pub signals: BTreeMap<&'f str, Value>,
}

pub(super) struct Expander<'f, 'r> {
    pub globals: Globals<'f>,
    pub formulas: Formulas,
    pub report: &'r mut Report,
    pub sites: Vec<Site>,
    known: BTreeMap<&'f str, Value>,
    steps: u64,
    depth: u32,
}

type Scope<'a> = Option<&'a ScopeBinding<'a>>;

impl<'f, 'r> Expander<'f, 'r> {
    pub fn new(globals: Globals<'f>, report: &'r mut Report) -> Self {
        Self {
            globals,
            formulas: Formulas::default(),
            report,
            sites: vec![Site {
                range: 0..0,
                outer: 0,
                with: String::new(),
            }],
            known: BTreeMap::new(),
            steps: 0,
            depth: 0,
        }
    }

    /// Expands a formula of a section.
    pub fn formula(&mut self, tree: &'f Tree) -> Result<FormulaId> {
        let value = self.value(tree, None, 0)?;
        self.as_formula(&value, tree, 0)
    }

    pub fn number(&mut self, tree: &'f Tree) -> Result<i64> {
        self.numeric(tree, None, 0)
    }

    fn fail<T>(
        &mut self,
        code: Code,
        range: &Range<usize>,
        site: u32,
        message: impl Into<String>,
        help: impl Into<String>,
    ) -> Result<T> {
        let finding = Diagnostic::error(code, self.report.span(range), message).with_help(help);
        let finding = located(finding, site, &self.sites, self.report);
        self.report.push(finding);
        Err(AlreadyReported)
    }

    fn note(
        &mut self,
        code: Code,
        range: &Range<usize>,
        site: u32,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        let finding = Diagnostic::note(code, self.report.span(range), message).with_help(help);
        let finding = located(finding, site, &self.sites, self.report);
        self.report.push(finding);
    }

    /// Evaluates an expression; [`MAX_DEPTH`] limits the recursion.
    fn value(&mut self, tree: &'f Tree, scope: Scope<'_>, site: u32) -> Result<Value> {
        self.steps += 1;
        if self.depth >= MAX_DEPTH {
            return self.fail(
                codes::TOO_LARGE,
                &tree.range,
                site,
                format!("calls nest more than {MAX_DEPTH} levels deep here"),
                "give a recursive function a case that ends the recursion",
            );
        }
        if self.steps > MAX_STEPS || self.formulas.too_large {
            return self.fail(
                codes::TOO_LARGE,
                &tree.range,
                site,
                "the file becomes too large after its definitions are expanded",
                "give the parameters smaller values",
            );
        }
        self.depth += 1;
        let value = self.inner(tree, scope, site);
        self.depth -= 1;
        value
    }

    fn inner(&mut self, tree: &'f Tree, scope: Scope<'_>, site: u32) -> Result<Value> {
        let place = Place::new(&tree.range, site);
        Ok(match &tree.kind {
            Kind::Number(n) => Value::Number(*n),
            Kind::Truth(t) => Value::Formula(self.formulas.constant(*t, place)),
            Kind::Otherwise => Value::Formula(self.formulas.constant(true, place)),
            Kind::Wild => {
                return self.fail(
                    codes::SYNTAX,
                    &tree.range,
                    site,
                    "`_` is only allowed in a pattern",
                    "write a pattern after `~`",
                );
            }
            Kind::Name(name) => return self.name(name, tree, scope, site),
            Kind::Call(name, arguments) => return self.call(name, arguments, tree, scope, site),
            Kind::Element(name, index) => {
                let found = match ScopeBinding::find(scope, name) {
                    Some(value) => value,
                    None => self.resolve(name, tree, site)?,
                };
                let Value::Bus(bits) = found else {
                    return self.fail(
                        codes::TYPE_MISMATCH,
                        &tree.range,
                        site,
                        format!("`{}` is {}, not a bus", quoted(name), found.word()),
                        "use an index only with a bus",
                    );
                };
                let index = self.numeric(index, scope, site)?;
                let Some(bit) = usize::try_from(index).ok().and_then(|i| bits.get(i)) else {
                    return self.fail(
                        codes::INDEX_RANGE,
                        &tree.range,
                        site,
                        format!("`{}` has no element {index}", quoted(name)),
                        format!("use an index from 0 to {}", bits.len() as i64 - 1),
                    );
                };
                Value::Formula(self.formulas.make(Op::Atom(*bit), place))
            }
            Kind::Set(elements) => {
                let mut set = BTreeSet::new();
                for element in elements {
                    set.insert(self.value(element, scope, site)?);
                }
                Value::Set(Rc::new(set))
            }
            Kind::Span(first, second, last) => {
                let first = self.numeric(first, scope, site)?;
                let second = self.numeric(second, scope, site)?;
                let last = self.numeric(last, scope, site)?;
                let step = second.saturating_sub(first);
                if step <= 0 {
                    return self.fail(
                        codes::DOMAIN_EMPTY,
                        &tree.range,
                        site,
                        "the second number of this set is not larger than the first",
                        "write `{0,1..n}`: the first two numbers give the step",
                    );
                }
                if last.saturating_sub(first) / step >= MAX_SET {
                    return self.large_set(tree, site);
                }
                let numbers = (0..MAX_SET)
                    .filter_map(|k| first.checked_add(k.checked_mul(step)?))
                    .take_while(|n| *n <= last);
                Value::Set(Rc::new(numbers.map(Value::Number).collect()))
            }
            Kind::Unary(op, a) => return self.unary(*op, a, tree, scope, site),
            Kind::Bounded(op, bound, body) => {
                return self.bounded(*op, bound, body, tree, scope, site);
            }
            Kind::Big(op, ranges, body) => {
                let mut values = Vec::new();
                self.iterate(ranges, body, scope, site, &mut values)?;
                return self.combine(*op, &values, tree, body, site);
            }
            Kind::And(list) | Kind::Or(list) => {
                let and = matches!(tree.kind, Kind::And(_));
                let mut parts = Vec::new();
                for part in list {
                    let f = self.condition(part, scope, site)?;
                    // Stop at the first operand that decides the result. It can be a guard that
                    // prevents an index outside a bus in a later operand.
                    let decided = self.formulas.truth(f) == Some(!and);
                    parts.push(f);
                    if decided {
                        break;
                    }
                }
                Value::Formula(if and {
                    self.formulas.and(parts, place)
                } else {
                    self.formulas.or(parts, place)
                })
            }
            Kind::Binary(op, a, b) => return self.binary(*op, a, b, tree, scope, site),
        })
    }
}
