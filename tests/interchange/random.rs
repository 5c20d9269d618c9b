//! Random specifications small enough for the solver to decide each in milliseconds.

use linewright::gr1::{
    BinaryOp, Domain, Expr, Formula, Owner, Side, Specification, Time, Timing, UnaryOp, VarId,
    Variable,
};
use linewright::source::Span;
use proptest::prelude::*;

/// Values that a random formula may mention.
#[derive(Debug, Clone, Copy)]
struct Scope {
    outputs: bool,
    next_inputs: bool,
    next_outputs: bool,
}

fn domain() -> impl Strategy<Value = Domain> {
    prop_oneof![
        3 => Just(Domain::Bool),
        2 => (-1i64..=1, 0i64..=2).prop_map(|(low, more)| Domain::Range { low, high: low + more }),
        1 => Just(Domain::Enum { name: None, labels: vec!["idle".to_owned(), "busy".to_owned(), "done".to_owned()] }),
    ]
}

fn number(readable: Vec<(VarId, Time)>) -> BoxedStrategy<Expr> {
    let constant = (-1i64..=3).prop_map(Expr::Const);
    if readable.is_empty() {
        return constant.boxed();
    }
    let leaf = prop_oneof![
        2 => prop::sample::select(readable).prop_map(|(v, t)| Expr::Var(v, t)),
        1 => constant,
    ];
    leaf.prop_recursive(2, 6, 2, |inner| {
        use BinaryOp as B;
        let ops = prop::sample::select(vec![B::Add, B::Sub, B::Mul, B::Min, B::Max]);
        prop_oneof![
            3 => (ops, inner.clone(), inner.clone()).prop_map(|(op, a, b)| Expr::binary(op, a, b)),
            1 => inner.clone().prop_map(|a| Expr::binary(B::Mod, a, Expr::Const(2))),
            1 => inner.clone().prop_map(|a| Expr::binary(B::Div, a, Expr::Const(2))),
            1 => inner.prop_map(|a| Expr::Unary(UnaryOp::Abs, Box::new(a))),
        ]
    })
    .boxed()
}

fn formula(variables: &[Variable], scope: Scope) -> BoxedStrategy<Expr> {
    use BinaryOp as B;
    let readable: Vec<(VarId, Time)> = variables
        .iter()
        .enumerate()
        .flat_map(|(i, v)| [(i, v, Time::Now), (i, v, Time::Next)])
        .filter(|(_, v, t)| match (v.owner, t) {
            (Owner::Environment, Time::Now) => true,
            (Owner::Environment, Time::Next) => scope.next_inputs,
            (Owner::System, Time::Now) => scope.outputs,
            (Owner::System, Time::Next) => scope.next_outputs,
        })
        .map(|(i, _, t)| (VarId(i as u32), t))
        .collect();
    let of = |truth: bool| -> Vec<(VarId, Time)> {
        let is = |v: &VarId| (variables[v.index()].domain == Domain::Bool) == truth;
        readable.iter().copied().filter(|(v, _)| is(v)).collect()
    };
    let (truths, numbers) = (of(true), of(false));
    let compare = prop::sample::select(vec![B::Eq, B::Ne, B::Lt, B::Le, B::Gt, B::Ge]);
    let comparison = (compare, number(numbers.clone()), number(numbers))
        .prop_map(|(op, a, b)| Expr::binary(op, a, b));
    let leaf = if truths.is_empty() {
        comparison.boxed()
    } else {
        let variable = prop::sample::select(truths).prop_map(|(v, t)| Expr::Var(v, t));
        prop_oneof![3 => variable, 1 => comparison].boxed()
    };
    leaf.prop_recursive(3, 10, 3, |inner| {
        let ops = prop::sample::select(vec![B::And, B::Or, B::Implies, B::Eq, B::Ne]);
        prop_oneof![
            2 => inner.clone().prop_map(Expr::not),
            5 => (ops, inner.clone(), inner.clone()).prop_map(|(op, a, b)| Expr::binary(op, a, b)),
            1 => (inner.clone(), inner.clone(), inner)
                .prop_map(|(c, a, b)| Expr::If(Box::new(c), Box::new(a), Box::new(b))),
        ]
    })
    .boxed()
}

fn list(
    variables: &[Variable],
    name: &'static str,
    at_most: usize,
    scope: Scope,
) -> BoxedStrategy<Vec<Formula>> {
    prop::collection::vec(formula(variables, scope), 0..=at_most)
        .prop_map(move |expressions| {
            let made = expressions
                .into_iter()
                .enumerate()
                .map(|(i, expr)| Formula {
                    defines: false,
                    name: format!("{name} {i}"),
                    requirement: None,
                    expr,
                    span: Span::default(),
                    text: String::new(),
                });
            made.collect()
        })
        .boxed()
}

/// Random specifications of both timings, with all kinds of formulas.
pub fn specifications() -> BoxedStrategy<Specification> {
    let names = ["a", "line", "x[1]", "next", "Wert ü", "b@0"];
    let variables = (
        prop::collection::vec(domain(), 1..=2),
        prop::collection::vec(domain(), 1..=2),
    );
    let timing = prop_oneof![3 => Just(Timing::Mealy), 1 => Just(Timing::Moore)];
    (variables, timing)
        .prop_flat_map(move |((inputs, outputs), timing)| {
            let owners = inputs
                .into_iter()
                .map(|d| (Owner::Environment, d))
                .chain(outputs.into_iter().map(|d| (Owner::System, d)));
            let variables: Vec<Variable> = owners
                .zip(names)
                .map(|((owner, domain), name)| Variable {
                    name: name.to_owned(),
                    owner,
                    internal: false,
                    unit: String::new(),
                    domain,
                    span: Span::default(),
                })
                .collect();
            let scope = |outputs, next_inputs, next_outputs| Scope {
                outputs,
                next_inputs,
                next_outputs,
            };
            let v = &variables;
            let assumptions = (
                list(v, "ENV INIT", 1, scope(false, false, false)),
                list(v, "ENV INV", 1, scope(false, false, false)),
                list(v, "ENV TRANS", 2, scope(true, true, false)),
                list(v, "ENV GOAL", 2, scope(true, true, true)),
            );
            let guarantees = (
                list(v, "SYS INIT", 2, scope(true, false, false)),
                list(v, "SYS INV", 1, scope(true, false, false)),
                list(v, "SYS TRANS", 2, scope(true, true, true)),
                list(v, "SYS GOAL", 2, scope(true, true, true)),
            );
            let side = |(initial, invariants, safety, justice)| Side {
                initial,
                invariants,
                safety,
                justice,
            };
            (Just(variables), Just(timing), assumptions, guarantees).prop_map(
                move |(variables, timing, assumptions, guarantees)| Specification {
                    name: "Random".to_owned(),
                    timing,
                    variables,
                    assumptions: side(assumptions),
                    guarantees: side(guarantees),
                },
            )
        })
        .boxed()
}
