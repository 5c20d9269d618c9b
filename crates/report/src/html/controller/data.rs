//! What the script needs to walk through a controller, as JSON. The script reads it in the same
//! way, so both change together.

use super::super::for_script;
use super::{Opponent, Page};
use linewright_core::gr1::{
    BinaryOp, Domain, Expr, FormulaKind, Owner, Side, Specification, Time, Timing, UnaryOp, VarId,
    Variable,
};
use linewright_core::source::SourceMap;
use linewright_language::contract::Definition;
use linewright_solver::mealy::{Controller, Machine, Transition};
use serde_json::{Value, json};

pub(super) fn json(page: &Page<'_>) -> String {
    let specification = &*page.contract.specification;
    let reader = page.opponent.reader();
    let (own, others): (Vec<usize>, Vec<usize>) = (0..specification.variables.len())
        .partition(|index| specification.variables[*index].owner == reader);
    let variables = specification.variables.iter().enumerate();
    let variables = variables.map(|(index, v)| variable(specification, VarId(index as u32), v));
    let is_reader = |owner| owner == reader;
    let sources = page.origin.sources;
    let mut rules = side(
        sources,
        &specification.assumptions,
        is_reader(Owner::Environment),
        "assumption",
    );
    rules.extend(side(
        sources,
        &specification.guarantees,
        is_reader(Owner::System),
        "guarantee",
    ));
    let mut document = json!({
        "reader": if reader == Owner::Environment { "plant" } else { "machine" },
        "opponent": if reader == Owner::Environment { "controller" } else { "counterstrategy" },
        "movesFirst": page.opponent.timing() == Timing::Moore,
        "variables": variables.collect::<Vec<_>>(),
        "own": own,
        "others": others,
        "rules": rules,
        "definitions": page.definitions.iter().map(|d| definition(sources, d)).collect::<Vec<_>>(),
    });
    match page.opponent {
        Opponent::Controller(Controller::Functions(functions)) => {
            document["functions"] = functions.to_json(true);
        }
        Opponent::Controller(Controller::Machine(machine)) | Opponent::Counterstrategy(machine) => {
            document["machine"] = json!({
                "initial": transitions(machine, &machine.initial),
                "states": machine.states.iter().map(|list| transitions(machine, list)).collect::<Vec<_>>(),
            });
        }
    }
    for_script(&exact(document).to_string())
}

/// Greatest number up to which scripts read all whole numbers of JSON exactly: 2^53 - 1.
const MAX_EXACT: u64 = (1 << 53) - 1;

/// Writes whole numbers that scripts would round as text.
fn exact(value: Value) -> Value {
    match value {
        Value::Number(number) => {
            let magnitude = number.as_i64().map(i64::unsigned_abs).or(number.as_u64());
            match magnitude {
                Some(magnitude) if magnitude > MAX_EXACT => json!(number.to_string()),
                _ => Value::Number(number),
            }
        }
        Value::Array(items) => items.into_iter().map(exact).collect(),
        Value::Object(members) => {
            let members = members.into_iter();
            Value::Object(members.map(|(name, value)| (name, exact(value))).collect())
        }
        other => other,
    }
}

/// A definition with its value, if it has one.
fn definition(sources: &SourceMap, definition: &Definition) -> Value {
    let file = &sources.file(definition.span.file).name;
    let mut shown = json!({
        "name": definition.name,
        "text": definition.text,
        "place": format!("{file}:{}", sources.start(definition.span).line),
    });
    if let Some(value) = &definition.value {
        shown["labels"] = json!(value.labels);
        shown["unit"] = json!(value.unit);
        shown["value"] = expression(&value.expr);
    }
    shown
}

fn variable(specification: &Specification, id: VarId, variable: &Variable) -> Value {
    let mut value = json!({
        "name": variable.name,
        "low": variable.domain.low(),
        "high": variable.domain.high(),
        "unit": variable.unit,
        "hidden": specification.is_auxiliary(id),
    });
    match &variable.domain {
        Domain::Bool => value["labels"] = json!(["false", "true"]),
        Domain::Enum { labels, .. } => value["labels"] = json!(labels),
        Domain::Range { .. } => {}
    }
    value
}

/// Each transition: cubes of `[input, low, high]`, the outputs, the next state, and the condition
/// as text.
fn transitions(machine: &Machine, list: &[Transition]) -> Value {
    let transition = |t: &Transition| {
        let cubes = t.guard.0.iter().map(|cube| {
            let tests = cube.0.iter().map(|t| json!([t.input, t.low, t.high]));
            tests.collect::<Vec<_>>()
        });
        json!([
            cubes.collect::<Vec<_>>(),
            t.output,
            t.to,
            machine.show_guard(&t.guard)
        ])
    };
    list.iter().map(transition).collect()
}

/// The rules of a side for single steps.
fn side(sources: &SourceMap, side: &Side, is_own: bool, kind: &str) -> Vec<Value> {
    let formulas = side
        .formulas()
        .filter(|(when, ..)| *when != FormulaKind::Justice);
    let rules = formulas.map(|(when, _, formula)| {
        let file = &sources.file(formula.span.file).name;
        json!({
            "own": is_own,
            "kind": kind,
            "when": match when {
                FormulaKind::Initial => "first",
                FormulaKind::Safety => "later",
                _ => "each",
            },
            "name": formula.name,
            "text": formula.text,
            "place": format!("{file}:{}", sources.start(formula.span).line),
            "holds": expression(&formula.expr),
        })
    });
    rules.collect()
}

/// An expression: a number, or an operator with its operands. `now` and `next` are variables.
fn expression(expr: &Expr) -> Value {
    match expr {
        Expr::Const(value) => json!(value),
        Expr::Var(variable, Time::Now) => json!(["now", variable.index()]),
        Expr::Var(variable, Time::Next) => json!(["next", variable.index()]),
        Expr::Unary(op, a) => json!([unary(*op), expression(a)]),
        Expr::Binary(op, a, b) => json!([binary(*op), expression(a), expression(b)]),
        Expr::If(a, b, c) => json!(["if", expression(a), expression(b), expression(c)]),
    }
}

fn unary(op: UnaryOp) -> &'static str {
    match op {
        UnaryOp::Not => "not",
        UnaryOp::Neg => "neg",
        UnaryOp::Abs => "abs",
    }
}

fn binary(op: BinaryOp) -> &'static str {
    match op {
        BinaryOp::And => "and",
        BinaryOp::Or => "or",
        BinaryOp::Implies => "->",
        BinaryOp::Eq => "=",
        BinaryOp::Ne => "!=",
        BinaryOp::Lt => "<",
        BinaryOp::Le => "<=",
        BinaryOp::Gt => ">",
        BinaryOp::Ge => ">=",
        BinaryOp::Add => "+",
        BinaryOp::Sub => "-",
        BinaryOp::Mul => "*",
        BinaryOp::Div => "div",
        BinaryOp::Mod => "mod",
        BinaryOp::Min => "min",
        BinaryOp::Max => "max",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_that_scripts_round_are_texts() {
        let value = json!({"low": [-9_007_199_254_740_993_i64, 9_007_199_254_740_991_i64], "high": u64::MAX, "share": 0.5});
        let wanted = json!({"low": ["-9007199254740993", 9_007_199_254_740_991_i64], "high": "18446744073709551615", "share": 0.5});
        assert_eq!(exact(value), wanted);
    }
}
