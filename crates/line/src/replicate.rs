//! Replications: the same line under several seeds, with confidence intervals.

use super::bottleneck::Bottleneck;
use super::estimates::{self, Estimated};
use super::log::Observer;
use super::metric::{self, Figures as _};
use super::plant::Plant;
use super::requirement::{self, ReplicatedRequirement, Sample};
use super::statistics::student_t;
use super::trace::{End, Trace};
use linewright_core::deadline::StopReason;
use linewright_core::diagnostics::{Diagnostic, Severity, codes};
use linewright_language::contract::line::Line;
use linewright_language::contract::metric::Measure;

/// Statistics over several runs.
#[derive(Debug, Clone, PartialEq)]
pub struct Replications {
    /// Seeds, one per run.
    pub seeds: Vec<u64>,
    /// Products per hour.
    pub throughput_per_hour: Option<Estimate>,
    /// Seconds to the last product, over the runs that made a product; `None` if no run made one.
    pub makespan: Option<Estimate>,
    /// Mean lead time in seconds, over the runs that made a product.
    pub lead_time: Option<Estimate>,
    /// 95th percentile of the lead time in seconds, over the runs that made a product.
    pub lead_time_p95: Option<Estimate>,
    /// Mean number of parts in the line.
    pub wip: Option<Estimate>,
    /// Total energy in kWh.
    pub energy_kwh: Option<Estimate>,
    /// All measures of the line, its products and its places; empty for a single run.
    pub measures: Vec<Estimated>,
    /// The line's requirements over all runs, in line order.
    pub requirements: Vec<ReplicatedRequirement>,
    /// The shortest and the longest warm-up, in seconds.
    pub warm_up: (f64, f64),
    /// Problems in any of the runs, without duplicates. Each requirement that fails or is undecided
    /// adds one finding.
    pub findings: Vec<Diagnostic>,
}

/// A mean with half the width of its 95 % confidence interval (Student's t distribution).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Mean of the runs.
    pub mean: f64,
    /// Half the width of the interval, before it is cut to the range; `None` for a single run,
    /// which allows no estimate. Verdicts and precision rest on it.
    pub half_width: Option<f64>,
    /// The least and the greatest value that can be; infinite without bounds.
    pub range: (f64, f64),
    /// Number of runs in which nothing could be measured. They are no part of the mean.
    pub missing: usize,
}

impl Estimate {
    /// Estimates the mean of independent values; `None` if there are none.
    pub fn of(values: &[f64]) -> Option<Self> {
        if values.is_empty() {
            return None;
        }
        let range = (f64::NEG_INFINITY, f64::INFINITY);
        // Equal values have no rounding error.
        if let [first, others @ ..] = values
            && !others.is_empty()
            && others
                .iter()
                .all(|value| value.to_bits() == first.to_bits())
        {
            return Some(Self {
                mean: *first,
                half_width: Some(0.0),
                range,
                missing: 0,
            });
        }
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let half_width = (values.len() > 1).then(|| {
            let squares: f64 = values.iter().map(|x| (x - mean).powi(2)).sum();
            let deviation = (squares / (count - 1.0)).sqrt();
            student_t(values.len() as u64 - 1) * deviation / count.sqrt()
        });
        Some(Self {
            mean,
            half_width,
            range,
            missing: 0,
        })
    }

    /// Estimates the mean of a measure over runs, of which some may have no value; `None` if none
    /// has one.
    pub fn over_runs(
        measure: Measure,
        values: impl IntoIterator<Item = Option<f64>>,
    ) -> Option<Self> {
        let values: Vec<Option<f64>> = values.into_iter().collect();
        let measured: Vec<f64> = values.iter().copied().flatten().collect();
        Some(Self {
            missing: values.len() - measured.len(),
            ..Self::of(&measured)?.of_measure(measure)
        })
    }

    /// The estimate of a measure, whose values lie in a range: none is negative, and no share is
    /// above 1.
    #[must_use]
    pub fn of_measure(self, measure: Measure) -> Self {
        let greatest = measure.info().unit.greatest();
        Self {
            range: (0.0, greatest.unwrap_or(f64::INFINITY)),
            ..self
        }
    }

