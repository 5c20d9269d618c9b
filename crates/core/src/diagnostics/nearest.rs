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
    let (letters, name_words) = (Letters::of(name), words(name));
    let ranked = known.filter_map(|k| {
        let may_be = letters.compare(&Letters::of(k), most_mistakes(name, k));
        Some((rank(name, &name_words, k, may_be?)?, k))
    });
    ranked.min().map(|(_, k)| k)
}

/// Returns how many typing mistakes a known name may be away.
fn most_mistakes(name: &str, known: &str) -> usize {
    name.len().min(known.len()).div_ceil(4).min(name.len() / 2)
}

/// What [`Letters`] say of two names.
#[derive(Debug, Clone, Copy)]
struct MayBe {
    /// The same letters, joined to words in another way.
    same: bool,
    misspelt: bool,
    similar: bool,
}

/// Which letters and digits a name has, in lower case: a bit for each of them, and one for all that
/// are not ASCII. Comparing these is much faster than comparing words, and excludes most names,
/// which matters where thousands of names are unknown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Letters {
    /// Those of the whole name.
    all: u64,
    /// Those with which its words begin.
    initials: u64,
    words: usize,
    chars: usize,
}

impl Letters {
    fn of(name: &str) -> Self {
        let mut found = Self {
            all: 0,
            initials: 0,
            words: 0,
            chars: 0,
        };
        for (c, begins) in letters(name) {
            found.chars += 1;
            let Some(begins) = begins else { continue };
            for (index, c) in c.to_lowercase().enumerate() {
                let bit = match c {
                    'a'..='z' => c as u32 - 'a' as u32,
                    '0'..='9' => 32 + c as u32 - '0' as u32,
                    _ => 63,
                };
                found.all |= 1 << bit;
                if begins && index == 0 {
                    found.initials |= 1 << bit;
                }
            }
            found.words += usize::from(begins);
        }
        found
    }

    /// Compares an unknown name with a known one, given how many typing mistakes count as few.
    /// `None` if they cannot be close. A mistake adds and removes at most one letter; similar names
    /// have words that begin alike (see [`same`]).
    fn compare(&self, known: &Self, few: usize) -> Option<MayBe> {
        let (short, long) = if self.words <= known.words {
            (self, known)
        } else {
            (known, self)
        };
        let only = |a: u64, b: u64| (a & !b).count_ones() as usize;
        let (added, removed) = (only(known.all, self.all), only(self.all, known.all));
        let may_be = MayBe {
            same: self.all == known.all,
            misspelt: self.chars.abs_diff(known.chars) <= few && added.max(removed) <= few,
            similar: short.initials & !long.initials == 0,
        };
        (may_be.same || may_be.misspelt || may_be.similar).then_some(may_be)
    }
}

/// Ranks a known name by the way in which it differs from `name`, then by how much; `None` if it is
/// not close.
fn rank(name: &str, name_words: &[String], known: &str, may_be: MayBe) -> Option<(u8, usize)> {
    let mistakes = may_be.misspelt.then(|| edit_distance(name, known));
    let mistakes = mistakes.filter(|mistakes| *mistakes <= most_mistakes(name, known));
    if mistakes.is_none() && !may_be.similar && !may_be.same {
        return None;
    }
    let words = words(known);
    if !name_words.is_empty() && name_words.concat() == words.concat() {
        return Some((0, edit_distance(name, known)));
    }
    if differ_in_numbers_only(name_words, &words) {
        return None;
    }
    if let Some(mistakes) = mistakes {
        return Some((1, mistakes));
    }
    if !may_be.similar {
        return None;
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
    for (c, begins) in letters(name) {
        match (begins, words.last_mut()) {
            (Some(false), Some(word)) => word.extend(c.to_lowercase()),
            (Some(_), _) => words.push(c.to_lowercase().collect()),
            (None, _) => {}
        }
    }
    words
}

/// Returns the characters of a name; with each letter or digit, whether a word begins there.
fn letters(name: &str) -> impl Iterator<Item = (char, Option<bool>)> + '_ {
    let mut before = '_';
    name.chars().map(move |c| {
        let begins = c.is_alphanumeric().then(|| {
            !before.is_alphanumeric()
                || before.is_lowercase() && c.is_uppercase()
                || before.is_numeric() != c.is_numeric()
        });
        before = c;
        (c, begins)
    })
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

    /// Names that differ in every way that counts, and in ways that do not.
    #[test]
    fn letters_never_hide_a_close_name() {
        let parts = [
            "turn", "trun", "Turn", "TURN", "cmd", "command", "pos", "position", "1", "2", "12",
            "é", "\u{212a}", "x", "_", "",
        ];
        let mut names: Vec<String> = Vec::new();
        for a in parts {
            for b in parts {
                names.extend([format!("{a}_{b}"), format!("{a}{b}"), format!("{b}{a}_x")]);
            }
        }
        let any = MayBe {
            same: true,
            misspelt: true,
            similar: true,
        };
        let mut close = 0;
        for name in &names {
            let (all, words) = (Letters::of(name), words(name));
            for known in &names {
                let may_be = all.compare(&Letters::of(known), most_mistakes(name, known));
                let ranked = may_be.and_then(|may_be| rank(name, &words, known, may_be));
                assert_eq!(ranked, rank(name, &words, known, any), "{name} {known}");
                close += usize::from(ranked.is_some());
            }
        }
        assert!(close > names.len() && close < names.len() * names.len() / 2);
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
