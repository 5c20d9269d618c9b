//! Conversion of pest's pairs to the syntax tree.
//!
//! Each grammar rule has one function here, with nearly the same name. The grammar guarantees which
//! children a pair has. If one is missing nevertheless, [`Children::next`] panics with a message
//! that asks for a bug report.

mod contract;
mod expression;
mod line;
mod machine;
mod pattern;
mod recipe;
mod skills;

use super::ast::{
    Argument, ConstDecl, Define, File, Formal, Header, Import, Item, Name, Parameter, TypeDecl,
};
use super::parser::{Rule, explain};
use super::value::{Value, ValueSyntax};
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::source::{FileId, Span};
use pest::iterators::{Pair, Pairs};

pub(super) use expression::{MAX_CHAIN, small_enough_for_the_middle};

pub(super) struct Builder {
    pub tree: File,
    pub findings: Vec<Diagnostic>,
    file: FileId,
    /// Length of the file. Places are limited to it, because a mended copy can be longer.
    length: usize,
    /// Number of expressions that contain the one being built.
    level: usize,
}

/// Children of a pair, without keywords and punctuation.
struct Children<'a> {
    pairs: std::iter::Peekable<std::vec::IntoIter<Pair<'a, Rule>>>,
}

impl<'a> Children<'a> {
    fn of(pair: Pair<'a, Rule>) -> Self {
        let pairs: Vec<_> = pair
            .into_inner()
            .filter(|p| {
                !matches!(
                    p.as_rule(),
                    Rule::open_brace
                        | Rule::open_bracket
                        | Rule::arrow
                        | Rule::dots
                        | Rule::close_paren
                        | Rule::close_bracket
                        | Rule::close_brace
                        | Rule::colon
                        | Rule::equals
                        | Rule::comma
                        | Rule::ampersand
                        | Rule::bar
                ) && !is_keyword(p.as_rule())
            })
            .collect();
        Self {
            pairs: pairs.into_iter().peekable(),
        }
    }

    fn next(&mut self) -> Pair<'a, Rule> {
        self.pairs.next().unwrap_or_else(|| {
            unreachable!("the grammar and its builder disagree; please report this")
        })
    }

    fn take(&mut self, rule: Rule) -> Option<Pair<'a, Rule>> {
        self.pairs.next_if(|p| p.as_rule() == rule)
    }

    fn rest(self) -> impl Iterator<Item = Pair<'a, Rule>> {
        self.pairs
    }
}

impl Builder {
    pub fn new(file: FileId, length: usize) -> Self {
        Self {
            tree: File::default(),
            findings: Vec::new(),
            file,
            length,
            level: 0,
        }
    }

    pub fn file(&mut self, pairs: Pairs<'_, Rule>) {
        for pair in pairs.flat_map(Pair::into_inner) {
            self.place(&pair);
            match pair.as_rule() {
                Rule::import => {
                    let item = self.import(pair);
                    self.tree.items.push(Item::Import(item));
                }
                Rule::type_decl => {
                    let item = self.type_decl(pair);
                    self.tree.items.push(Item::Type(item));
                }
                Rule::const_decl => {
                    let item = self.const_decl(pair);
                    self.tree.items.push(Item::Const(item));
                }
                Rule::define => {
                    let item = self.define(pair);
                    self.tree.items.push(Item::Define(item));
                }
                Rule::contract => {
                    let item = self.contract(pair);
                    self.tree.items.push(Item::Contract(item));
                }
                Rule::machine => {
                    let item = self.machine(pair);
                    self.tree.items.push(Item::Machine(item));
                }
                Rule::line => {
                    let item = self.line(pair);
                    self.tree.items.push(Item::Line(item));
                }
                Rule::skills => {
                    let item = self.skills(pair);
                    self.tree.items.push(Item::Skills(item));
                }
                Rule::layout => {
                    let item = self.layout(pair);
                    self.tree.items.push(Item::Layout(item));
                }
                Rule::recipe => {
                    let item = self.recipe(pair);
                    self.tree.items.push(Item::Recipe(item));
                }
                Rule::realize => {
                    let item = self.realize(pair);
                    self.tree.items.push(Item::Realize(item));
                }
                Rule::bad_item => self.bad(&pair),
                _ => {}
            }
        }
    }

