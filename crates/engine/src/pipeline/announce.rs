//! Announces what is known of an unrealizable contract while its explanation is still being
//! computed.

use super::known::Analysis;
use crate::findings::list;
use linewright_core::gr1::Specification;
use linewright_solver::game::{Phase, Progress};
use std::fmt;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Time after which a stage of an explanation is announced. Most explanations take less.
const DELAY: Duration = Duration::from_millis(300);

/// If the work before a stage took longer than a second, the stage is announced after this share of
/// that work, so that a verdict that took long is not held back.
const SHARE: u32 = 20;

/// Returns how long a stage must last to be announced, given the duration of the work before it.
fn delay(before: Duration) -> Duration {
    if before > Duration::from_secs(1) {
        (before / SHARE).min(DELAY)
    } else {
        DELAY
    }
}

/// Where to print announcements; each is a line without its end.
#[derive(Clone)]
pub struct Announcer(Arc<dyn Fn(&str) + Send + Sync>);

impl Announcer {
    /// Creates an announcer that prints with this function.
    pub fn new(print: impl Fn(&str) + Send + Sync + 'static) -> Self {
        Self(Arc::new(print))
    }
}

impl fmt::Debug for Announcer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Announcer")
    }
}

/// What is computed of an explanation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stage {
    Core,
    Play,
    Repairs,
}

impl Stage {
    /// The current stage; `None` before the verdict, for a realizable contract and at the end.
    fn current(solve: &Progress, reported: Option<&Analysis>) -> Option<Self> {
        let Some(known) = reported else {
            return (solve.phase() == Phase::Core).then_some(Self::Core);
        };
        if known.realizable {
            return None;
        }
        match known.explanation.as_deref() {
            None => Some(Self::Play),
            Some(explanation) if explanation.play.is_none() => Some(Self::Play),
            Some(explanation) if explanation.advice.is_none() => Some(Self::Repairs),
            Some(_) => None,
        }
    }
}

/// The announcements of one contract.
pub(super) struct Announcements<'a> {
    announcer: Option<&'a Announcer>,
    specification: &'a Specification,
    begin: Instant,
    /// The current stage and its beginning.
    since: Option<(Stage, Instant)>,
    /// The last stage that was announced.
    said: Option<Stage>,
}

impl<'a> Announcements<'a> {
    pub(super) fn new(announcer: Option<&'a Announcer>, specification: &'a Specification) -> Self {
        Self {
            announcer,
            specification,
            begin: Instant::now(),
            since: None,
            said: None,
        }
    }

    /// Announces the current stage if it has lasted for a while.
    pub(super) fn update(&mut self, solve: &Progress, reported: Option<&Analysis>) {
        let (Some(announcer), Some(stage)) = (self.announcer, Stage::current(solve, reported))
        else {
            return;
        };
        let begin = match self.since {
            Some((known, begin)) if known == stage => begin,
            _ => self.since.insert((stage, Instant::now())).1,
        };
        if self.said != Some(stage) && begin.elapsed() >= delay(begin.duration_since(self.begin)) {
            self.said = Some(stage);
            (announcer.0)(&self.text(stage, reported));
        }
    }

    fn text(&self, stage: Stage, reported: Option<&Analysis>) -> String {
        let name = &self.specification.name;
        match stage {
            Stage::Core => {
                format!("`{name}` is unrealizable; looking for the guarantees that clash")
            }
            Stage::Play => {
                let names = reported.map_or_else(Vec::new, |k| k.core_names(self.specification));
                let clashing: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
                let verb = match clashing.len() {
                    1 => "cannot be kept",
                    _ => "clash",
                };
                let clashing = list(&clashing);
                format!(
                    "`{name}` is unrealizable: {clashing} {verb}; looking for a play that shows it"
                )
            }
            Stage::Repairs => {
                format!("`{name}` is unrealizable, as a play shows; looking for repairs")
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::known::tests::specification;
    use super::*;
    use crate::statistics::Statistics;
    use std::sync::Mutex;

    #[test]
    fn each_stage_is_announced_once_it_lasts() {
        let printed = Arc::new(Mutex::new(Vec::new()));
        let lines = Arc::clone(&printed);
        let announcer = Announcer::new(move |line| lines.lock().unwrap().push(line.to_owned()));
        let specification = specification("Lamp");
        let solve = Progress::default();
        let mut announcements = Announcements::new(Some(&announcer), &specification);

        let lost = Analysis::new(Statistics::default());
        announcements.update(&solve, None);
        announcements.update(&solve, Some(&lost));
        assert!(printed.lock().unwrap().is_empty());
        let long_ago = Instant::now().checked_sub(2 * DELAY).unwrap();
        announcements.since = Some((Stage::Play, long_ago));
        announcements.update(&solve, Some(&lost));
        announcements.update(&solve, Some(&lost));
        assert_eq!(printed.lock().unwrap().len(), 1);

        let won = Analysis {
            realizable: true,
            ..lost
        };
        announcements.since = Some((Stage::Play, long_ago));
        announcements.update(&solve, Some(&won));
        assert_eq!(printed.lock().unwrap().len(), 1);
    }

    #[test]
    fn a_verdict_that_took_long_is_announced_soon() {
        let delays = [0, 1, 2, 10, 100].map(|before| delay(Duration::from_secs(before)));
        assert_eq!(
            delays.map(|delay| delay.as_millis()),
            [300, 300, 100, 300, 300]
        );
    }
}