    /// The interval, cut to the range that the measure can take: the parts beyond it hold no
    /// possible mean. `None` for a single run.
    pub fn interval(&self) -> Option<(f64, f64)> {
        let half = self.half_width?;
        let (least, greatest) = self.range;
        // Rounding may put the mean itself beyond the range.
        let low = (self.mean - half).max(least.min(self.mean));
        let high = (self.mean + half).min(greatest.max(self.mean));
        Some((low, high))
    }

    /// The same in another unit, of which `scale` are one of this.
    #[must_use]
    pub fn scaled(self, scale: f64) -> Self {
        Self {
            mean: self.mean * scale,
            half_width: self.half_width.map(|half| half * scale),
            range: (self.range.0 * scale, self.range.1 * scale),
            ..self
        }
    }

    /// Estimated number of runs, in addition to the `runs` that were made, after which the interval
    /// no longer contains `bound`, if mean and deviation stay as they are. `None` if the mean is
    /// the bound, or if more than [`MAX_REPLICATIONS`] runs are needed. Needs an interval.
    pub(super) fn further_runs(&self, runs: u64, bound: f64) -> Option<u64> {
        let distance = (self.mean - bound).abs();
        let deviation = self.half_width? * (runs as f64).sqrt() / student_t(runs - 1);
        let half = |count: u64| student_t(count - 1) * deviation / (count as f64).sqrt();
        if distance <= 0.0 || half(MAX_REPLICATIONS) >= distance {
            return None;
        }
        // The half width falls with the number of runs: `few` are not enough, `enough` are.
        let (mut few, mut enough) = (runs, MAX_REPLICATIONS.max(runs + 1));
        while enough - few > 1 {
            let middle = u64::midpoint(few, enough);
            if half(middle) < distance {
                enough = middle;
            } else {
                few = middle;
            }
        }
        Some(enough - runs)
    }

    /// Whether the relative error of the mean is at most `precision`, from 0 to 1, as far as the
    /// interval tells. The interval is around the estimated mean, not the true one; with the half
    /// width at most `precision / (1 + precision)` of the estimate, the error is at most
    /// `precision` of the true mean (Law, "Simulation Modeling and Analysis", section 9.4.1).
    pub fn is_within(&self, precision: f64) -> bool {
        let allowed = precision / (1.0 + precision) * self.mean.abs();
        self.half_width.is_some_and(|half| half <= allowed)
    }
}

/// How many replications are made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Count {
    /// This many, at least 1.
    Fixed(u64),
    /// As many as it takes until throughput and mean lead time have this relative precision (from 0
    /// to 1), but at most `most`.
    Until {
        /// Relative precision; see [`Estimate::is_within`].
        precision: f64,
        /// Maximum number of replications.
        most: u64,
    },
}

impl Default for Count {
    /// A single run.
    fn default() -> Self {
        Self::Fixed(1)
    }
}

/// Maximum number of replications of a command.
pub const MAX_REPLICATIONS: u64 = 10_000;

/// Number of replications that are made before their precision is judged. With fewer, the interval
/// may be narrow by chance.
const FIRST: u64 = 10;

impl Count {
    /// Number of replications to make at first.
    fn first(self) -> u64 {
        match self {
            Self::Fixed(count) => count.max(1),
            Self::Until { most, .. } => FIRST.min(most).max(1),
        }
    }

    /// Number of replications to make next, given those made so far; `None` if they suffice. At
    /// most as many again are made as there are, so that a poor estimate costs little.
    fn next(self, done: &Replications) -> Option<u64> {
        let Self::Until { precision, most } = self else {
            return None;
        };
        let count = done.seeds.len() as u64;
        if done.is_within(precision) || count >= most {
            return None;
        }
        Some(count.min(most - count))
    }
}

