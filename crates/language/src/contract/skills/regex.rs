//! Resolution of regular expressions over skills. Their size is limited, because the automaton
//! contains every repetition.

use super::Resolver;
use linewright_automata::regex::Regex;
use linewright_core::diagnostics::codes;
use linewright_core::source::Span;
use linewright_syntax::ast::{self, RegexKind, Times};

/// Maximum bound of a repetition.
const MAX_TIMES: u64 = 1000;
/// Maximum number of skills in a sequence, with repetitions expanded.
const MAX_SIZE: u64 = 10_000;

impl Resolver<'_> {
    /// Resolves a sequence. Reports a sequence that is too large.
    pub(super) fn sequence(&mut self, regex: &ast::Regex) -> Option<Regex> {
        let resolved = self.regex(regex)?;
        let size = size(&resolved);
        if size > MAX_SIZE {
            self.error(
                codes::TOO_LARGE,
                regex.span,
                format!("this has more than {MAX_SIZE} skills when repetitions are expanded"),
                "use fewer repetitions, or an order such as `at most 20 of Grip between Down and Up`, which is not expanded",
            );
            return None;
        }
        Some(resolved)
    }

    fn regex(&mut self, regex: &ast::Regex) -> Option<Regex> {
        Some(match &regex.kind {
            RegexKind::Empty => Regex::Empty,
            RegexKind::Skill(name) => Regex::Letter(self.find(name)?),
            RegexKind::Any => Regex::AnyBut(Vec::new()),
            RegexKind::AnyBut(names) => {
                let found: Vec<_> = names.iter().map(|n| self.find(n)).collect();
                let mut skills: Vec<usize> = found.into_iter().collect::<Option<_>>()?;
                skills.sort_unstable();
                skills.dedup();
                Regex::AnyBut(skills)
            }
            RegexKind::AnyOrder(names) => {
                let separate =
                    |a: &str, b: &str| format!("write both orders: `({a} {b} | {b} {a})`");
                Regex::AnyOrder(self.at_once(names, separate)?)
            }
            RegexKind::Concat(parts) => Regex::Concat(self.parts(parts)?),
            RegexKind::Either(parts) => Regex::Either(self.parts(parts)?),
            RegexKind::Repeat(of, times) => {
                let of = self.regex(of);
                let bounds = self.times(*times, regex.span);
                let (of, (low, high)) = (Box::new(of?), bounds?);
                Regex::Repeat { of, low, high }
            }
        })
    }

    fn parts(&mut self, parts: &[ast::Regex]) -> Option<Vec<Regex>> {
        let parts: Vec<Option<Regex>> = parts.iter().map(|p| self.regex(p)).collect();
        parts.into_iter().collect()
    }

    fn times(&mut self, times: Times, span: Span) -> Option<(u32, Option<u32>)> {
        let (low, high) = times.bounds();
        let most = high.unwrap_or(0).max(low);
        if most > MAX_TIMES {
            self.error(
                codes::TOO_LARGE,
                span,
                format!("this is repeated up to {most} times, but at most {MAX_TIMES} are allowed"),
                "write `*` if the number does not matter, or use fewer repetitions",
            );
            return None;
        }
        if high.is_some_and(|high| high < low) {
            self.error(
                codes::DOMAIN_EMPTY,
                span,
                format!("`{times}` is an empty range"),
                "write the smaller number first",
            );
            return None;
        }
        let number = |n: u64| u32::try_from(n).ok();
        Some((number(low)?, high.and_then(number)))
    }
}

/// Returns the number of skills in an expression when repetitions are expanded.
fn size(regex: &Regex) -> u64 {
    match regex {
        Regex::Nothing | Regex::Empty => 0,
        Regex::Letter(_) | Regex::AnyBut(_) => 1,
        // The automaton has a transition from each subset for each skill that is not in it.
        Regex::AnyOrder(skills) => {
            let sets = 1_u64.checked_shl(skills.len().saturating_sub(1) as u32);
            sets.unwrap_or(u64::MAX).saturating_mul(skills.len() as u64)
        }
        Regex::Concat(parts) | Regex::Either(parts) => {
            parts.iter().map(size).fold(0, u64::saturating_add)
        }
        Regex::Repeat { of, low, high } => {
            let times = high.unwrap_or(0).max(*low).max(1);
            size(of).saturating_mul(u64::from(times))
        }
    }
}
