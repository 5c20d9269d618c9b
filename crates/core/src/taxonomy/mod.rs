//! The taxonomies that contracts name in `implements`: DIN 8580 (manufacturing) and VDI 2860
//! (handling).
//!
//! The data are two tables in `din8580/`, embedded in the program. A [`Taxonomy`] is the tree of
//! their entries. A full code has its standard before a colon (`din:4.3.1`, `vdi:Drehen`), as in
//! the language. Each entry also gives its source and a confidence, since neither standard is
//! freely available and the sources disagree in places.

use crate::diagnostics::edit_distance;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::LazyLock;

const DIN: &str = include_str!("../../../../din8580/din8580.csv");
const VDI: &str = include_str!("../../../../din8580/vdi2860.csv");

/// Standard that a code comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Standard {
    /// DIN 8580, manufacturing processes.
    Din8580,
    /// VDI 2860, handling functions.
    Vdi2860,
}

impl Standard {
    /// Returns the prefix before the colon of a code.
    pub fn prefix(self) -> &'static str {
        match self {
            Self::Din8580 => "din",
            Self::Vdi2860 => "vdi",
        }
    }

    /// Returns the title of the standard.
    pub fn title(self) -> &'static str {
        match self {
            Self::Din8580 => "DIN 8580",
            Self::Vdi2860 => "VDI 2860",
        }
    }
}

/// A process or function.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Entry {
    /// Standard of the entry.
    pub standard: Standard,
    /// Code without prefix: `4.3.1` or `Drehen`.
    pub code: String,
    /// German term.
    pub german: String,
    /// English term.
    pub english: String,
    /// Code of the parent, without prefix; `None` at the top.
    pub parent: Option<String>,
    /// Source of the entry.
    pub source: String,
    /// Edition of the standard; empty if the table does not give it.
    pub edition: String,
    /// Confidence: `high` if several sources agree, `medium` if there is only one source.
    pub confidence: String,
    /// Remarks on the entry.
    pub note: String,
}

impl Entry {
    /// Returns the code as written in contracts: `din:4.3.1`.
    pub fn full_code(&self) -> String {
        format!("{}:{}", self.standard.prefix(), self.code)
    }

    /// Returns code and terms: `din:4.3.1 Schrauben (Screwing)`.
    pub fn describe(&self) -> String {
        format!("{} {} ({})", self.full_code(), self.german, self.english)
    }
}

/// Error in a table of a taxonomy.
#[derive(Debug, thiserror::Error)]
#[error("{table}, record {record}: {message}")]
pub struct TableError {
    table: &'static str,
    record: usize,
    message: String,
}

/// Both standards as trees.
#[derive(Debug, Clone, Default)]
pub struct Taxonomy {
    /// Entries in the order of the tables, DIN first.
    entries: Vec<Entry>,
    /// Index of each entry, by its full code as `fold` returns it.
    by_code: BTreeMap<String, usize>,
}

static TAXONOMY: LazyLock<Taxonomy> = LazyLock::new(|| {
    Taxonomy::parse(&[(Standard::Din8580, DIN), (Standard::Vdi2860, VDI)])
        .unwrap_or_else(|e| panic!("the embedded taxonomy is damaged, please report this: {e}"))
});

/// Returns the embedded taxonomy.
pub fn taxonomy() -> &'static Taxonomy {
    &TAXONOMY
}

/// Returns the entry of a full code such as `din:4.3.1`, in the embedded taxonomy.
pub fn find(code: &str) -> Option<&'static Entry> {
    taxonomy().find(code)
}

/// Returns the entry of a full code in the embedded taxonomy.
///
/// # Errors
/// If there is no such entry; the error is a suggested next step for the user.
pub fn lookup(code: &str) -> Result<&'static Entry, String> {
    taxonomy().find(code).ok_or_else(|| {
        let near: Vec<String> = taxonomy()
            .suggestions(code)
            .into_iter()
            .map(Entry::describe)
            .collect();
        match near.as_slice() {
            [] => "find it by its term: `linewright din search WORD`".to_owned(),
            near => format!("did you mean {}?", near.join(", or ")),
        }
    })
}

