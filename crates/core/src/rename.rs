//! Consistently replaces names that another language does not allow.

use std::collections::{BTreeMap, BTreeSet};

/// Returns a unique name that `is_allowed` accepts for each of `names`, in their order.
///
/// The first occurrence of an allowed name keeps it. In other names, `_` replaces each character
/// that is not an ASCII letter, digit or `_`. Then `prefix` and a suffix are added as needed. Names
/// that occur again are replaced, too.
///
/// `is_allowed` has to accept words of these characters that begin with a letter or with `prefix`,
/// but for a few.
pub fn renamed<'a>(
    names: impl IntoIterator<Item = &'a str>,
    prefix: &str,
    is_allowed: impl Fn(&str) -> bool,
) -> Vec<String> {
    let names: Vec<&str> = names.into_iter().collect();
    let mut used: BTreeSet<String> = BTreeSet::new();
    // Allowed names first, so that no replacement takes one of them.
    let mut result: Vec<Option<String>> = names
        .iter()
        .map(|name| {
            (is_allowed(name) && used.insert((*name).to_owned())).then(|| (*name).to_owned())
        })
        .collect();
    let mut next: BTreeMap<String, u32> = BTreeMap::new();
    for (name, slot) in names.iter().zip(&mut result) {
        if slot.is_some() {
            continue;
        }
        let plain: String = name
            .chars()
            .map(|c| {
                if c.is_ascii_alphanumeric() || c == '_' {
                    c
                } else {
                    '_'
                }
            })
            .collect();
        let plain = plain.trim_end_matches('_');
        let stem = if plain.starts_with(|c: char| c.is_ascii_alphabetic()) {
            plain.to_owned()
        } else {
            format!("{prefix}{plain}")
        };
        // Of each stem, the candidates before the next one are taken.
        let next = next.entry(stem.clone()).or_insert(0);
        while slot.is_none() {
            let candidate = match *next {
                0 => stem.clone(),
                1 => format!("{stem}_"),
                number => format!("{stem}_{number}"),
            };
            *next += 1;
            *slot = Some(candidate).filter(|c| is_allowed(c) && !used.contains(c));
        }
        used.extend(slot.clone());
    }
    result.into_iter().flatten().collect()
}
