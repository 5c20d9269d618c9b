//! Numbers that are set from outside of the file of a line or layout, as by `linewright run --set`.
//!
//! Values are set in the syntax tree, after parsing and before names are resolved, so that they are
//! checked as if they stood in the file. Each option is a source of its own, so that findings point
//! into its text. A number of a machine is set for one station or conveyor only: the resolver gets
//! a copy of the machine's declaration for that place.

mod layouts;
mod places;
mod slots;
mod wiring;

use linewright_core::diagnostics::{Diagnostic, codes, nearest};
use linewright_core::source::{FileId, SourceMap, Span};
use linewright_syntax::{Value, ast, parse_value};
pub(super) use slots::Variants;
use slots::{Present, Slot};
use std::collections::{BTreeMap, BTreeSet};
use std::str::FromStr;

/// Maximum number of names in a help text.
const MAX_NAMES: usize = 16;

/// A number of a line or layout and the value that it gets: `capper.takes=2 s`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Setting {
    /// The text as given.
    text: String,
    /// Offset of `=`.
    equals: usize,
    /// The option that gives it, for findings.
    option: &'static str,
}

impl FromStr for Setting {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.find('=') {
            Some(equals) if !text[..equals].trim().is_empty() => Ok(Self {
                text: text.to_owned(),
                equals,
                option: "--set",
            }),
            _ => Err("write a name, `=` and a value, such as `capper.takes='2 s'`".to_owned()),
        }
    }
}

impl Setting {
    /// The same, given by another option than `--set`.
    #[must_use]
    pub fn given_by(self, option: &'static str) -> Self {
        Self { option, ..self }
    }

    /// The name of a variant that is given before the number, `fast: capper.takes='2 s'`, and the
    /// setting without it.
    pub fn split_variant(&self) -> (Option<&str>, Self) {
        let Some((variant, rest)) = self.text[..self.equals].split_once(':') else {
            return (None, self.clone());
        };
        let text = format!("{rest}{}", &self.text[self.equals..]);
        let rest = Self {
            text,
            equals: rest.len(),
            option: self.option,
        };
        (Some(variant.trim()), rest)
    }

    /// Name of the number: `capper.takes`.
    pub fn name(&self) -> &str {
        self.text[..self.equals].trim()
    }

    /// The value as given, without blanks around it.
    pub fn value(&self) -> &str {
        self.text[self.equals + 1..].trim()
    }

    /// A finding about its name. The setting becomes a source.
    pub fn wrong_name(&self, sources: &mut SourceMap, message: &str) -> Diagnostic {
        let file = self.add_to(sources);
        Diagnostic::error(codes::ARGUMENT, self.name_span(file), message)
    }

    /// A finding about its value. The setting becomes a source.
    pub fn wrong_value(&self, sources: &mut SourceMap, message: String) -> Diagnostic {
        let file = self.add_to(sources);
        Diagnostic::error(codes::ARGUMENT, self.value_span(file), message)
    }

    fn add_to(&self, sources: &mut SourceMap) -> FileId {
        let source = format!("{} {}", self.option, self.name());
        sources.add(source, self.text.as_str())
    }

    /// The finding that this setting changes what `first` has changed already. Both become sources.
    pub fn repeats(&self, first: &Self, sources: &mut SourceMap) -> Diagnostic {
        let [first, second] = [first, self].map(|setting| {
            let file = setting.add_to(sources);
            setting.name_span(file)
        });
        set_twice(self.name(), second, first)
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

/// What has numbers that can be set.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Owner {
    /// A line.
    #[default]
    Line,
    /// A layout.
    Layout,
}

/// Settings of one line or layout.
#[derive(Debug, Clone, Copy, Default)]
pub struct Settings<'a> {
    /// Whether it is a line or a layout.
    pub of: Owner,
    /// Its name; `None` for the only one of the requested files.
    pub name: Option<&'a str>,
    /// What is set.
    pub list: &'a [Setting],
}

/// A number of a line or layout that can be set.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SettableNumber {
    /// Names, the shortest first. A name that several numbers have is left out.
    pub names: Vec<String>,
    /// Text of its value; `None` if the statement is absent and has a default.
    pub value: Option<String>,
    /// Whether it is a time for each step of a machine's action.
    pub per_step: bool,
    /// Place of its value; `None` for a whole number, which has no place in the tree.
    pub place: Option<Span>,
}

/// A line or layout in its file, with everything that settings refer to.
pub(super) struct Target<'t> {
    /// Items of the file.
    pub items: Vec<ast::Item>,
    /// Whether it is a line or a layout.
    pub of: Owner,
    /// Its name, and the place of the name.
    pub name: &'t ast::Name,
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
    /// The tables that the new values name.
    pub tables: Vec<ast::Name>,
    /// Where the resolver may report a wrong value, and the place of the option's value.
    moved: Vec<(Span, Span)>,
}

