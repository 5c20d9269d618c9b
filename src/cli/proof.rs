//! `check --proof`: the reason why a contract is realizable, for an independent check.
//! `docs/proof.md` describes that check.

use super::console::schema;
use crate::game::{Rank, Ranking};
use crate::gr1::{Domain, Owner, Specification, Timing};
use serde::Serialize;

/// The JSON document.
#[derive(Debug, Serialize)]
struct Document<'a> {
    schema: String,
    contract: &'a str,
    verdict: &'static str,
    timing: &'static str,
    variables: Vec<Variable<'a>>,
    assumptions: Vec<&'a str>,
    goals: Vec<Goal<'a>>,
    order: Vec<String>,
    region: u32,
    /// Bit, edge if it is 1, edge if it is 0.
    nodes: Vec<(u16, u32, u32)>,
}

#[derive(Debug, Serialize)]
struct Variable<'a> {
    name: &'a str,
    owner: &'static str,
    low: i64,
    high: i64,
    #[serde(skip_serializing_if = "Option::is_none")]
    labels: Option<&'a [String]>,
    bits: &'a [u16],
}

#[derive(Debug, Serialize)]
struct Goal<'a> {
    name: &'a str,
    layers: Vec<Layer>,
}

#[derive(Debug, Serialize)]
struct Layer {
    assumption: usize,
    wait: u32,
    reached: u32,
}

/// The document as text, one line per node.
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

/// Each current bit by its variable's name and its index in it.
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
