//! Numbers that are set from outside of a line's file, as by `linewright run --set`.
//!
//! Values are set in the syntax tree, after parsing and before names are resolved, so that they are
//! checked as if they stood in the file. Each option is a source of its own, so that findings point
//! into its text. A number of a machine is set for one station or conveyor only: the resolver gets
//! a copy of the machine's declaration for that place ([`Variants`]).

mod slots;

use linewright_core::diagnostics::{Diagnostic, codes, nearest};
use linewright_core::source::{FileId, SourceMap, Span};
use linewright_syntax::{Value, ast, parse_value};
pub(super) use slots::Variants;
use slots::{Present, Slot};
use std::collections::{BTreeMap, BTreeSet};
use std::str::FromStr;

/// Maximum number of names in a help text.
const MAX_NAMES: usize = 16;

/// A number of a line and the value that it gets: `capper.takes=2 s`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Setting {
    /// The text as given.
    text: String,
    /// Offset of `=`.
    equals: usize,
}

impl FromStr for Setting {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.find('=') {
            Some(equals) if !text[..equals].trim().is_empty() => Ok(Self {
                text: text.to_owned(),
                equals,
            }),
            _ => Err("write a name, `=` and a value, such as `capper.takes='2 s'`".to_owned()),
        }
    }
}

impl Setting {
    /// Name of the number: `capper.takes`.
    pub fn name(&self) -> &str {
        self.text[..self.equals].trim()
    }

    /// The value as given, without blanks around it.
    pub fn value(&self) -> &str {
        self.text[self.equals + 1..].trim()
    }

    /// Place of the name in the option's text.
    fn name_span(&self, file: FileId) -> Span {
        let start = self.text.len() - self.text.trim_start().len();
        Span::new(file, start, start + self.name().len())
    }

    /// Place of the value in the option's text.
    fn value_span(&self, file: FileId) -> Span {
        let text = &self.text[self.equals + 1..];
        let start = self.equals + 1 + text.len() - text.trim_start().len();
        Span::new(file, start, start + self.value().len())
    }
}

/// Settings of one line.
#[derive(Debug, Clone, Copy, Default)]
pub struct Settings<'a> {
    /// Name of the line; `None` for the only line of the requested files.
    pub line: Option<&'a str>,
    /// What is set.
    pub list: &'a [Setting],
}

/// A number of a line that can be set.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SettableNumber {
    /// Names, the shortest first. A name that several numbers have is left out.
    pub names: Vec<String>,
    /// Text of its value; `None` if the statement is absent and has a default.
    pub value: Option<String>,
}

/// A line in its file, with everything that settings refer to.
pub(super) struct Target<'t> {
    /// Items of the line's file.
    pub items: Vec<ast::Item>,
    /// Name of the line, and its place.
    pub line: &'t ast::Name,
    /// Machines that are visible in the file.
    pub machines: BTreeMap<&'t str, &'t ast::Machine>,
    /// Whether a syntax error could be the reason why a name is not found.
    pub is_malformed: bool,
}

/// What a setting did to the tree.
#[derive(Default)]
pub(super) struct Changes {
    /// The machines that replace shared ones.
    pub variants: Variants,
    /// For whole numbers, which have no place in the tree: where the resolver reports a wrong one,
    /// and the place of the option's value.
    moved: Vec<(Span, Span)>,
}

impl Changes {
    /// Moves findings about whole numbers to the text of their options.
    pub fn relocate(&self, findings: &mut [Diagnostic]) {
        for finding in findings.iter_mut().filter(|f| f.code == codes::ARGUMENT) {
            let moved = self
                .moved
                .iter()
                .find(|(from, _)| finding.span == Some(*from));
            if let Some((_, to)) = moved {
                finding.span = Some(*to);
            }
        }
    }
}

/// Names, syntax and value of a slot.
struct Known {
    names: Vec<String>,
    syntax: linewright_syntax::ValueSyntax,
    present: Option<Present>,
    reported_at: Option<Span>,
}

