//! Draws durations from distributions.
//!
//! The generator is our own ([`super::random`]). What is more than a line comes from `rand_distr`.

use super::random::Stream;
use linewright_language::contract::MAX_SECONDS;
use linewright_language::contract::distribution::Distribution;
use rand_distr::Distribution as _;

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
}

impl Sampler {
    /// Draws from this distribution with the numbers of a stream.
    pub fn new(distribution: &Distribution, stream: Stream) -> Self {
        // The distribution is valid, so no constructor fails. What has no width is constant.
        let shape = match *distribution {
            Distribution::Constant(value) => Err(value),
            Distribution::Uniform { low, high } => Ok(Shape::Uniform {
                low,
                width: high - low,
            }),
            Distribution::Exponential { mean } => Ok(Shape::Exponential { mean }),
            Distribution::Triangular { low, mode, high } => {
                let wide = (low < high).then(|| rand_distr::Triangular::new(low, high, mode).ok());
                wide.flatten().map(Shape::Triangular).ok_or(low)
            }
            Distribution::Normal { mean, deviation } => {
                let wide = (deviation > 0.0).then(|| rand_distr::Normal::new(mean, deviation).ok());
                wide.flatten().map(Shape::Normal).ok_or(mean)
            }
            Distribution::Lognormal { mean, deviation } => {
                let variance = (deviation / mean).powi(2).ln_1p();
                let location = mean.ln() - variance / 2.0;
                let wide = (deviation > 0.0)
                    .then(|| rand_distr::LogNormal::new(location, variance.sqrt()).ok());
                wide.flatten().map(Shape::Lognormal).ok_or(mean)
            }
            Distribution::Erlang { stages, mean } => {
                gamma(f64::from(stages), mean / f64::from(stages))
            }
            Distribution::Gamma { shape, scale } => gamma(shape, scale),
            Distribution::Weibull { shape, scale } => {
                let wide = (scale > 0.0).then(|| rand_distr::Weibull::new(scale, shape).ok());
                wide.flatten().map(Shape::Weibull).ok_or(0.0)
            }
            Distribution::Beta {
                alpha,
                beta,
                low,
                high,
            } => {
                let unit = rand_distr::Beta::new(alpha, beta).ok();
                let wide = unit.filter(|_| low < high).map(|unit| Shape::Beta {
                    unit,
                    low,
                    width: high - low,
                });
                wide.ok_or(low)
            }
            Distribution::Pert { low, mode, high } => {
                let wide =
                    (low < high).then(|| rand_distr::Pert::new(low, high).with_mode(mode).ok());
                wide.flatten().map(Shape::Pert).ok_or(low)
            }
            Distribution::Discrete(ref outcomes) => {
                let mut total = 0.0;
                let sums = outcomes.iter().map(|&(value, probability)| {
                    total += probability;
                    (value, total)
                });
                Ok(Shape::Discrete(sums.collect()))
            }
        };
        Self {
            shape: shape.unwrap_or_else(Shape::Constant),
            stream,
        }
    }

    /// Draws a duration in seconds: from 0 to [`MAX_SECONDS`].
    #[inline]
    pub fn draw(&mut self) -> f64 {
        let stream = &mut self.stream;
        let seconds = match &self.shape {
            Shape::Constant(value) => return *value,
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
        };
        seconds.clamp(0.0, MAX_SECONDS)
    }
}

fn gamma(shape: f64, scale: f64) -> Result<Shape, f64> {
    let wide = (scale > 0.0).then(|| rand_distr::Gamma::new(shape, scale).ok());
    wide.flatten().map(Shape::Gamma).ok_or(0.0)
}
