//! Regular expressions over skills, matched by recursion over the positions of a word. Sets of
//! positions are masks, so a word has fewer than 128 calls.

use linewright::automata::regex::Regex;

/// Whether there is a word at all.
fn has_words(regex: &Regex, skills: usize) -> bool {
    match regex {
        Regex::Nothing => false,
        Regex::Empty | Regex::Letter(_) | Regex::AnyOrder(_) => true,
        Regex::AnyBut(but) => (0..skills).any(|s| !but.contains(&s)),
        Regex::Concat(parts) => parts.iter().all(|p| has_words(p, skills)),
        Regex::Either(parts) => parts.iter().any(|p| has_words(p, skills)),
        Regex::Repeat { of, low, .. } => *low == 0 || has_words(of, skills),
    }
}

/// A word of single skills, out of this many.
#[derive(Clone, Copy)]
pub struct Word<'a> {
    pub called: &'a [usize],
    pub skills: usize,
}

impl Word<'_> {
    /// Whether the whole word belongs to the expression.
    pub fn is_whole(self, regex: &Regex) -> bool {
        self.ends(regex, 0) >> self.called.len() & 1 == 1
    }

    /// Whether it is a prefix of a word of the expression.
    pub fn is_begun(self, regex: &Regex) -> bool {
        self.begins(regex, 0)
    }

    /// Positions at which words of the expression end that begin at this position.
    fn ends(self, regex: &Regex, at: usize) -> u128 {
        let one = |fits: bool| if fits { 1 << (at + 1) } else { 0 };
        let here = self.called.get(at);
        match regex {
            Regex::Nothing => 0,
            Regex::Empty => 1 << at,
            Regex::Letter(skill) => one(here == Some(skill)),
            Regex::AnyBut(but) => one(here.is_some_and(|s| !but.contains(s))),
            Regex::AnyOrder(skills) => {
                let end = at + skills.len();
                let fits = self.called.get(at..end);
                let fits = fits.is_some_and(|called| left_of(skills, called).is_some());
                if fits { 1 << end } else { 0 }
            }
            Regex::Concat(parts) => parts.iter().fold(1 << at, |from, part| {
                positions(from).fold(0, |ends, p| ends | self.ends(part, p))
            }),
            Regex::Either(parts) => parts.iter().fold(0, |ends, p| ends | self.ends(p, at)),
            Regex::Repeat { of, low, high } => self.repeated(of, *low, *high, at),
        }
    }

    fn repeated(self, of: &Regex, low: u32, high: Option<u32>, at: usize) -> u128 {
        let mut ends = if low == 0 { 1 << at } else { 0 };
        if high == Some(0) {
            return ends;
        }
        for next in positions(self.ends(of, at)) {
            // A repetition without calls counts only as long as more are required.
            if next > at || low > 0 {
                let high = high.map(|h| h - 1);
                ends |= self.repeated(of, low.saturating_sub(1), high, next);
            }
        }
        ends
    }

    /// Whether everything called from this position on is a prefix of a word.
    fn begins(self, regex: &Regex, at: usize) -> bool {
        if !has_words(regex, self.skills) {
            return false;
        }
        if at == self.called.len() {
            return true;
        }
        let rest = &self.called[at..];
        match regex {
            Regex::Nothing | Regex::Empty => false,
            Regex::Letter(skill) => rest == [*skill],
            Regex::AnyBut(but) => rest.len() == 1 && !but.contains(&rest[0]),
            Regex::AnyOrder(skills) => left_of(skills, rest).is_some(),
            Regex::Concat(parts) => {
                let Some((first, others)) = parts.split_first() else {
                    return false;
                };
                let others = Regex::Concat(others.to_vec());
                self.begins(first, at)
                    || positions(self.ends(first, at)).any(|p| self.begins(&others, p))
            }
            Regex::Either(parts) => parts.iter().any(|p| self.begins(p, at)),
            Regex::Repeat { of, low, high } => self.begins_repeated(of, *low, *high, at),
        }
    }

    fn begins_repeated(self, of: &Regex, low: u32, high: Option<u32>, at: usize) -> bool {
        if at == self.called.len() {
            return true;
        }
        if high == Some(0) {
            return false;
        }
        let high = high.map(|h| h - 1);
        self.begins(of, at)
            || positions(self.ends(of, at)).any(|next| {
                (next > at || low > 0)
                    && self.begins_repeated(of, low.saturating_sub(1), high, next)
            })
    }
}

fn positions(mask: u128) -> impl Iterator<Item = usize> {
    (0..u128::BITS as usize).filter(move |p| mask >> p & 1 == 1)
}

/// The remaining skills after others have been called; `None` if one is called that is not among
/// them.
fn left_of(skills: &[usize], called: &[usize]) -> Option<Vec<usize>> {
    let mut left = skills.to_vec();
    for skill in called {
        let place = left.iter().position(|s| s == skill)?;
        left.remove(place);
    }
    Some(left)
}
