//! "Did you mean ...?": the known word closest to an undeclared one.
//!
//! A name can be wrong in three ways: in its spelling (`comand`), in how its words are joined
//! (`angleDesired`, `ANGLE_DESIRED`), and in its choice of words (`desired` for `desired_angle`,
//! `cmd` for `command`). The first two are typing mistakes. The third is a guess, so it is tried
//! last, and only whole words and common engineering abbreviations count.

/// Maximum length of a compared name, in bytes. Longer names are not compared, because they are not
/// typing mistakes.
const MAX_NAME_LENGTH: usize = 256;

/// Returns the known name closest to an unknown one, if any is close.
pub fn nearest<'n>(name: &str, known: impl Iterator<Item = &'n str>) -> Option<&'n str> {
    if name.len() > MAX_NAME_LENGTH {
        return None;
    }
    let name_words = words(name);
    let ranked = known.filter_map(|k| Some((rank(name, &name_words, k)?, k)));
    ranked.min().map(|(_, k)| k)
}

/// Ranks a known name by the way in which it differs from `name`, then by how much; `None` if it is
/// not close.
fn rank(name: &str, name_words: &[String], known: &str) -> Option<(u8, usize)> {
    let words = words(known);
    if !name_words.is_empty() && name_words.concat() == words.concat() {
        return Some((0, edit_distance(name, known)));
    }
    if differ_in_numbers_only(name_words, &words) {
        return None;
    }
    let mistakes = edit_distance(name, known);
    let few = name.len().min(known.len()).div_ceil(4).min(name.len() / 2);
    if mistakes <= few {
        return Some((1, mistakes));
    }
    let similarity = word_similarity(name_words, &words)?;
    Some((2, similarity.words.len() * 100 + words.concat().len()))
}

/// Returns whether two names differ only in their numbers: `h1` is not a misspelt `h2`.
fn differ_in_numbers_only(a: &[String], b: &[String]) -> bool {
    let number = |w: &&String| w.starts_with(|c: char| c.is_numeric());
    let numbers = |words: &[String]| words.iter().filter(number).cloned().collect::<Vec<_>>();
    let others = |words: &[String]| {
        words
            .iter()
            .filter(|w| !number(w))
            .cloned()
            .collect::<Vec<_>>()
    };
    let (x, y) = (numbers(a), numbers(b));
    x != y && !x.is_empty() && !y.is_empty() && others(a) == others(b)
}

/// Difference between two similar names.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NameSimilarity {
    /// Words that only one of the two names has.
    pub words: Vec<String>,
    /// Whether a word of one name abbreviates a word of the other.
    pub abbreviated: bool,
}

/// Compares two different names word by word, given their [`words`]. They are similar if one begins
/// or ends with the words of the other, or with abbreviations of those words, or if both have the
/// same words in a different order. Returns `None` if they are not similar.
pub fn word_similarity(a: &[String], b: &[String]) -> Option<NameSimilarity> {
    let (short, long) = if a.len() <= b.len() { (a, b) } else { (b, a) };
    // A single letter or a number is too little to identify a name.
    if short.iter().all(|w| w.len() < 3) {
        return None;
    }
    let matching = |part: &[String], rest: &[String]| {
        let matches = short.iter().zip(part).all(|(x, y)| same(x, y));
        matches.then(|| NameSimilarity {
            words: rest.to_vec(),
            abbreviated: short != part,
        })
    };
    let extra = long.len() - short.len();
    let (head, tail) = (&long[..short.len()], &long[short.len()..]);
    let (front, end) = (&long[..extra], &long[extra..]);
    let in_other_order = || {
        let (mut x, mut y) = (short.to_vec(), long.to_vec());
        x.sort_unstable();
        y.sort_unstable();
        (extra == 0 && x == y).then(|| NameSimilarity {
            words: Vec::new(),
            abbreviated: false,
        })
    };
    matching(head, tail)
        .or_else(|| matching(end, front))
        .or_else(in_other_order)
}

fn same(a: &str, b: &str) -> bool {
    a == b || abbreviates(a, b) || abbreviates(b, a)
}

