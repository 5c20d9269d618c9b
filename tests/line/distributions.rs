//! Draws against the distributions that they are from: Kolmogorov-Smirnov for continuous ones,
//! chi-square for discrete ones, at fixed seeds. The distribution functions here are computed
//! numerically from the densities, and share no code with the sampler.

use linewright::contract::MAX_SECONDS;
use linewright::contract::distribution::Distribution;
use linewright::line::random::{Purpose, Stream};
use linewright::line::sampler::Sampler;

const DRAWS: usize = 20_000;

fn draws(distribution: &Distribution, seed: u64) -> Vec<f64> {
    assert!(distribution.is_valid(), "{distribution:?}");
    let stream = Stream::new(seed, Purpose::Service, "station.Part");
    let mut sampler = Sampler::new(distribution, stream);
    (0..DRAWS).map(|_| sampler.draw()).collect()
}

/// The density of a distribution up to a constant factor, and the interval that contains it.
fn density(distribution: &Distribution) -> (Box<dyn Fn(f64) -> f64>, f64, f64) {
    let triangle = |low: f64, mode: f64, high: f64| {
        move |x: f64| {
            if x < mode {
                (x - low) / (mode - low)
            } else {
                (high - x) / (high - mode)
            }
        }
    };
    let stretched = |a: f64, b: f64, low: f64, high: f64| {
        move |x: f64| {
            let unit = (x - low) / (high - low);
            unit.powf(a - 1.0) * (1.0 - unit).powf(b - 1.0)
        }
    };
    match *distribution {
        Distribution::Uniform { low, high } => (Box::new(|_| 1.0), low, high),
        Distribution::Triangular { low, mode, high } => {
            (Box::new(triangle(low, mode, high)), low, high)
        }
        Distribution::Normal { mean, deviation } => (
            Box::new(move |x| (-((x - mean) / deviation).powi(2) / 2.0).exp()),
            0.0,
            mean + 9.0 * deviation,
        ),
        Distribution::Lognormal { mean, deviation } => {
            let variance = (1.0 + (deviation / mean).powi(2)).ln();
            let location = mean.ln() - variance / 2.0;
            (
                Box::new(move |x| (-(x.ln() - location).powi(2) / (2.0 * variance)).exp() / x),
                0.0,
                (location + 8.0 * variance.sqrt()).exp(),
            )
        }
        Distribution::Exponential { mean } => {
            (Box::new(move |x| (-x / mean).exp()), 0.0, 40.0 * mean)
        }
        Distribution::Erlang { stages, mean } => {
            let scale = mean / f64::from(stages);
            let shape = f64::from(stages);
            (
                Box::new(move |x| (x / scale).powf(shape - 1.0) * (-x / scale).exp()),
                0.0,
                mean + 40.0 * scale * shape.sqrt(),
            )
        }
        Distribution::Gamma { shape, scale } => (
            Box::new(move |x| (x / scale).powf(shape - 1.0) * (-x / scale).exp()),
            0.0,
            scale * (shape + 40.0 * shape.sqrt().max(1.0)),
        ),
        Distribution::Weibull { shape, scale } => (
            Box::new(move |x| (x / scale).powf(shape - 1.0) * (-(x / scale).powf(shape)).exp()),
            0.0,
            scale * 40.0_f64.powf(1.0 / shape),
        ),
        Distribution::Beta {
            alpha,
            beta,
            low,
            high,
        } => (Box::new(stretched(alpha, beta, low, high)), low, high),
        Distribution::Pert { low, mode, high } => {
            let a = 1.0 + 4.0 * (mode - low) / (high - low);
            let b = 1.0 + 4.0 * (high - mode) / (high - low);
            (Box::new(stretched(a, b, low, high)), low, high)
        }
        Distribution::Constant(_) | Distribution::Discrete(_) | Distribution::Empirical(_) => {
            unreachable!("not continuous")
        }
    }
}