/// Runs a line several times, with consecutive seeds from that of the options, on several threads.
/// `plant` creates the plant of a thread; its argument states whether it is the first one, whose
/// runs can be shown. The observer watches the first run. The traces are those that
/// [`Plant::replicate`] returns, in the same order, for any number of threads.
///
/// # Errors
/// Returns the findings of `plant`.
pub fn replicate(
    threads: usize,
    plant: impl Fn(bool) -> Result<Plant, Vec<Diagnostic>> + Sync,
    count: Count,
    mut observer: Option<&mut dyn Observer>,
) -> Result<(Vec<Trace>, Replications), Vec<Diagnostic>> {
    let mut own = plant(true)?;
    let mut traces: Vec<Trace> = Vec::new();
    let mut wanted = count.first();
    loop {
        let done = traces.len() as u64;
        let more = runs(&mut own, threads, &plant, done, wanted, observer.take())?;
        let complete = more.len() as u64 == wanted;
        traces.extend(more);
        let (kept, mut replications) = own.combined(traces, done + wanted);
        traces = kept;
        let deadlocked = |trace: &Trace| matches!(trace.bottleneck, Bottleneck::Deadlock(_));
        let is_in_vain = traces.iter().all(deadlocked);
        let next = count
            .next(&replications)
            .filter(|_| complete && !is_in_vain);
        let Some(next) = next else {
            replications.report_precision(own.line(), count);
            return Ok((traces, replications));
        };
        wanted = next;
    }
}

/// Makes runs number `done` to `done + wanted`. Each thread makes every n-th of them. If the
/// deadline kept a run from beginning, it is missing, and so are all runs after it.
fn runs(
    own: &mut Plant,
    threads: usize,
    plant: &(impl Fn(bool) -> Result<Plant, Vec<Diagnostic>> + Sync),
    done: u64,
    wanted: u64,
    observer: Option<&mut dyn Observer>,
) -> Result<Vec<Trace>, Vec<Diagnostic>> {
    let threads = threads.clamp(1, usize::try_from(wanted).unwrap_or(usize::MAX));
    let step = threads as u64;
    let others: Vec<Result<Vec<Trace>, Vec<Diagnostic>>> = std::thread::scope(|scope| {
        let started: Vec<_> = (1..step)
            .map(|first| {
                scope
                    .spawn(move || Ok(plant(false)?.every(done + first, step, done + wanted, None)))
            })
            .collect();
        let own = Ok(own.every(done, step, done + wanted, observer));
        let others = started.into_iter().map(|thread| {
            let result = thread.join();
            result.unwrap_or_else(|panic| std::panic::resume_unwind(panic))
        });
        std::iter::once(own).chain(others).collect()
    });
    let mut others = others.into_iter().collect::<Result<Vec<_>, _>>()?;
    let mut streams: Vec<_> = others.iter_mut().map(|traces| traces.drain(..)).collect();
    let mut traces = Vec::new();
    for run in 0..wanted {
        match streams[(run % step) as usize].next() {
            Some(trace) => traces.push(trace),
            None => break,
        }
    }
    Ok(traces)
}

impl Plant {
    /// Runs the line `count` times (at least once) with consecutive seeds, starting with the seed
    /// of the options. Consecutive seeds are as independent as any others, because the generator
    /// mixes them. Returns the traces in the order of the runs. Once the deadline has passed, no
    /// further run begins, and a finding reports this. A run that the deadline cut off is omitted,
    /// unless it is the first.
    pub fn replicate(&mut self, count: u64) -> (Vec<Trace>, Replications) {
        let count = count.max(1);
        let traces = self.every(0, 1, count, None);
        self.combined(traces, count)
    }

    /// Makes runs number `first`, `first + step` and so on, before `end`, until the deadline.
    /// The observer watches the first of them.
    fn every(
        &mut self,
        first: u64,
        step: u64,
        end: u64,
        mut observer: Option<&mut dyn Observer>,
    ) -> Vec<Trace> {
        let mut traces = Vec::new();
        let mut run = first;
        while run < end {
            if run > 0 && self.late().is_some() {
                break;
            }
            let seed = self.seed().wrapping_add(run);
            let mut trace = self.run_observed(seed, observer.take());
            if run > 0 {
                // Many runs have to fit into memory.
                trace.wip_over_time = None;
            }
            traces.push(trace);
            self.count_run();
            run += step;
        }
        traces
    }