/// Returns whether `short` abbreviates `long`: as its beginning (`pos`, `req`) or its consonants
/// (`cmd`, `cnt`).
fn abbreviates(short: &str, long: &str) -> bool {
    if short.len() < 3 || long.len() < short.len() + 2 || short.as_bytes()[0] != long.as_bytes()[0]
    {
        return false;
    }
    if long.starts_with(short) {
        // `part` is a full word, not an abbreviation of `partition`.
        return short.len() <= 3;
    }
    let vowel = |c: char| "aeiou".contains(c);
    let mut rest = long.chars();
    let within = short.chars().all(|c| rest.any(|l| l == c));
    within && !short.chars().skip(1).any(vowel)
}

/// Splits a name into lower-case words: `turnDone_2` is `turn`, `done`, `2`.
pub fn words(name: &str) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    let mut before = '_';
    for c in name.chars() {
        if c.is_alphanumeric() {
            let begins = !before.is_alphanumeric()
                || before.is_lowercase() && c.is_uppercase()
                || before.is_numeric() != c.is_numeric();
            match words.last_mut() {
                Some(word) if !begins => word.extend(c.to_lowercase()),
                _ => words.push(c.to_lowercase().collect()),
            }
        }
        before = c;
    }
    words
}

/// Returns the edit distance of two names: the number of letters changed, added, omitted or swapped
/// with their neighbour (optimal string alignment).
pub fn edit_distance(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().collect(), b.chars().collect());
    let mut before: Vec<usize> = Vec::new();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for i in 0..a.len() {
        let mut next = vec![i + 1];
        for j in 0..b.len() {
            let mut least = (row[j] + usize::from(a[i] != b[j])).min(row[j + 1] + 1);
            least = least.min(next[j] + 1);
            if i > 0 && j > 0 && a[i] == b[j - 1] && a[i - 1] == b[j] {
                least = least.min(before[j - 1] + 1);
            }
            next.push(least);
        }
        before = std::mem::replace(&mut row, next);
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distance_counts_typing_mistakes() {
        assert_eq!(edit_distance("", "abc"), 3);
        assert_eq!(edit_distance("drehen", "dreehn"), 1);
        assert_eq!(edit_distance("turn", "turn"), 0);
    }

    #[test]
    fn typical_typing_mistakes_are_found() {
        let known = ["Turn", "turn", "command", "angle", "a"];
        for (typed, meant) in [
            ("Trun", Some("Turn")),
            ("comand", Some("command")),
            ("angel", Some("angle")),
            ("angles", Some("angle")),
            ("b", None),
            ("press", None),
        ] {
            assert_eq!(nearest(typed, known.into_iter()), meant, "{typed}");
        }
    }

    #[test]
    fn words_are_recognized_in_other_combinations() {
        let known = [
            "desired_angle",
            "command",
            "position",
            "turn_executed",
            "part_count",
            "ready",
            "x",
        ];
        for (name, meant) in [
            ("desired", Some("desired_angle")),
            ("desiredAngle", Some("desired_angle")),
            ("DESIRED_ANGLE", Some("desired_angle")),
            ("angle_desired", Some("desired_angle")),
            ("angle", Some("desired_angle")),
            ("cmd", Some("command")),
            ("pos", Some("position")),
            ("command_turn", Some("command")),
            ("part_cnt", Some("part_count")),
            ("is_ready", Some("ready")),
        ] {
            assert_eq!(nearest(name, known.into_iter()), meant, "{name}");
        }
    }

    #[test]
    fn dissimilar_names_are_not_suggested() {
        let known = [
            "turn_executed",
            "command",
            "ready",
            "x",
            "h1",
            "partition",
            "none",
        ];
        for name in [
            "turn_done",
            "red",
            "compare",
            "x_target",
            "h2",
            "part",
            "executed_by",
            "n",
            "",
            "_",
        ] {
            assert_eq!(nearest(name, known.into_iter()), None, "{name}");
        }
    }

    #[test]
    fn a_typing_mistake_takes_precedence_over_a_guess() {
        let known = ["angle_desired", "angles", "angle_max"];
        assert_eq!(nearest("angle", known.into_iter()), Some("angles"));
        assert_eq!(nearest("desired", known.into_iter()), Some("angle_desired"));
    }

    #[test]
    fn similarity_names_the_additional_words() {
        let extra = |a, b| word_similarity(&words(a), &words(b)).map(|s| s.words.join(" "));
        assert_eq!(extra("desired", "desired_angle").as_deref(), Some("angle"));
        assert_eq!(extra("cmd_turn", "command_turn").as_deref(), Some(""));
        assert_eq!(extra("turn_done", "turn_executed"), None);
        assert_eq!(extra("h1", "h2"), None);
    }
}
