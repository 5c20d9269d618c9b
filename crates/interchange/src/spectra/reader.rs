//! The state of reading a Spectra file: the specification so far, its names and its limits.

use super::definition::{self, Group};
use super::dwyer;
use super::scope::{self, Cells, Scope};
use super::syntax::Define;
use super::value::Value;
use linewright_core::diagnostics::{Code, Diagnostic, codes, nearest};
use linewright_core::gr1::interval::{Interval, IntervalError, interval};
use linewright_core::gr1::monitors::{Monitors, Origin};
use linewright_core::gr1::{Domain, Expr, Owner, Side, Specification, Timing, VarId, Variable};
use linewright_core::source::{FileId, Span};
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

/// Temporary id of the first monitor of a past formula. The final ids follow those of all other
/// variables, whose number is not known while the file is read.
const FIRST_MONITOR: u32 = 1 << 28;
/// Maximum number of operators and operands of an expanded formula.
const MAX_SIZE: u64 = 1 << 18;
/// Maximum depth of an expanded formula.
const MAX_DEPTH: u32 = 400;
/// Maximum number of operators and operands in all formulas of an empty file. Each byte of a file
/// adds 8.
const MIN_BUDGET: u64 = 4 << 20;
/// Cost of each formula in the budget, in addition to its size.
const FORMULA: u64 = 16;
/// Maximum nesting depth of formulas, including those of expanded definitions.
const MAX_EXPANSION: u32 = 400;
/// Maximum number of variables of a file, including elements of arrays.
pub(super) const MAX_VARIABLES: usize = 1 << 14;
/// Maximum number of unknown names for which a similar name is searched.
const MAX_GUESSES: usize = 50;

/// Value of an expanded define, and the variables that it mentions.
type Expansion = (Option<Value>, BTreeSet<(VarId, Span)>);

