//! Distributions of durations.

use super::units::{MAX_SECONDS, is_duration};
use std::sync::Arc;

/// A probability distribution of durations, in seconds.
///
/// Draws are never negative. A draw above [`MAX_SECONDS`] counts as [`MAX_SECONDS`], so that the
/// clock of a run stays exact.
#[derive(Debug, Clone, PartialEq)]
pub enum Distribution {
    /// Always the same duration.
    Constant(f64),
    /// Every duration from `low` to `high` is equally likely.
    Uniform {
        /// Minimum.
        low: f64,
        /// Maximum.
        high: f64,
    },
    /// The density rises linearly from `low` to `mode`, and falls linearly to `high`.
    Triangular {
        /// Minimum.
        low: f64,
        /// Most likely duration.
        mode: f64,
        /// Maximum.
        high: f64,
    },
    /// The normal distribution, cut off at 0: negative draws are repeated. Mean and standard
    /// deviation are those of the distribution that is not cut off.
    Normal {
        /// Mean.
        mean: f64,
        /// Standard deviation.
        deviation: f64,
    },
    /// The lognormal distribution. Mean and standard deviation are those of the durations, not of
    /// their logarithms.
    Lognormal {
        /// Mean, greater than 0.
        mean: f64,
        /// Standard deviation.
        deviation: f64,
    },
    /// The exponential distribution.
    Exponential {
        /// Mean.
        mean: f64,
    },
    /// The sum of exponentially distributed durations.
    Erlang {
        /// Number of summands, at least 1.
        stages: u32,
        /// Mean of the sum.
        mean: f64,
    },
    /// The gamma distribution; its mean is `shape * scale`.
    Gamma {
        /// Shape, greater than 0.
        shape: f64,
        /// Scale.
        scale: f64,
    },
    /// The Weibull distribution.
    Weibull {
        /// Shape, greater than 0; greater than 1 for wear, less than 1 for early failures.
        shape: f64,
        /// Scale: 63.2 % of the durations are shorter.
        scale: f64,
    },
    /// The beta distribution, stretched to the interval from `low` to `high`.
    Beta {
        /// First shape, greater than 0.
        alpha: f64,
        /// Second shape, greater than 0.
        beta: f64,
        /// Minimum.
        low: f64,
        /// Maximum.
        high: f64,
    },
    /// The beta distribution of project planning (Malcolm et al., 1959): its mean is
    /// `(low + 4 mode + high) / 6`.
    Pert {
        /// Minimum.
        low: f64,
        /// Most likely duration.
        mode: f64,
        /// Maximum.
        high: f64,
    },
    /// One of several durations, each with its probability; the probabilities add up to 1.
    Discrete(Vec<(f64, f64)>),
    /// One of several observed durations, each with the same probability (the empirical
    /// distribution); at least one, in ascending order.
    Empirical(Arc<[f64]>),
}

/// No time.
impl Default for Distribution {
    fn default() -> Self {
        Self::Constant(0.0)
    }
}

impl Distribution {
    /// Whether every draw is 0.
    pub fn is_zero(&self) -> bool {
        self.greatest() <= 0.0
    }

    /// The mean, or a number above it where the mean has no simple form.
    pub fn mean_at_most(&self) -> f64 {
        match *self {
            Self::Constant(value) => value,
            Self::Uniform { low, high } => f64::midpoint(low, high),
            Self::Triangular { low, mode, high } => (low + mode + high) / 3.0,
            Self::Pert { low, mode, high } => (low + 4.0 * mode + high) / 6.0,
            Self::Beta {
                alpha,
                beta,
                low,
                high,
            } => low + (high - low) * alpha / (alpha + beta),
            // Cut off at 0; with a mean of 0 before, the mean is 0.798 deviations.
            Self::Normal { mean, deviation } => mean + 0.8 * deviation,
            Self::Lognormal { mean, .. }
            | Self::Exponential { mean }
            | Self::Erlang { mean, .. } => mean,
            Self::Gamma { shape, scale } => shape * scale,
            Self::Weibull { shape, scale } if shape >= 1.0 => scale,
            Self::Weibull { .. } | Self::Empirical(_) => self.greatest(),
            Self::Discrete(ref outcomes) => outcomes.iter().map(|(value, p)| value * p).sum(),
        }
    }

