//! Shapes of declared types: scalars, arrays and records.
//!
//! Later stages have only scalar variables. So a variable becomes one scalar variable for each leaf
//! of its type. Each is named after the path to its leaf: `target.x`, `places[2].angle`.

use super::units::Unit;
use super::value::Type;
use linewright_core::gr1::{Domain, VarId};
use std::collections::BTreeMap;
use std::sync::Arc;

/// A finite type.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Shape {
    /// A single value, with its unit.
    Scalar(Domain, Option<Unit>),
    /// An array: element shape and length.
    Array(Box<Shape>, usize),
    /// Members by name, in the order of their declaration.
    Record(Vec<(String, Shape)>),
}

impl Shape {
    /// Returns the type of the values that have this shape.
    pub fn ty(&self) -> Type {
        match self {
            Self::Scalar(domain, unit) => measured(domain, *unit),
            Self::Array(of, n) => Type::Array(Box::new(of.ty()), *n),
            Self::Record(members) => {
                Type::Record(members.iter().map(|(n, s)| (n.clone(), s.ty())).collect())
            }
        }
    }

    /// Returns the number of scalar leaves, or `usize::MAX` if the number is larger.
    pub fn leaf_count(&self) -> usize {
        match self {
            Self::Scalar(..) => 1,
            Self::Array(of, n) => of.leaf_count().saturating_mul(*n),
            Self::Record(members) => members
                .iter()
                .fold(0, |sum: usize, (_, s)| sum.saturating_add(s.leaf_count())),
        }
    }

    /// Declares the variables of this shape: calls `add` with the name, domain and unit of each
    /// leaf.
    pub fn declare(
        &self,
        name: String,
        add: &mut impl FnMut(String, &Domain, Option<Unit>) -> VarId,
    ) -> Entry {
        match self {
            Self::Scalar(domain, unit) => Entry::One(add(name, domain, *unit)),
            Self::Array(of, n) => {
                let elements = (0..*n).map(|i| of.declare(format!("{name}[{i}]"), add));
                Entry::Many(Arc::new(elements.collect()))
            }
            Self::Record(members) => {
                let entries = members.iter().map(|(member, shape)| {
                    let entry = shape.declare(format!("{name}.{member}"), add);
                    (member.clone(), entry)
                });
                Entry::Record(entries.collect())
            }
        }
    }
}

/// Returns the type of a scalar with this domain and unit.
pub(super) fn measured(domain: &Domain, unit: Option<Unit>) -> Type {
    match (domain, unit) {
        (Domain::Range { .. }, Some(unit)) => Type::Measured(unit),
        _ => Type::of(domain),
    }
}

/// A variable in scope, of any shape.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Entry {
    /// A scalar.
    One(VarId),
    /// An array; shared, so that cloning an entry does not copy its elements.
    Many(Arc<Vec<Entry>>),
    /// Members by name, in the order of their declaration.
    Record(Vec<(String, Entry)>),
}

impl Entry {
    /// Returns the same entry with every id replaced by `change`.
    pub fn renumbered(&self, change: &impl Fn(VarId) -> VarId) -> Self {
        match self {
            Self::One(id) => Self::One(change(*id)),
            Self::Many(list) => {
                let list = list.iter().map(|e| e.renumbered(change)).collect();
                Self::Many(Arc::new(list))
            }
            Self::Record(members) => Self::Record(
                members
                    .iter()
                    .map(|(name, e)| (name.clone(), e.renumbered(change)))
                    .collect(),
            ),
        }
    }

    /// Returns the variable at the end of a path; `None` if the path does not lead to a scalar.
    pub fn at(&self, path: &[Segment<'_>]) -> Option<VarId> {
        match (self, path) {
            (Self::One(id), []) => Some(*id),
            (Self::Many(list), [Segment::Element(i), rest @ ..]) => list.get(*i)?.at(rest),
            (Self::Record(members), [Segment::Member(name), rest @ ..]) => {
                let (_, entry) = members.iter().find(|(n, _)| n == name)?;
                entry.at(rest)
            }
            _ => None,
        }
    }

    fn insert(&mut self, path: &[Segment<'_>], id: VarId) {
        let [first, rest @ ..] = path else {
            *self = Self::One(id);
            return;
        };
        match first {
            Segment::Element(i) => {
                if !matches!(self, Self::Many(_)) {
                    *self = Self::Many(Arc::default());
                }
                if let Self::Many(list) = self {
                    let list = Arc::make_mut(list);
                    // Leaves are inserted in the order of their indices.
                    if list.len() <= *i {
                        list.push(Self::Many(Arc::default()));
                    }
                    if let Some(entry) = list.last_mut() {
                        entry.insert(rest, id);
                    }
                }
            }
            Segment::Member(name) => {
                if !matches!(self, Self::Record(_)) {
                    *self = Self::Record(Vec::new());
                }
                if let Self::Record(members) = self {
                    if members.last().is_none_or(|(n, _)| n != name) {
                        members.push(((*name).to_owned(), Self::Many(Arc::default())));
                    }
                    if let Some((_, entry)) = members.last_mut() {
                        entry.insert(rest, id);
                    }
                }
            }
        }
    }
}

/// One segment of the path from a variable to one of its leaves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Segment<'t> {
    /// `[2]`
    Element(usize),
    /// `.x`
    Member(&'t str),
}

/// Splits the name of a leaf into the name of its variable and the path to the leaf.
pub(super) fn leaf_path(leaf: &str) -> (&str, Vec<Segment<'_>>) {
    let end = leaf.find(['.', '[']).unwrap_or(leaf.len());
    let (name, rest) = leaf.split_at(end);
    let pieces = rest.split(['.', '[']).skip(1);
    let segments = pieces.map(|piece| match piece.strip_suffix(']') {
        Some(number) => Segment::Element(number.parse().unwrap_or(usize::MAX)),
        None => Segment::Member(piece),
    });
    (name, segments.collect())
}

/// Builds the entries of variables from their leaves, which have to be in the order of their
/// declaration.
pub(super) fn entries_of<'t>(
    leaves: impl IntoIterator<Item = (&'t str, VarId)>,
) -> BTreeMap<String, Entry> {
    let mut found: BTreeMap<String, Entry> = BTreeMap::new();
    for (leaf, id) in leaves {
        let (name, path) = leaf_path(leaf);
        found
            .entry(name.to_owned())
            .or_insert_with(|| Entry::Many(Arc::default()))
            .insert(&path, id);
    }
    found
}