    /// Evaluates these runs, of which `count` were wanted. Leaves out runs that the deadline cut
    /// off, unless there are no others.
    fn combined(&self, mut traces: Vec<Trace>, count: u64) -> (Vec<Trace>, Replications) {
        let is_over = |trace: &Trace| trace.end != End::GaveUp;
        let done = traces.iter().filter(|t| is_over(t)).count() as u64;
        if done > 0 {
            traces.retain(is_over);
        } else {
            traces.truncate(1);
        }
        let mut replications = Replications::of(self.line(), &traces);
        if done < count {
            let late = self.late().unwrap_or(StopReason::Time);
            let message = format!("{late}: {done} of {count} runs were complete");
            replications.findings.push(
                Diagnostic::error(codes::GAVE_UP, self.line().span, message).with_help(format!(
                    "{}, or request fewer runs with --replications",
                    late.remedy()
                )),
            );
        }
        (traces, replications)
    }
}

impl Replications {
    /// Whether throughput and mean lead time have this relative precision.
    fn is_within(&self, precision: f64) -> bool {
        let within = |estimate: Option<Estimate>| estimate.is_some_and(|e| e.is_within(precision));
        within(self.throughput_per_hour) && within(self.lead_time)
    }

    /// Reports that the wanted precision was not reached.
    fn report_precision(&mut self, line: &Line, count: Count) {
        let Count::Until { precision, most } = count else {
            return;
        };
        if self.is_within(precision) || (self.seeds.len() as u64) < most {
            return;
        }
        let what = if most == 1 {
            "1 replication of"
        } else {
            &format!("{most} replications of")
        };
        let message = format!(
            "{what} {} cannot give the throughput and the mean lead time to {} %",
            line.name,
            precision * 100.0
        );
        self.findings.push(
            Diagnostic::warning(codes::LINE_LIMIT, line.span, message).with_help(
                "Let each run last longer, allow more with --replications, or ask for less precision.",
            ),
        );
    }

    /// Evaluates these runs of a line.
    pub fn of(line: &Line, traces: &[Trace]) -> Self {
        let estimate = |measure: Measure| {
            let metric = measure.into();
            let values = traces.iter().map(|trace| metric::measure(&metric, trace));
            Estimate::over_runs(measure, values)
        };
        let requirements = requirement::over(line, Sample::Runs(traces));
        let mut findings = in_any(traces);
        if !traces.iter().any(Trace::has_counted) {
            // A result without any figures is none.
            let about_end = |finding: &&mut Diagnostic| finding.code == codes::LINE_LIMIT;
            for finding in findings.iter_mut().filter(about_end) {
                finding.severity = Severity::Error;
            }
        }
        if traces.len() > 1 {
            findings.extend(requirement::unmet(
                line,
                Sample::Runs(traces),
                &requirements,
            ));
        }
        Self {
            seeds: traces.iter().map(|trace| trace.seed).collect(),
            throughput_per_hour: estimate(Measure::Throughput),
            makespan: estimate(Measure::Makespan),
            lead_time: estimate(Measure::LeadTime),
            lead_time_p95: estimate(Measure::LeadTimePercentile),
            wip: estimate(Measure::Wip),
            energy_kwh: estimate(Measure::Energy),
            measures: estimates::of_runs(line, traces),
            requirements,
            warm_up: traces
                .iter()
                .fold((f64::INFINITY, 0.0), |(least, most), trace| {
                    (trace.warm_up.min(least), trace.warm_up.max(most))
                }),
            findings,
        }
    }
}

/// The findings in any of the runs, without duplicates. What ended runs early differs in its time
/// only: such findings of several runs are one, with the seeds.
fn in_any(traces: &[Trace]) -> Vec<Diagnostic> {
    let mut findings: Vec<(Diagnostic, Vec<u64>)> = Vec::new();
    for trace in traces {
        for finding in &trace.findings {
            if traces.len() > 1 && finding.code == codes::LINE_REQUIREMENT {
                continue;
            }
            let is_early = [codes::LINE_LIMIT, codes::LINE_BLOCKED].contains(&finding.code);
            let is_same = |(known, _): &&mut (Diagnostic, Vec<u64>)| {
                let is_alike = (known.code, known.span, known.severity)
                    == (finding.code, finding.span, finding.severity);
                known == finding || is_early && is_alike
            };
            let seed = is_early.then_some(trace.seed);
            match findings.iter_mut().find(is_same) {
                Some((_, seeds)) => {
                    seeds.extend(seed.filter(|seed| seeds.last() != Some(seed)));
                }
                None => findings.push((finding.clone(), seed.into_iter().collect())),
            }
        }
    }
    let findings = findings
        .into_iter()
        .map(|(finding, seeds)| match seeds[..] {
            [first, ..] if traces.len() > 1 => finding.with_note(format!(
                "this is the run with seed {first}; {} of {} runs ended like this{}",
                seeds.len(),
                traces.len(),
                also(&seeds[1..]),
            )),
            _ => finding,
        });
    findings.collect()
}

