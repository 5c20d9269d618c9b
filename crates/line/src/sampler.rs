//! Draws durations from distributions.
//!
//! The generator is our own ([`super::random`]). What is more than a line comes from `rand_distr`.

use super::random::Stream;
use linewright_language::contract::MAX_SECONDS;
use linewright_language::contract::distribution::Distribution;
use rand_distr::Distribution as _;
use std::sync::Arc;

/// A distribution with its stream of random numbers.
#[derive(Debug, Clone)]
pub struct Sampler {
    shape: Shape,
    stream: Stream,
}

#[derive(Debug, Clone)]
enum Shape {
    Constant(f64),
    Uniform {
        low: f64,
        width: f64,
    },
    Exponential {
        mean: f64,
    },
    Triangular(rand_distr::Triangular<f64>),
    Normal(rand_distr::Normal<f64>),
    Lognormal(rand_distr::LogNormal<f64>),
    Gamma(rand_distr::Gamma<f64>),
    Weibull(rand_distr::Weibull<f64>),
    Beta {
        unit: rand_distr::Beta<f64>,
        low: f64,
        width: f64,
    },
    Pert(rand_distr::Pert<f64>),
    /// Values, each with the probability that the draw is this value or an earlier one.
    Discrete(Vec<(f64, f64)>),
    /// Values with equal probabilities.
    Empirical(Arc<[f64]>),
}

impl Sampler {
    /// Draws from this distribution with the numbers of a stream.
    pub fn new(distribution: &Distribution, stream: Stream) -> Self {
        let shape = match *distribution {
            Distribution::Constant(value) => Shape::Constant(value),
            Distribution::Uniform { low, high } => Shape::Uniform {
                low,
                width: high - low,
            },
            Distribution::Exponential { mean } => Shape::Exponential { mean },
            Distribution::Triangular { low, mode, high } => {
                let made = rand_distr::Triangular::new(low, high, mode);
                wide_or(low, low < high, made, Shape::Triangular)
            }
            Distribution::Normal { mean, deviation } => {
                let made = rand_distr::Normal::new(mean, deviation);
                wide_or(mean, deviation > 0.0, made, Shape::Normal)
            }
            Distribution::Lognormal { mean, deviation } => {
                let variance = (deviation / mean).powi(2).ln_1p();
                let location = mean.ln() - variance / 2.0;
                let made = rand_distr::LogNormal::new(location, variance.sqrt());
                wide_or(mean, deviation > 0.0, made, Shape::Lognormal)
            }
            Distribution::Erlang { stages, mean } => {
                let made = rand_distr::Gamma::new(f64::from(stages), mean / f64::from(stages));
                wide_or(0.0, mean > 0.0, made, Shape::Gamma)
            }
            Distribution::Gamma { shape, scale } => {
                let made = rand_distr::Gamma::new(shape, scale);
                wide_or(0.0, scale > 0.0, made, Shape::Gamma)
            }
            Distribution::Weibull { shape, scale } => {
                let made = rand_distr::Weibull::new(scale, shape);
                wide_or(0.0, scale > 0.0, made, Shape::Weibull)
            }
            Distribution::Beta {
                alpha,
                beta,
                low,
                high,
            } => {
                let made = rand_distr::Beta::new(alpha, beta);
                wide_or(low, low < high, made, |unit| Shape::Beta {
                    unit,
                    low,
                    width: high - low,
                })
            }
            Distribution::Pert { low, mode, high } => {
                let made = rand_distr::Pert::new(low, high).with_mode(mode);
                wide_or(low, low < high, made, Shape::Pert)
            }
            Distribution::Discrete(ref outcomes) => {
                let mut total = 0.0;
                let sums = outcomes.iter().map(|&(value, probability)| {
                    total += probability;
                    (value, total)
                });
                Shape::Discrete(sums.collect())
            }
            Distribution::Empirical(ref values) => Shape::Empirical(Arc::clone(values)),
        };
        Self { shape, stream }
    }

    /// Draws a duration in seconds: from 0 to [`MAX_SECONDS`].
    #[inline]
    pub fn draw(&mut self) -> f64 {
        match self.shape {
            Shape::Constant(value) => value,
            Shape::Exponential { mean } => self.stream.exponential(mean).min(MAX_SECONDS),
            _ => self.draw_otherwise(),
        }
    }

    /// Draws from a distribution that takes longer.
    #[inline(never)]
    fn draw_otherwise(&mut self) -> f64 {
        let stream = &mut self.stream;
        let seconds = match &self.shape {
            Shape::Constant(value) => *value,
            Shape::Uniform { low, width } => low + width * stream.unit(),
            Shape::Exponential { mean } => stream.exponential(*mean),
            Shape::Triangular(it) => it.sample(stream),
            // The mean is not negative, so at least every second draw is accepted on average.
            Shape::Normal(it) => loop {
                let seconds = it.sample(stream);
                if seconds >= 0.0 {
                    break seconds;
                }
            },
            Shape::Lognormal(it) => it.sample(stream),
            Shape::Gamma(it) => it.sample(stream),
            Shape::Weibull(it) => it.sample(stream),
            Shape::Beta { unit, low, width } => low + width * unit.sample(stream),
            Shape::Pert(it) => it.sample(stream),
            Shape::Discrete(outcomes) => {
                let unit = stream.unit();
                let drawn = outcomes.iter().find(|(_, sum)| unit < *sum);
                // Rounding can leave the last sum just below 1.
                drawn.or(outcomes.last()).map_or(0.0, |(value, _)| *value)
            }
            Shape::Empirical(values) => values[stream.below(values.len() as u64) as usize],
        };
        seconds.clamp(0.0, MAX_SECONDS)
    }
}

/// The shape of a distribution, or this constant if the distribution has no width. Then its
/// constructor may fail; that of a valid distribution with a width does not.
fn wide_or<T, E>(
    constant: f64,
    is_wide: bool,
    made: Result<T, E>,
    shape: impl FnOnce(T) -> Shape,
) -> Shape {
    match made {
        Ok(made) if is_wide => shape(made),
        _ => Shape::Constant(constant),
    }
}
