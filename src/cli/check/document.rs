//! The JSON document of `check`, which its other formats are made from, too.

use super::watch::Occasion;
use crate::cli::statistics::Statistics;
use crate::diagnostics::json;
use serde::Serialize;

/// The JSON document.
#[derive(Debug, Serialize)]
pub(super) struct Document {
    pub(super) schema: String,
    /// Why it was checked again, with `--watch`.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub(super) occasion: Option<Occasion>,
    pub(super) semantics: &'static str,
    pub(super) contracts: Vec<ContractEntry>,
    pub(super) machines: Vec<MachineEntry>,
    pub(super) lines: Vec<LineEntry>,
    /// Findings that belong to no declaration.
    pub(super) findings: Vec<json::Finding>,
    pub(super) summary: Summary,
}

#[derive(Debug, Serialize)]
pub(super) struct ContractEntry {
    pub(super) name: String,
    pub(super) file: String,
    /// For a specification of another tool: its format, by the ending of its files.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) format: Option<&'static str>,
    pub(super) codes: Vec<String>,
    pub(super) verdict: &'static str,
    pub(super) findings: Vec<json::Finding>,
    pub(super) core: Vec<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) input_bits: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) output_bits: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) states: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) seconds: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) peak_nodes: Option<u64>,
    /// With `--stats`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) statistics: Option<Statistics>,
    /// The kernel, for people; in JSON it is among the statistics.
    #[serde(skip)]
    pub(super) kernel: String,
    /// Whether only the verdict was asked for, since the game is large.
    #[serde(skip)]
    pub(super) verdict_only: bool,
}

#[derive(Debug, Serialize)]
pub(super) struct MachineEntry {
    pub(super) name: String,
    pub(super) file: String,
    pub(super) codes: Vec<String>,
    pub(super) verdict: &'static str,
    pub(super) components: Vec<ComponentEntry>,
    /// How each assumption of a component is met, where the composition was checked.
    pub(super) discharges: Vec<DischargeEntry>,
    pub(super) findings: Vec<json::Finding>,
}

#[derive(Debug, Serialize)]
pub(super) struct ComponentEntry {
    pub(super) name: String,
    pub(super) contract: String,
    pub(super) verdict: &'static str,
}

#[derive(Debug, Serialize)]
pub(super) struct DischargeEntry {
    pub(super) component: String,
    pub(super) assumption: String,
    pub(super) by: String,
}

#[derive(Debug, Serialize)]
pub(super) struct LineEntry {
    pub(super) name: String,
    pub(super) file: String,
    /// `valid` or `invalid`.
    pub(super) verdict: &'static str,
    pub(super) findings: Vec<json::Finding>,
}

#[derive(Debug, Default, Serialize)]
pub(super) struct Summary {
    pub(super) realizable: usize,
    pub(super) unrealizable: usize,
    pub(super) gave_up: usize,
    pub(super) invalid: usize,
    pub(super) findings: usize,
}