impl Changes {
    /// Moves findings about values to the text of their options.
    pub fn relocate(&self, findings: &mut [Diagnostic]) {
        let about_value = [codes::ARGUMENT, codes::TYPE_MISMATCH];
        for finding in findings {
            let here = |(from, _): &&(Span, Span)| finding.span == Some(*from);
            if about_value.contains(&finding.code)
                && let Some((_, to)) = self.moved.iter().find(here)
            {
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
        let owner = self.name.span;
        slots::for_each(&mut self.items, owner, &self.machines, variants, visit);
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
        let numbers = known.iter().map(|slot| {
            let names = slot.names.iter().filter(|n| unique.contains(n.as_str()));
            let (value, place) = match slot.present {
                None => (None, None),
                Some(Present::Text(span) | Present::PerStep(span)) => {
                    (Some(sources.text(span).to_owned()), Some(span))
                }
                Some(Present::Count(count)) => (Some(count.to_string()), None),
            };
            SettableNumber {
                names: names.cloned().collect(),
                value,
                per_step: matches!(slot.present, Some(Present::PerStep(_))),
                place,
            }
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
            let file = setting.add_to(sources);
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
                findings.push(set_twice(name, span, first));
                continue;
            }
            match parse_value(file, &setting.text, setting.equals + 1, known[slot].syntax) {
                Ok(value) => {
                    let at = known[slot].reported_at;
                    let value_span = setting.value_span(file);
                    changes.moved.extend(at.map(|at| (at, value_span)));
                    if let Value::Time(time, _) = &value {
                        let column = time.column();
                        changes.tables.extend(column.map(|c| c.path.clone()));
                    }
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

    /// Reports a name that no number has.
    fn unknown(&self, known: &[Known], name: &str, span: Span) -> Diagnostic {
        let target = &self.name.text;
        let unique = unique_names(known);
        let of = |n: &str| n.split('.').next().unwrap_or(n).to_owned();
        let rest_of = |n: &str| n.split_once('.').map_or("", |(_, rest)| rest).to_owned();
        let (place, rest) = (of(name), rest_of(name));
        // The shortest name of each number.
        let mut shown: Vec<&str> = Vec::new();
        for slot in known {
            let mut names = slot.names.iter().map(String::as_str);
            shown.extend(names.find(|n| unique.contains(n)));
        }
        let numbers_of = |owner: &str| -> Vec<&str> {
            let numbers = shown.iter().filter(|n| of(n) == owner);
            numbers.copied().collect()
        };
        // The number of this place whose name is close to the given one.
        let near_in = |owner: &str| -> Option<&str> {
            let names: Vec<&str> = unique.iter().copied().filter(|n| of(n) == owner).collect();
            let rests: Vec<String> = names.iter().map(|n| rest_of(n)).collect();
            let near = nearest(&rest, rests.iter().map(String::as_str))?;
            let at = rests.iter().position(|r| r == near)?;
            Some(names[at])
        };
        let error = |message: String| Diagnostic::error(codes::NAME_UNKNOWN, span, message);
        if let Some((all, index)) = place.split_once('[')
            && let Some(count) = count_of(known, all)
        {
            let index = index.strip_suffix(']').and_then(|index| index.parse().ok());
            if count < 2 || !index.is_some_and(|index| (1..=count).contains(&index)) {
                let there_are = match count {
                    0 | 1 => {
                        format!("`{all}` is a single station; `{all}.times=2` makes two of it")
                    }
                    _ => format!("its stations are `{all}[1]` to `{all}[{count}]`"),
                };
                return error(format!("`{target}` has no station `{place}`")).with_help(there_are);
            }
            return error(format!("`{place}` has no numbers of its own")).with_help(format!(
                "the stations of `{all}` are alike, and their numbers are set together: {}; declare a station of its own for other numbers, or let one alone work faster: `--what-if '{place}=10%'`",
                quoted(&numbers_of(all))
            ));
        }
        let within = numbers_of(&place);
        if !within.is_empty() {
            let list = format!("its numbers are {}", quoted(&within));
            let help = match near_in(&place) {
                Some(near) => format!("did you mean `{near}`? {list}"),
                None => list,
            };
            return error(format!("`{place}` has no number `{name}` that can be set"))
                .with_help(help);
        }
        let mut places: Vec<String> = Vec::new();
        for owner in shown.iter().map(|n| of(n)) {
            if !places.contains(&owner) {
                places.push(owner);
            }
        }
        let places: Vec<&str> = places.iter().map(String::as_str).collect();
        let declared = self.items.iter().any(|item| match item {
            ast::Item::Line(l) => l.name.span == self.name.span && declares(l, &place),
            ast::Item::Layout(l) => l.name.span == self.name.span && has_resource(l, &place),
            _ => false,
        });
        if declared {
            return error(format!("`{place}` has no number that can be set"))
                .with_help(format!("`{target}` has numbers in {}", quoted(&places)));
        }
        let help = match nearest(&place, places.iter().copied()) {
            Some(owner) => near_in(owner).map_or_else(
                || {
                    let numbers = quoted(&numbers_of(owner));
                    format!("did you mean `{owner}`? its numbers are {numbers}")
                },
                |near| format!("did you mean `{near}`?"),
            ),
            None => format!("`{target}` has numbers in {}", quoted(&places)),
        };
        let kinds = match self.of {
            Owner::Line => "place, constant or requirement",
            Owner::Layout => "resource, transport or constant",
        };
        error(format!("`{target}` has no {kinds} `{place}`")).with_help(help)
    }
}

fn set_twice(name: &str, span: Span, first: Span) -> Diagnostic {
    Diagnostic::error(
        codes::NAME_DUPLICATE,
        span,
        format!("`{name}` is set twice"),
    )
    .with_label(first, "first set here")
    .with_help("remove one of the two")
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

/// Whether a layout declares a resource or a transport with this name.
fn has_resource(layout: &ast::Layout, name: &str) -> bool {
    use ast::LayoutItem::{Duplicate, Resource, Transport};
    layout.items.iter().any(|item| match item {
        Resource(r) => r.name.text == name,
        Transport(t) => t.name.text == name,
        Duplicate { name: n, .. } => n.text == name,
        _ => false,
    })
}

/// The number of stations that a station's `times` declares; `None` if there is no such station.
fn count_of(known: &[Known], station: &str) -> Option<u64> {
    let times = format!("{station}.times");
    let slot = known.iter().find(|slot| slot.names.contains(&times))?;
    match slot.present {
        Some(Present::Count(count)) => Some(count),
        _ => Some(1),
    }
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