impl Taxonomy {
    /// Reads CSV tables with the columns `code,german,english,parent,source,confidence,...`.
    ///
    /// # Errors
    /// If a table is malformed, or a code occurs twice, or a record has no code or term.
    pub fn parse(tables: &[(Standard, &str)]) -> Result<Self, TableError> {
        let mut taxonomy = Self::default();
        for (standard, text) in tables {
            let fail = |record: usize, message: String| TableError {
                table: standard.title(),
                record,
                message,
            };
            let mut reader = csv::Reader::from_reader(text.as_bytes());
            let columns: BTreeMap<String, usize> = reader
                .headers()
                .map_err(|e| fail(0, e.to_string()))?
                .iter()
                .enumerate()
                .map(|(i, name)| (name.to_owned(), i))
                .collect();
            for (i, record) in reader.records().enumerate() {
                let record = record.map_err(|e| fail(i + 1, e.to_string()))?;
                let optional = |name: &str| {
                    let column = columns.get(name).copied();
                    column.and_then(|c| record.get(c)).unwrap_or("").to_owned()
                };
                let required = |name: &str| match optional(name) {
                    value if value.is_empty() => Err(fail(i + 1, format!("`{name}` is empty"))),
                    value => Ok(value),
                };
                let entry = Entry {
                    standard: *standard,
                    code: required("code")?,
                    german: required("german")?,
                    english: required("english")?,
                    parent: Some(optional("parent")).filter(|p| !p.is_empty()),
                    source: optional("source"),
                    edition: optional("edition"),
                    confidence: optional("confidence"),
                    note: optional("note"),
                };
                let key = fold(&entry.full_code());
                if taxonomy
                    .by_code
                    .insert(key, taxonomy.entries.len())
                    .is_some()
                {
                    return Err(fail(i + 1, format!("{} occurs twice", entry.code)));
                }
                taxonomy.entries.push(entry);
            }
        }
        Ok(taxonomy)
    }

    /// Returns all entries, in the order of the tables.
    pub fn entries(&self) -> &[Entry] {
        &self.entries
    }

    /// Returns the entry of a full code, standard included. Case and the spelling of umlauts (`ü`
    /// or `ue`) are ignored.
    pub fn find(&self, code: &str) -> Option<&Entry> {
        self.by_code
            .get(&fold(code.trim()))
            .map(|i| &self.entries[*i])
    }

    /// Returns the entries whose code, German term or English term contains a word. Case and the
    /// spelling of umlauts are ignored: `Fraesen` and `frasen` both find Fräsen.
    pub fn search(&self, word: &str) -> Vec<&Entry> {
        let spellings = [fold(word.trim()), without_umlauts(word.trim())];
        self.entries
            .iter()
            .filter(|e| {
                [&e.full_code(), &e.german, &e.english].iter().any(|text| {
                    fold(text).contains(&spellings[0])
                        || without_umlauts(text).contains(&spellings[1])
                })
            })
            .collect()
    }

    /// Returns the parent of an entry.
    pub fn parent(&self, entry: &Entry) -> Option<&Entry> {
        let parent = entry.parent.as_ref()?;
        self.find(&format!("{}:{parent}", entry.standard.prefix()))
    }

    /// Returns the direct children of an entry, in the order of the table.
    pub fn children<'a>(&'a self, entry: &'a Entry) -> impl Iterator<Item = &'a Entry> {
        self.entries
            .iter()
            .filter(|e| e.standard == entry.standard && e.parent.as_ref() == Some(&entry.code))
    }

    /// Returns the entries without a parent.
    pub fn roots(&self) -> impl Iterator<Item = &Entry> {
        self.entries.iter().filter(|e| e.parent.is_none())
    }

    /// Returns the path from a root down to an entry, which is the last element.
    pub fn path<'a>(&'a self, entry: &'a Entry) -> Vec<&'a Entry> {
        let mut path = vec![entry];
        let mut seen = BTreeSet::from([entry.code.as_str()]);
        while let Some(parent) = path.last().and_then(|e| self.parent(e)) {
            if !seen.insert(parent.code.as_str()) {
                break;
            }
            path.push(parent);
        }
        path.reverse();
        path
    }

    /// Returns at most three entries similar to an unknown code, nearest first. An entry is similar
    /// if only its standard is missing or wrong, if it is an ancestor of the code, or if its code
    /// or term differs in a few letters.
    pub fn suggestions(&self, code: &str) -> Vec<&Entry> {
        let wanted = fold(code.trim());
        let local = wanted.split_once(':').map_or(wanted.as_str(), |(_, l)| l);
        if local.is_empty() {
            return Vec::new();
        }
        let prefix = wanted.split_once(':').map(|(p, _)| p);
        let mut near: Vec<(usize, bool, usize)> = Vec::new();
        for (i, entry) in self.entries.iter().enumerate() {
            let own = fold(&entry.code);
            let terms = [&entry.german, &entry.english];
            let distance = if own == local || terms.iter().any(|t| fold(t) == local) {
                0
            } else if local
                .strip_prefix(&own)
                .is_some_and(|rest| rest.starts_with('.'))
            {
                1 + local[own.len()..].matches('.').count()
            } else {
                let limit = if own.starts_with(|c: char| c.is_ascii_digit()) {
                    1
                } else {
                    local.chars().count().div_ceil(3)
                };
                match terms
                    .iter()
                    .map(|t| edit_distance(&fold(t), local))
                    .chain([edit_distance(&own, local)])
                    .min()
                {
                    Some(d) if d <= limit => 2 + d,
                    _ => continue,
                }
            };
            let other = prefix.is_some_and(|p| p != entry.standard.prefix());
            near.push((distance, other, i));
        }
        near.sort_unstable();
        near.into_iter()
            .take(3)
            .map(|(_, _, i)| &self.entries[i])
            .collect()
    }
}