/// The greatest distance between the empirical distribution function of the draws and that of the
/// density, which the midpoint rule integrates. The grid is finer near 0, where a density may be
/// infinite.
fn distance(distribution: &Distribution, draws: &mut [f64]) -> f64 {
    const CELLS: usize = 200_000;
    let (density, low, high) = density(distribution);
    let at = |cell: usize| low + (high - low) * (cell as f64 / CELLS as f64).powi(4);
    let mut sums = vec![0.0];
    for cell in 0..CELLS {
        let (from, to) = (at(cell), at(cell + 1));
        let mass = density(f64::midpoint(from, to)) * (to - from);
        sums.push(sums[cell] + mass);
    }
    let total = sums[CELLS];
    draws.sort_unstable_by(f64::total_cmp);
    let count = draws.len() as f64;
    let mut greatest: f64 = 0.0;
    for (index, draw) in draws.iter().enumerate() {
        assert!((low..=high).contains(draw), "{distribution:?} drew {draw}");
        let place =
            (((draw - low) / (high - low)).powf(0.25) * CELLS as f64).min(CELLS as f64 - 1.0);
        let cell = place.floor();
        let (before, after) = (sums[cell as usize], sums[cell as usize + 1]);
        let share = (before + (after - before) * (place - cell)) / total;
        greatest = greatest
            .max((share - index as f64 / count).abs())
            .max(((index + 1) as f64 / count - share).abs());
    }
    greatest
}

fn continuous() -> Vec<Distribution> {
    vec![
        Distribution::Uniform {
            low: 2.0,
            high: 5.0,
        },
        Distribution::Triangular {
            low: 1.8,
            mode: 2.0,
            high: 2.5,
        },
        Distribution::Triangular {
            low: 1.0,
            mode: 1.0,
            high: 4.0,
        },
        Distribution::Normal {
            mean: 10.0,
            deviation: 2.0,
        },
        // Half of this one is cut off.
        Distribution::Normal {
            mean: 0.0,
            deviation: 3.0,
        },
        Distribution::Lognormal {
            mean: 10.0,
            deviation: 4.0,
        },
        Distribution::Exponential { mean: 3.0 },
        Distribution::Erlang {
            stages: 1,
            mean: 4.0,
        },
        Distribution::Erlang {
            stages: 3,
            mean: 4.0,
        },
        Distribution::Gamma {
            shape: 0.5,
            scale: 2.0,
        },
        Distribution::Gamma {
            shape: 2.5,
            scale: 2.0,
        },
        Distribution::Weibull {
            shape: 0.7,
            scale: 5.0,
        },
        Distribution::Weibull {
            shape: 1.5,
            scale: 5.0,
        },
        Distribution::Beta {
            alpha: 2.0,
            beta: 3.0,
            low: 1.0,
            high: 4.0,
        },
        Distribution::Pert {
            low: 1.0,
            mode: 2.0,
            high: 4.0,
        },
    ]
}

/// The Kolmogorov-Smirnov statistic times the root of the number of draws exceeds 2.2 less often
/// than once in 15,000 samples. Three seeds are tried.
#[test]
fn continuous_draws_have_their_distribution() {
    for distribution in continuous() {
        for seed in 1..=3 {
            let distance = distance(&distribution, &mut draws(&distribution, seed));
            let statistic = distance * (DRAWS as f64).sqrt();
            assert!(
                statistic < 2.2,
                "{distribution:?}, seed {seed}: {statistic}"
            );
        }
    }
}

/// The test above finds small errors: a neighboring distribution fails it.
#[test]
fn draws_of_another_distribution_are_told_apart() {
    let neighbors = [
        (
            Distribution::Gamma {
                shape: 2.5,
                scale: 2.0,
            },
            Distribution::Gamma {
                shape: 2.6,
                scale: 2.0,
            },
        ),
        (
            Distribution::Lognormal {
                mean: 10.0,
                deviation: 4.0,
            },
            Distribution::Lognormal {
                mean: 10.0,
                deviation: 4.3,
            },
        ),
        (
            Distribution::Pert {
                low: 1.0,
                mode: 2.0,
                high: 4.0,
            },
            Distribution::Pert {
                low: 1.0,
                mode: 2.1,
                high: 4.0,
            },
        ),
    ];
    for (drawn, other) in neighbors {
        let statistic = distance(&other, &mut draws(&drawn, 1)) * (DRAWS as f64).sqrt();
        assert!(statistic > 2.2, "{other:?}: {statistic}");
    }
}

#[test]
fn discrete_draws_have_their_probabilities() {
    let outcomes = vec![(2.0, 0.5), (5.0, 0.3), (0.0, 0.15), (30.0, 0.05)];
    let distribution = Distribution::Discrete(outcomes.clone());
    for seed in 1..=3 {
        let drawn = draws(&distribution, seed);
        let mut statistic = 0.0;
        for (value, probability) in &outcomes {
            let seen = drawn
                .iter()
                .filter(|d| d.to_bits() == value.to_bits())
                .count() as f64;
            let expected = probability * DRAWS as f64;
            statistic += (seen - expected).powi(2) / expected;
        }
        // The 0.1 % critical value of chi-square with three degrees of freedom is 16.27.
        assert!(statistic < 16.27, "seed {seed}: {statistic}");
    }
}

