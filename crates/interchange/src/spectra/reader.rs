//! A specification that grows while its declarations are read, and the names in it.

use super::dwyer;
use super::scope::{self, Cells, Scope};
use super::syntax::Define;
use super::value::Value;
use linewright_core::diagnostics::{Code, Diagnostic, codes, nearest};
use linewright_core::gr1::interval::{Interval, Problem, interval};
use linewright_core::gr1::monitors::{Monitors, Origin};
use linewright_core::gr1::{Domain, Expr, Owner, Side, Specification, Timing, VarId, Variable};
use linewright_core::source::{FileId, Span};
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

/// Monitors of past formulas are numbered from here until all variables are known.
const FIRST_MONITOR: u32 = 1 << 28;
/// Maximum number of operators and operands of an expanded formula.
const MAX_SIZE: u64 = 1 << 18;
/// And be so deep.
const MAX_DEPTH: u32 = 400;
/// Maximum number of operators and operands of all formulas of a file.
const MIN_BUDGET: u64 = 4 << 20;
/// What a formula takes beside them.
const FORMULA: u64 = 16;
/// Defines and predicates may use one another so deeply, all their formulas counted.
const MAX_EXPANSION: u32 = 400;
/// Maximum number of variables of a file, including elements of arrays.
pub(super) const MAX_VARIABLES: usize = 1 << 14;
/// Maximum number of unknown names for which a similar name is searched.
const MAX_GUESSES: usize = 50;

/// What a define came to, with what it mentions.
type Expansion = (Option<Value>, BTreeSet<(VarId, Span)>);

/// What a parameter, or a name bound by `forall`, stands for.
#[derive(Debug, Clone)]
pub(super) enum Binding {
    Value(Value),
    Cells(Cells),
    /// An array of formulas: `define a[2] := {..}`.
    Elements(Rc<Define>),
}

pub(super) struct Reader {
    pub findings: Vec<Diagnostic>,
    pub specification: Specification,
    /// The file that is read; others are imported.
    pub root: FileId,
    /// Names, by files.
    pub scopes: BTreeMap<FileId, Scope>,
    /// Of the published patterns.
    pub published: Scope,
    /// Monitors and counters.
    pub watchers: BTreeSet<VarId>,
    /// All values of enumerations.
    pub labels: BTreeSet<String>,
    pub monitors: Monitors,
    /// What is bound in the definition at hand; those of the definitions around it are not seen.
    pub frames: Vec<Vec<(String, Binding)>>,
    /// Definitions that are being expanded, by their names' places.
    pub open: Vec<Span>,
    /// What the formula at hand mentions, and where.
    pub mentions: BTreeSet<(VarId, Span)>,
    /// The assumption or guarantee at hand.
    pub origin: Origin,
    /// How often each stem was given to helpers.
    pub numbers: BTreeMap<String, u32>,
    /// Defines that were expanded, by their names' places. Nothing around a define is seen in it,
    /// so it is expanded once.
    pub expanded: BTreeMap<Span, Expansion>,
    depth: u32,
    budget: u64,
    exhausted: bool,
    guessed: usize,
    /// What was said already: a mistake in a definition is met at each of its uses.
    told: BTreeSet<(Span, &'static str, String)>,
    noted: BTreeSet<String>,
}

impl Reader {
    pub fn new(name: &str, root: FileId, length: usize, taken: Vec<String>) -> Self {
        Self {
            findings: Vec::new(),
            specification: Specification {
                name: name.to_owned(),
                timing: Timing::Mealy,
                variables: Vec::new(),
                assumptions: Side::default(),
                guarantees: Side::default(),
            },
            root,
            scopes: BTreeMap::new(),
            published: scope::published(),
            watchers: BTreeSet::new(),
            labels: BTreeSet::new(),
            monitors: Monitors::new(VarId(FIRST_MONITOR), taken),
            frames: vec![Vec::new()],
            open: Vec::new(),
            mentions: BTreeSet::new(),
            origin: Origin::default(),
            numbers: BTreeMap::new(),
            expanded: BTreeMap::new(),
            depth: 0,
            exhausted: false,
            told: BTreeSet::new(),
            budget: MIN_BUDGET + 8 * length as u64,
            guessed: 0,
            noted: BTreeSet::new(),
        }
    }

