//! The table of types, as it is read from `types.txt`.

use rustc_hash::FxHashMap;
use std::sync::OnceLock;

/// Text of the table. Its head describes the format.
const TYPES: &str = include_str!("types.txt");

/// Number of a type.
pub(super) type TypeId = usize;

/// All types.
pub(crate) struct Schema {
    roots: FxHashMap<&'static str, TypeId>,
    types: Vec<Type>,
}

/// A type of elements.
pub(super) enum Type {
    /// Elements in sequence.
    Sequence(Vec<Particle>),
    /// Text.
    Text(TextType),
}

/// A type of texts, with all that it has from its bases.
#[derive(Clone)]
pub(super) struct TextType {
    /// Type of the text.
    pub base: Builtin,
    /// Attributes. All are optional.
    pub attributes: Vec<(&'static str, Builtin)>,
    /// Values that are allowed; all if empty.
    pub values: Vec<String>,
}

/// A place in a sequence.
pub(super) struct Particle {
    /// Alternatives; mostly one.
    pub elements: Vec<ElementType>,
    /// Whether it has to occur.
    pub is_required: bool,
    /// Whether it may occur more than once.
    pub repeats: bool,
}

/// An element of a sequence.
pub(super) struct ElementType {
    /// Its name.
    pub name: &'static str,
    /// Its type.
    pub of: TypeId,
    /// Whether it may have the attribute `xsi:nil`.
    pub is_nillable: bool,
}

/// A type of XML Schema.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Builtin {
    String,
    NormalizedString,
    Boolean,
    Decimal,
    DateTime,
    TimeSpan,
    Language,
    AnyUri,
}

impl Schema {
    /// Returns the schema. It is read from the table at the first call.
    pub(crate) fn get() -> &'static Self {
        static SCHEMA: OnceLock<Schema> = OnceLock::new();
        SCHEMA.get_or_init(|| Self::read(TYPES).expect("the table is right"))
    }

    /// Returns the type of a root.
    pub(super) fn root(&self, name: &str) -> Option<TypeId> {
        self.roots.get(name).copied()
    }

    /// Returns whether an element can be a root.
    pub(crate) fn has_root(&self, name: &str) -> bool {
        self.roots.contains_key(name)
    }

    /// Returns the names of all roots, in alphabetical order.
    pub(crate) fn root_names(&self) -> Vec<&'static str> {
        let mut names: Vec<&str> = self.roots.keys().copied().collect();
        names.sort_unstable();
        names
    }

    /// Returns a type.
    pub(super) fn of(&self, id: TypeId) -> &Type {
        &self.types[id]
    }

    fn read(text: &'static str) -> Option<Self> {
        let mut declarations: Vec<Vec<&'static str>> = Vec::new();
        for line in text.lines().filter(|l| !l.starts_with('#')) {
            if line.starts_with("  ") {
                declarations.last_mut()?.extend(line.split_whitespace());
            } else {
                declarations.push(line.split_whitespace().collect());
            }
        }
        let types = declarations.iter().filter(|d| d[0] != "root");
        let numbers: FxHashMap<&str, TypeId> =
            types.clone().enumerate().map(|(n, d)| (d[1], n)).collect();
        let texts: FxHashMap<&str, &[&'static str]> = (types.clone())
            .filter(|d| d[0] == "value")
            .map(|d| (d[1], &d[2..]))
            .collect();
        let mut schema = Self {
            roots: FxHashMap::default(),
            types: Vec::new(),
        };
        for declaration in types {
            let words = &declaration[2..];
            schema.types.push(if declaration[0] == "sequence" {
                let particles = words.iter().map(|w| particle(w, &numbers));
                Type::Sequence(particles.collect::<Option<_>>()?)
            } else {
                Type::Text(text_type(words, &texts)?)
            });
        }
        for root in declarations.iter().filter(|d| d[0] == "root") {
            schema.roots.insert(root[1], *numbers.get(root[2])?);
        }
        Some(schema)
    }
}