impl Target<'_> {
    fn for_each(&mut self, variants: &mut Variants, visit: &mut dyn FnMut(Slot<'_>)) {
        let line = self.line.span;
        slots::for_each(&mut self.items, line, &self.machines, variants, visit);
    }

    fn known(&mut self) -> Vec<Known> {
        let mut known = Vec::new();
        self.for_each(&mut Variants::new(), &mut |slot| {
            known.push(Known {
                names: slot.names,
                syntax: slot.syntax,
                present: slot.present,
                reported_at: slot.reported_at,
            });
        });
        known
    }

    /// All numbers that can be set.
    pub fn settable(&mut self, sources: &SourceMap) -> Vec<SettableNumber> {
        let known = self.known();
        let unique = unique_names(&known);
        let numbers = known.iter().map(|slot| SettableNumber {
            names: (slot.names.iter())
                .filter(|name| unique.contains(name.as_str()))
                .cloned()
                .collect(),
            value: slot.present.map(|present| match present {
                Present::Text(span) => sources.text(span).to_owned(),
                Present::Count(count) => count.to_string(),
            }),
        });
        numbers.filter(|number| !number.names.is_empty()).collect()
    }

    /// Sets the numbers in the items, and reports settings that are wrong. Each setting becomes a
    /// source.
    pub fn apply(
        &mut self,
        settings: &[Setting],
        sources: &mut SourceMap,
        findings: &mut Vec<Diagnostic>,
    ) -> Changes {
        let known = self.known();
        let mut changes = Changes::default();
        let mut first: BTreeMap<usize, Span> = BTreeMap::new();
        let mut values: BTreeMap<usize, Value> = BTreeMap::new();
        for setting in settings {
            let name = setting.name();
            let file = sources.add(format!("--set {name}"), setting.text.as_str());
            let span = setting.name_span(file);
            let mut matching =
                (0..known.len()).filter(|i| known[*i].names.iter().any(|n| n == name));
            let Some(slot) = matching.next() else {
                if !self.is_malformed {
                    findings.push(self.unknown(&known, name, span));
                }
                continue;
            };
            let others: Vec<usize> = matching.collect();
            if !others.is_empty() {
                let all = std::iter::once(slot).chain(others);
                findings.push(ambiguous(all.map(|i| &known[i]), name, span));
                continue;
            }
            if let Some(first) = first.insert(slot, span) {
                findings.push(
                    Diagnostic::error(
                        codes::NAME_DUPLICATE,
                        span,
                        format!("`{name}` is set twice"),
                    )
                    .with_label(first, "first set here")
                    .with_help("remove one of the two"),
                );
                continue;
            }
            match parse_value(file, &setting.text, setting.equals + 1, known[slot].syntax) {
                Ok(value) => {
                    let at = known[slot].reported_at;
                    let value_span = setting.value_span(file);
                    changes.moved.extend(at.map(|at| (at, value_span)));
                    values.insert(slot, value);
                }
                Err(found) => findings.extend(found),
            }
        }
        let mut index = 0;
        self.for_each(&mut changes.variants, &mut |slot| {
            if let Some(value) = values.remove(&index) {
                (slot.set)(value);
            }
            index += 1;
        });
        changes
    }

    fn unknown(&self, known: &[Known], name: &str, span: Span) -> Diagnostic {
        let line = &self.line.text;
        let place = name.split('.').next().unwrap_or(name);
        let unique = unique_names(known);
        let all = known.iter().flat_map(|slot| &slot.names);
        let all = all.map(String::as_str).filter(|n| unique.contains(n));
        let shortest = known.iter().filter_map(|slot| {
            let mut names = slot.names.iter().map(String::as_str);
            names.find(|n| unique.contains(n))
        });
        let within: Vec<&str> = shortest
            .clone()
            .filter(|n| n.split('.').next() == Some(place))
            .collect();
        let near = nearest(name, all.clone());
        if !within.is_empty() {
            let list = format!("its numbers are {}", quoted(&within));
            let help = near.map_or_else(
                || list.clone(),
                |near| format!("did you mean `{near}`? {list}"),
            );
            let message = format!("`{place}` has no number `{name}` that can be set");
            return Diagnostic::error(codes::NAME_UNKNOWN, span, message).with_help(help);
        }
        let items = self.items.iter();
        let declared = items.clone().any(|item| match item {
            ast::Item::Line(l) => l.name.span == self.line.span && declares(l, place),
            _ => false,
        });
        let message = if declared {
            format!("`{place}` in the line `{line}` has no number that can be set")
        } else {
            format!("the line `{line}` has no `{place}` with a number that can be set")
        };
        let mut places: Vec<&str> = Vec::new();
        for owner in shortest.filter_map(|n| n.split('.').next()) {
            if !places.contains(&owner) {
                places.push(owner);
            }
        }
        let rest = name.strip_prefix(place).unwrap_or_default();
        let help = match (nearest(place, places.iter().copied()), near) {
            (Some(owner), _) if all.clone().any(|n| n == format!("{owner}{rest}")) => {
                format!("did you mean `{owner}{rest}`?")
            }
            (_, Some(near)) => format!("did you mean `{near}`?"),
            (Some(owner), None) => {
                let numbers: Vec<&str> =
                    all.filter(|n| n.split('.').next() == Some(owner)).collect();
                format!(
                    "did you mean `{owner}`? Its numbers are {}",
                    quoted(&numbers)
                )
            }
            (None, None) => format!("numbers belong to {}", quoted(&places)),
        };
        Diagnostic::error(codes::NAME_UNKNOWN, span, message).with_help(help)
    }
}

/// Whether a line declares a place, a part type or a requirement with this name.
fn declares(line: &ast::Line, name: &str) -> bool {
    use ast::LineItem::{Buffer, Conveyor, Part, Requirement, Sink, Source, Station, Store};
    line.items.iter().any(|item| match item {
        Part { name: n, .. }
        | Source { name: n, .. }
        | Store { name: n, .. }
        | Sink { name: n, .. }
        | Buffer { name: n, .. }
        | Conveyor { name: n, .. }
        | Station { name: n, .. }
        | Requirement { name: n, .. } => n.text == name,
        _ => false,
    })
}

/// Names that only one slot has.
fn unique_names(known: &[Known]) -> BTreeSet<&str> {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for name in known.iter().flat_map(|slot| &slot.names) {
        *counts.entry(name).or_default() += 1;
    }
    counts.retain(|_, count| *count == 1);
    counts.into_keys().collect()
}

fn ambiguous<'k>(slots: impl Iterator<Item = &'k Known>, name: &str, span: Span) -> Diagnostic {
    let full = slots.filter_map(|slot| slot.names.last());
    let full: Vec<&str> = full.map(String::as_str).collect();
    Diagnostic::error(
        codes::NAME_DUPLICATE,
        span,
        format!("`{name}` is the name of several numbers"),
    )
    .with_help(if full.iter().all(|n| *n == name) {
        "change the file: only one of them can stay".to_owned()
    } else {
        format!(
            "write {}",
            full.iter()
                .map(|n| format!("`{n}`"))
                .collect::<Vec<_>>()
                .join(" or ")
        )
    })
}

/// Lists names, up to a maximum number.
fn quoted(names: &[&str]) -> String {
    let shown = names.iter().take(MAX_NAMES).map(|n| format!("`{n}`"));
    let shown = shown.collect::<Vec<_>>().join(", ");
    match names.len().saturating_sub(MAX_NAMES) {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}
