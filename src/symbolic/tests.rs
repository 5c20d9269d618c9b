//! Every operator of the encoder against direct evaluation, over all valuations of small domains.

use super::*;
use crate::gr1::eval::eval;
use crate::gr1::interval::{Interval, interval};
use crate::gr1::*;
use crate::source::Span;

fn specification(domains: &[(i64, i64)]) -> Specification {
    let variables = domains.iter().enumerate().map(|(i, (low, high))| Variable {
        name: format!("v{i}"),
        owner: Owner::System,
        internal: false,
        domain: Domain::Range {
            low: *low,
            high: *high,
        },
        span: Span::default(),
    });
    Specification {
        name: "test".to_owned(),
        timing: Timing::Mealy,
        variables: variables.collect(),
        assumptions: Side::default(),
        guarantees: Side::default(),
    }
}

/// All values of the variables, one after the other.
fn valuations(spec: &Specification) -> Vec<Vec<i64>> {
    let mut all = vec![Vec::new()];
    for variable in &spec.variables {
        let values = variable.domain.low()..=variable.domain.high();
        all = all
            .into_iter()
            .flat_map(|v: Vec<i64>| values.clone().map(move |x| [v.clone(), vec![x]].concat()))
            .collect();
    }
    all
}

fn holds_at(m: &Manager, encoding: &Encoding, f: &Function, now: &[i64], next: &[i64]) -> bool {
    let mut bits = Vec::new();
    for i in 0..now.len() {
        let var = VarId(i as u32);
        bits.extend(encoding.assignment(var, Time::Now, now[i]));
        bits.extend(encoding.assignment(var, Time::Next, next[i]));
    }
    let rest = m.restrict(f, &bits).unwrap();
    assert!(rest.is_true() || rest.is_false());
    rest.is_true()
}

/// The formula, and every single value of the expression, agree with direct evaluation wherever `valid` is not 0.
fn agrees(domains: &[(i64, i64)], expr: &Expr, valid: &Expr) {
    let spec = specification(domains);
    let encoding = Encoding::new(&spec);
    let m = Manager::new(encoding.pairs(), &Limits::default()).unwrap();
    let domain = |v: VarId| Interval::of(&spec.variable(v).domain);
    let Ok(range) = interval(expr, &domain) else {
        panic!("not encodable: {expr:?}")
    };
    let formula = encoding.formula(&m, expr).unwrap();
    let values: Vec<_> = (range.low..=range.high)
        .map(|v| (v, encoding.has_value(&m, expr, v).unwrap()))
        .collect();
    for now in valuations(&spec) {
        if eval(valid, &now, &now) == 0 {
            continue;
        }
        // The next values are the current ones turned round, so that both times differ.
        let next: Vec<i64> = domains
            .iter()
            .zip(&now)
            .map(|((low, high), v)| low + high - v)
            .collect();
        let expected = eval(expr, &now, &next);
        assert_eq!(
            holds_at(&m, &encoding, &formula, &now, &next),
            expected != 0,
            "{expr:?} at {now:?}"
        );
        for (value, f) in &values {
            assert_eq!(
                holds_at(&m, &encoding, f, &now, &next),
                *value == expected,
                "{expr:?} = {value} at {now:?}"
            );
        }
    }
}

const DOMAINS: [(i64, i64); 6] = [(0, 1), (0, 4), (-3, 4), (-6, -2), (2, 5), (-1, 0)];

const OPERATORS: [BinaryOp; 16] = [
    BinaryOp::And,
    BinaryOp::Or,
    BinaryOp::Implies,
    BinaryOp::Eq,
    BinaryOp::Ne,
    BinaryOp::Lt,
    BinaryOp::Le,
    BinaryOp::Gt,
    BinaryOp::Ge,
    BinaryOp::Add,
    BinaryOp::Sub,
    BinaryOp::Mul,
    BinaryOp::Div,
    BinaryOp::Mod,
    BinaryOp::Min,
    BinaryOp::Max,
];

