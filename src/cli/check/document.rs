//! The JSON document of `check`, from which the text formats are also generated.

use super::watch::Trigger;
use crate::cli::schema::AnyValue;
use crate::contract::line::Line;
use crate::diagnostics::json;
use crate::engine::findings::lost::Suggestion;
use crate::engine::lines::LineVerdict;
use crate::engine::machine::{ClosedEntry, RefinesEntry};
use crate::engine::pipeline::{Examination, Verdict};
use crate::engine::statistics::Statistics;
use crate::engine::words::DischargeEntry;
use crate::line::calls::{Premise, Range, WorkTime};
use crate::source::Span;
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt;

/// The JSON document.
#[derive(Debug, JsonSchema, Serialize)]
pub(super) struct Document {
    pub(super) schema: String,
    /// With `--watch`: the reason for the check.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub(super) occasion: Option<Trigger>,
    /// The semantics of contracts: always `strict`, which means that the guarantees have to be kept
    /// as long as the assumptions have been kept.
    #[schemars(extend("const" = "strict"))]
    pub(super) semantics: &'static str,
    /// The contracts.
    pub(super) contracts: Vec<ContractEntry>,
    /// Sets of skills; omitted if there are none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) skills: Vec<SkillsEntry>,
    /// Layouts of resources; omitted if there are none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) layouts: Vec<LayoutEntry>,
    /// Recipes; omitted if there are none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) recipes: Vec<RecipeEntry>,
    /// What is to be made on layouts; omitted if there is nothing.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) realizations: Vec<RealizationEntry>,
    /// The machines.
    pub(super) machines: Vec<MachineEntry>,
    /// The production lines.
    pub(super) lines: Vec<LineEntry>,
    /// Findings outside all declarations.
    pub(super) findings: Vec<json::Finding>,
    /// The number of contracts by verdict, and of findings.
    pub(super) summary: Summary,
}

/// Result for a contract.
#[derive(Debug, JsonSchema, Serialize)]
pub(super) struct ContractEntry {
    /// The name of the contract.
    pub(super) name: String,
    /// The file that declares the contract.
    pub(super) file: String,
    /// For a specification of another tool: its format, by file extension.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) format: Option<&'static str>,
    /// The codes of the contract in the taxonomies, such as `vdi:Drehen`.
    pub(super) codes: Vec<String>,
    /// Whether the contract has a controller.
    pub(super) verdict: Verdict,
    /// Findings about the contract.
    pub(super) findings: Vec<json::Finding>,
    /// For an unrealizable contract: the guarantees that clash.
    pub(super) core: Vec<String>,
    /// For an unrealizable contract: the assumptions that matter; without any one of them, fewer
    /// guarantees would already clash.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) matters: Vec<String>,
    /// For an unrealizable contract: a play that the plant wins.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) play: Option<PlayEntry>,
    /// For an unrealizable contract: changes that would make it realizable.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) suggestions: Vec<Suggestion>,
    /// For an unrealizable contract: size of the counterstrategy, which `synth --counterstrategy`
    /// writes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) counterstrategy: Option<CounterstrategyEntry>,
    /// For a realizable contract: the number of situations from which the machine can make the
    /// plant break an assumption.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) well_separation: Option<WellSeparation>,
    /// The number of bits that encode the inputs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) input_bits: Option<u32>,
    /// The number of bits that encode the outputs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) output_bits: Option<u32>,
    /// The number of states of the controller.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) states: Option<usize>,
    /// Wall-clock time in seconds; absent with `--no-timing`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0))]
    pub(super) seconds: Option<f64>,
    /// Peak number of BDD nodes; absent with `--no-timing`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) peak_nodes: Option<u64>,
    /// Statistics of the solver; only with `--stats`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) statistics: Option<Statistics>,
    /// Name of the kernel, for the table; in JSON, it is in the statistics.
    #[serde(skip)]
    pub(super) kernel: String,
    /// How much of it was examined, if this is less than was asked.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) examination: Option<Examination>,
}

/// A play that the plant wins.
#[derive(Debug, JsonSchema, Serialize)]
pub(super) struct PlayEntry {
    /// Values of all variables by name for every step; for a step without an answer, only those of
    /// the inputs.
    #[schemars(with = "Vec<BTreeMap<String, AnyValue>>")]
    pub(super) steps: Vec<BTreeMap<String, serde_json::Value>>,
    /// Guarantees that clash in the last step.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) clash: Vec<String>,
    /// Index of the step to which the play returns after the last step, for ever.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) repeats_from: Option<usize>,
    /// The guarantee that never holds again once the play repeats.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) never: Option<String>,
}

