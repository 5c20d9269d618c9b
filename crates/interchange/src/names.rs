//! Declarations, and the rules about which section can refer to which variables.
//!
//! | section | environment | system |
//! |---|---|---|
//! | initial | current inputs | current values |
//! | transition | current values, next inputs | all |
//! | goal | all | all |

use super::terms::{Kind, MAX_DEPTH, Term, TermLimit, Terms};
use linewright_core::diagnostics::{Code, Diagnostic, codes, nearest};
use linewright_core::gr1::interval::{Interval, interval};
use linewright_core::gr1::{
    BinaryOp, Domain, Expr, Formula, Owner, Side, Specification, Time, Timing, VarId, Variable,
};
use linewright_core::source::{FileId, Span};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// Maximum number of values of a domain, the same as in contracts.
const MAX_DOMAIN: i64 = 1 << 20;
/// Exclusive upper bound of the numbers in formulas.
const MAX_NUMBER: i64 = 1 << 40;
/// Maximum number of operators and operands in all expanded formulas of an empty file. Each byte of
/// a file adds 8.
const MIN_BUDGET: u64 = 4 << 20;

/// Maximum number of unknown names for which a similar name is searched, because the search takes
/// time.
const MAX_GUESSES: usize = 50;

/// The kind of a section of formulas.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Part {
    Initial,
    Transition,
    Goal,
}

/// A section of formulas.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Section {
    pub owner: Owner,
    pub part: Part,
    /// Name of the section in the file, such as `SYSTRANS`.
    pub name: &'static str,
}

/// An occurrence of a variable in a formula.
#[derive(Debug, Clone)]
struct Mention {
    var: VarId,
    time: Time,
    range: Range<usize>,
}

/// The specification under construction, with its variables by name and the findings so far.
pub(super) struct Names<'t> {
    pub text: &'t str,
    pub terms: Terms,
    pub findings: Vec<Diagnostic>,
    file: FileId,
    specification: Specification,
    by_name: BTreeMap<&'t str, VarId>,
    /// Variables whose numeric domain was refused. They have a substitute domain, which must not
    /// cause further findings.
    refused: BTreeSet<VarId>,
    /// Variables mentioned so far in the current formula.
    mentions: Vec<Mention>,
    counts: BTreeMap<Section, usize>,
    budget: u64,
    /// Messages of the notes so far.
    noted: BTreeSet<String>,
    /// Number of unknown names so far.
    guessed: usize,
}

impl<'t> Names<'t> {
    pub fn new(name: &str, file: FileId, text: &'t str) -> Self {
        Self {
            text,
            terms: Terms::default(),
            findings: Vec::new(),
            file,
            specification: Specification {
                name: name.to_owned(),
                timing: Timing::Mealy,
                variables: Vec::new(),
                assumptions: Side::default(),
                guarantees: Side::default(),
            },
            by_name: BTreeMap::new(),
            refused: BTreeSet::new(),
            mentions: Vec::new(),
            counts: BTreeMap::new(),
            budget: MIN_BUDGET + 8 * text.len() as u64,
            noted: BTreeSet::new(),
            guessed: 0,
        }
    }

    /// Returns the specification and the findings.
    pub fn finish(self) -> (Specification, Vec<Diagnostic>) {
        (self.specification, self.findings)
    }

    /// The specification so far, for lowerings to modify.
    pub fn specification(&mut self) -> &mut Specification {
        &mut self.specification
    }

    pub fn span(&self, range: Range<usize>) -> Span {
        Span::new(self.file, range.start, range.end)
    }

    pub fn error(
        &mut self,
        code: Code,
        range: Range<usize>,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        let span = self.span(range);
        self.findings
            .push(Diagnostic::error(code, span, message).with_help(help));
    }

    pub fn syntax(
        &mut self,
        range: Range<usize>,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        self.error(codes::SYNTAX, range, message, help);
    }