    /// Builds a value that stands alone.
    pub fn value(&mut self, pairs: Pairs<'_, Rule>, syntax: ValueSyntax) -> Value {
        let pairs: Vec<_> = pairs.flat_map(Pair::into_inner).collect();
        let mut c = Children {
            pairs: pairs.into_iter().peekable(),
        };
        match syntax {
            ValueSyntax::Count => Value::Count(self.count(&c.next())),
            ValueSyntax::Parts => Value::Parts(self.parts_between(c.next())),
            ValueSyntax::Time | ValueSyntax::Interval => {
                let random = c.take(Rule::random).is_some();
                Value::Time(self.duration(c.next()), random)
            }
            ValueSyntax::Expression
            | ValueSyntax::ActionTime
            | ValueSyntax::Bound
            | ValueSyntax::Limit => {
                let value = self.expr(c.next());
                let words = c.pairs.peek().is_some_and(|p| p.as_rule() != Rule::EOI);
                Value::Expression(value, words)
            }
        }
    }

    /// Returns the place of a pair, without the trailing blanks and comments that pest includes.
    fn span(&self, pair: &Pair<'_, Rule>) -> Span {
        let span = pair.as_span();
        let trimmed = span.as_str().trim_end();
        let mut end = span.start() + trimmed.len();
        if trimmed.contains("//") || trimmed.contains("*/") {
            let mut last = pair.clone();
            while let Some(child) = last.clone().into_inner().next_back() {
                last = child;
            }
            end = last.as_span().start() + last.as_str().trim_end().len();
        }
        Span::new(
            self.file,
            span.start().min(self.length),
            end.min(self.length),
        )
    }

    /// Records the place of an item.
    fn place(&mut self, pair: &Pair<'_, Rule>) {
        if pair.as_rule() != Rule::EOI {
            let span = self.span(pair);
            self.tree.places.push(span);
        }
    }

    fn bad(&mut self, pair: &Pair<'_, Rule>) {
        let finding = explain(
            self.file,
            pair.as_span().start(),
            pair.as_str(),
            pair.as_rule(),
        );
        self.findings.push(finding);
    }

    fn name(&self, pair: &Pair<'_, Rule>) -> Name {
        Name {
            text: pair.as_str().trim().to_owned(),
            span: self.span(pair),
        }
    }

    /// Builds a natural number. Reports a number that is too large and returns `None`.
    fn integer(&mut self, pair: &Pair<'_, Rule>) -> Option<i64> {
        let text = pair.as_str().trim();
        match text.parse::<i64>() {
            Ok(value) if value <= 1 << 53 => Some(value),
            _ => {
                let finding = Diagnostic::error(
                    codes::NUMBER_RANGE,
                    self.span(pair),
                    format!("{text} is too large"),
                )
                .with_help("the largest number is 9007199254740992");
                self.findings.push(finding);
                None
            }
        }
    }

    /// Builds a count. A number that is too large becomes 1, so that it causes no other findings.
    fn count(&mut self, pair: &Pair<'_, Rule>) -> u64 {
        self.integer(pair).map_or(1, |count| count as u64)
    }

    fn import(&mut self, pair: Pair<'_, Rule>) -> Import {
        let target = Children::of(pair).next();
        let span = self.span(&target);
        let text = target.as_str().trim();
        let dotted = target.as_rule() == Rule::module;
        Import {
            path: text.trim_matches('"').to_owned(),
            dotted,
            span,
        }
    }

    fn doc(children: &mut Children<'_>) -> String {
        let Some(doc) = children.take(Rule::doc) else {
            return String::new();
        };
        let lines: Vec<&str> = doc
            .into_inner()
            .map(|l| {
                let text = l.as_str().trim_start_matches('/');
                text.strip_prefix(' ').unwrap_or(text).trim_end()
            })
            .collect();
        lines.join("\n")
    }

    fn type_decl(&mut self, pair: Pair<'_, Rule>) -> TypeDecl {
        let mut c = Children::of(pair);
        Self::doc(&mut c);
        TypeDecl {
            name: self.name(&c.next()),
            domain: self.domain(c.next()),
        }
    }

    fn const_decl(&mut self, pair: Pair<'_, Rule>) -> ConstDecl {
        let mut c = Children::of(pair);
        Self::doc(&mut c);
        ConstDecl {
            name: self.name(&c.next()),
            domain: c.take(Rule::domain).map(|d| self.domain(d)),
            value: self.expr(c.next()),
        }
    }

    fn parameters(&mut self, pair: Option<Pair<'_, Rule>>) -> Vec<Parameter> {
        let Some(pair) = pair else { return Vec::new() };
        let pairs: Vec<_> = Children::of(pair).rest().collect();
        pairs
            .into_iter()
            .map(|p| {
                let mut c = Children::of(p);
                Parameter {
                    name: self.name(&c.next()),
                    domain: self.domain(c.next()),
                    default: c.take(Rule::expression).map(|e| self.expr(e)),
                }
            })
            .collect()
    }