/// The size of a counterstrategy.
#[derive(Debug, JsonSchema, Serialize)]
pub(super) struct CounterstrategyEntry {
    /// The number of states of the counterstrategy.
    pub(super) states: usize,
    /// Whether the counterstrategy was verified.
    pub(super) verified: bool,
}

/// Results of both well-separation checks of Maoz and Ringert (2016). Each is `[number, total]`:
/// the number of situations from which the machine can make the plant break an assumption, and the
/// number of all situations that can occur.
#[derive(Debug, JsonSchema, Serialize)]
pub(super) struct WellSeparation {
    /// For a machine that always keeps its guarantees.
    pub(super) forced: [u64; 2],
    /// For a machine that can also break its guarantees.
    pub(super) forced_ignoring_guarantees: [u64; 2],
}

/// Whether a line can be run, or a layout or a recipe be used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Validity {
    /// No problems found.
    Valid,
    /// It, or a machine of the line, has an error.
    Invalid,
    /// A limit was reached before it was decided whether a machine, in the size that the line gives
    /// it, has controllers.
    GaveUp,
    /// An internal error occurred.
    InternalError,
}

impl fmt::Display for Validity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.serialize(f)
    }
}

/// Verdict on a set of skills.
#[derive(Debug, Clone, Copy, PartialEq, Eq, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum SkillsVerdict {
    /// The rules can be kept.
    Consistent,
    /// The rules or situations have errors; for example, the rules allow no call.
    Contradictory,
    /// A limit was reached first.
    GaveUp,
    /// The declaration is invalid.
    Invalid,
    /// An internal error occurred.
    InternalError,
}

impl fmt::Display for SkillsVerdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.serialize(f)
    }
}

/// Result for a set of skills.
#[derive(Debug, JsonSchema, Serialize)]
pub(super) struct SkillsEntry {
    /// The name of the set.
    pub(super) name: String,
    /// The file that declares the set of skills.
    pub(super) file: String,
    /// Whether the rules can be kept.
    pub(super) verdict: SkillsVerdict,
    /// The number of skills in the set.
    pub(super) skills: usize,
    /// The number of rules in the set.
    pub(super) rules: usize,
    /// Findings about the set of skills.
    pub(super) findings: Vec<json::Finding>,
}

/// Result for a layout of resources.
#[derive(Debug, JsonSchema, Serialize)]
pub(super) struct LayoutEntry {
    /// The name of the layout.
    pub(super) name: String,
    /// The file that declares the layout.
    pub(super) file: String,
    /// Whether the layout can be used.
    pub(super) verdict: Validity,
    /// The number of its resources, with the places of its transports; 0 if it is invalid.
    pub(super) resources: usize,
    /// Findings about the layout.
    pub(super) findings: Vec<json::Finding>,
}

/// Result for a recipe.
#[derive(Debug, JsonSchema, Serialize)]
pub(super) struct RecipeEntry {
    /// The name of the recipe.
    pub(super) name: String,
    /// The file that declares the recipe.
    pub(super) file: String,
    /// Whether the recipe can be used.
    pub(super) verdict: Validity,
    /// The number of its states; 0 if it is invalid.
    pub(super) states: usize,
    /// The number of its transitions; 0 if it is invalid.
    pub(super) transitions: usize,
    /// Findings about the recipe.
    pub(super) findings: Vec<json::Finding>,
}

/// Whether the products of a statement `realize` can be made on a layout.
#[derive(Debug, JsonSchema, Serialize)]
pub(super) struct RealizationEntry {
    /// The statement without its first word: `Hinge on Pad`.
    pub(super) name: String,
    /// The file with the statement.
    pub(super) file: String,
    /// Whether the products can be made, whatever the outcomes of the tests. `realizable` only if
    /// the replay of the controller or plan has confirmed it.
    pub(super) verdict: Verdict,
    /// If realizable: the number of vectors (steps that resources take together) until an end of
    /// the recipe or of its loop, in the worst case over the outcomes of the tests. Several
    /// products are made one after the other if that is possible.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) worst_case: Option<u64>,
    /// If realizable: whether it is proved that fewer vectors do not suffice.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) is_least: Option<bool>,
    /// If fewer vectors could suffice for several products: a lower bound.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) lower_bound: Option<u64>,
    /// Why it cannot be made, or was not decided.
    pub(super) findings: Vec<json::Finding>,
}

