//! What a verdict took, as `--stats` shows it.

use linewright_core::gr1::{Specification, VarId};
use linewright_solver::game;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt::Write as _;

/// What a verdict took.
#[derive(Debug, Clone, Default, PartialEq, JsonSchema, Serialize, Deserialize)]
#[expect(
    clippy::struct_excessive_bools,
    reason = "each says one thing that is known of a solve"
)]
pub struct Statistics {
    /// Whether this was read from the cache: then all that follows is of the run that put it there.
    pub cached: bool,
    /// Whether the search began with the order of an earlier version of the contract.
    pub known_order: bool,
    /// Whether the search began within the winning region of an earlier version of the contract.
    pub known_region: bool,
    /// The kernel; empty when none was started.
    pub kernel: String,
    /// Pairs of a current and a next bit.
    pub pairs: usize,
    /// Whether the game is too large to be examined beside its verdict.
    pub large: bool,
    /// Seconds by phase.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seconds: Option<Seconds>,
    /// The largest number of nodes that were kept at once.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub peak_nodes: Option<u64>,
    /// Steps of the fixpoints.
    pub iterations: Iterations,
    /// Controllable predecessors that were computed.
    pub predecessors: u64,
    /// The variables from the top of the diagrams to their bottom at the start.
    pub order_before: Vec<String>,
    /// The same at the end.
    pub order_after: Vec<String>,
}

/// Seconds of the clock by phase.
#[derive(Debug, Clone, Copy, Default, PartialEq, JsonSchema, Serialize, Deserialize)]
pub struct Seconds {
    /// Formulas become functions.
    pub encode: f64,
    /// Looking for an order.
    pub order: f64,
    /// The winning region.
    pub fixpoint: f64,
    /// The controller, minimised.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub extract: Option<f64>,
    /// Checking the controller.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub verify: Option<f64>,
}

/// Steps of the fixpoints.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, JsonSchema, Serialize, Deserialize)]
pub struct Iterations {
    /// Once a goal and round.
    pub outer: u64,
    /// Once an assumption and round.
    pub middle: u64,
    /// The innermost ones.
    pub inner: u64,
}

impl Statistics {
    /// What the solver says.
    pub fn of_solver(solver: &game::Statistics, specification: &Specification) -> Self {
        let names = |order: &[VarId]| -> Vec<String> {
            let names = order.iter().map(|v| &specification.variable(*v).name);
            names.cloned().collect()
        };
        Self {
            kernel: solver.kernel.to_owned(),
            pairs: solver.pairs,
            large: solver.large,
            seconds: Some(Seconds {
                encode: solver.encode_seconds,
                order: solver.order_seconds,
                fixpoint: solver.fixpoint_seconds,
                extract: None,
                verify: None,
            }),
            peak_nodes: Some(solver.peak_nodes),
            iterations: Iterations {
                outer: solver.outer,
                middle: solver.middle,
                inner: solver.inner,
            },
            predecessors: solver.predecessors,
            order_before: names(&solver.order_before),
            order_after: names(&solver.order_after),
            ..Self::default()
        }
    }

    /// With or without what is measured.
    #[must_use]
    pub fn timed(&self, timing: bool) -> Self {
        Self {
            seconds: self.seconds.filter(|_| timing),
            peak_nodes: self.peak_nodes.filter(|_| timing),
            ..self.clone()
        }
    }

    /// A block for a person.
    pub fn show(&self, name: &str) -> String {
        let mut text = format!("{name}\n");
        let mut line = |label: &str, value: String| {
            let _ = writeln!(text, "  {label:<12}  {value}");
        };
        if self.kernel.is_empty() {
            line("kernel", "none was started".to_owned());
            return text;
        }
        if self.cached {
            line(
                "result",
                "from the cache; the rest is of the run that found it".to_owned(),
            );
        }
        line(
            "kernel",
            format!("{}, {} pairs of bits", self.kernel, self.pairs),
        );
        let known = match (self.known_order, self.known_region) {
            (true, true) => Some("the order and the winning region of the version before"),
            (true, false) => Some("the order of the version before"),
            (false, _) => None,
        };
        if let Some(known) = known {
            line("began with", known.to_owned());
        }
        if let Some(s) = self.seconds {
            let mut parts = vec![
                format!("encode {:.3} s", s.encode),
                format!("order {:.3} s", s.order),
                format!("fixpoint {:.3} s", s.fixpoint),
            ];
            parts.extend(s.extract.map(|s| format!("extract {s:.3} s")));
            parts.extend(s.verify.map(|s| format!("verify {s:.3} s")));
            line("time", parts.join(", "));
        }
        if let Some(nodes) = self.peak_nodes {
            line("peak", format!("{nodes} nodes"));
        }
        let n = self.iterations;
        let steps = format!("outer {}, middle {}, inner {}", n.outer, n.middle, n.inner);
        line("iterations", steps);
        line("predecessors", self.predecessors.to_string());
        line("order before", self.order_before.join(" "));
        if !self.order_after.is_empty() {
            line("order after", self.order_after.join(" "));
        }
        text
    }
}
