//! "Did you mean ...?": the known word closest to an undeclared one.
//!
//! A name can be wrong in three ways: in its spelling (`comand`), in how its words are joined
//! (`angleDesired`, `ANGLE_DESIRED`), and in its choice of words (`desired` for `desired_angle`,
//! `cmd` for `command`). The first two are typing mistakes. The third is a guess, so it is tried
//! last, and only whole words and common engineering abbreviations count.

use rapidfuzz::distance::osa;
use std::cell::OnceCell;

/// Maximum length of a compared name, in bytes. Longer names are not compared, because they are not
/// typing mistakes.
const MAX_NAME_LENGTH: usize = 256;

/// Returns the known name closest to an unknown one, if any is close. Each known name is only
/// compared as far as it may be closer than the best one before it.
pub fn nearest<'n>(name: &str, known: impl Iterator<Item = &'n str>) -> Option<&'n str> {
    let name = Spelling::of(name);
    let mut best: Option<(Rank, &str)> = None;
    for k in known {
        let most = best.map_or(Rank::MOST, |(rank, _)| rank);
        if let Some(rank) = name.rank(&Spelling::of(k), most) {
            best = Some(best.map_or((rank, k), |best| best.min((rank, k))));
        }
    }
    best.map(|(_, k)| k)
}

/// A name and what its comparison with other names needs. Where many names are compared with many
/// others, each is spelled once.
pub struct Spelling<'n> {
    name: &'n str,
    letters: Letters,
    words: OnceCell<Vec<String>>,
    edits: OnceCell<osa::BatchComparator<char>>,
}

impl<'n> Spelling<'n> {
    /// Reads a name. Linear in its length.
    pub fn of(name: &'n str) -> Self {
        Self {
            name,
            letters: Letters::of(name),
            words: OnceCell::new(),
            edits: OnceCell::new(),
        }
    }

    /// Returns whether this unknown name may be meant for a known one, as [`nearest`] judges it.
    pub fn is_close(&self, known: &Self) -> bool {
        self.rank(known, Rank::MOST).is_some()
    }

    fn words(&self) -> &[String] {
        self.words.get_or_init(|| words(self.name))
    }

    /// Returns the edit distance to another name, or `None` if it is greater than `most`.
    fn edits(&self, other: &str, most: usize) -> Option<usize> {
        let new = || osa::BatchComparator::new(self.name.chars());
        let edits = self.edits.get_or_init(new);
        edits.distance_with_args(other.chars(), &osa::Args::default().score_cutoff(most))
    }

    /// Ranks a known name by the way in which it differs from this one, then by how much; `None` if
    /// it is not close, or less close than `most`.
    fn rank(&self, known: &Self, most: Rank) -> Option<Rank> {
        if self.name.len() > MAX_NAME_LENGTH {
            return None;
        }
        let mistakes = most.mistakes(self.name, known.name);
        let may_be = self.letters.compare(&known.letters, mistakes);
        self.rank_as(known, most, may_be)
    }

    /// Ranks a known name in those ways in which it may differ.
    fn rank_as(&self, known: &Self, most: Rank, may_be: MayBe) -> Option<Rank> {
        let same = may_be.same && self.letters.words > 0;
        if same && lower_case(self.name).eq(lower_case(known.name)) {
            return Some(Rank::Joined(edit_distance(self.name, known.name)));
        }
        let misspelt = may_be
            .misspelt
            .then(|| self.edits(known.name, most.mistakes(self.name, known.name)));
        let mistakes = misspelt.flatten();
        let similar = may_be.similar && matches!(most, Rank::Similar(_));
        if mistakes.is_none() && !similar || differ_in_numbers_only(self.words(), known.words()) {
            return None;
        }
        if let Some(mistakes) = mistakes {
            return Some(Rank::Misspelt(mistakes));
        }
        let similarity = word_similarity(self.words(), known.words())?;
        let length: usize = known.words().iter().map(String::len).sum();
        Some(Rank::Similar(similarity.words.len() * 100 + length))
    }
}

/// How close a known name is, the closest first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Rank {
    /// The same letters, joined to words in another way, with the edit distance.
    Joined(usize),
    /// Misspelt, with the number of typing mistakes.
    Misspelt(usize),
    /// Similar words, with what the longer name has in addition.
    Similar(usize),
}

impl Rank {
    /// As far as any name may be.
    const MOST: Self = Self::Similar(usize::MAX);

    /// Returns how many typing mistakes a known name may be away that is at least as close.
    fn mistakes(self, name: &str, known: &str) -> usize {
        let few = name.len().min(known.len()).div_ceil(4).min(name.len() / 2);
        match self {
            Self::Joined(_) => 0,
            Self::Misspelt(most) => few.min(most),
            Self::Similar(_) => few,
        }
    }
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
    /// The last byte of the letter with which each of its first [`Letters::IN_ORDER`] words begins.
    in_order: u128,
    words: usize,
    chars: usize,
}

