//! The JSON document of `check`, from which its other formats are also made.

use super::watch::Trigger;
use crate::diagnostics::json;
use crate::engine::findings::lost::Suggestion;
use crate::engine::lines::LineVerdict;
use crate::engine::machine::{ClosedEntry, RefinesEntry};
use crate::engine::pipeline::Verdict;
use crate::engine::statistics::Statistics;
use crate::engine::words::DischargeEntry;
use crate::line::calls::Premise;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt;

/// The JSON document.
#[derive(Debug, Serialize)]
pub(super) struct Document {
    pub(super) schema: String,
    /// Why it was checked again, with `--watch`.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub(super) occasion: Option<Trigger>,
    pub(super) semantics: &'static str,
    pub(super) contracts: Vec<ContractEntry>,
    /// Sets of skills; omitted if there are none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) skills: Vec<SkillsEntry>,
    pub(super) machines: Vec<MachineEntry>,
    pub(super) lines: Vec<LineEntry>,
    /// Findings outside all declarations.
    pub(super) findings: Vec<json::Finding>,
    pub(super) summary: Summary,
}

#[derive(Debug, Serialize)]
pub(super) struct ContractEntry {
    pub(super) name: String,
    pub(super) file: String,
    /// For a specification of another tool: its format, by file extension.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) format: Option<&'static str>,
    pub(super) codes: Vec<String>,
    pub(super) verdict: Verdict,
    pub(super) findings: Vec<json::Finding>,
    pub(super) core: Vec<String>,
    /// For an unrealizable one: the assumptions that matter for the core.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) matters: Vec<String>,
    /// The play that shows that it is unrealizable.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) play: Option<PlayEntry>,
    /// Changes that would make it realizable.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) suggestions: Vec<Suggestion>,
    /// Size of its counterstrategy, which `synth --counterstrategy` writes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) counterstrategy: Option<CounterstrategyEntry>,
    /// For a realizable one: the number of situations from which the machine can make the plant
    /// break an assumption.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) well_separation: Option<WellSeparation>,
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
    /// Present with `--stats`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) statistics: Option<Statistics>,
    /// Kernel name, for people; in JSON it is in the statistics.
    #[serde(skip)]
    pub(super) kernel: String,
    /// Whether only the verdict was computed, since the game is large.
    #[serde(skip)]
    pub(super) verdict_only: bool,
}

/// A play lost by the machine.
#[derive(Debug, Serialize)]
pub(super) struct PlayEntry {
    /// Values of all variables by name for every step; for a step without an answer, only those of
    /// the inputs.
    pub(super) steps: Vec<BTreeMap<String, serde_json::Value>>,
    /// Guarantees that clash in the last step.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) clash: Vec<String>,
    /// Index of the step that follows the last one, for ever.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) repeats_from: Option<usize>,
    /// The guarantee that is never met again.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) never: Option<String>,
}

#[derive(Debug, Serialize)]
pub(super) struct CounterstrategyEntry {
    pub(super) states: usize,
    pub(super) verified: bool,
}

/// Both checks of Maoz and Ringert: `[from, of]` possible situations.
#[derive(Debug, Serialize)]
pub(super) struct WellSeparation {
    /// For a machine that always keeps its guarantees.
    pub(super) forced: [u64; 2],
    /// For an unrestricted machine.
    pub(super) forced_ignoring_guarantees: [u64; 2],
}

/// Whether a line can be run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Validity {
    /// No problems found.
    Valid,
    /// The line, or one of its machines, has an error.
    Invalid,
    /// An internal error occurred.
    InternalError,
}

impl fmt::Display for Validity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.serialize(f)
    }
}

/// Verdict on a set of skills.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum SkillsVerdict {
    /// Its rules can be kept.
    Consistent,
    /// They allow nothing, or lead nowhere.
    Contradictory,
    /// A limit was reached before it was decided.
    GaveUp,
    /// The declaration is invalid.
    Invalid,
    /// This program failed while it looked at it.
    InternalError,
}

impl fmt::Display for SkillsVerdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.serialize(f)
    }
}

#[derive(Debug, Serialize)]
pub(super) struct SkillsEntry {
    pub(super) name: String,
    pub(super) file: String,
    pub(super) verdict: SkillsVerdict,
    pub(super) skills: usize,
    pub(super) rules: usize,
    pub(super) findings: Vec<json::Finding>,
}

#[derive(Debug, Serialize)]
pub(super) struct MachineEntry {
    pub(super) name: String,
    pub(super) file: String,
    pub(super) codes: Vec<String>,
    pub(super) verdict: Verdict,
    pub(super) components: Vec<ComponentEntry>,
    /// How each assumption of a component is met, if the composition was checked.
    pub(super) discharges: Vec<DischargeEntry>,
    /// Closed composition of its controllers, if each component has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) closed: Option<ClosedEntry>,
    /// Contracts that it is declared to refine.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) refines: Vec<RefinesEntry>,
    pub(super) findings: Vec<json::Finding>,
}

#[derive(Debug, Serialize)]
pub(super) struct ComponentEntry {
    pub(super) name: String,
    pub(super) contract: String,
    pub(super) verdict: Verdict,
}

#[derive(Debug, Serialize)]
pub(super) struct LineEntry {
    pub(super) name: String,
    pub(super) file: String,
    pub(super) verdict: Validity,
    /// For a valid line: whether parts keep moving.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) proof: Option<LineVerdict>,
    /// If proved or safe: premises that the line itself does not establish.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) premises: Vec<PremiseEntry>,
    /// If safe: what was not decided.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) undecided: Vec<String>,
    /// What each requirement of the line, and each assumption of a place in it, rests on.
    pub(super) discharges: Vec<DischargeEntry>,
    pub(super) findings: Vec<json::Finding>,
}

/// A premise of a proof.
#[derive(Debug, Serialize)]
pub(super) struct PremiseEntry {
    pub(super) name: String,
    /// The premise as text.
    pub(super) text: String,
}

impl From<Premise> for PremiseEntry {
    fn from(Premise { name, text }: Premise) -> Self {
        Self { name, text }
    }
}

#[derive(Debug, Default, Serialize)]
pub(super) struct Summary {
    pub(super) realizable: usize,
    pub(super) unrealizable: usize,
    pub(super) gave_up: usize,
    pub(super) invalid: usize,
    /// Number of contracts with an internal error; omitted if there are none.
    #[serde(skip_serializing_if = "is_zero")]
    pub(super) internal_error: usize,
    pub(super) findings: usize,
}

#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "serde gives a reference to every field"
)]
fn is_zero(count: &usize) -> bool {
    *count == 0
}
