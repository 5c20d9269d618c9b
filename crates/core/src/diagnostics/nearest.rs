//! "Did you mean ...?": the known word closest to an undeclared one.
//!
//! A name can be wrong in three ways: in its spelling (`comand`), in how its words are joined
//! (`angleDesired`, `ANGLE_DESIRED`), and in its words (`desired` for `desired_angle`, `cmd` for
//! `command`). The first two are slips. The third is a guess, so it is tried last, and only whole
//! words and common engineering abbreviations count.

/// Maximum length of a compared name, in bytes. Longer names are not typing mistakes.
const LONGEST_NAME: usize = 256;

/// Returns the known name closest to an unknown one, if any is close.
pub fn nearest<'n>(name: &str, known: impl Iterator<Item = &'n str>) -> Option<&'n str> {
    if name.len() > LONGEST_NAME {
        return None;
    }
    let own = words(name);
    let ranked = known.filter_map(|k| Some((rank(name, &own, k)?, k)));
    ranked.min().map(|(_, k)| k)
}

/// Ranks a known name by how it differs: in which way, and by how much.
fn rank(name: &str, own: &[String], known: &str) -> Option<(u8, usize)> {
    let words = words(known);
    if !own.is_empty() && own.concat() == words.concat() {
        return Some((0, distance(name, known)));
    }
    if numbered_apart(own, &words) {
        return None;
    }
    let slips = distance(name, known);
    let few = name.len().min(known.len()).div_ceil(4).min(name.len() / 2);
    if slips <= few {
        return Some((1, slips));
    }
    let extra = related(own, &words)?;
    Some((2, extra.words.len() * 100 + words.concat().len()))
}

/// Returns whether two names differ only in their numbers: `h1` and `h2` are different things.
fn numbered_apart(a: &[String], b: &[String]) -> bool {
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

/// How two names are related if they have the same words, or one has additional words.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NameSimilarity {
    /// Words that only one of the two names has.
    pub words: Vec<String>,
    /// Whether a word of one name abbreviates a word of the other.
    pub abbreviated: bool,
}

/// Compares two different names word by word, given their [`words`]: they are related if one begins
/// or ends with the words of the other, or with abbreviations of them.
pub fn related(a: &[String], b: &[String]) -> Option<NameSimilarity> {
    let (short, long) = if a.len() <= b.len() { (a, b) } else { (b, a) };
    // A single letter or a number is too little to identify a name.
    if short.iter().all(|w| w.len() < 3) {
        return None;
    }
    let kin = |part: &[String], rest: &[String]| {
        let alike = short.iter().zip(part).all(|(x, y)| same(x, y));
        alike.then(|| NameSimilarity {
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
    kin(head, tail)
        .or_else(|| kin(end, front))
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

/// Returns the edit distance of two names: letters changed, added, omitted or swapped with their
/// neighbour (optimal string alignment).
pub fn distance(a: &str, b: &str) -> usize {
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
    fn distance_counts_slips() {
        assert_eq!(distance("", "abc"), 3);
        assert_eq!(distance("drehen", "dreehn"), 1);
        assert_eq!(distance("turn", "turn"), 0);
    }

    #[test]
    fn typical_slips_are_found() {
        let known = ["Turn", "turn", "command", "angle", "a"];
        for (slip, meant) in [
            ("Trun", Some("Turn")),
            ("comand", Some("command")),
            ("angel", Some("angle")),
            ("angles", Some("angle")),
            ("b", None),
            ("press", None),
        ] {
            assert_eq!(nearest(slip, known.into_iter()), meant, "{slip}");
        }
    }

    #[test]
    fn words_are_known_in_other_company() {
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
    fn strangers_stay_strangers() {
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
    fn a_slip_goes_before_a_guess() {
        let known = ["angle_desired", "angles", "angle_max"];
        assert_eq!(nearest("angle", known.into_iter()), Some("angles"));
        assert_eq!(nearest("desired", known.into_iter()), Some("angle_desired"));
    }

    #[test]
    fn kin_say_what_sets_them_apart() {
        let apart = |a, b| related(&words(a), &words(b)).map(|k| k.words.join(" "));
        assert_eq!(apart("desired", "desired_angle").as_deref(), Some("angle"));
        assert_eq!(apart("cmd_turn", "command_turn").as_deref(), Some(""));
        assert_eq!(apart("turn_done", "turn_executed"), None);
        assert_eq!(apart("h1", "h2"), None);
    }
}