impl Letters {
    /// How many words are compared in order.
    const IN_ORDER: usize = 16;

    fn of(name: &str) -> Self {
        let mut found = Self {
            all: 0,
            initials: 0,
            in_order: 0,
            words: 0,
            chars: 0,
        };
        for (c, begins) in letters(name) {
            found.chars += 1;
            let Some(begins) = begins else { continue };
            let first = if c.is_ascii() {
                c.to_ascii_lowercase()
            } else {
                found.all |= c.to_lowercase().fold(0, |all, c| all | Self::bit(c));
                c.to_lowercase().next().unwrap_or(c)
            };
            found.all |= Self::bit(first);
            if begins {
                found.initials |= Self::bit(first);
                if found.words < Self::IN_ORDER {
                    let byte = u128::from(u32::from(first) & 0xff);
                    found.in_order |= byte << (8 * found.words);
                }
                found.words += 1;
            }
        }
        found
    }

    /// The bit of a letter in lower case.
    fn bit(c: char) -> u64 {
        match c {
            'a'..='z' => 1 << (c as u32 - 'a' as u32),
            '0'..='9' => 1 << (32 + c as u32 - '0' as u32),
            _ => 1 << 63,
        }
    }

    /// Returns whether a longer name may begin or end with the words of this one, or have the same
    /// words in another order.
    fn may_begin_or_end(&self, long: &Self) -> bool {
        if long.words > Self::IN_ORDER || self.words == long.words {
            return true;
        }
        let (extra, mask) = (8 * (long.words - self.words), (1 << (8 * self.words)) - 1);
        long.in_order & mask == self.in_order || long.in_order >> extra == self.in_order
    }

    /// Returns in which ways a known name may be close to an unknown one, given how many typing
    /// mistakes count as few. A mistake adds and removes at most one letter; similar names have
    /// words that begin alike (see [`same`]).
    fn compare(&self, known: &Self, few: usize) -> MayBe {
        let (short, long) = if self.words <= known.words {
            (self, known)
        } else {
            (known, self)
        };
        let only = |a: u64, b: u64| (a & !b).count_ones() as usize;
        let (added, removed) = (only(known.all, self.all), only(self.all, known.all));
        MayBe {
            same: self.all == known.all,
            misspelt: self.chars.abs_diff(known.chars) <= few && added.max(removed) <= few,
            similar: short.initials & !long.initials == 0 && short.may_begin_or_end(long),
        }
    }
}

/// Returns the letters and digits of a name in lower case, without what joins its words.
fn lower_case(name: &str) -> impl Iterator<Item = char> + '_ {
    let letters = letters(name).filter(|(_, begins)| begins.is_some());
    letters.flat_map(|(c, _)| c.to_lowercase())
}

/// Returns whether two names differ only in their numbers: `h1` is not a misspelt `h2`.
fn differ_in_numbers_only(a: &[String], b: &[String]) -> bool {
    let is_number = |w: &&String| w.starts_with(|c: char| c.is_numeric());
    let numbers = |words: &[String]| words.iter().filter(is_number).count();
    let same_numbers = a.iter().filter(is_number).eq(b.iter().filter(is_number));
    let others = |w: &&String| !is_number(w);
    let same_others = a.iter().filter(others).eq(b.iter().filter(others));
    !same_numbers && same_others && numbers(a) > 0 && numbers(b) > 0
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
    osa::distance(a.chars(), b.chars())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distance_counts_typing_mistakes() {
        assert_eq!(edit_distance("", "abc"), 3);
        assert_eq!(edit_distance("drehen", "dreehn"), 1);
        assert_eq!(edit_distance("turn", "turn"), 0);
        assert_eq!(Spelling::of("drehen").edits("dreehn", 1), Some(1));
        assert_eq!(Spelling::of("drehen").edits("dreehn", 0), None);
        assert_eq!(Spelling::of("turn").edits("command", 4), None);
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
            let spelling = Spelling::of(name);
            let mut best = None;
            for known in &names {
                let ranked = spelling.rank(&Spelling::of(known), Rank::MOST);
                let whole = spelling.rank_as(&Spelling::of(known), Rank::MOST, any);
                assert_eq!(ranked, whole, "{name} {known}");
                close += usize::from(ranked.is_some());
                let found = ranked.map(|rank| (rank, known.as_str()));
                best = best.into_iter().chain(found).min();
            }
            let found = nearest(name, names.iter().map(String::as_str));
            assert_eq!(found, best.map(|(_, known)| known), "{name}");
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