#[test]
fn every_binary_operator_is_exact() {
    let (a, b) = (Expr::now(VarId(0)), Expr::next(VarId(1)));
    for left in DOMAINS {
        for right in DOMAINS {
            for op in OPERATORS {
                let divides = matches!(op, BinaryOp::Div | BinaryOp::Mod);
                if divides && right.0 <= 0 && right.1 >= 0 {
                    continue;
                }
                let logical = matches!(op, BinaryOp::And | BinaryOp::Or | BinaryOp::Implies);
                if logical && (left != (0, 1) || right != (0, 1)) {
                    continue;
                }
                let expr = Expr::binary(op, a.clone(), b.clone());
                agrees(&[left, right], &expr, &Expr::TRUE);
            }
        }
    }
}

#[test]
fn every_unary_operator_and_choice_are_exact() {
    let a = Expr::now(VarId(0));
    for domain in DOMAINS {
        for op in [UnaryOp::Neg, UnaryOp::Abs] {
            agrees(
                &[domain],
                &Expr::Unary(op, Box::new(a.clone())),
                &Expr::TRUE,
            );
        }
        let condition = Expr::next(VarId(1));
        let other = Expr::Const(7);
        let choice = Expr::If(Box::new(condition), Box::new(a.clone()), Box::new(other));
        agrees(&[domain, (0, 1)], &choice, &Expr::TRUE);
    }
    agrees(&[(0, 1)], &a.not(), &Expr::TRUE);
}

#[test]
fn nested_arithmetic_never_wraps() {
    use BinaryOp::{Add, Div, Le, Max, Mod, Mul, Sub};
    let v = |i: u32| Expr::now(VarId(i));
    let product = Expr::binary(Mul, v(0), Expr::binary(Add, v(1), Expr::next(VarId(0))));
    let divisor = Expr::binary(
        Sub,
        Expr::Unary(UnaryOp::Neg, Box::new(v(1))),
        Expr::Const(3),
    );
    for expr in [
        product.clone(),
        Expr::binary(Div, product.clone(), divisor.clone()),
        Expr::binary(Mod, product.clone(), divisor.clone()),
        Expr::binary(
            Max,
            Expr::binary(Sub, product.clone(), v(1)),
            Expr::Const(-9),
        ),
        Expr::binary(Le, product, divisor),
    ] {
        agrees(&[(-3, 4), (-2, 3)], &expr, &Expr::TRUE);
    }
}

#[test]
fn domains_exclude_exactly_the_codes_without_a_value() {
    for (low, high) in DOMAINS {
        let spec = specification(&[(low, high)]);
        let encoding = Encoding::new(&spec);
        let m = Manager::new(encoding.pairs(), &Limits::default()).unwrap();
        for time in [Time::Now, Time::Next] {
            let mut within = encoding.in_domain(&m, VarId(0), time).unwrap();
            for value in low..=high {
                let bits = encoding.assignment(VarId(0), time, value);
                assert!(m.restrict(&within, &bits).unwrap().is_true());
                let mut cube = m.constant(true);
                for (bit, positive) in bits {
                    cube = m.and(&cube, &m.literal(bit, positive)).unwrap();
                }
                within = m.and_not(&within, &cube).unwrap();
            }
            assert!(within.is_false());
        }
    }
}

#[test]
fn quantifying_renaming_and_limits() {
    let m = Manager::new(3, &Limits::default()).unwrap();
    let v = |i: u16| m.literal(Bit(i), true);
    let f = m.and(&v(0), &m.or(&v(2), &v(4)).unwrap()).unwrap();
    let primed = m.prime(&f).unwrap();
    assert_eq!(primed.support(), [Bit(1), Bit(3), Bit(5)]);
    assert_eq!(m.unprime(&primed).unwrap(), f);
    let bits = BitSet::new([Bit(2), Bit(4)]);
    assert_eq!(m.exists(&f, &bits).unwrap(), v(0));
    assert!(m.forall(&f, &bits).unwrap().is_false());
    let fused = m.and_exists(&f, &v(2), &BitSet::new([Bit(2)])).unwrap();
    assert_eq!(fused, v(0));

    let none = Limits {
        memory_mib: Some(0),
        deadline: None,
    };
    assert_eq!(m.with_limits(&none).and(&f, &v(1)), Err(Limit::Memory));
    let past = Limits {
        memory_mib: None,
        deadline: Some(std::time::Instant::now()),
    };
    assert_eq!(m.with_limits(&past).and(&f, &v(1)), Err(Limit::Time));
    drop((f, primed, fused));
    assert!(m.peak_nodes() > 0);
}