/// Reads a place of a sequence.
fn particle(word: &'static str, numbers: &FxHashMap<&str, TypeId>) -> Option<Particle> {
    let (elements, often) = if let Some(choice) = word.strip_prefix('(') {
        let (inside, often) = choice.split_once(')')?;
        let elements = inside.split('|').map(|e| element(e, numbers));
        let elements = elements.map(|e| e.map(|(e, _)| e)).collect::<Option<_>>()?;
        (elements, often)
    } else {
        let (element, often) = element(word, numbers)?;
        (vec![element], often)
    };
    let (is_required, repeats) = match often {
        "" => (true, false),
        "?" => (false, false),
        "*" => (false, true),
        "+" => (true, true),
        _ => return None,
    };
    Some(Particle {
        elements,
        is_required,
        repeats,
    })
}

/// Reads an element, and how often it may occur.
fn element(
    word: &'static str,
    numbers: &FxHashMap<&str, TypeId>,
) -> Option<(ElementType, &'static str)> {
    let (before, of) = word.split_once(':')?;
    let name = before.trim_end_matches(['?', '*', '+']);
    if !name.bytes().all(|b| b.is_ascii_alphanumeric()) {
        return None;
    }
    let (of, is_nillable) = match of.strip_suffix('!') {
        Some(of) => (of, true),
        None => (of, false),
    };
    let element = ElementType {
        name,
        of: *numbers.get(of)?,
        is_nillable,
    };
    Some((element, &before[name.len()..]))
}

/// Reads a type of texts: its base, its attributes and values.
fn text_type(words: &[&'static str], texts: &FxHashMap<&str, &[&'static str]>) -> Option<TextType> {
    let (base, more) = words.split_first()?;
    let mut of = match Builtin::named(base) {
        Some(base) => TextType {
            base,
            attributes: Vec::new(),
            values: Vec::new(),
        },
        None => text_type(texts.get(base)?, texts)?,
    };
    for word in more {
        if let Some(attribute) = word.strip_prefix('@') {
            let (name, kind) = attribute.split_once(':')?;
            of.attributes.push((name, Builtin::named(kind)?));
        } else {
            of.values.push(word.strip_prefix('=')?.replace('_', " "));
        }
    }
    Some(of)
}

impl Builtin {
    fn named(name: &str) -> Option<Self> {
        Some(match name.strip_prefix("xsd:")? {
            "string" => Self::String,
            "normalizedString" => Self::NormalizedString,
            "boolean" => Self::Boolean,
            "decimal" => Self::Decimal,
            "dateTime" => Self::DateTime,
            "duration" => Self::TimeSpan,
            "language" => Self::Language,
            "anyURI" => Self::AnyUri,
            _ => return None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Within a sequence, each name occurs once; validation relies on it.
    #[test]
    fn names_are_unique_in_sequences() {
        let mut sequences = 0;
        for of in &Schema::get().types {
            if let Type::Sequence(particles) = of {
                let elements = particles.iter().flat_map(|p| &p.elements);
                let mut names: Vec<&str> = elements.map(|e| e.name).collect();
                let all = names.len();
                names.sort_unstable();
                names.dedup();
                assert_eq!(names.len(), all, "{names:?}");
                sequences += 1;
            }
        }
        assert_eq!(sequences, 66);
    }

    #[test]
    fn types_have_what_their_bases_have() {
        let schema = Schema::get();
        let root = schema.root("OperationsSchedule").expect("it is a root");
        let Type::Sequence(particles) = schema.of(root) else {
            panic!("it has children");
        };
        let kind = particles.iter().flat_map(|p| &p.elements);
        let mut kind = kind.filter(|e| e.name == "OperationsType").map(|e| e.of);
        let Type::Text(kind) = schema.of(kind.next().expect("it has a type")) else {
            panic!("it is a text");
        };
        assert_eq!(kind.base, Builtin::NormalizedString);
        assert_eq!(
            kind.attributes.last(),
            Some(&("OtherValue", Builtin::String))
        );
        assert!(kind.attributes.contains(&("languageID", Builtin::Language)));
        assert_eq!(kind.values.len(), 6);
    }

    #[test]
    fn a_damaged_table_is_refused() {
        for damaged in [
            "value A B",
            "value A xsd:int",
            "sequence A B:C",
            "root A B",
            "value A xsd:string\nsequence B A%:A",
            "  value",
            "value A xsd:string x",
        ] {
            assert!(Schema::read(damaged).is_none(), "{damaged}");
        }
    }
}