/// Rows with the same value add up. Draws have the probabilities of the empirical distribution.
#[test]
fn empirical_draws_are_rows_with_equal_probability() {
    let rows = [0.5, 1.0, 1.0, 1.0, 2.0, 7.0, 7.0, 30.0];
    let distribution = Distribution::Empirical(rows.into());
    for seed in 1..=3 {
        let drawn = draws(&distribution, seed);
        let mut statistic = 0.0;
        for (value, count) in [(0.5, 1.0), (1.0, 3.0), (2.0, 1.0), (7.0, 2.0), (30.0, 1.0)] {
            let is_value = |d: &&f64| d.to_bits() == f64::to_bits(value);
            let seen = drawn.iter().filter(is_value).count() as f64;
            let expected = count / rows.len() as f64 * DRAWS as f64;
            statistic += (seen - expected).powi(2) / expected;
        }
        // The 0.1 % critical value of chi-square with four degrees of freedom is 18.47. If a draw
        // were no row, the sum would be far greater.
        assert!(statistic < 18.47, "seed {seed}: {statistic}");
    }
    let bounds = (distribution.least(), distribution.greatest());
    assert_eq!(bounds, (0.5, 30.0));
    assert!(distribution.takes_time() && distribution.is_valid());
    let with_zero = Distribution::Empirical([0.0, 1.0].into());
    assert!(!with_zero.takes_time() && !with_zero.is_zero());
    let unsorted = Distribution::Empirical([1.0, 0.0].into());
    let empty = Distribution::Empirical([].into());
    assert!(!unsorted.is_valid() && !empty.is_valid());
}

#[test]
fn what_has_no_width_is_constant() {
    let constant = [
        (Distribution::Constant(2.0), 2.0),
        (
            Distribution::Uniform {
                low: 2.0,
                high: 2.0,
            },
            2.0,
        ),
        (
            Distribution::Triangular {
                low: 2.0,
                mode: 2.0,
                high: 2.0,
            },
            2.0,
        ),
        (
            Distribution::Pert {
                low: 2.0,
                mode: 2.0,
                high: 2.0,
            },
            2.0,
        ),
        (
            Distribution::Beta {
                alpha: 1.0,
                beta: 1.0,
                low: 2.0,
                high: 2.0,
            },
            2.0,
        ),
        (
            Distribution::Normal {
                mean: 2.0,
                deviation: 0.0,
            },
            2.0,
        ),
        (
            Distribution::Lognormal {
                mean: 2.0,
                deviation: 0.0,
            },
            2.0,
        ),
        (Distribution::Exponential { mean: 0.0 }, 0.0),
        (
            Distribution::Erlang {
                stages: 2,
                mean: 0.0,
            },
            0.0,
        ),
        (
            Distribution::Gamma {
                shape: 2.0,
                scale: 0.0,
            },
            0.0,
        ),
        (
            Distribution::Weibull {
                shape: 2.0,
                scale: 0.0,
            },
            0.0,
        ),
        (Distribution::Discrete(vec![(2.0, 1.0)]), 2.0),
        (Distribution::Empirical([2.0, 2.0].into()), 2.0),
        (Distribution::Empirical([0.0].into()), 0.0),
    ];
    for (distribution, value) in constant {
        assert!(
            draws(&distribution, 1)
                .iter()
                .all(|d| d.to_bits() == f64::to_bits(value)),
            "{distribution:?}"
        );
        assert_eq!(distribution.takes_time(), value > 0.0, "{distribution:?}");
        assert_eq!(distribution.is_zero(), value == 0.0, "{distribution:?}");
    }
}

/// Draws stay within the bounds that the clock of a run needs, even with extreme parameters.
#[test]
fn draws_stay_within_bounds() {
    let extreme = [
        Distribution::Weibull {
            shape: 0.01,
            scale: 1e9,
        },
        Distribution::Gamma {
            shape: 0.01,
            scale: 1e9,
        },
        Distribution::Gamma {
            shape: 1e4,
            scale: 1e9,
        },
        Distribution::Lognormal {
            mean: 1e-6,
            deviation: 1e9,
        },
        Distribution::Beta {
            alpha: 0.01,
            beta: 1e4,
            low: 0.0,
            high: 1e9,
        },
        Distribution::Exponential { mean: 1e9 },
    ];
    for distribution in extreme {
        for draw in draws(&distribution, 1) {
            assert!(
                (0.0..=MAX_SECONDS).contains(&draw),
                "{distribution:?}: {draw}"
            );
        }
    }
}
