//! Faults of rules: rules that together allow no call, contradict each other, or exclude nothing.
//!
//! The responsible rules are found by deletion, as for the cores of contracts: a rule is removed if
//! the fault remains without it. So every rule that is named is necessary for the fault.

use super::fsm::{Fsm, distinguished_calls};
use super::program::{self, DifferenceOptions};
use super::supervisor::{Call, Options, Supervisor};
use super::{Kind, Level, Skills};
use linewright_automata::bound::BoundExceeded;
use linewright_automata::dfa::REFUSED;
use linewright_core::deadline::Deadline;
use linewright_core::diagnostics::{Diagnostic, codes};

/// Maximum number of table entries of an automaton that is examined. It is small, because the
/// examination is repeated for many subsets of the rules.
const MAX_EXAMINED_ENTRIES: usize = 1 << 18;

/// Maximum number of table entries that are explored to find rules that exclude nothing. It applies
/// to all rules together.
const MAX_COMPARED_ENTRIES: usize = 1 << 22;

/// Returns the faults of the rules of a skill set at the level valid. If some rule applies only at
/// the level reasonable, the faults at that level follow.
pub fn examine(skills: &Skills, until: Deadline) -> Vec<Diagnostic> {
    let mut findings = Vec::new();
    let mut levels: Vec<Level> = skills.rules.iter().map(|r| r.level).collect();
    levels.push(Level::Valid);
    levels.sort_unstable();
    levels.dedup();
    for level in levels {
        let mut found = Vec::new();
        if let Err(error) = at_level(skills, level, until, &mut found) {
            found.push(too_large(skills, &error));
        }
        found.retain(|f| {
            let is_same = |o: &Diagnostic| o.code == f.code && o.span == f.span;
            !findings.iter().any(is_same)
        });
        findings.append(&mut found);
    }
    findings
}

fn too_large(skills: &Skills, error: &BoundExceeded) -> Diagnostic {
    let message = format!(
        "the rules of `{}` were not fully examined: {error}",
        skills.name
    );
    let finding = Diagnostic::warning(codes::TOO_LARGE, skills.span, message);
    match error {
        BoundExceeded::Stopped(late) => finding.with_help(late.remedy()).giving_up(true),
        BoundExceeded::Count { .. } => {
            finding.with_help("use fewer rules, or fewer repetitions in a sequence")
        }
    }
}

/// Adds the findings of one level. If a bound is exceeded, `findings` contains those found until
/// then.
fn at_level(
    skills: &Skills,
    level: Level,
    until: Deadline,
    findings: &mut Vec<Diagnostic>,
) -> Result<(), BoundExceeded> {
    let examined = OrderExamination {
        skills,
        calls: distinguished_calls(skills),
        options: Options {
            level,
            until,
            ..Options::default()
        },
    };
    let all: Vec<usize> = (0..skills.rules.len())
        .filter(|r| skills.rules[*r].level <= level)
        .collect();
    if all.is_empty() || skills.skills.is_empty() {
        return Ok(());
    }
    let fsm = examined.fsm(&all)?;
    if let Some(finding) = examined.no_first_call(&all)? {
        // All other findings would follow from this one.
        findings.push(finding);
        return Ok(());
    }
    findings.extend(examined.dead_end(&fsm, &all)?);
    examined.never_at_once(&all, findings)?;
    examined.never_called(&fsm, &all, findings)?;
    if findings.is_empty() {
        findings.extend(examined.unfinished(&fsm, &all)?);
    }
    examined.redundant(&all, findings)
}

struct OrderExamination<'a> {
    skills: &'a Skills,
    /// Calls to examine.
    calls: Vec<Call>,
    options: Options,
}