    /// Reports a note, unless one with the same message was reported.
    pub fn note(
        &mut self,
        code: Code,
        range: Range<usize>,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        let (span, message) = (self.span(range), message.into());
        if self.noted.insert(message.clone()) {
            self.findings
                .push(Diagnostic::note(code, span, message).with_help(help));
        }
    }

    /// Declares a variable; reports a second declaration of the same name.
    pub fn declare(&mut self, owner: Owner, name: &'t str, domain: Domain, range: Range<usize>) {
        if let Some(first) = self.by_name.get(name) {
            let first = self.specification.variable(*first).span;
            let finding = Diagnostic::error(
                codes::NAME_DUPLICATE,
                self.span(range),
                format!("the variable `{}` is declared twice", quoted(name)),
            )
            .with_label(first, "declared here first")
            .with_help("declare each variable once, as the environment's or as the system's");
            self.findings.push(finding);
            return;
        }
        let span = self.span(range);
        self.by_name
            .insert(name, VarId(self.specification.variables.len() as u32));
        self.specification.variables.push(Variable {
            name: name.to_owned(),
            owner,
            internal: false,
            unit: String::new(),
            domain,
            span,
        });
    }

    /// Declares a number whose domain was refused, so that its uses cause no findings.
    pub fn declare_refused(&mut self, owner: Owner, name: &'t str, range: Range<usize>) {
        let id = VarId(self.specification.variables.len() as u32);
        self.declare(owner, name, Domain::Range { low: 0, high: 1 }, range);
        if self.specification.variables.len() > id.index() {
            self.refused.insert(id);
        }
    }

    /// Whether the domain of a variable was refused.
    pub fn is_refused(&self, var: VarId) -> bool {
        self.refused.contains(&var)
    }

    /// Whether the current formula refers to a number whose domain was refused.
    pub fn mentions_refused(&self) -> bool {
        self.mentions.iter().any(|m| self.is_refused(m.var))
    }

    /// Declares a Boolean helper variable of the system; its name is `wanted`, made unique.
    pub fn helper(&mut self, wanted: &str) -> VarId {
        let mut name = wanted.to_owned();
        while self.specification.variables.iter().any(|v| v.name == name) {
            name.push('_');
        }
        self.specification.variables.push(Variable {
            name,
            owner: Owner::System,
            internal: true,
            unit: String::new(),
            domain: Domain::Bool,
            span: self.span(0..0),
        });
        VarId(self.specification.variables.len() as u32 - 1)
    }

    /// The domain `low..=high`. If it is empty or too large, reports this and returns `None`.
    pub fn domain(&mut self, low: i64, high: i64, range: Range<usize>) -> Option<Domain> {
        if low > high {
            self.error(
                codes::DOMAIN_EMPTY,
                range,
                format!("the domain from {low} to {high} is empty"),
                "write the smaller number first",
            );
            return None;
        }
        if high.saturating_sub(low) >= MAX_DOMAIN {
            self.error(
                codes::DOMAIN_EMPTY,
                range,
                format!("the domain has more than {MAX_DOMAIN} values"),
                "use a coarser abstraction",
            );
            return None;
        }
        Some(Domain::Range { low, high })
    }

    /// Parses a number. If it is not a whole number or is too large, reports this and returns
    /// `None`.
    pub fn number(&mut self, digits: &str, range: Range<usize>) -> Option<i64> {
        match digits.parse::<i64>() {
            Ok(value) if value.unsigned_abs() < MAX_NUMBER.unsigned_abs() => Some(value),
            _ => {
                self.error(
                    codes::NUMBER_RANGE,
                    range,
                    "this number has a fraction or is too large",
                    format!("write a whole number smaller than {MAX_NUMBER}"),
                );
                None
            }
        }
    }

    /// The variable called `name`, and the kind of its values; `None` if there is no such variable.
    pub fn find(&self, name: &str) -> Option<(VarId, Kind)> {
        let var = *self.by_name.get(name)?;
        let kind = match self.specification.variable(var).domain {
            Domain::Bool => Kind::Bool,
            _ => Kind::Int,
        };
        Some((var, kind))
    }