/// Converts to lower case and writes out umlauts, so that `Fräsen` and `Fraesen` are equal.
fn fold(text: &str) -> String {
    let mut folded = String::with_capacity(text.len());
    for c in text.chars().flat_map(char::to_lowercase) {
        match c {
            'ä' => folded.push_str("ae"),
            'ö' => folded.push_str("oe"),
            'ü' => folded.push_str("ue"),
            'ß' => folded.push_str("ss"),
            c => folded.push(c),
        }
    }
    folded
}

/// Converts to lower case and replaces umlauts by their vowels: `frasen` for `Fräsen`.
fn without_umlauts(text: &str) -> String {
    fold_with(text, |c| match c {
        'ä' => 'a',
        'ö' => 'o',
        'ü' => 'u',
        c => c,
    })
}

fn fold_with(text: &str, replace: impl Fn(char) -> char) -> String {
    text.chars()
        .flat_map(char::to_lowercase)
        .map(replace)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn codes(entries: &[&Entry]) -> Vec<String> {
        entries.iter().map(|e| e.full_code()).collect()
    }

    #[test]
    fn parents_exist_and_lead_to_the_top_without_cycles() {
        let taxonomy = taxonomy();
        for entry in taxonomy.entries() {
            assert_eq!(
                taxonomy.parent(entry).is_some(),
                entry.parent.is_some(),
                "{entry:?}"
            );
            let path = taxonomy.path(entry);
            assert!(
                path[0].parent.is_none(),
                "{} is in a cycle",
                entry.full_code()
            );
            assert_eq!(path.last(), Some(&entry));
        }
    }

    #[test]
    fn both_tables_are_read_whole() {
        let count = |standard| {
            let entries = taxonomy().entries().iter();
            entries.filter(|e| e.standard == standard).count()
        };
        assert_eq!(
            (count(Standard::Din8580), count(Standard::Vdi2860)),
            (211, 46)
        );
    }

    #[test]
    fn codes_are_unique() {
        let all: BTreeSet<String> = taxonomy().entries().iter().map(Entry::full_code).collect();
        assert_eq!(all.len(), taxonomy().entries().len());
        let twice = "code,german,english,parent\n1,A,A,\n1,B,B,\n";
        let error = Taxonomy::parse(&[(Standard::Din8580, twice)]).unwrap_err();
        assert_eq!(error.to_string(), "DIN 8580, record 2: 1 occurs twice");
    }

    #[test]
    fn din_8580_has_six_main_groups_and_its_codes_are_their_own_paths() {
        let roots: Vec<&Entry> = taxonomy()
            .roots()
            .filter(|e| e.standard == Standard::Din8580)
            .collect();
        assert_eq!(
            codes(&roots),
            ["din:1", "din:2", "din:3", "din:4", "din:5", "din:6"]
        );
        for entry in taxonomy().entries() {
            if let (Standard::Din8580, Some(parent)) = (entry.standard, &entry.parent) {
                assert_eq!(
                    entry.code.rsplit_once('.').map(|c| c.0),
                    Some(parent.as_str())
                );
            }
        }
    }

    #[test]
    fn find_requires_the_standard_and_ignores_case() {
        assert_eq!(find("din:4.3.1").unwrap().german, "Schrauben");
        assert_eq!(find("VDI:drehen").unwrap().english, "Rotating");
        assert_eq!(find("vdi:Prüfen").unwrap().code, "Pruefen");
        assert!(find("4.3.1").is_none());
        assert!(find("din:Drehen").is_none());
    }

    #[test]
    fn search_ignores_how_umlauts_are_typed() {
        for word in ["Fräsen", "Fraesen", "FRAESEN", "frasen", "milling"] {
            assert!(
                codes(&taxonomy().search(word)).contains(&"din:3.2.3".to_owned()),
                "{word}"
            );
        }
        assert!(taxonomy().search("no such process").is_empty());
    }

    #[test]
    fn suggestions_are_near() {
        let first = |code: &str| codes(&taxonomy().suggestions(code)).first().cloned();
        assert_eq!(first("4.3.1").as_deref(), Some("din:4.3.1"));
        assert_eq!(first("vdi:4.3.1").as_deref(), Some("din:4.3.1"));
        assert_eq!(first("din:4.3.1.7").as_deref(), Some("din:4.3.1"));
        assert_eq!(first("vdi:Dreehn").as_deref(), Some("vdi:Drehen"));
        assert_eq!(first("vdi:Rotating").as_deref(), Some("vdi:Drehen"));
        assert!(taxonomy().suggestions("din:xxxxxxxxxxxx").is_empty());
        assert!(taxonomy().suggestions("").is_empty());
    }

    #[test]
    fn lookup_gives_a_next_step() {
        assert_eq!(
            lookup("din:4.3.1").unwrap().english,
            find("din:4.3.1").unwrap().english
        );
        assert!(
            lookup("vdi:Dreehn")
                .unwrap_err()
                .contains("vdi:Drehen Drehen (Rotating)")
        );
        assert!(
            lookup("din:xxxxxxxxxxxx")
                .unwrap_err()
                .contains("din search")
        );
    }
}