impl OrderExamination<'_> {
    fn only(&self, rules: &[usize]) -> Skills {
        self.skills.with_rules(rules)
    }

    fn fsm(&self, rules: &[usize]) -> Result<Fsm, BoundExceeded> {
        let skills = self.only(rules);
        let mut supervisor = Supervisor::new(&skills, self.options)?.track_relevant_only();
        Fsm::explore_within(&mut supervisor, self.calls.clone(), MAX_EXAMINED_ENTRIES)
    }

    /// Returns a minimal subset of the rules that still has the fault.
    fn core(
        rules: &[usize],
        fault: impl Fn(&[usize]) -> Result<bool, BoundExceeded>,
    ) -> Result<Vec<usize>, BoundExceeded> {
        let mut core = rules.to_vec();
        let mut at = 0;
        while at < core.len() {
            let mut fewer = core.clone();
            fewer.remove(at);
            if fault(&fewer)? {
                core = fewer;
            } else {
                at += 1;
            }
        }
        Ok(core)
    }

    /// Returns whether these calls are all allowed, and no call is allowed after them.
    fn is_stuck(&self, rules: &[usize], word: &[Call]) -> Result<bool, BoundExceeded> {
        let skills = self.only(rules);
        let mut supervisor = Supervisor::new(&skills, self.options)?;
        let mut state = supervisor.start();
        for call in word {
            match supervisor.call(&state, *call)? {
                Ok(after) => state = after,
                Err(_) => return Ok(false),
            }
        }
        // It is enough to try single skills, because where several skills can be called at once,
        // each of them can also be called alone.
        Ok(program::allowed(&mut supervisor, &state, 1)?.is_empty())
    }

    /// Finds rules that allow no call at the start.
    fn no_first_call(&self, all: &[usize]) -> Result<Option<Diagnostic>, BoundExceeded> {
        if !self.is_stuck(all, &[])? {
            return Ok(None);
        }
        let core = Self::core(all, |rules| self.is_stuck(rules, &[]))?;
        let (whose, verb) = self.named(&core);
        let finding = Diagnostic::error(
            codes::ORDER_EMPTY,
            self.span(&core),
            format!("{whose} {verb} no call at the start{}", self.at()),
        );
        let help = match core.as_slice() {
            [] => {
                "every skill is a recall at the start: declare another initial situation".to_owned()
            }
            _ => format!(
                "{}allow one of the skills as the first call, or declare another initial situation",
                self.unit_is("at the start", &self.initial())
            ),
        };
        Ok(Some(self.labelled(finding, &core).with_help(help)))
    }

    /// Formats a situation as the beginning of a help text, such as `there the unit is left, up: `.
    /// Returns an empty text if no component has situations.
    fn unit_is(&self, place: &str, situation: &[usize]) -> String {
        match self.skills.situation_text(situation).as_str() {
            "" => String::new(),
            situation => format!("{place} the unit is {situation}: "),
        }
    }

    /// Finds rules that together allow no further call in some state, although no single rule
    /// causes this.
    fn dead_end(&self, fsm: &Fsm, all: &[usize]) -> Result<Option<Diagnostic>, BoundExceeded> {
        let letters = fsm.dfa.letter_count();
        let is_stuck = |state: u32| (0..letters).all(|l| fsm.dfa.next(state, l) == REFUSED);
        for state in (0..fsm.states.len() as u32).filter(|s| is_stuck(*s)) {
            let word = fsm.path_to(state as usize);
            let core = Self::core(all, |rules| self.is_stuck(rules, &word))?;
            if core.len() < 2 {
                // A single rule that ends the program is no contradiction: it is a sequence that
                // does not start again.
                continue;
            }
            let (whose, _) = self.named(&core);
            let finding = Diagnostic::error(
                codes::ORDER_CONTRADICTION,
                self.span(&core),
                format!(
                    "{whose} contradict each other{}: after {} no further call is allowed",
                    self.at(),
                    self.word(&word)
                ),
            );
            return Ok(Some(self.labelled(finding, &core).with_help(format!(
                "{}allow a further call there, or forbid the calls that lead there",
                self.unit_is("there", &self.situation(&word))
            ))));
        }
        Ok(None)
    }

    /// Finds skills that no program ever calls, although no rule forbids them explicitly.
    fn never_called(
        &self,
        fsm: &Fsm,
        all: &[usize],
        findings: &mut Vec<Diagnostic>,
    ) -> Result<(), BoundExceeded> {
        let is_called = |fsm: &Fsm, skill: usize| {
            let mut columns = fsm
                .calls
                .iter()
                .enumerate()
                .filter(|(_, call)| call.0 >> skill & 1 == 1);
            let states = 0..fsm.states.len() as u32;
            columns.any(|(c, _)| states.clone().any(|s| fsm.dfa.next(s, c) != REFUSED))
        };
        for skill in 0..self.skills.skills.len() {
            if is_called(fsm, skill) {
                continue;
            }
            let core = Self::core(all, |rules| Ok(!is_called(&self.fsm(rules)?, skill)))?;
            let is_explicit = match core.as_slice() {
                [] => true,
                [rule] => match &self.skills.rules[*rule].kind {
                    Kind::Never(_) | Kind::Sequence(_) => true,
                    Kind::AtMost { count, .. } => *count == 0,
                    _ => false,
                },
                _ => false,
            };
            let span = self.span(&core);
            if is_explicit || findings.iter().any(|f| f.span == Some(span)) {
                continue;
            }
            let (whose, _) = self.named(&core);
            let name = &self.skills.skills[skill].name;
            let message = match core.len() {
                1 => format!(
                    "{whose} contradicts itself{}: `{name}` can never be called",
                    self.at()
                ),
                _ => format!(
                    "{whose} contradict each other{}: `{name}` can never be called",
                    self.at()
                ),
            };
            let finding = Diagnostic::error(codes::ORDER_CONTRADICTION, span, message);
            findings.push(self.labelled(finding, &core).with_help(format!(
                "allow `{name}` somewhere, or write `never {name}` if that is intended"
            )));
        }
        Ok(())
    }

    /// Finds combinations of simultaneous skills that a rule mentions but never allows, because the
    /// rule refuses one of the skills alone, or refuses the combination after one of the skills.
    fn never_at_once(
        &self,
        all: &[usize],
        findings: &mut Vec<Diagnostic>,
    ) -> Result<(), BoundExceeded> {
        for rule in all {
            let of = &self.skills.rules[*rule];
            let mut events: Vec<Call> = Vec::new();
            if matches!(of.kind, Kind::Never(_) | Kind::InARow(_))
                || matches!(of.kind, Kind::AtMost { count: 0, .. })
            {
                continue;
            }
            of.kind.for_each_event(&mut |event| {
                let call = event.0.iter().fold(0, |mask, skill| mask | 1 << skill);
                if event.0.len() > 1 && !events.contains(&Call(call)) {
                    events.push(Call(call));
                }
            });
            if events.is_empty() {
                continue;
            }
            let fsm = self.fsm(&[*rule])?;
            for event in events {
                let columns = fsm
                    .calls
                    .iter()
                    .enumerate()
                    .filter(|(_, call)| call.0 & event.0 == event.0);
                let mut columns = columns.peekable();
                let states = 0..fsm.states.len() as u32;
                if columns.peek().is_none()
                    || columns.any(|(c, _)| states.clone().any(|s| fsm.dfa.next(s, c) != REFUSED))
                {
                    continue;
                }
                let text = event.text(self.skills);
                let finding = Diagnostic::error(
                    codes::ORDER_CONTRADICTION,
                    of.span,
                    format!(
                        "the rule `{}` contradicts itself{}: `{text}` can never be called",
                        of.name,
                        self.at()
                    ),
                );
                findings.push(finding.with_note(
                    "a call of several skills counts as a call of each skill alone and as a call of all of them at once, in every order",
                ).with_help(format!(
                    "name either `{text}` or its skills in one rule, not both; or write `never {text}` if that is intended"
                )));
            }
        }
        Ok(())
    }

    /// Finds a sequence that cannot be completed because of other rules.
    fn unfinished(&self, fsm: &Fsm, all: &[usize]) -> Result<Option<Diagnostic>, BoundExceeded> {
        // A shortest allowed sequence of calls that cannot be extended to a complete one.
        let begun = fsm.dfa.clone().prefix_closed();
        let completed = fsm.dfa.clone().trimmed().prefix_closed();
        let Some(word) = begun.difference(&completed) else {
            return Ok(None);
        };
        let word: Vec<Call> = word.into_iter().map(|l| fsm.calls[l]).collect();
        let core = Self::core(all, |rules| {
            let skills = self.only(rules);
            let mut supervisor = Supervisor::new(&skills, self.options)?;
            let checked = program::check(&mut supervisor, &word)?;
            Ok(checked.violation.is_none()
                && !checked.unfinished.is_empty()
                && checked.completion?.is_none())
        })?;
        let (whose, _) = self.named(&core);
        let contradict = if core.len() == 1 {
            format!("{whose} contradicts itself")
        } else {
            format!("{whose} contradict each other")
        };
        let finding = Diagnostic::error(
            codes::ORDER_CONTRADICTION,
            self.span(&core),
            format!(
                "{contradict}{}: after {} no program can be completed",
                self.at(),
                self.word(&word)
            ),
        );
        Ok(Some(self.labelled(finding, &core).with_help(
            "let the sequence continue there, or use the other rules to forbid the calls that lead there",
        )))
    }

    /// Finds rules that forbid only calls that are also forbidden without them.
    fn redundant(
        &self,
        all: &[usize],
        findings: &mut Vec<Diagnostic>,
    ) -> Result<(), BoundExceeded> {
        for (at, rule) in all.iter().enumerate() {
            // A rule of a lower level was checked at that level.
            if self.skills.rules[*rule].level < self.options.level {
                continue;
            }
            let mut others = all.to_vec();
            others.remove(at);
            let (with, without) = (self.only(all), self.only(&others));
            let whole = DifferenceOptions {
                whole: true,
                one_way: false,
                entries: MAX_COMPARED_ENTRIES / all.len(),
            };
            let first = Supervisor::new(&with, self.options)?;
            let second = Supervisor::new(&without, self.options)?;
            if program::difference(&first, &second, &self.calls, whole)?.is_none() {
                let rule = &self.skills.rules[*rule];
                let reason = if others.is_empty() && self.options.level == Level::Valid {
                    "it forbids no call"
                } else {
                    "the calls that it forbids are also forbidden without it"
                };
                let finding = Diagnostic::warning(
                    codes::ORDER_REDUNDANT,
                    rule.span,
                    format!("the rule `{}` excludes nothing: {reason}", rule.name),
                );
                findings.push(finding.with_help(
                    "remove the rule, or check whether it says what you mean: for `before`, `after` and `until`, the skills of the initial situation count as called",
                ));
            }
        }
        Ok(())
    }

    fn initial(&self) -> Vec<usize> {
        self.skills.components.iter().map(|c| c.initial).collect()
    }

    /// Returns the situations of the components after these calls.
    fn situation(&self, word: &[Call]) -> Vec<usize> {
        let mut situation = self.initial();
        for skill in word.iter().flat_map(|call| call.skills()) {
            let skill = &self.skills.skills[skill];
            if let Some(effect) = skill.effect {
                situation[skill.component] = effect;
            }
        }
        situation
    }

    fn at(&self) -> String {
        match self.options.level {
            Level::Reasonable => " at the level reasonable".to_owned(),
            _ => String::new(),
        }
    }

    fn word(&self, word: &[Call]) -> String {
        let calls: Vec<String> = word.iter().map(|c| c.text(self.skills)).collect();
        match calls.len() {
            0 => "no call".to_owned(),
            _ => format!("`{}`", calls.join(", ")),
        }
    }

    /// Formats the rules as the subject of a message, `the rules a and b`, and returns the verb.
    fn named(&self, rules: &[usize]) -> (String, &'static str) {
        let names: Vec<String> = rules
            .iter()
            .map(|r| format!("`{}`", self.skills.rules[*r].name))
            .collect();
        match names.as_slice() {
            [] => ("the ban on recalls".to_owned(), "allows"),
            [one] => (format!("the rule {one}"), "allows"),
            [others @ .., last] => (
                format!("the rules {} and {last}", others.join(", ")),
                "allow",
            ),
        }
    }

    fn span(&self, rules: &[usize]) -> linewright_core::source::Span {
        rules
            .first()
            .map_or(self.skills.span, |r| self.skills.rules[*r].span)
    }

    fn labelled(&self, mut finding: Diagnostic, rules: &[usize]) -> Diagnostic {
        for rule in rules.iter().skip(1) {
            let rule = &self.skills.rules[*rule];
            finding = finding.with_label(rule.span, format!("and `{}`", rule.name));
        }
        finding
    }
}