    /// Smallest and largest value of a variable.
    pub fn bounds(&self, var: VarId) -> (i64, i64) {
        let domain = &self.specification.variable(var).domain;
        (domain.low(), domain.high())
    }

    /// The player that chooses the variable's value.
    pub fn owner(&self, var: VarId) -> Owner {
        self.specification.variable(var).owner
    }

    /// Number of mentions so far in the current formula, for [`Self::primed`].
    pub fn mark(&self) -> usize {
        self.mentions.len()
    }

    /// Records a mention of a variable in the current formula, and returns its term.
    pub fn mention(&mut self, var: VarId, kind: Kind, time: Time, range: Range<usize>) -> Term {
        self.mentions.push(Mention { var, time, range });
        self.terms.var(var, time, kind)
    }

    /// The term with next values in place of current ones. `mark` is the result of [`Self::mark`]
    /// before the term's first variable was mentioned.
    pub fn primed(&mut self, term: Term, mark: usize) -> Term {
        for mention in &mut self.mentions[mark..] {
            mention.time = Time::Next;
        }
        self.terms.primed(term)
    }

    /// Reports an undeclared name.
    pub fn unknown(&mut self, name: &str, range: Range<usize>) {
        let name = quoted(name);
        let near = if self.guessed < MAX_GUESSES {
            nearest(&name, self.by_name.keys().copied())
        } else {
            None
        };
        self.guessed += 1;
        let help = match near {
            Some(near) => format!("did you mean `{near}`?"),
            None => "declare it as a variable of the environment or of the system".to_owned(),
        };
        let message = format!("`{name}` is not declared");
        self.error(codes::NAME_UNKNOWN, range, message, help);
    }

    /// Discards the current formula.
    pub fn forget(&mut self) {
        self.mentions.clear();
        self.terms.clear();
    }

    /// Ends the current formula, and adds it to its section unless it is invalid.
    ///
    /// `term` is `None` if the formula could not be parsed; `range` is the formula's text. The
    /// number in a formula's name counts invalid formulas, too, so that it matches the file.
    pub fn formula(&mut self, section: Section, term: Option<Term>, range: Range<usize>) {
        let count = self.counts.entry(section).or_default();
        *count += 1;
        let number = *count;
        if let Some(term) = term
            && self.is_permitted(section)
            && let Some(expr) = self.tree(term, &range)
        {
            let formula = Formula {
                defines: false,
                name: format!("{} {number}", section.name),
                requirement: None,
                expr,
                span: self.span(range.clone()),
                text: one_line(&self.text[range]),
            };
            self.list(section).push(formula);
        }
        self.forget();
    }

    /// The list of formulas that a section belongs to.
    pub fn list(&mut self, section: Section) -> &mut Vec<Formula> {
        let side = match section.owner {
            Owner::Environment => &mut self.specification.assumptions,
            Owner::System => &mut self.specification.guarantees,
        };
        match section.part {
            Part::Initial => &mut side.initial,
            Part::Transition => &mut side.safety,
            Part::Goal => &mut side.justice,
        }
    }

    /// The term as a tree. If it is too deep or too large, or if its numbers overflow, reports this
    /// and returns `None`.
    pub fn tree(&mut self, term: Term, range: &Range<usize>) -> Option<Expr> {
        let size = self.terms.size(term);
        let tree = match self.terms.tree(term) {
            Ok(_) if size > self.budget => Err(TermLimit::Large),
            other => other,
        };
        let expr = match tree {
            Ok(expr) => expr,
            Err(why) => {
                let message = match why {
                    TermLimit::Deep => {
                        format!("this formula nests more than {MAX_DEPTH} levels deep")
                    }
                    TermLimit::Large => {
                        "this formula becomes too large after its memory cells are expanded"
                            .to_owned()
                    }
                };
                let help = "introduce variables for parts of the formula";
                self.error(codes::TOO_LARGE, range.clone(), message, help);
                return None;
            }
        };
        self.budget -= size;
        let domain = |v: VarId| Interval::of(&self.specification.variable(v).domain);
        if interval(&expr, &domain).is_err() {
            self.error(
                codes::NUMBER_RANGE,
                range.clone(),
                "the numbers in this formula become too large",
                "use smaller numbers or fewer multiplications",
            );
            return None;
        }
        Some(expr)
    }