    pub fn error(
        &mut self,
        code: Code,
        span: Span,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        let message = message.into();
        if self.told.insert((span, code.id, message.clone())) {
            self.findings
                .push(Diagnostic::error(code, span, message).with_help(help));
        }
    }

    /// A note, once a message.
    pub fn note(
        &mut self,
        code: Code,
        span: Span,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        let message = message.into();
        if self.noted.insert(message.clone()) {
            self.findings
                .push(Diagnostic::note(code, span, message).with_help(help));
        }
    }

    /// Adds a variable, or those of an array.
    pub fn variables(
        &mut self,
        name: &str,
        owner: Owner,
        internal: bool,
        (domain, sizes): (Domain, Vec<i64>),
        span: Span,
    ) -> Option<Cells> {
        let first = VarId(self.specification.variables.len() as u32);
        let count = sizes
            .iter()
            .try_fold(1_usize, |n, s| n.checked_mul(usize::try_from(*s).ok()?))
            .filter(|n| {
                *n <= MAX_VARIABLES - self.specification.variables.len().min(MAX_VARIABLES)
            });
        let Some(count) = count else {
            self.error(
                codes::DOMAIN_EMPTY,
                span,
                format!("the file would have more than {MAX_VARIABLES} variables"),
                "use smaller arrays",
            );
            return None;
        };
        for element in 0..count {
            let mut suffix = String::new();
            let mut rest = element;
            for size in sizes.iter().rev() {
                let size = *size as usize;
                suffix = format!("[{}]{suffix}", rest % size);
                rest /= size;
            }
            self.specification.variables.push(Variable {
                name: format!("{name}{suffix}"),
                owner,
                internal,
                unit: String::new(),
                domain: domain.clone(),
                span,
            });
        }
        Some(Cells {
            first,
            sizes,
            domain,
        })
    }

    /// A name that nothing has yet: `stem_1`, `stem_2` ...
    pub fn fresh(&mut self, stem: &str) -> String {
        let number = self.numbers.entry(stem.to_owned()).or_default();
        loop {
            *number += 1;
            let name = format!("{stem}_{number}");
            let taken = |scope: &Scope| scope.symbols.contains_key(&name);
            if !self.scopes.get(&self.root).is_some_and(taken) {
                return name;
            }
        }
    }

    /// What a bound name stands for.
    pub fn bound(&self, name: &str) -> Option<&Binding> {
        let frame = self.frames.last()?;
        let found = frame.iter().rev().find(|(n, _)| n == name);
        found.map(|(_, binding)| binding)
    }

    /// Reports a name that is not declared.
    pub fn unknown(&mut self, what: &str, name: &str, span: Span) {
        if let Some(declared) = self.left_behind(name, span) {
            let message = format!(
                "`{name}` stays in its file: imports bring in no variables, monitors and counters"
            );
            if self
                .told
                .insert((span, codes::NAME_UNKNOWN.id, message.clone()))
            {
                self.findings.push(
                    Diagnostic::error(codes::NAME_UNKNOWN, span, message)
                        .with_label(declared, "declared here")
                        .with_help(
                            "declare it in the file that imports, and give it to predicates and patterns as an argument",
                        ),
                );
            }
            return;
        }
        self.guessed += 1;
        let near = if self.guessed > MAX_GUESSES {
            None
        } else if what == "type" {
            nearest(name, self.seen_types(span)).map(str::to_owned)
        } else {
            let bound = self.frames.last().into_iter().flatten().map(|(n, _)| n);
            let others = self.labels.iter().chain(bound).map(String::as_str);
            nearest(name, self.seen(span).chain(others)).map(str::to_owned)
        };
        let help = match near {
            _ if self.published.symbols.contains_key(name) => format!(
                "it is one of the published patterns: write `import \"{}\"` before `spec`",
                dwyer::FILE
            ),
            Some(near) => format!("did you mean `{near}`?"),
            None if what == "type" => "declare it: `type T = {a, b};`".to_owned(),
            None => "declare it, as a variable, a value of an enumeration, a define, a predicate or a pattern".to_owned(),
        };
        let message = format!("the {what} `{name}` is not declared");
        self.error(codes::NAME_UNKNOWN, span, message, help);
    }

