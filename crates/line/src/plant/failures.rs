//! Breakdowns of stations.
//!
//! A station has any number of failure modes, each with its own random numbers. If a failure
//! strikes while the station is under repair, its own repair begins when the earlier ones have
//! ended. Repairs continue off shift.

use super::station::Phase;
use super::{Event, Place, Run, WORK, stream};
use crate::log::EventKind;
use crate::random::Purpose;
use crate::sampler::Sampler;
use linewright_language::contract::machine::{Between, FailureMode, InterruptedWork};
use std::collections::VecDeque;

/// The failure modes of a station.
#[derive(Debug)]
pub(super) struct Failures {
    modes: Vec<Mode>,
    /// The mode under repair.
    current: Option<usize>,
    /// Modes that have struck during a repair, in order.
    waiting: VecDeque<usize>,
}

#[derive(Debug)]
struct Mode {
    trigger: Trigger,
    repair: Sampler,
    interrupted: InterruptedWork,
}

/// What leads to the next failure.
#[derive(Debug)]
enum Trigger {
    /// Seconds of work left, and the draws of such times.
    Work(f64, Sampler),
    Calendar(Sampler),
    /// Number of parts left, and number of parts between failures.
    Parts(u64, u64),
    /// Number of parts left, and the draws of such numbers.
    DrawnParts(u64, Sampler),
}

/// Draws a number of parts: to the nearest whole number, and at least 1.
fn parts(count: &mut Sampler) -> u64 {
    count.draw().round().max(1.0) as u64
}

impl Failures {
    /// Creates the failure modes of the station with this name.
    pub(super) fn new(station: &str, modes: &[FailureMode], seed: u64) -> Self {
        let modes = modes.iter().map(|mode| {
            let name = if mode.name.is_empty() {
                station.to_owned()
            } else {
                format!("{station}.{}", mode.name)
            };
            let between = |time| Sampler::new(time, stream(seed, Purpose::Failures, &name));
            Mode {
                trigger: match &mode.between {
                    Between::Working(time) => {
                        let mut between = between(time);
                        Trigger::Work(between.draw(), between)
                    }
                    Between::Calendar(time) => Trigger::Calendar(between(time)),
                    Between::Parts(count) => Trigger::Parts(*count, *count),
                    Between::DrawnParts(count) => {
                        let mut between = between(count);
                        Trigger::DrawnParts(parts(&mut between), between)
                    }
                },
                repair: Sampler::new(&mode.repair, stream(seed, Purpose::Repairs, &name)),
                interrupted: mode.interrupted,
            }
        });
        Self {
            modes: modes.collect(),
            current: None,
            waiting: VecDeque::new(),
        }
    }

    /// Whether the station is broken down.
    pub(super) fn is_failed(&self) -> bool {
        self.current.is_some()
    }

    /// Whether there is a failure mode.
    #[inline]
    pub(super) fn can_strike(&self) -> bool {
        !self.modes.is_empty()
    }

    /// Seconds of work until the next failure.
    #[inline]
    pub(super) fn seconds_left(&self) -> f64 {
        let mut least = f64::INFINITY;
        for mode in &self.modes {
            if let Trigger::Work(left, _) = &mode.trigger {
                least = least.min(*left);
            }
        }
        least
    }

    /// Counts seconds of work.
    #[inline]
    pub(super) fn worked(&mut self, seconds: f64) {
        for mode in &mut self.modes {
            if let Trigger::Work(left, _) = &mut mode.trigger {
                *left = (*left - seconds).max(0.0);
            }
        }
    }

    /// The mode that strikes after [`Self::seconds_left`] seconds of work. Draws the working time
    /// until it strikes again.
    pub(super) fn strike_at_work(&mut self) -> Option<usize> {
        let least = self.seconds_left();
        let mut modes = self.modes.iter_mut().enumerate();
        modes.find_map(|(index, mode)| match &mut mode.trigger {
            Trigger::Work(left, between) if *left <= least => {
                *left = between.draw();
                Some(index)
            }
            _ => None,
        })
    }

    /// Counts a finished part. Returns the modes that strike.
    pub(super) fn part_finished(&mut self) -> Vec<usize> {
        let mut struck = Vec::new();
        for (index, mode) in self.modes.iter_mut().enumerate() {
            let left = match &mut mode.trigger {
                Trigger::Parts(left, _) | Trigger::DrawnParts(left, _) => left,
                Trigger::Work(..) | Trigger::Calendar(_) => continue,
            };
            *left -= 1;
            if *left > 0 {
                continue;
            }
            match &mut mode.trigger {
                Trigger::Parts(left, every) => *left = *every,
                Trigger::DrawnParts(left, every) => *left = parts(every),
                Trigger::Work(..) | Trigger::Calendar(_) => {}
            }
            struck.push(index);
        }
        struck
    }

    /// Draws the time until a mode strikes by the calendar; `None` if it does not.
    fn calendar_seconds(&mut self, mode: usize) -> Option<f64> {
        match &mut self.modes[mode].trigger {
            Trigger::Calendar(between) => Some(between.draw()),
            _ => None,
        }
    }
}

impl Run<'_> {
    /// Schedules the first failures that strike by the calendar.
    pub(super) fn schedule_failures(&mut self, node: usize) {
        let modes = match &self.nodes[node].place {
            Place::Station(station) => station.failures.modes.len(),
            _ => 0,
        };
        for mode in 0..modes {
            self.schedule_failure(node, mode);
        }
    }

    fn schedule_failure(&mut self, node: usize, mode: usize) {
        if let Some(seconds) = self.station(node).failures.calendar_seconds(mode) {
            let event = Event::Failure(node as u32, mode as u32);
            self.schedule(self.now + seconds, WORK, event);
        }
    }

    /// A station breaks down in one of its failure modes.
    pub(super) fn break_down(&mut self, node: usize, mode: usize) {
        let now = self.now;
        self.end_wait(node);
        let station = self.station(node);
        if station.failures.current.is_some() {
            station.failures.waiting.push_back(mode);
            return;
        }
        station.pause(now);
        station.failures.current = Some(mode);
        let mode = &mut station.failures.modes[mode];
        let seconds = mode.repair.draw();
        let interrupted = mode.interrupted;
        let works = matches!(station.phase, Phase::Setup | Phase::Service);
        if interrupted == InterruptedWork::Restarts && works {
            station.restart();
        }
        station.book(now);
        self.record(node, None, EventKind::Failed);
        self.record_state(node);
        if interrupted == InterruptedWork::ScrapsPart {
            self.scrap_work(node);
        }
        self.schedule(now + seconds, WORK, Event::Repair(node as u32));
    }

    /// A station is repaired.
    pub(super) fn repair(&mut self, node: usize) {
        let station = self.station(node);
        let repaired = station.failures.current.take();
        let next = station.failures.waiting.pop_front();
        self.record(node, None, EventKind::Repaired);
        if let Some(mode) = repaired {
            self.schedule_failure(node, mode);
        }
        match next {
            Some(mode) => self.break_down(node, mode),
            None => self.work_again(node),
        }
    }
}
