//! Replications: the same line under several seeds, with confidence intervals.

use super::metric::{self, ReplicatedRequirement};
use super::plant::Plant;
use super::statistics::student_t;
use super::trace::{End, Trace};
use linewright_core::deadline::StopReason;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_language::contract::line::{Line, Metric};

/// Statistics over several runs.
#[derive(Debug, Clone, PartialEq)]
pub struct Replications {
    /// Seeds, one per run.
    pub seeds: Vec<u64>,
    /// Products per hour.
    pub throughput_per_hour: Option<Estimate>,
    /// Seconds to the last product, over the runs that made a product; `None` if no run made one.
    pub makespan: Option<Estimate>,
    /// Total energy in kWh.
    pub energy_kwh: Option<Estimate>,
    /// The line's requirements over all runs, in line order.
    pub requirements: Vec<ReplicatedRequirement>,
    /// Problems in any of the runs, without duplicates. Each requirement that some run violates
    /// adds one finding.
    pub findings: Vec<Diagnostic>,
}

/// A mean with half the width of its 95 % confidence interval (Student's t distribution).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Mean of the runs.
    pub mean: f64,
    /// The interval is `mean - half_width ..= mean + half_width`; `None` for a single run, which
    /// allows no estimate.
    pub half_width: Option<f64>,
}

impl Estimate {
    /// Estimates the mean of independent values; `None` if there are none.
    pub fn of(values: &[f64]) -> Option<Self> {
        if values.is_empty() {
            return None;
        }
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let half_width = (values.len() > 1).then(|| {
            let squares: f64 = values.iter().map(|x| (x - mean).powi(2)).sum();
            let deviation = (squares / (count - 1.0)).sqrt();
            student_t(values.len() as u64 - 1) * deviation / count.sqrt()
        });
        Some(Self { mean, half_width })
    }
}

impl Plant {
    /// Runs the line `count` times (at least once) with consecutive seeds, starting with the seed
    /// of the options. Consecutive seeds are as independent as any others, because the generator
    /// mixes them. Returns the traces in the order of the runs. Once the deadline has passed, no
    /// further run begins, and a finding reports this. A run that the deadline cut off is omitted,
    /// unless it is the first.
    pub fn replicate(&mut self, count: u64) -> (Vec<Trace>, Replications) {
        let first = self.seed();
        let count = count.max(1);
        let mut traces = Vec::new();
        for offset in 0..count {
            traces.push(self.run_seeded(first.wrapping_add(offset)));
            if offset + 1 < count && self.late().is_some() {
                break;
            }
        }
        let is_over = |trace: &Trace| trace.end != End::GaveUp;
        let done = traces.iter().filter(|t| is_over(t)).count() as u64;
        if done > 0 {
            traces.retain(is_over);
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
    /// Evaluates these runs of a line.
    pub fn of(line: &Line, traces: &[Trace]) -> Self {
        let estimate = |metric: &Metric| {
            let measured = traces
                .iter()
                .filter_map(|trace| metric::measure(metric, trace));
            Estimate::of(&measured.collect::<Vec<_>>())
        };
        let requirements = metric::over(line, traces);
        let mut findings: Vec<Diagnostic> = Vec::new();
        for finding in traces.iter().flat_map(|trace| &trace.findings) {
            let of_one_run = traces.len() > 1 && finding.code == codes::LINE_REQUIREMENT;
            if !of_one_run && !findings.contains(finding) {
                findings.push(finding.clone());
            }
        }
        if traces.len() > 1 {
            findings.extend(metric::unmet(line, traces, &requirements));
        }
        Self {
            seeds: traces.iter().map(|trace| trace.seed).collect(),
            throughput_per_hour: estimate(&Metric::ThroughputPerHour),
            makespan: estimate(&Metric::MakespanSeconds),
            energy_kwh: estimate(&Metric::EnergyKwh),
            requirements,
            findings,
        }
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
}