/// Lists further seeds, up to a maximum number: `, also with seeds 2, 5 and 7 more`.
fn also(seeds: &[u64]) -> String {
    const SHOWN: usize = 10;
    let shown: Vec<String> = seeds.iter().take(SHOWN).map(u64::to_string).collect();
    let shown = shown.join(", ");
    match (seeds.len(), seeds.len().saturating_sub(SHOWN)) {
        (0, _) => String::new(),
        (1, _) => format!(", also with seed {shown}"),
        (_, 0) => format!(", also with seeds {shown}"),
        (_, more) => format!(", also with seeds {shown} and {more} more"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_known_interval() {
        // Mean 3, standard deviation sqrt(2.5), five values: 2.776445 * sqrt(2.5) / sqrt(5).
        let estimate = Estimate::of(&[1.0, 2.0, 3.0, 4.0, 5.0]).unwrap();
        assert!((estimate.mean - 3.0).abs() < 1e-12);
        assert!((estimate.half_width.unwrap() - 1.963_243).abs() < 1e-5);
        assert_eq!(Estimate::of(&[4.0]).unwrap().half_width, None);
        assert_eq!(Estimate::of(&[]), None);
    }

    /// The interval of a share ends at 0 and 1, and that of any other measure at 0.
    #[test]
    fn intervals_end_with_the_range() {
        let estimate = Estimate::of(&[0.7, 0.8, 1.0]).unwrap();
        let half = estimate.half_width.unwrap();
        let (low, high) = (estimate.mean - half, estimate.mean + half);
        assert!(high > 1.0);
        assert_eq!(estimate.interval(), Some((low, high)));
        let share = estimate.of_measure(Measure::Busy);
        assert_eq!(share.interval(), Some((low, 1.0)));
        assert_eq!(share.half_width, Some(half));
        assert_eq!(
            estimate.of_measure(Measure::Wip).interval(),
            Some((low, high))
        );
        let (percent, hundred) = share.scaled(100.0).interval().unwrap();
        assert!((percent - low * 100.0).abs() < 1e-9);
        assert!((hundred - 100.0).abs() < 1e-12);
        let scrap = Estimate::of(&[0.0, 0.0, 0.1])
            .unwrap()
            .of_measure(Measure::Scrap);
        assert_eq!(scrap.interval().map(|(low, _)| low), Some(0.0));
        assert_eq!(Estimate::of(&[4.0]).unwrap().interval(), None);
    }

    /// The mean of equal values is that value, although their sum is rounded.
    #[test]
    fn equal_values_are_a_point() {
        let estimate = Estimate::of(&[0.1; 10]).unwrap();
        assert_eq!(estimate.mean.to_bits(), 0.1_f64.to_bits());
        assert_eq!(estimate.half_width, Some(0.0));
    }

    /// With as many more runs, the interval ends before the bound; with one less, it does not.
    #[test]
    fn further_runs_decide() {
        let estimate = Estimate::of(&[1.0, 2.0, 3.0, 4.0, 5.0]).unwrap();
        let deviation = 2.5_f64.sqrt();
        for bound in [1.5, 2.5, 3.1, 4.9] {
            let more = estimate.further_runs(5, bound).unwrap();
            let half = |runs: u64| student_t(runs - 1) * deviation / (runs as f64).sqrt();
            let distance = (3.0 - bound).abs();
            assert!(half(5 + more) < distance, "{bound}: {more}");
            assert!(half(4 + more) >= distance, "{bound}: {more}");
        }
        assert_eq!(estimate.further_runs(5, 3.0), None);
        assert_eq!(estimate.further_runs(5, 3.001), None);
    }
}