    /// Whether the current formula refers only to variables that its section allows. Reports each
    /// other variable.
    fn is_permitted(&mut self, section: Section) -> bool {
        let mut shown: Vec<VarId> = Vec::new();
        let mut findings = Vec::new();
        for mention in &self.mentions {
            let variable = self.specification.variable(mention.var);
            let (name, span) = (quoted(&variable.name), self.span(mention.range.clone()));
            let outputs = variable.owner == Owner::System;
            let next = mention.time == Time::Next;
            let finding = match (section.part, section.owner) {
                (Part::Initial, _) if next => Diagnostic::error(
                    codes::NOT_GR1,
                    span,
                    format!("an initial condition refers to the next value of `{name}`"),
                )
                .with_help("refer to current values only, or move the formula to the transitions"),
                (Part::Initial, Owner::Environment) if outputs => Diagnostic::error(
                    codes::NOT_CONTROLLED,
                    span,
                    format!("this assumption constrains `{name}`, which the system chooses"),
                )
                .with_help("the environment chooses first: refer only to its own variables in its initial condition"),
                (Part::Transition, Owner::Environment) if outputs && next => Diagnostic::error(
                    codes::NEXT_OUTPUT_ASSUMED,
                    span,
                    format!("this assumption refers to the next value of `{name}`, which the system chooses after the environment has moved"),
                )
                .with_help(format!(
                    "the environment moves before `{name}'` is known: use `{name}` without the prime, and let the environment react one step later"
                )),
                _ => continue,
            };
            if !shown.contains(&mention.var) {
                shown.push(mention.var);
                findings.push(finding);
            }
        }
        self.findings.append(&mut findings);
        shown.is_empty()
    }
}

/// The text for messages, cut off after 40 characters.
pub(super) fn quoted(text: &str) -> String {
    const LENGTH: usize = 40;
    match text.char_indices().nth(LENGTH) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_owned(),
    }
}

/// The text on one line, without `#` comments.
pub(super) fn one_line(text: &str) -> String {
    let lines = text.lines().map(|l| l.split('#').next().unwrap_or(l));
    let words: Vec<&str> = lines.flat_map(str::split_whitespace).collect();
    words.join(" ")
}

/// `value - value mod 2^bits + low`: replaces the lowest `bits` bits of `value` with `low`.
pub(super) fn overwrite_low_bits(terms: &mut Terms, low: Term, value: Term, bits: u32) -> Term {
    let power = terms.int(1 << bits);
    let rest = terms.binary(BinaryOp::Mod, value, power);
    let high = terms.binary(BinaryOp::Sub, value, rest);
    terms.binary(BinaryOp::Add, high, low)
}

/// The term for one bit of a variable: whether bit `k` of the variable's distance from its smallest
/// value is set.
pub(super) fn bit(
    names: &mut Names<'_>,
    var: VarId,
    k: u32,
    time: Time,
    range: Range<usize>,
) -> Term {
    let low = names.bounds(var).0;
    let value = names.mention(var, Kind::Int, time, range);
    let terms = &mut names.terms;
    let base = terms.int(low);
    let offset = terms.binary(BinaryOp::Sub, value, base);
    let power = terms.int(1 << k);
    let shifted = terms.binary(BinaryOp::Div, offset, power);
    let two = terms.int(2);
    let bit = terms.binary(BinaryOp::Mod, shifted, two);
    let one = terms.int(1);
    terms.binary(BinaryOp::Eq, bit, one)
}
