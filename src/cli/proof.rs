//! `check --proof`: writes a certificate that a contract is realizable. `docs/proof.md` describes
//! how to check it independently.

use super::console::schema;
use crate::cli::schema::{Described, form};
use crate::game::{Rank, Ranking};
use crate::gr1::{Domain, Owner, Specification, Timing};
use schemars::JsonSchema;
use serde::Serialize;

/// The document of a proof.
pub const DOCUMENT: Described = Described::new(
    "proof",
    "Why a contract is realizable: `check --proof`",
    &[form::<Document<'_>>],
);

/// The JSON document of a proof.
#[derive(Debug, JsonSchema, Serialize)]
struct Document<'a> {
    schema: String,
    /// The name of the contract.
    contract: &'a str,
    /// The verdict that is proved.
    #[schemars(extend("const" = "realizable"))]
    verdict: &'static str,
    /// `mealy`: the controller sets the outputs of a step after it has seen the inputs of the step;
    /// `moore`: before it has seen them.
    #[schemars(extend("enum" = ["mealy", "moore"]))]
    timing: &'static str,
    /// The variables; internal ones count as outputs.
    variables: Vec<Variable<'a>>,
    /// The names of the justice assumptions; `true` alone if there are none.
    assumptions: Vec<&'a str>,
    /// The justice guarantees; a single goal named `true` if there are none.
    goals: Vec<Goal<'a>>,
    /// The bits from the top of the diagrams to the bottom, such as `turning.0`.
    order: Vec<String>,
    /// The edge to the root of the winning region.
    region: u32,
    /// The nodes of the diagrams: bit, edge if the bit is 1, edge if it is 0.
    nodes: Vec<(u16, u32, u32)>,
}

/// A variable.
#[derive(Debug, JsonSchema, Serialize)]
struct Variable<'a> {
    /// The name of the variable.
    name: &'a str,
    /// Whether the plant sets it (`input`) or the machine (`output`).
    #[schemars(extend("enum" = ["input", "output"]))]
    owner: &'static str,
    /// The lowest value.
    low: i64,
    /// The highest value.
    high: i64,
    /// The labels of an enumeration.
    #[serde(skip_serializing_if = "Option::is_none")]
    labels: Option<&'a [String]>,
    /// The numbers of the variable's bits, the most significant first; the bits encode the value
    /// minus `low`.
    bits: &'a [u16],
}

/// A goal.
#[derive(Debug, JsonSchema, Serialize)]
struct Goal<'a> {
    /// The name of the goal.
    name: &'a str,
    /// The layers of states, the nearest to the goal first.
    layers: Vec<Layer>,
}

/// A layer of a goal.
#[derive(Debug, JsonSchema, Serialize)]
struct Layer {
    /// The index of the assumption that the controller waits for.
    assumption: usize,
    /// The edge to the states in which the controller makes progress, or waits for the assumption.
    wait: u32,
    /// The edge to all states of this layer and the layers before it.
    reached: u32,
}

/// Formats the document of a proof.
pub fn to_text(specification: &Specification, ranking: &Ranking) -> String {
    let root = |root: usize| ranking.diagram.roots[root].0;
    let layer = |rank: &Rank| Layer {
        assumption: rank.assumption,
        wait: root(rank.wait),
        reached: root(rank.reached),
    };
    let names = |list: &'_ [crate::gr1::Formula]| -> Vec<String> {
        list.iter().map(|f| f.name.clone()).collect()
    };
    let assumptions = or_true(names(&specification.assumptions.justice));
    let goals = or_true(names(&specification.guarantees.justice));
    let document = Document {
        schema: schema("proof"),
        contract: &specification.name,
        verdict: "realizable",
        timing: match specification.timing {
            Timing::Mealy => "mealy",
            Timing::Moore => "moore",
        },
        variables: specification
            .variables
            .iter()
            .zip(&ranking.bits)
            .map(|(v, bits)| Variable {
                name: &v.name,
                owner: match v.owner {
                    Owner::Environment => "input",
                    Owner::System => "output",
                },
                low: v.domain.low(),
                high: v.domain.high(),
                labels: match &v.domain {
                    Domain::Enum { labels, .. } => Some(labels),
                    _ => None,
                },
                bits,
            })
            .collect(),
        assumptions: assumptions.iter().map(String::as_str).collect(),
        goals: goals
            .iter()
            .zip(&ranking.goals)
            .map(|(name, ranks)| Goal {
                name,
                layers: ranks.iter().map(layer).collect(),
            })
            .collect(),
        order: order(specification, ranking),
        region: root(0),
        nodes: ranking
            .diagram
            .nodes
            .iter()
            .map(|n| (n.bit.0, n.high.0, n.low.0))
            .collect(),
    };
    let value = serde_json::to_value(document).unwrap_or_default();
    crate::mealy::json::to_text(&value)
}

fn or_true(names: Vec<String>) -> Vec<String> {
    if names.is_empty() {
        vec!["true".to_owned()]
    } else {
        names
    }
}

/// Names of the current bits in variable order: the variable and the index of the bit in it.
fn order(specification: &Specification, ranking: &Ranking) -> Vec<String> {
    let name = |bit: &u16| {
        let variables = specification.variables.iter().zip(&ranking.bits);
        variables
            .filter_map(|(v, bits)| bits.iter().position(|b| b == bit).map(|p| (v, p)))
            .map(|(v, place)| format!("{}.{place}", v.name))
            .next()
            .unwrap_or_default()
    };
    ranking.order.iter().map(name).collect()
}
