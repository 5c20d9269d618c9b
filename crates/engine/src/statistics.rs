//! Statistics of the solver, as shown by `--stats`.

use linewright_core::gr1::{Specification, VarId};
use linewright_solver::game;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt::Write as _;

/// Statistics of one solve.
#[derive(Debug, Clone, Default, PartialEq, JsonSchema, Serialize, Deserialize)]
#[expect(
    clippy::struct_excessive_bools,
    reason = "each is an independent fact about a solve"
)]
pub struct Statistics {
    /// Whether the result was read from the cache; all other values are then those of the run that
    /// stored it.
    pub cached: bool,
    /// Whether the search began with the variable order of an earlier version of the contract.
    pub known_order: bool,
    /// Whether the search began within the winning region of an earlier version of the contract.
    pub known_region: bool,
    /// Name of the kernel; empty if none was started.
    pub kernel: String,
    /// Number of bit pairs; a pair is a bit of the current state and the same bit of the next
    /// state.
    pub pairs: usize,
    /// Whether the game is too large for checks in addition to its verdict.
    pub large: bool,
    /// Wall-clock seconds by phase.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seconds: Option<Seconds>,
    /// Peak number of live nodes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub peak_nodes: Option<u64>,
    /// Iterations of the fixpoints.
    pub iterations: Iterations,
    /// Number of controllable predecessors computed.
    pub predecessors: u64,
    /// Variables from the top of the diagrams to the bottom, at the start.
    pub order_before: Vec<String>,
    /// Variables from the top of the diagrams to the bottom, at the end of the run; empty if a
    /// limit was reached before.
    pub order_after: Vec<String>,
}

/// Wall-clock seconds by phase.
#[derive(Debug, Clone, Copy, Default, PartialEq, JsonSchema, Serialize, Deserialize)]
pub struct Seconds {
    /// Encoding formulas as BDDs.
    pub encode: f64,
    /// Searching for a variable order.
    pub order: f64,
    /// Computing the winning region.
    pub fixpoint: f64,
    /// Extracting and minimizing the controller.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub extract: Option<f64>,
    /// Verifying the controller.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub verify: Option<f64>,
}

/// Iterations of the nested fixpoints.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, JsonSchema, Serialize, Deserialize)]
pub struct Iterations {
    /// Outer iterations, one per goal and round.
    pub outer: u64,
    /// Middle iterations, one per assumption and round.
    pub middle: u64,
    /// Innermost iterations.
    pub inner: u64,
}

impl Statistics {
    /// Converts the solver's statistics.
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

    /// Returns a copy, without the measured times and node counts unless `timing` is set.
    #[must_use]
    pub fn timed(&self, timing: bool) -> Self {
        Self {
            seconds: self.seconds.filter(|_| timing),
            peak_nodes: self.peak_nodes.filter(|_| timing),
            ..self.clone()
        }
    }

    /// Formats the statistics as a block of text.
    pub fn show(&self, name: &str) -> String {
        let mut text = format!("{name}\n");
        let mut line = |label: &str, value: String| {
            let _ = writeln!(text, "  {label:<12}  {value}");
        };
        if self.kernel.is_empty() {
            line("kernel", "none started".to_owned());
            return text;
        }
        if self.cached {
            line(
                "result",
                "from the cache; the other values are of the run that stored it".to_owned(),
            );
        }
        line(
            "kernel",
            format!("{}, {} pairs of bits", self.kernel, self.pairs),
        );
        let known = match (self.known_order, self.known_region) {
            (true, true) => Some("the order and the winning region of the previous version"),
            (true, false) => Some("the order of the previous version"),
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