/// The meaning of a parameter or of a name bound by a quantifier.
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
    /// The main file; all others are imported.
    pub root: FileId,
    /// Names of each file.
    pub scopes: BTreeMap<FileId, Scope>,
    /// Names of the published patterns.
    pub published: Scope,
    /// Variables of monitors and counters.
    pub watchers: BTreeSet<VarId>,
    /// The values of all enumerations.
    pub labels: BTreeSet<String>,
    pub monitors: Monitors,
    /// Monitors, counters and uses of patterns, with their formulas.
    pub groups: Vec<Group>,
    /// Bound names, one frame per open definition; only the last frame is visible.
    pub frames: Vec<Vec<(String, Binding)>>,
    /// Locations of the names of the definitions that are being expanded.
    pub open: Vec<Span>,
    /// Variables that the current formula mentions, with locations.
    pub mentions: BTreeSet<(VarId, Span)>,
    /// The current assumption or guarantee.
    pub origin: Origin,
    /// Names of the assumptions and guarantees so far.
    pub statement_names: BTreeSet<String>,
    /// Number of helper variables for each stem.
    pub numbers: BTreeMap<String, u32>,
    /// Expanded defines, by the locations of their names. The value of a define does not depend on
    /// its context, so it is expanded once.
    pub expanded: BTreeMap<Span, Expansion>,
    depth: u32,
    budget: u64,
    exhausted: bool,
    guessed: usize,
    /// Findings reported so far, so that an error in a definition is reported only once although it
    /// occurs at each use.
    shown: BTreeSet<(Span, &'static str, String)>,
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
            groups: Vec::new(),
            frames: vec![Vec::new()],
            open: Vec::new(),
            mentions: BTreeSet::new(),
            origin: Origin::default(),
            statement_names: BTreeSet::new(),
            numbers: BTreeMap::new(),
            expanded: BTreeMap::new(),
            depth: 0,
            exhausted: false,
            shown: BTreeSet::new(),
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
        if self.shown.insert((span, code.id, message.clone())) {
            self.findings
                .push(Diagnostic::error(code, span, message).with_help(help));
        }
    }

    /// Reports a note, unless one with the same message was reported.
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

    /// Adds a variable, or all variables of an array. If there are too many variables, reports this
    /// and returns `None`.
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
                format!("the file has more than {MAX_VARIABLES} variables"),
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

    /// An unused name: `stem_1`, `stem_2`, ...
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

    /// The binding of a name, if it is a visible parameter or quantified name.
    pub fn bound(&self, name: &str) -> Option<&Binding> {
        let frame = self.frames.last()?;
        let found = frame.iter().rev().find(|(n, _)| n == name);
        found.map(|(_, binding)| binding)
    }

    /// Reports an undeclared name; `what` is the expected kind of name.
    pub fn unknown(&mut self, what: &str, name: &str, span: Span) {
        if let Some(declared) = self.not_imported(name, span) {
            let message = format!(
                "`{name}` is not imported: imports do not include variables, monitors and counters"
            );
            if self
                .shown
                .insert((span, codes::NAME_UNKNOWN.id, message.clone()))
            {
                self.findings.push(
                    Diagnostic::error(codes::NAME_UNKNOWN, span, message)
                        .with_label(declared, "declared here")
                        .with_help(
                            "declare it in the importing file, and pass it to predicates and patterns as an argument",
                        ),
                );
            }
            return;
        }
        self.guessed += 1;
        let near = if self.guessed > MAX_GUESSES {
            None
        } else if what == "type" {
            nearest(name, self.visible_types(span)).map(str::to_owned)
        } else {
            let bound = self.frames.last().into_iter().flatten().map(|(n, _)| n);
            let others = self.labels.iter().chain(bound).map(String::as_str);
            nearest(name, self.visible_names(span).chain(others)).map(str::to_owned)
        };
        let help = match near {
            _ if self.published.symbols.contains_key(name) => format!(
                "it is one of the published patterns: write `import \"{}\"` before `spec`",
                dwyer::FILE
            ),
            Some(near) => format!("did you mean `{near}`?"),
            None if what == "type" => "declare it: `type T = {a, b};`".to_owned(),
            None => "declare it as a variable, a value of an enumeration, a define, a predicate or a pattern".to_owned(),
        };
        let message = format!("the {what} `{name}` is not declared");
        self.error(codes::NAME_UNKNOWN, span, message, help);
    }

    /// Enters a nested formula or definition; [`up`](Self::up) leaves it.
    pub fn down(&mut self, span: Span) -> Option<()> {
        self.spend(1, span)?;
        self.depth += 1;
        if self.depth > MAX_EXPANSION {
            self.too_large(span, "nest too deeply after their definitions are expanded");
            self.depth -= 1;
            return None;
        }
        Some(())
    }

    pub fn up(&mut self) {
        self.depth -= 1;
    }

    /// Takes `work` from the file's budget. If the budget is exhausted, returns `None`, and reports
    /// this the first time.
    pub fn spend(&mut self, work: u64, span: Span) -> Option<()> {
        if work <= self.budget && !self.exhausted {
            self.budget -= work;
            return Some(());
        }
        if !self.exhausted {
            self.exhausted = true;
            self.too_large(span, "are too large in total");
        }
        None
    }

    fn too_large(&mut self, span: Span, why: &str) {
        self.error(
            codes::TOO_LARGE,
            span,
            format!("these formulas {why}"),
            "nest fewer definitions, or split the formula",
        );
    }

    /// Returns `value`. If it is too large or too deep, reports this and returns `None`.
    pub fn check_size(&mut self, value: Value, span: Span) -> Option<Value> {
        if value.size > MAX_SIZE {
            self.too_large(
                span,
                "become too large after their definitions are expanded",
            );
            return None;
        }
        if value.depth > MAX_DEPTH {
            self.too_large(span, "nest too deeply after their definitions are expanded");
            return None;
        }
        self.spend(value.size / 8, span)?;
        Some(value)
    }

    /// Takes the size of a finished formula from the budget, and checks its numbers for overflow
    /// and division by zero.
    pub fn check_finished(&mut self, expr: &Expr, size: u64, span: Span) -> Option<()> {
        self.spend(size + FORMULA, span)?;
        let domain = |v: VarId| self.interval(v);
        match interval(expr, &domain) {
            Ok(_) => Some(()),
            Err(IntervalError::DivisorZero) => {
                self.error(
                    codes::DIVISION,
                    span,
                    "a divisor in this formula can be zero",
                    "divide by a number or by a variable whose range excludes 0",
                );
                None
            }
            Err(IntervalError::TooLarge) => {
                self.error(
                    codes::NUMBER_RANGE,
                    span,
                    "the numbers in this formula become too large",
                    "use smaller numbers or fewer multiplications",
                );
                None
            }
        }
    }

    pub fn interval(&self, v: VarId) -> Interval {
        Interval::of(&self.variable(v).domain)
    }

    /// The variable with an id, or the monitor's variable if the id is that of a monitor.
    pub fn variable(&self, v: VarId) -> &Variable {
        match self.monitors.get(v) {
            Some(monitor) => &monitor.variable,
            None => self.specification.variable(v),
        }
    }

    /// Adds the monitors to the specification. Returns the specification and the findings.
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
        for group in &self.groups {
            definition::mark(&mut self.specification, group);
        }
        (self.specification, self.findings)
    }
}
