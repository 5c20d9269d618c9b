//! Stations that work faster or slower than their file says, for `run --what-if capper=10%`.

use linewright_language::contract::distribution::Distribution;
use linewright_language::contract::line::{Line, NodeKind, declared_name};
use linewright_station::{CallError, Controller, Service};

/// Divides the durations of a distribution by `speed`, which is greater than 0.
pub fn faster(distribution: &Distribution, speed: f64) -> Distribution {
    use Distribution as D;
    let by = |seconds: f64| seconds / speed;
    match *distribution {
        D::Constant(value) => D::Constant(by(value)),
        D::Uniform { low, high } => D::Uniform {
            low: by(low),
            high: by(high),
        },
        D::Triangular { low, mode, high } => D::Triangular {
            low: by(low),
            mode: by(mode),
            high: by(high),
        },
        D::Normal { mean, deviation } => D::Normal {
            mean: by(mean),
            deviation: by(deviation),
        },
        D::Lognormal { mean, deviation } => D::Lognormal {
            mean: by(mean),
            deviation: by(deviation),
        },
        D::Exponential { mean } => D::Exponential { mean: by(mean) },
        D::Erlang { stages, mean } => D::Erlang {
            stages,
            mean: by(mean),
        },
        D::Gamma { shape, scale } => D::Gamma {
            shape,
            scale: by(scale),
        },
        D::Weibull { shape, scale } => D::Weibull {
            shape,
            scale: by(scale),
        },
        D::Beta {
            alpha,
            beta,
            low,
            high,
        } => D::Beta {
            alpha,
            beta,
            low: by(low),
            high: by(high),
        },
        D::Pert { low, mode, high } => D::Pert {
            low: by(low),
            mode: by(mode),
            high: by(high),
        },
        D::Discrete(ref outcomes) => {
            D::Discrete(outcomes.iter().map(|(value, p)| (by(*value), *p)).collect())
        }
        D::Empirical(ref values) => D::Empirical(values.iter().map(|value| by(*value)).collect()),
    }
}

/// The stations of a line that `name` stands for: the station itself, or all of `times n`.
pub fn stations_named(line: &Line, name: &str) -> Vec<usize> {
    let is_named = |node: &str| node == name || declared_name(node) == name;
    let nodes = line.nodes.iter().enumerate();
    nodes
        .filter(|(_, node)| matches!(node.kind, NodeKind::Station(_)) && is_named(&node.name))
        .map(|(index, _)| index)
        .collect()
}

/// Divides the times of work of a station by `speed`. Times of a machine are not in the line; see
/// [`FasterController`].
pub fn speed_up(line: &mut Line, node: usize, speed: f64) {
    if let Some(NodeKind::Station(station)) = line.nodes.get_mut(node).map(|n| &mut n.kind) {
        for task in &mut station.tasks {
            task.time = task.time.as_ref().map(|time| faster(time, speed));
        }
    }
}

/// A controller whose work takes less time, with the same power.
pub struct FasterController {
    controller: Box<dyn Controller>,
    speed: f64,
}

impl FasterController {
    /// Divides times and energies of the work by `speed`, which is greater than 0.
    pub fn new(controller: Box<dyn Controller>, speed: f64) -> Self {
        Self { controller, speed }
    }
}

impl Controller for FasterController {
    fn simulate(&mut self, operation: usize, values: &mut [f64]) -> Result<Service, CallError> {
        let service = self.controller.simulate(operation, values)?;
        Ok(Service {
            seconds: service.seconds / self.speed,
            joules: service.joules / self.speed,
            ..service
        })
    }

    fn step(&mut self, plant: &[i64], outputs: &mut [i64]) -> Result<(), CallError> {
        self.controller.step(plant, outputs)
    }

    fn reset(&mut self) {
        self.controller.reset();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ten_percent_faster_divides_by_one_point_one() {
        let scaled = |distribution| faster(&distribution, 1.1);
        assert_eq!(
            scaled(Distribution::Constant(11.0)),
            Distribution::Constant(11.0 / 1.1)
        );
        let gamma = Distribution::Gamma {
            shape: 2.0,
            scale: 3.0,
        };
        assert_eq!(
            faster(&gamma, 0.5),
            Distribution::Gamma {
                shape: 2.0,
                scale: 6.0
            }
        );
    }
}