    /// Whether a draw is greater than 0 with probability 1.
    pub fn takes_time(&self) -> bool {
        match self {
            Self::Discrete(outcomes) => outcomes.iter().all(|(value, p)| *value > 0.0 || *p <= 0.0),
            Self::Empirical(_) => self.least() > 0.0,
            other => other.greatest() > 0.0,
        }
    }

    /// The greatest lower bound of the draws, in seconds.
    pub fn least(&self) -> f64 {
        match *self {
            Self::Constant(value) => value,
            Self::Uniform { low, .. }
            | Self::Triangular { low, .. }
            | Self::Beta { low, .. }
            | Self::Pert { low, .. } => low,
            Self::Normal { mean, deviation } | Self::Lognormal { mean, deviation } => {
                if deviation > 0.0 { 0.0 } else { mean }
            }
            Self::Exponential { .. }
            | Self::Erlang { .. }
            | Self::Gamma { .. }
            | Self::Weibull { .. } => 0.0,
            Self::Discrete(ref outcomes) => outcomes
                .iter()
                .filter(|(_, p)| *p > 0.0)
                .map(|(value, _)| *value)
                .fold(f64::INFINITY, f64::min),
            Self::Empirical(ref values) => values.first().copied().unwrap_or(0.0),
        }
    }

    /// The least upper bound of the draws, in seconds; [`MAX_SECONDS`] if they are unbounded.
    pub fn greatest(&self) -> f64 {
        let unbounded = |scale: f64| if scale > 0.0 { MAX_SECONDS } else { 0.0 };
        match *self {
            Self::Constant(value) => value,
            Self::Uniform { high, .. }
            | Self::Triangular { high, .. }
            | Self::Beta { high, .. }
            | Self::Pert { high, .. } => high,
            Self::Normal { mean, deviation } | Self::Lognormal { mean, deviation } => {
                if deviation > 0.0 { MAX_SECONDS } else { mean }
            }
            Self::Exponential { mean } | Self::Erlang { mean, .. } => unbounded(mean),
            Self::Gamma { scale, .. } | Self::Weibull { scale, .. } => unbounded(scale),
            Self::Discrete(ref outcomes) => outcomes
                .iter()
                .filter(|(_, p)| *p > 0.0)
                .map(|(value, _)| *value)
                .fold(0.0, f64::max),
            Self::Empirical(ref values) => values.last().copied().unwrap_or(0.0),
        }
    }

    /// Whether the parameters are finite, not negative and in order, and the shapes greater than 0.
    /// The resolver accepts no other distribution.
    pub fn is_valid(&self) -> bool {
        let seconds = |values: &[f64]| values.iter().all(|value| is_duration(*value));
        let shapes = |values: &[f64]| values.iter().all(|value| is_shape(*value));
        match *self {
            Self::Constant(value) => is_duration(value),
            Self::Uniform { low, high } => seconds(&[low, high]) && low <= high,
            Self::Triangular { low, mode, high } | Self::Pert { low, mode, high } => {
                seconds(&[low, mode, high]) && low <= mode && mode <= high
            }
            Self::Normal { mean, deviation } => seconds(&[mean, deviation]),
            Self::Lognormal { mean, deviation } => seconds(&[mean, deviation]) && mean > 0.0,
            Self::Exponential { mean } => is_duration(mean),
            Self::Erlang { stages, mean } => stages > 0 && is_duration(mean),
            Self::Gamma { shape, scale } | Self::Weibull { shape, scale } => {
                shapes(&[shape]) && is_duration(scale)
            }
            Self::Beta {
                alpha,
                beta,
                low,
                high,
            } => shapes(&[alpha, beta]) && seconds(&[low, high]) && low <= high,
            Self::Discrete(ref outcomes) => {
                let total: f64 = outcomes.iter().map(|(_, p)| p).sum();
                outcomes
                    .iter()
                    .all(|(value, p)| is_duration(*value) && (0.0..=1.0).contains(p))
                    && (total - 1.0).abs() <= PROBABILITY_TOLERANCE
            }
            Self::Empirical(ref values) => {
                !values.is_empty() && seconds(values) && values.is_sorted()
            }
        }
    }
}

/// Maximum error of a sum of probabilities that should be 1.
pub(super) const PROBABILITY_TOLERANCE: f64 = 1e-9;

/// Whether the shape of a distribution has this value: from 0.01 to 10,000. Beyond these bounds,
/// draws are 0, constant or not representable.
pub(super) fn is_shape(shape: f64) -> bool {
    (0.01..=1e4).contains(&shape)
}