    fn arguments(&mut self, pair: Option<Pair<'_, Rule>>) -> Vec<Argument> {
        let Some(pair) = pair else { return Vec::new() };
        let pairs: Vec<_> = Children::of(pair).rest().collect();
        pairs.into_iter().map(|p| self.argument(p)).collect()
    }

    fn argument(&mut self, pair: Pair<'_, Rule>) -> Argument {
        let mut c = Children::of(pair);
        Argument {
            name: self.name(&c.next()),
            value: self.expr(c.next()),
        }
    }

    fn define(&mut self, pair: Pair<'_, Rule>) -> Define {
        let mut c = Children::of(pair);
        Self::doc(&mut c);
        let name = self.name(&c.next());
        let mut formals = Vec::new();
        if let Some(list) = c.take(Rule::formals) {
            for formal in Children::of(list).rest().collect::<Vec<_>>() {
                let mut c = Children::of(formal);
                formals.push(Formal {
                    name: self.name(&c.next()),
                    domain: c.take(Rule::domain).map(|d| self.domain(d)),
                });
            }
        }
        Define {
            name,
            formals,
            value: self.expr(c.next()),
        }
    }

    fn codes(&self, pair: Option<Pair<'_, Rule>>) -> Vec<Name> {
        pair.map(|p| Children::of(p).rest().map(|c| self.name(&c)).collect())
            .unwrap_or_default()
    }

    fn header(&mut self, doc: String, c: &mut Children<'_>) -> Header {
        let name = self.name(&c.next());
        let parameters = c.take(Rule::parameters);
        Header {
            doc,
            name,
            parameters: self.parameters(parameters),
            codes: self.codes(c.take(Rule::implements)),
        }
    }
}

/// Returns whether a rule is a keyword that the tree does not need.
fn is_keyword(rule: Rule) -> bool {
    matches!(
        rule,
        Rule::k_a
            | Rule::k_abstract
            | Rule::k_after
            | Rule::k_an
            | Rule::k_and
            | Rule::k_array
            | Rule::k_at
            | Rule::k_becomes
            | Rule::k_before
            | Rule::k_between
            | Rule::k_break
            | Rule::k_buffer
            | Rule::k_by
            | Rule::k_calendar
            | Rule::k_capacity
            | Rule::k_component
            | Rule::k_const
            | Rule::k_contract
            | Rule::k_conveyor
            | Rule::k_counter
            | Rule::k_counts
            | Rule::k_defect
            | Rule::k_define
            | Rule::k_deletes
            | Rule::k_done
            | Rule::k_else
            | Rule::k_end
            | Rule::k_every
            | Rule::k_failures
            | Rule::k_finish
            | Rule::k_first
            | Rule::k_from
            | Rule::k_guarantee
            | Rule::k_holds
            | Rule::k_holiday
            | Rule::k_hour
            | Rule::k_idle
            | Rule::k_if
            | Rule::k_implements
            | Rule::k_import
            | Rule::k_in
            | Rule::k_internal
            | Rule::k_layout
            | Rule::k_leftover
            | Rule::k_limit
            | Rule::k_line
            | Rule::k_machine
            | Rule::k_most
            | Rule::k_mtbf
            | Rule::k_mttr
            | Rule::k_never
            | Rule::k_nop
            | Rule::k_not
            | Rule::k_of
            | Rule::k_on
            | Rule::k_one
            | Rule::k_only
            | Rule::k_operation
            | Rule::k_order
            | Rule::k_out
            | Rule::k_parameter
            | Rule::k_part
            | Rule::k_parts
            | Rule::k_per
            | Rule::k_perform
            | Rule::k_power
            | Rule::k_probability
            | Rule::k_product
            | Rule::k_property
            | Rule::k_realize
            | Rule::k_recipe
            | Rule::k_record
            | Rule::k_refines
            | Rule::k_reorder
            | Rule::k_requirement
            | Rule::k_resource
            | Rule::k_resets
            | Rule::k_restart
            | Rule::k_route
            | Rule::k_row
            | Rule::k_sequence
            | Rule::k_scrap
            | Rule::k_sets
            | Rule::k_setup
            | Rule::k_shift
            | Rule::k_signal
            | Rule::k_sink
            | Rule::k_skills
            | Rule::k_source
            | Rule::k_start
            | Rule::k_station
            | Rule::k_step
            | Rule::k_steps
            | Rule::k_store
            | Rule::k_takes
            | Rule::k_then
            | Rule::k_time
            | Rule::k_times
            | Rule::k_to
            | Rule::k_transport
            | Rule::k_twice
            | Rule::k_type
            | Rule::k_until
            | Rule::k_when
            | Rule::k_within
            | Rule::k_work
            | Rule::k_write
    )
}
