//! Expands definitions, big operators and sets: what is left are signals and operators of temporal logic.
//!
//! The expansion is bounded in steps, in depth and in the size of what it makes.

use super::ast::{Big, Binary, Definition, Enumeration, Kind, Tree, Unary};
use super::ltl::{F, Formulas, Op, Place};
use super::report::Report;
use super::value::{Bound, Value};
use crate::diagnostics::{Code, Diagnostic, codes, nearest};
use crate::gr1::VarId;
use crate::interchange::names::quoted;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::rc::Rc;

/// So many expressions are evaluated for one file.
const MAX_STEPS: u64 = 4_000_000;
/// Evaluations nest so deep; see [`super::STACK`].
const MAX_DEPTH: u32 = 4_000;
/// A set has at most so many elements.
const MAX_SET: i64 = 1 << 16;
/// `X[n]` looks at most so far ahead.
const MAX_AHEAD: i64 = 256;

/// What went wrong has been said.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Said;

type Result<T> = std::result::Result<T, Said>;

/// A call, or a round of a big operator.
#[derive(Debug, Clone)]
pub(super) struct Site {
    pub range: Range<usize>,
    pub outer: u32,
    /// What it is bound to: `i = 1`; empty for a call.
    pub with: String,
}

/// What names stand for, outside of functions.
#[derive(Debug)]
pub(super) struct Globals<'f> {
    pub definitions: BTreeMap<(&'f str, usize), &'f Definition>,
    pub enumerations: &'f [Enumeration],
    pub labels: BTreeMap<&'f str, (usize, usize)>,
    /// Signals that are single, and buses.
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

type Scope<'a> = Option<&'a Bound<'a>>;

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

    /// A formula of a section.
    pub fn formula(&mut self, tree: &'f Tree) -> Result<F> {
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
        Err(Said)
    }

    /// The recursion is bounded by [`MAX_DEPTH`].
    fn value(&mut self, tree: &'f Tree, scope: Scope<'_>, site: u32) -> Result<Value> {
        self.steps += 1;
        if self.depth >= MAX_DEPTH {
            return self.fail(
                codes::TOO_LARGE,
                &tree.range,
                site,
                format!("calls nest more than {MAX_DEPTH} levels deep here"),
                "a function that calls itself needs a case in which it does not",
            );
        }
        if self.steps > MAX_STEPS || self.formulas.too_large {
            return self.fail(
                codes::TOO_LARGE,
                &tree.range,
                site,
                "the file becomes too large once its definitions are written out",
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
                    "`_` stands for anything in a pattern, and for nothing elsewhere",
                    "patterns stand behind `~`",
                );
            }
            Kind::Name(name) => return self.name(name, tree, scope, site),
            Kind::Call(name, arguments) => return self.call(name, arguments, tree, scope, site),
            Kind::Element(name, index) => {
                let found = match Bound::find(scope, name) {
                    Some(value) => value,
                    None => self.named(name, tree, scope, site)?,
                };
                let Value::Bus(bits) = found else {
                    return self.fail(
                        codes::TYPE_MISMATCH,
                        &tree.range,
                        site,
                        format!("`{}` is {}, no bus", quoted(name), found.word()),
                        "only buses have elements",
                    );
                };
                let index = self.numeric(index, scope, site)?;
                let Some(bit) = usize::try_from(index).ok().and_then(|i| bits.get(i)) else {
                    return self.fail(
                        codes::INDEX_RANGE,
                        &tree.range,
                        site,
                        format!("`{}` has no element {index}", quoted(name)),
                        format!("its elements are 0 to {}", bits.len() as i64 - 1),
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
                self.rounds(ranges, body, scope, site, &mut values)?;
                return self.gathered(*op, &values, tree, body, site);
            }
            Kind::And(list) | Kind::Or(list) => {
                let and = matches!(tree.kind, Kind::And(_));
                let mut parts = Vec::new();
                for part in list {
                    let f = self.condition(part, scope, site)?;
                    // As guards do: what is decided needs no further look, which may be outside a bus.
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

    fn large_set<T>(&mut self, tree: &Tree, site: u32) -> Result<T> {
        self.fail(
            codes::TOO_LARGE,
            &tree.range,
            site,
            format!("this set has more than {MAX_SET} elements"),
            "give the parameters smaller values",
        )
    }

    fn as_formula(&mut self, value: &Value, tree: &Tree, site: u32) -> Result<F> {
        match value {
            Value::Formula(f) => Ok(*f),
            Value::Bus(_) => self.fail(
                codes::TYPE_MISMATCH,
                &tree.range,
                site,
                "this is a bus, where a truth value is needed",
                "name one of its elements, `b[0]`, or compare it with a value of its enumeration",
            ),
            other => self.fail(
                codes::TYPE_MISMATCH,
                &tree.range,
                site,
                format!("this is {}, where a truth value is needed", other.word()),
                "compare it with something",
            ),
        }
    }

    fn condition(&mut self, tree: &'f Tree, scope: Scope<'_>, site: u32) -> Result<F> {
        let value = self.value(tree, scope, site)?;
        self.as_formula(&value, tree, site)
    }

    fn numeric(&mut self, tree: &'f Tree, scope: Scope<'_>, site: u32) -> Result<i64> {
        match self.value(tree, scope, site)? {
            Value::Number(n) => Ok(n),
            other => self.fail(
                codes::TYPE_MISMATCH,
                &tree.range,
                site,
                format!("this is {}, where a number is needed", other.word()),
                "numbers are constants, parameters, sums and the like, and `SIZEOF` of a bus",
            ),
        }
    }

    fn set(&mut self, tree: &'f Tree, scope: Scope<'_>, site: u32) -> Result<Rc<BTreeSet<Value>>> {
        match self.value(tree, scope, site)? {
            Value::Set(set) => Ok(set),
            other => self.fail(
                codes::TYPE_MISMATCH,
                &tree.range,
                site,
                format!("this is {}, where a set is needed", other.word()),
                "sets are written `{1,2,5}` or `{0,1..n}`",
            ),
        }
    }

    fn name(
        &mut self,
        name: &'f str,
        tree: &'f Tree,
        scope: Scope<'_>,
        site: u32,
    ) -> Result<Value> {
        match Bound::find(scope, name) {
            Some(Value::Formula(f)) => Ok(Value::Formula(f)),
            Some(value) => Ok(value),
            None => match self.named(name, tree, scope, site)? {
                // A signal is read where it stands.
                Value::Formula(f) if matches!(self.formulas.op(f), Op::Atom(_)) => {
                    let op = self.formulas.op(f).clone();
                    let place = Place::new(&tree.range, site);
                    Ok(Value::Formula(self.formulas.make(op, place)))
                }
                value => Ok(value),
            },
        }
    }

    fn named(&mut self, name: &'f str, tree: &'f Tree, _: Scope<'_>, site: u32) -> Result<Value> {
        if let Some(value) = self.known.get(name) {
            return Ok(value.clone());
        }
        if let Some(definition) = self.globals.definitions.get(&(name, 0)).copied() {
            let value = self.cases(definition, tree, None, site)?;
            self.known.insert(&definition.name, value.clone());
            return Ok(value);
        }
        if let Some(value) = self.globals.signals.get(name) {
            return Ok(value.clone());
        }
        if let Some((e, l)) = self.globals.labels.get(name) {
            return Ok(Value::Label(*e, *l));
        }
        self.unknown(name, &tree.range, site, usize::MAX)
    }

    fn unknown<T>(
        &mut self,
        name: &str,
        range: &Range<usize>,
        site: u32,
        count: usize,
    ) -> Result<T> {
        let of_name = |n: &&(&str, usize)| n.0 == name;
        let wanted = self.globals.definitions.keys().find(of_name).map(|d| d.1);
        if let Some(wanted) = wanted {
            let got = if count == usize::MAX { 0 } else { count };
            return self.fail(
                codes::ARGUMENT,
                range,
                site,
                format!("`{}` takes {wanted} arguments, not {got}", quoted(name)),
                "give one for each name in its definition",
            );
        }
        let globals = &self.globals;
        let all = { globals.definitions.keys().map(|d| d.0) }
            .chain(globals.signals.keys().copied())
            .chain(globals.labels.keys().copied());
        let help = match nearest(&quoted(name), all) {
            Some(near) => format!("did you mean `{near}`?"),
            None if count == usize::MAX => {
                "declare it as a signal in INPUTS or OUTPUTS, or define it under PARAMETERS or DEFINITIONS".to_owned()
            }
            None => "define it under DEFINITIONS".to_owned(),
        };
        self.fail(
            codes::NAME_UNKNOWN,
            range,
            site,
            format!("`{}` is not declared", quoted(name)),
            help,
        )
    }

    fn call(
        &mut self,
        name: &'f str,
        arguments: &'f [Tree],
        tree: &'f Tree,
        scope: Scope<'_>,
        site: u32,
    ) -> Result<Value> {
        let Some(definition) = self
            .globals
            .definitions
            .get(&(name, arguments.len()))
            .copied()
        else {
            return self.unknown(name, &tree.range, site, arguments.len());
        };
        let mut values = Vec::new();
        for argument in arguments {
            values.push(self.value(argument, scope, site)?);
        }
        let inner = self.site(&tree.range, site, String::new());
        let names = definition.arguments.iter().map(String::as_str);
        self.with(names.zip(values).collect(), None, &mut |s, scope| {
            s.cases(definition, tree, scope, inner)
        })
    }

    fn site(&mut self, range: &Range<usize>, outer: u32, with: String) -> u32 {
        self.sites.push(Site {
            range: range.clone(),
            outer,
            with,
        });
        self.sites.len() as u32 - 1
    }

    /// Runs something with further names bound.
    fn with<T>(
        &mut self,
        names: Vec<(&str, Value)>,
        scope: Scope<'_>,
        run: &mut dyn FnMut(&mut Self, Scope<'_>) -> Result<T>,
    ) -> Result<T> {
        let mut names = names;
        match names.pop() {
            None => run(self, scope),
            Some((name, value)) => {
                let bound = Bound {
                    name,
                    value,
                    outer: scope,
                };
                self.with(names, Some(&bound), run)
            }
        }
    }

    /// The value of the first case that applies.
    fn cases(
        &mut self,
        definition: &'f Definition,
        tree: &'f Tree,
        scope: Scope<'_>,
        site: u32,
    ) -> Result<Value> {
        for case in &definition.cases {
            let Kind::Binary(Binary::Colon, guard, value) = &case.kind else {
                return self.value(case, scope, site);
            };
            let mut bound = Vec::new();
            if self.guard(guard, scope, site, &mut bound)? {
                return self.with(bound, scope, &mut |s, scope| s.value(value, scope, site));
            }
        }
        self.fail(
            codes::ARGUMENT,
            &tree.range,
            site,
            format!("no case of `{}` applies here", quoted(&definition.name)),
            "add a case `otherwise : ...` at its end",
        )
    }

    fn guard(
        &mut self,
        guard: &'f Tree,
        scope: Scope<'_>,
        site: u32,
        bound: &mut Vec<(&'f str, Value)>,
    ) -> Result<bool> {
        if let Kind::Binary(Binary::Pattern, formula, pattern) = &guard.kind {
            let formula = self.condition(formula, scope, site)?;
            return Ok(self.matches(formula, pattern, bound));
        }
        let f = self.condition(guard, scope, site)?;
        match self.formulas.truth(f) {
            Some(truth) => Ok(truth),
            None => self.fail(
                codes::NOT_CONSTANT,
                &guard.range,
                site,
                "this condition is a formula, which nobody can decide beforehand",
                "a guard compares numbers or sets, or matches a formula with a pattern: `f ~ a U b`",
            ),
        }
    }

    /// Whether a formula has the shape of a pattern; what names stand for then. The recursion is as deep as the pattern.
    fn matches(&mut self, f: F, pattern: &'f Tree, bound: &mut Vec<(&'f str, Value)>) -> bool {
        let op = self.formulas.op(f).clone();
        let two =
            |s: &mut Self, (a, b): (F, F), (p, q): (&'f Tree, &'f Tree), bound: &mut Vec<_>| {
                s.matches(a, p, bound) && s.matches(b, q, bound)
            };
        match (&pattern.kind, op) {
            (Kind::Wild, _) => true,
            (Kind::Name(name), _) => {
                bound.push((name, Value::Formula(f)));
                true
            }
            (Kind::Truth(t), op) => op == if *t { Op::True } else { Op::False },
            (Kind::Unary(Unary::Not, p), Op::Not(a))
            | (Kind::Unary(Unary::Next, p), Op::Next(a))
            | (Kind::Unary(Unary::Globally, p), Op::Globally(a))
            | (Kind::Unary(Unary::Finally, p), Op::Finally(a)) => self.matches(a, p, bound),
            (Kind::And(patterns), Op::And(parts)) | (Kind::Or(patterns), Op::Or(parts)) => {
                let and = matches!(pattern.kind, Kind::And(_));
                let Some(more) = parts.len().checked_sub(patterns.len()) else {
                    return false;
                };
                // Operators lean to the left: the first pattern takes what is too much.
                let (head, rest) = parts.split_at(more + 1);
                let place = self.formulas.place(f);
                let head = if and {
                    self.formulas.and(head.to_vec(), place)
                } else {
                    self.formulas.or(head.to_vec(), place)
                };
                let parts = std::iter::once(head).chain(rest.iter().copied());
                { parts.zip(patterns) }.all(|(part, p)| self.matches(part, p, bound))
            }
            (Kind::Binary(Binary::Implies, p, q), Op::Implies(a, b))
            | (Kind::Binary(Binary::Equivalent, p, q), Op::Iff(a, b))
            | (Kind::Binary(Binary::Until, p, q), Op::Until(a, b))
            | (Kind::Binary(Binary::Weak, p, q), Op::Weak(a, b))
            | (Kind::Binary(Binary::Release, p, q), Op::Release(a, b)) => {
                two(self, (a, b), (p, q), bound)
            }
            _ => false,
        }
    }

    fn unary(
        &mut self,
        op: Unary,
        a: &'f Tree,
        tree: &'f Tree,
        scope: Scope<'_>,
        site: u32,
    ) -> Result<Value> {
        let place = Place::new(&tree.range, site);
        let make: fn(F) -> Op = match op {
            Unary::Not => Op::Not,
            Unary::Next => Op::Next,
            Unary::Globally => Op::Globally,
            Unary::Finally => Op::Finally,
            Unary::SizeOf => {
                return match self.value(a, scope, site)? {
                    Value::Bus(bits) => Ok(Value::Number(bits.len() as i64)),
                    other => self.fail(
                        codes::TYPE_MISMATCH,
                        &a.range,
                        site,
                        format!("this is {}, where a bus is needed", other.word()),
                        "`SIZEOF` counts the signals of a bus, `SIZE` the elements of a set",
                    ),
                };
            }
            Unary::Size => return Ok(Value::Number(self.set(a, scope, site)?.len() as i64)),
            Unary::Min | Unary::Max => {
                let set = self.set(a, scope, site)?;
                let numbers = set.iter().filter_map(|v| match v {
                    Value::Number(n) => Some(*n),
                    _ => None,
                });
                let found = if op == Unary::Min {
                    numbers.min()
                } else {
                    numbers.max()
                };
                return match found {
                    Some(n) => Ok(Value::Number(n)),
                    None => self.fail(
                        codes::DOMAIN_EMPTY,
                        &tree.range,
                        site,
                        "there is no number in this set",
                        "only a set of numbers that is not empty has a smallest and a largest one",
                    ),
                };
            }
        };
        let a = self.condition(a, scope, site)?;
        Ok(Value::Formula(self.formulas.make(make(a), place)))
    }

    /// `X[n] f`, `G[n:m] f`, `F[n:m] f`
    fn bounded(
        &mut self,
        op: Unary,
        bound: &'f Tree,
        body: &'f Tree,
        tree: &'f Tree,
        scope: Scope<'_>,
        site: u32,
    ) -> Result<Value> {
        let place = Place::new(&tree.range, site);
        let (low, high) = match (&bound.kind, op) {
            (Kind::Binary(Binary::Colon, low, high), Unary::Globally | Unary::Finally) => (
                self.numeric(low, scope, site)?,
                self.numeric(high, scope, site)?,
            ),
            (_, Unary::Next) => {
                let n = self.numeric(bound, scope, site)?;
                (n, n)
            }
            _ => {
                return self.fail(
                    codes::SYNTAX,
                    &bound.range,
                    site,
                    "expected two numbers with `:` between them",
                    "write `G[0:3] a` or `F[0:3] a`, and `X[3] a`",
                );
            }
        };
        if !(0..=MAX_AHEAD).contains(&low) || high > MAX_AHEAD {
            return self.fail(
                codes::TOO_LARGE,
                &bound.range,
                site,
                format!("steps are counted from 0 to {MAX_AHEAD} here"),
                "count with a bus of outputs where more is needed",
            );
        }
        let and = op != Unary::Finally;
        if low > high {
            // The format's definition: no step at all; its tool says `true` for both.
            return Ok(Value::Formula(self.formulas.constant(true, place)));
        }
        let mut f = self.condition(body, scope, site)?;
        let first = f;
        for _ in low..high {
            let next = self.formulas.make(Op::Next(f), place);
            f = if and {
                self.formulas.and(vec![first, next], place)
            } else {
                self.formulas.or(vec![first, next], place)
            };
        }
        for _ in 0..low {
            f = self.formulas.make(Op::Next(f), place);
        }
        Ok(Value::Formula(f))
    }

    /// The values of a body for every choice of what its operator runs over. The recursion is as deep as there are ranges.
    fn rounds(
        &mut self,
        ranges: &'f [Tree],
        body: &'f Tree,
        scope: Scope<'_>,
        site: u32,
        values: &mut Vec<Value>,
    ) -> Result<()> {
        let Some((range, rest)) = ranges.split_first() else {
            values.push(self.value(body, scope, site)?);
            return Ok(());
        };
        let (name, elements) = self.range(range, scope, site)?;
        for value in elements {
            let with = match &value {
                Value::Number(n) => format!("{name} = {n}"),
                _ => String::new(),
            };
            let inner = self.site(&range.range, site, with);
            let bound = Bound {
                name,
                value,
                outer: scope,
            };
            self.rounds(rest, body, Some(&bound), inner, values)?;
        }
        Ok(())
    }

    /// `0 <= i < n` or `i IN S`
    fn range(
        &mut self,
        tree: &'f Tree,
        scope: Scope<'_>,
        site: u32,
    ) -> Result<(&'f str, Vec<Value>)> {
        use Binary as B;
        match &tree.kind {
            Kind::Binary(B::Element, name, set) => {
                if let Kind::Name(name) = &name.kind {
                    let set = self.set(set, scope, site)?;
                    return Ok((name, set.iter().cloned().collect()));
                }
            }
            Kind::Binary(upper @ (B::Less | B::LessEqual), inner, high) => {
                if let Kind::Binary(lower @ (B::Less | B::LessEqual), low, name) = &inner.kind
                    && let Kind::Name(name) = &name.kind
                {
                    let low = self.numeric(low, scope, site)?;
                    let high = self.numeric(high, scope, site)?;
                    let low = low.saturating_add(i64::from(*lower == B::Less));
                    let high = high.saturating_sub(i64::from(*upper == B::Less));
                    if high.saturating_sub(low) >= MAX_SET {
                        return self.large_set(tree, site);
                    }
                    return Ok((name, (low..=high).map(Value::Number).collect()));
                }
            }
            _ => {}
        }
        self.fail(
            codes::SYNTAX,
            &tree.range,
            site,
            "this is nothing to run over",
            "write `&&[0 <= i < n]` or `&&[i IN {1,2,5}]`",
        )
    }

    fn gathered(
        &mut self,
        op: Big,
        values: &[Value],
        tree: &'f Tree,
        body: &'f Tree,
        site: u32,
    ) -> Result<Value> {
        let place = Place::new(&tree.range, site);
        match op {
            Big::And | Big::Or => {
                let mut parts = Vec::new();
                for value in values {
                    parts.push(self.as_formula(value, body, site)?);
                }
                Ok(Value::Formula(if op == Big::And {
                    self.formulas.and(parts, place)
                } else {
                    self.formulas.or(parts, place)
                }))
            }
            Big::Sum | Big::Product => {
                let mut result = Some(i64::from(op == Big::Product));
                for value in values {
                    let Value::Number(n) = value else {
                        return self.fail(
                            codes::TYPE_MISMATCH,
                            &body.range,
                            site,
                            format!("this is {}, where a number is needed", value.word()),
                            "`SUM` and `PROD` are for numbers",
                        );
                    };
                    result = result.and_then(|r| {
                        if op == Big::Sum {
                            r.checked_add(*n)
                        } else {
                            r.checked_mul(*n)
                        }
                    });
                }
                self.counted(result, tree, site)
            }
            Big::Cup | Big::Cap => {
                let mut result: Option<BTreeSet<Value>> = None;
                for value in values {
                    let Value::Set(set) = value else {
                        return self.fail(
                            codes::TYPE_MISMATCH,
                            &body.range,
                            site,
                            format!("this is {}, where a set is needed", value.word()),
                            "`CUP` and `CAP` are for sets",
                        );
                    };
                    result = Some(match result {
                        None => (**set).clone(),
                        Some(r) if op == Big::Cup => r.union(set).cloned().collect(),
                        Some(r) => r.intersection(set).cloned().collect(),
                    });
                }
                if op == Big::Cap && result.is_none() {
                    return self.fail(
                        codes::DOMAIN_EMPTY,
                        &tree.range,
                        site,
                        "the intersection of no sets at all is not defined",
                        "let it run over one set at least",
                    );
                }
                Ok(Value::Set(Rc::new(result.unwrap_or_default())))
            }
        }
    }

    fn counted(&mut self, result: Option<i64>, tree: &Tree, site: u32) -> Result<Value> {
        match result {
            Some(n) => Ok(Value::Number(n)),
            None => self.fail(
                codes::NUMBER_RANGE,
                &tree.range,
                site,
                "this number is too large to count with",
                "numbers have to fit 64 bits",
            ),
        }
    }

    fn binary(
        &mut self,
        op: Binary,
        a: &'f Tree,
        b: &'f Tree,
        tree: &'f Tree,
        scope: Scope<'_>,
        site: u32,
    ) -> Result<Value> {
        use Binary as B;
        let place = Place::new(&tree.range, site);
        match op {
            B::Times | B::Divide | B::Modulo | B::Plus | B::Minus => {
                let (x, y) = (self.numeric(a, scope, site)?, self.numeric(b, scope, site)?);
                if y == 0 && matches!(op, B::Divide | B::Modulo) {
                    return self.fail(
                        codes::DIVISION,
                        &tree.range,
                        site,
                        "the divisor is 0 here",
                        "exclude that case with a guard",
                    );
                }
                // Rounded towards minus infinity, as the format's tool does.
                let quotient = || {
                    let q = x.checked_div(y)?;
                    Some(q - i64::from(x % y != 0 && (x < 0) != (y < 0)))
                };
                let result = match op {
                    B::Times => x.checked_mul(y),
                    B::Plus => x.checked_add(y),
                    B::Minus => x.checked_sub(y),
                    B::Divide => quotient(),
                    _ => quotient().and_then(|q| x.checked_sub(q.checked_mul(y)?)),
                };
                self.counted(result, tree, site)
            }
            B::SetMinus | B::Cap | B::Cup => {
                let (x, y) = (self.set(a, scope, site)?, self.set(b, scope, site)?);
                Ok(Value::Set(Rc::new(match op {
                    B::SetMinus => x.difference(&y).cloned().collect(),
                    B::Cap => x.intersection(&y).cloned().collect(),
                    _ => x.union(&y).cloned().collect(),
                })))
            }
            B::Less | B::LessEqual | B::Greater | B::GreaterEqual => {
                let (x, y) = (self.numeric(a, scope, site)?, self.numeric(b, scope, site)?);
                let truth = match op {
                    B::Less => x < y,
                    B::LessEqual => x <= y,
                    B::Greater => x > y,
                    _ => x >= y,
                };
                Ok(Value::Formula(self.formulas.constant(truth, place)))
            }
            B::Element => {
                let x = self.value(a, scope, site)?;
                let set = self.set(b, scope, site)?;
                Ok(Value::Formula(self.formulas.constant(set.contains(&x), place)))
            }
            B::Equal | B::Unequal => {
                let (x, y) = (self.value(a, scope, site)?, self.value(b, scope, site)?);
                let equal = self.equal(&x, &y, tree, site)?;
                Ok(Value::Formula(if op == B::Equal {
                    equal
                } else {
                    self.formulas.make(Op::Not(equal), place)
                }))
            }
            B::Pattern | B::Colon => self.fail(
                codes::SYNTAX,
                &tree.range,
                site,
                if op == B::Colon {
                    "a guard stands outside a definition here"
                } else {
                    "a pattern stands outside a guard here"
                },
                "guards and patterns stand under DEFINITIONS: `f(x) = x ~ a U b : a  otherwise : x`",
            ),
            B::And | B::Or | B::Implies | B::Equivalent | B::Weak | B::Until | B::Release => {
                let (x, y) = (self.condition(a, scope, site)?, self.condition(b, scope, site)?);
                let op = match op {
                    B::And => Op::And(vec![x, y]),
                    B::Or => Op::Or(vec![x, y]),
                    B::Implies => Op::Implies(x, y),
                    B::Equivalent => Op::Iff(x, y),
                    B::Weak => Op::Weak(x, y),
                    B::Until => Op::Until(x, y),
                    _ => Op::Release(x, y),
                };
                Ok(Value::Formula(self.formulas.make(op, place)))
            }
        }
    }

    fn equal(&mut self, x: &Value, y: &Value, tree: &Tree, site: u32) -> Result<F> {
        let place = Place::new(&tree.range, site);
        let decided = match (x, y) {
            (Value::Bus(bits), Value::Label(e, l)) | (Value::Label(e, l), Value::Bus(bits)) => {
                let codes = self.globals.enumerations[*e].labels[*l].codes.clone();
                if bits.len() != self.globals.enumerations[*e].width {
                    return self.fail(
                        codes::TYPE_MISMATCH,
                        &tree.range,
                        site,
                        "the bus and the enumeration have different numbers of bits",
                        "compare a bus with a value of its own enumeration",
                    );
                }
                return Ok(self.coded(bits, &codes, place));
            }
            (Value::Bus(p), Value::Bus(q)) if p.len() == q.len() => {
                let mut parts = Vec::new();
                for (v, w) in p.iter().zip(q.iter()) {
                    let v = self.formulas.make(Op::Atom(*v), place);
                    let w = self.formulas.make(Op::Atom(*w), place);
                    parts.push(self.formulas.make(Op::Iff(v, w), place));
                }
                return Ok(self.formulas.and(parts, place));
            }
            (Value::Formula(f), Value::Formula(g)) => {
                let truths = (self.formulas.truth(*f), self.formulas.truth(*g));
                match truths {
                    (Some(a), Some(b)) => Some(a == b),
                    _ => None,
                }
            }
            (Value::Number(_), Value::Number(_))
            | (Value::Set(_), Value::Set(_))
            | (Value::Label(..), Value::Label(..)) => Some(x == y),
            _ => None,
        };
        match decided {
            Some(truth) => Ok(self.formulas.constant(truth, place)),
            None => self.fail(
                codes::TYPE_MISMATCH,
                &tree.range,
                site,
                format!("{} is compared with {} here", x.word(), y.word()),
                "`==` is for numbers, sets, and buses with values of their enumerations; for formulas it is `<->`",
            ),
        }
    }

    /// Whether a bus shows one of some codes.
    pub fn coded(&mut self, bits: &[VarId], codes: &[Vec<Option<bool>>], place: Place) -> F {
        let mut cases = Vec::new();
        for code in codes {
            let mut parts = Vec::new();
            for (bit, wanted) in bits.iter().zip(code) {
                let Some(wanted) = wanted else { continue };
                let atom = self.formulas.make(Op::Atom(*bit), place);
                parts.push(if *wanted {
                    atom
                } else {
                    self.formulas.make(Op::Not(atom), place)
                });
            }
            cases.push(self.formulas.and(parts, place));
        }
        self.formulas.or(cases, place)
    }
}

/// A finding with the calls it happened in, innermost first.
pub(super) fn located(
    mut finding: Diagnostic,
    site: u32,
    sites: &[Site],
    report: &Report,
) -> Diagnostic {
    let mut at = site;
    let mut shown = 0;
    while at != 0 && shown < 4 {
        let Some(found) = sites.get(at as usize) else {
            break;
        };
        let text = if found.with.is_empty() {
            "in this call".to_owned()
        } else {
            format!("for {}", found.with)
        };
        finding.labels.push((report.span(&found.range), text));
        shown += 1;
        at = found.outer;
    }
    finding
}