/// Result for a machine.
#[derive(Debug, JsonSchema, Serialize)]
pub(super) struct MachineEntry {
    /// The name of the machine.
    pub(super) name: String,
    /// The file that declares the machine.
    pub(super) file: String,
    /// The codes of the machine in the taxonomies.
    pub(super) codes: Vec<String>,
    /// The worst verdict of the machine's components.
    pub(super) verdict: Verdict,
    /// The components of the machine.
    pub(super) components: Vec<ComponentEntry>,
    /// How each assumption of a component is discharged, if the composition was checked.
    pub(super) discharges: Vec<DischargeEntry>,
    /// Closed composition of the components' controllers, if each component has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) closed: Option<ClosedEntry>,
    /// Contracts that the machine is declared to refine.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) refines: Vec<RefinesEntry>,
    /// Findings about the machine.
    pub(super) findings: Vec<json::Finding>,
}

/// A component of a machine.
#[derive(Debug, JsonSchema, Serialize)]
pub(super) struct ComponentEntry {
    /// The name of the component.
    pub(super) name: String,
    /// The name of the component's contract.
    pub(super) contract: String,
    /// Whether the contract has a controller.
    pub(super) verdict: Verdict,
}

/// Result for a production line.
#[derive(Debug, JsonSchema, Serialize)]
pub(super) struct LineEntry {
    /// The name of the line.
    pub(super) name: String,
    /// The file that declares the line.
    pub(super) file: String,
    /// Whether the line can be run.
    pub(super) verdict: Validity,
    /// For a valid line: whether parts keep moving.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) proof: Option<LineVerdict>,
    /// If proved or safe: premises of the proof that it does not establish itself.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) premises: Vec<PremiseEntry>,
    /// Names of the stations that are given by their times, without a controller. The proof takes
    /// for granted that their work ends.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) not_controlled: Vec<String>,
    /// If safe: names of the goals that were not decided.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) undecided: Vec<String>,
    /// How long the stations with machines work on a part, without failures; omitted if not all
    /// their calls could be tried.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) work: Vec<WorkEntry>,
    /// How each requirement of the line, and each assumption of a place in it, is discharged.
    pub(super) discharges: Vec<DischargeEntry>,
    /// Findings about the line.
    pub(super) findings: Vec<json::Finding>,
}

/// How long a station with a machine works on a part of one type. Each time has its least and its
/// greatest value.
#[derive(Debug, JsonSchema, Serialize)]
pub(super) struct WorkEntry {
    /// The name of the station.
    pub(super) station: String,
    /// The part type.
    pub(super) part: String,
    /// The time of the work, in seconds.
    pub(super) seconds: [f64; 2],
    /// The time in which some action of the machine is active, in seconds.
    pub(super) action_seconds: [f64; 2],
    /// The time of control, in which no action is active, in seconds.
    pub(super) control_seconds: [f64; 2],
}

impl WorkEntry {
    pub(super) fn new(line: &Line, time: &WorkTime) -> Self {
        // Sums of seconds are exact to the microsecond.
        let rounded = |range: Range| {
            [range.least, range.greatest].map(|seconds| (seconds * 1e6).round() / 1e6 + 0.0)
        };
        Self {
            station: line.nodes[time.node].name.clone(),
            part: line.parts[time.part].name.clone(),
            seconds: rounded(time.work),
            action_seconds: rounded(time.actions),
            control_seconds: rounded(time.control),
        }
    }
}

/// A premise of a proof.
#[derive(Debug, JsonSchema, Serialize)]
pub(super) struct PremiseEntry {
    /// The name of the premise.
    pub(super) name: String,
    /// The premise as text.
    pub(super) text: String,
    /// Place of the declaration that it is about, for pages.
    #[serde(skip)]
    pub(super) place: Span,
}

impl From<Premise> for PremiseEntry {
    fn from(Premise { name, text, span }: Premise) -> Self {
        Self {
            name,
            text,
            place: span,
        }
    }
}

/// Numbers of contracts by verdict, and of findings.
#[derive(Debug, Default, JsonSchema, Serialize)]
pub(super) struct Summary {
    /// Number of contracts that have a controller.
    pub(super) realizable: usize,
    /// Number of contracts that have no controller.
    pub(super) unrealizable: usize,
    /// Number of contracts for which a limit was reached.
    pub(super) gave_up: usize,
    /// Number of contracts with errors, and of files that cannot be read.
    pub(super) invalid: usize,
    /// Number of contracts with an internal error; omitted if there are none.
    #[serde(skip_serializing_if = "is_zero")]
    pub(super) internal_error: usize,
    /// Number of findings in the document.
    pub(super) findings: usize,
}

#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "serde gives a reference to every field"
)]
fn is_zero(count: &usize) -> bool {
    *count == 0
}