    /// Goes one step down in a formula or a definition; [`up`](Self::up) goes back.
    pub fn down(&mut self, span: Span) -> Option<()> {
        self.spend(1, span)?;
        self.depth += 1;
        if self.depth > MAX_EXPANSION {
            self.too_large(span, "nest too deeply once their definitions are put in");
            self.depth -= 1;
            return None;
        }
        Some(())
    }

    pub fn up(&mut self) {
        self.depth -= 1;
    }

    /// Takes work from what the file may have. What is not there is said once.
    pub fn spend(&mut self, work: u64, span: Span) -> Option<()> {
        if work <= self.budget && !self.exhausted {
            self.budget -= work;
            return Some(());
        }
        if !self.exhausted {
            self.exhausted = true;
            self.too_large(span, "become too large, all in all");
        }
        None
    }

    fn too_large(&mut self, span: Span, why: &str) {
        self.error(
            codes::TOO_LARGE,
            span,
            format!("the formulas here {why}"),
            "use fewer definitions in one another, or take the formula apart",
        );
    }

    /// The value, unless it became too large.
    pub fn sized(&mut self, value: Value, span: Span) -> Option<Value> {
        if value.size > MAX_SIZE {
            self.too_large(span, "become too large once their definitions are put in");
            return None;
        }
        if value.depth > MAX_DEPTH {
            self.too_large(span, "nest too deeply once their definitions are put in");
            return None;
        }
        self.spend(value.size / 8, span)?;
        Some(value)
    }

    /// Takes a finished formula's size from what the file may have, and looks at its numbers.
    pub fn finished(&mut self, expr: &Expr, size: u64, span: Span) -> Option<()> {
        self.spend(size + FORMULA, span)?;
        let domain = |v: VarId| self.interval(v);
        match interval(expr, &domain) {
            Ok(_) => Some(()),
            Err(Problem::DivisorZero) => {
                self.error(
                    codes::DIVISION,
                    span,
                    "a divisor in this formula can be zero",
                    "divide by a number or by a variable whose range leaves 0 out",
                );
                None
            }
            Err(Problem::TooLarge) => {
                self.error(
                    codes::NUMBER_RANGE,
                    span,
                    "the numbers in this formula become too large to count with",
                    "multiply less",
                );
                None
            }
        }
    }

    pub fn interval(&self, v: VarId) -> Interval {
        Interval::of(&self.variable(v).domain)
    }

    /// A variable or a monitor.
    pub fn variable(&self, v: VarId) -> &Variable {
        match self.monitors.get(v) {
            Some(monitor) => &monitor.variable,
            None => self.specification.variable(v),
        }
    }

    /// The specification with its monitors among the variables, and what was found.
    pub fn finish(mut self) -> (Specification, Vec<Diagnostic>) {
        self.monitors.define(&mut self.specification.guarantees);
        let shift = FIRST_MONITOR - self.specification.variables.len() as u32;
        self.specification
            .variables
            .extend(self.monitors.variables().cloned());
        let Specification {
            assumptions,
            guarantees,
            ..
        } = &mut self.specification;
        for side in [assumptions, guarantees] {
            let lists = [
                &mut side.initial,
                &mut side.invariants,
                &mut side.safety,
                &mut side.justice,
            ];
            for formula in lists.into_iter().flatten() {
                formula.expr = formula.expr.substitute(&mut |v, time| {
                    Expr::Var(
                        VarId(if v.0 < FIRST_MONITOR {
                            v.0
                        } else {
                            v.0 - shift
                        }),
                        time,
                    )
                });
            }
        }
        (self.specification, self.findings)
    }
}
