//! Tests every operator of the encoder against direct evaluation, over all valuations of small
//! domains.

use super::*;
use linewright_core::gr1::eval::eval;
use linewright_core::gr1::interval::{Interval, interval};
use linewright_core::gr1::*;
use linewright_core::source::Span;

fn specification(domains: &[(i64, i64)]) -> Specification {
    let variables = domains.iter().enumerate().map(|(i, (low, high))| Variable {
        name: format!("v{i}"),
        owner: Owner::System,
        internal: false,
        unit: String::new(),
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

/// All valuations of the variables.
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

/// A kernel whose order is not the natural one.
fn kernel<K: Kernel>(pairs: usize) -> K {
    let order = Order::new((0..pairs as u16).rev().collect()).unwrap();
    K::new(&order, &small()).unwrap()
}

fn small() -> Limits {
    Limits {
        max_nodes: Some(1 << 20),
        ..Limits::default()
    }
}

fn holds_at<K: Kernel>(
    m: &K,
    encoding: &Encoding,
    f: &K::Function,
    now: &[i64],
    next: &[i64],
) -> bool {
    let mut bits = Vec::new();
    for i in 0..now.len() {
        let var = VarId(i as u32);
        bits.extend(encoding.assignment(var, Time::Now, now[i]));
        bits.extend(encoding.assignment(var, Time::Next, next[i]));
    }
    let rest = m.restrict(f, &bits).unwrap();
    assert!(m.is_true(&rest) || m.is_false(&rest));
    m.is_true(&rest)
}

/// The formula, and every single value of the expression, agree with direct evaluation wherever
/// `valid` is not 0.
fn agrees(domains: &[(i64, i64)], expr: &Expr, valid: &Expr) {
    agrees_on::<Biodivine>(domains, expr, valid);
    agrees_on::<SharedStore>(domains, expr, valid);
}

fn agrees_on<K: Kernel>(domains: &[(i64, i64)], expr: &Expr, valid: &Expr) {
    let spec = specification(domains);
    let encoding = Encoding::new(&spec);
    let m: K = kernel(encoding.pairs());
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
        // The next values are the current ones in reverse order, so that the two times differ.
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

fn domains_exclude_on<K: Kernel>() {
    for (low, high) in DOMAINS {
        let spec = specification(&[(low, high)]);
        let encoding = Encoding::new(&spec);
        let m: K = kernel(encoding.pairs());
        for time in [Time::Now, Time::Next] {
            let mut within = encoding.in_domain(&m, VarId(0), time).unwrap();
            for value in low..=high {
                let bits = encoding.assignment(VarId(0), time, value);
                assert!(m.is_true(&m.restrict(&within, &bits).unwrap()));
                within = m.and_not(&within, &m.cube(&bits).unwrap()).unwrap();
            }
            assert!(m.is_false(&within));
        }
    }
}

#[test]
fn domains_exclude_exactly_the_codes_without_a_value() {
    domains_exclude_on::<Biodivine>();
    domains_exclude_on::<SharedStore>();
}

fn quantifying_and_renaming_on<K: Kernel>() {
    let m: K = kernel(3);
    let v = |i: u16| m.literal(Bit(i), true);
    let f = m.and(&v(0), &m.or(&v(2), &v(4)).unwrap()).unwrap();
    let primed = m.prime(&f).unwrap();
    assert_eq!(m.support(&primed), [Bit(1), Bit(3), Bit(5)]);
    assert!(m.unprime(&primed).unwrap() == f);
    let bits = BitSet::new([Bit(2), Bit(4)]);
    assert!(m.exists(&f, &bits).unwrap() == v(0));
    assert!(m.is_false(&m.forall(&f, &bits).unwrap()));
    let fused = m.and_exists(&f, &v(2), &BitSet::new([Bit(2)])).unwrap();
    assert!(fused == v(0));
    let witness = m.witness(&f).unwrap();
    assert!(witness[0] && (witness[2] || witness[4]));
    assert!(m.witness(&m.constant(false)).is_none());

    let past = Limits {
        deadline: linewright_core::deadline::Deadline::from_now(std::time::Duration::ZERO),
        ..Limits::default()
    };
    assert!(
        m.with_limits(&past).and(&f, &v(1))
            == Err(Limit::Stopped(linewright_core::deadline::StopReason::Time))
    );
    drop((f, primed, fused));
    assert!(m.peak_nodes() > 0);
}

#[test]
fn quantifying_renaming_and_the_time_limit() {
    quantifying_and_renaming_on::<Biodivine>();
    quantifying_and_renaming_on::<SharedStore>();
}

/// `(x0 = x1') ∧ (x1 = x2') ∧ …`, shifted: its size depends on the order.
fn chain<K: Kernel>(m: &K, pairs: u16) -> K::Function {
    let half = pairs / 2;
    let mut result = m.constant(true);
    for i in 0..half {
        let (a, b) = (
            m.literal(Bit(2 * i), true),
            m.literal(Bit(2 * (i + half)).primed(), true),
        );
        result = m.and(&result, &m.iff(&a, &b).unwrap()).unwrap();
    }
    result
}

fn fills<K: Kernel>(limits: &Limits) -> bool {
    let m = K::new(&Order::natural(40), limits).unwrap();
    let half = 20u16;
    let mut result = m.constant(true);
    for i in 0..half {
        let (a, b) = (
            m.literal(Bit(2 * i), true),
            m.literal(Bit(2 * (i + half)).primed(), true),
        );
        let Ok(same) = m.iff(&a, &b) else { return true };
        match m.and(&result, &same) {
            Ok(both) => result = both,
            Err(limit) => return limit == Limit::Memory,
        }
    }
    false
}

#[test]
fn out_of_nodes_is_a_value() {
    let few = Limits {
        max_nodes: Some(70_000),
        ..Limits::default()
    };
    assert!(fills::<Biodivine>(&few));
    assert!(fills::<SharedStore>(&few));
}

/// Makes a function that is large in this order, sifts, and quantifies. Returns the work, and the
/// result within the limit.
fn work_within<K: Kernel>(most: u64) -> (u64, Result<(), Limit>) {
    let limits = Limits {
        max_work: Some(most),
        ..small()
    };
    let m = K::new(&Order::natural(24), &limits).unwrap();
    let ends = || {
        let mut all = m.constant(true);
        for i in 0..12 {
            let (a, b) = (
                m.literal(Bit(2 * i), true),
                m.literal(Bit(2 * (i + 12)).primed(), true),
            );
            all = m.and(&all, &m.iff(&a, &b)?)?;
        }
        m.sift()?;
        let bits = BitSet::new((0..8).map(|b| Bit(2 * b)));
        m.exists(&all, &bits).map(drop)
    };
    let ends = ends();
    (m.work(), ends)
}

/// The total work, and the result with half of it.
fn work_on<K: Kernel>() -> (u64, (u64, Result<(), Limit>)) {
    let (whole, ends) = work_within::<K>(u64::MAX);
    assert_eq!(ends, Ok(()));
    assert!(whole > 1_000, "{whole}");
    let half = work_within::<K>(whole / 2);
    assert_eq!(half.1, Err(Limit::Work(whole / 2)));
    (whole, half)
}

/// On several threads that disturb one another, the count and the point of failure are the same.
#[test]
fn work_is_counted_alike_whatever_else_goes_on() {
    fn alike<K: Kernel>() {
        let alone = work_on::<K>();
        std::thread::scope(|scope| {
            let threads: Vec<_> = (0..4).map(|_| scope.spawn(work_on::<K>)).collect();
            for thread in threads {
                assert_eq!(thread.join().unwrap(), alone, "{}", K::NAME);
            }
        });
    }
    alike::<Biodivine>();
    alike::<SharedStore>();
}

/// Near a node limit, the package's own collector must not decide whether an operation fits.
#[test]
fn room_for_nodes_is_the_same_every_time() {
    let mut seen = [false; 2];
    for most in [30_000, 90_000, 240_000] {
        let limits = Limits {
            max_nodes: Some(most),
            max_work: Some(u64::MAX),
            ..Limits::default()
        };
        let once = || {
            let m = SharedStore::new(&Order::natural(34), &limits).unwrap();
            let ends = (0..17).try_fold(m.constant(true), |all, i| {
                let a = m.literal(Bit(2 * i), true);
                let b = m.literal(Bit(2 * (i + 17)).primed(), true);
                m.and(&all, &m.iff(&a, &b)?)
            });
            (ends.map(|f| m.size(&f)), m.work())
        };
        let first = once();
        for _ in 0..2 {
            assert_eq!(once(), first, "{most}");
        }
        seen[usize::from(first.0.is_ok())] = true;
    }
    assert!(seen[0], "{seen:?}");
}

#[test]
fn the_factor_scales_budgets_and_tighter_limits_stay() {
    let budget = Budget {
        work: 1_000,
        nodes: 50,
    };
    let with_factor = |factor| Limits {
        budget_factor: BudgetFactor::new(factor).unwrap(),
        ..Limits::default()
    };
    let of = |limits: &Limits| (limits.max_work.unwrap(), limits.max_nodes.unwrap());
    assert_eq!(of(&Limits::default().with_budget(budget)), (1_000, 50));
    assert_eq!(of(&with_factor(10.0).with_budget(budget)), (10_000, 500));
    assert_eq!(of(&with_factor(0.001).with_budget(budget)), (1, 1));
    assert_eq!(
        of(&with_factor(1e300).with_budget(budget)),
        (u64::MAX, u64::MAX)
    );
    let tight = Limits {
        max_work: Some(7),
        ..with_factor(10.0)
    };
    assert_eq!(of(&tight.with_budget(budget)), (7, 500));
    for wrong in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(BudgetFactor::new(wrong), None);
    }
    let limits = Limits::default().with_budget(budget);
    assert_eq!(limits.attribute(Limit::Memory), Limit::Nodes(50));
    assert_eq!(limits.attribute(Limit::Size), Limit::Size);
    let small = Limits {
        memory_mib: Some(0),
        ..limits
    };
    assert_eq!(small.attribute(Limit::Memory), Limit::Memory);
}

#[test]
fn sifting_finds_the_small_order_and_keeps_every_function() {
    let m = SharedStore::new(&Order::natural(24), &small()).unwrap();
    let f = chain(&m, 24);
    let other = m.and_not(&f, &m.literal(Bit(3), true)).unwrap();
    let before = m.size(&f);
    let diagram = m.export(&[&f, &other]);
    m.sift().unwrap();
    assert!(m.size(&f) * 20 < before, "{} of {before}", m.size(&f));
    assert!(m.and_not(&f, &m.literal(Bit(3), true)).unwrap() == other);
    assert!(chain(&m, 24) == f);
    let order = m.order();
    assert!(Order::new(order.pairs().to_vec()).is_some());

    // The order is passed to the other kernel, and so are the functions, in whatever order they
    // were exported.
    let b = Biodivine::new(&order, &small()).unwrap();
    assert!(b.size(&chain(&b, 24)) < before / 10);
    let imported = b.import(&diagram).unwrap();
    assert!(imported[0] == chain(&b, 24));
    let back = m.import(&b.export(&[&imported[0], &imported[1]])).unwrap();
    assert!(back[0] == f && back[1] == other);
}

/// All functions of four bits, by their truth tables, through every operation of both kernels.
#[test]
fn both_kernels_agree_with_truth_tables() {
    fn on<K: Kernel>() {
        let m: K = kernel(2);
        let bits: Vec<K::Function> = (0..4).map(|b| m.literal(Bit(b), true)).collect();
        let minterm = |row: u16| {
            let values: Vec<(Bit, bool)> = (0..4).map(|b| (Bit(b), row >> b & 1 == 1)).collect();
            m.cube(&values).unwrap()
        };
        let minterms: Vec<K::Function> = (0..16).map(minterm).collect();
        let function = |table: u16| {
            (0..16)
                .filter(|row| table >> row & 1 == 1)
                .fold(m.constant(false), |f, row| {
                    m.or(&f, &minterms[row]).unwrap()
                })
        };
        let table = |f: &K::Function| -> u16 {
            let diagram = m.export(&[f]);
            assert!(diagram.is_sound(4));
            (0..16u16)
                .filter(|row| {
                    let values: Vec<bool> = (0..4).map(|b| row >> b & 1 == 1).collect();
                    diagram.evaluate(0, &values)
                })
                .fold(0, |t, row| t | 1 << row)
        };
        let gone = BitSet::new([Bit(1), Bit(2)]);
        let exists = |t: u16| {
            (0..16u16)
                .filter(|row| [0, 2, 4, 6].iter().any(|flip| t >> (row ^ flip) & 1 == 1))
                .fold(0, |r, row| r | 1 << row)
        };
        let tables: Vec<u16> = (0..64)
            .map(|i: u16| i.wrapping_mul(40503) ^ i << 7)
            .collect();
        for a in &tables {
            let fa = function(*a);
            assert_eq!(table(&fa), *a);
            assert_eq!(table(&m.not(&fa).unwrap()), !a);
            assert_eq!(table(&m.exists(&fa, &gone).unwrap()), exists(*a));
            assert_eq!(table(&m.forall(&fa, &gone).unwrap()), !exists(!a));
            for b in &tables {
                let fb = function(*b);
                assert_eq!(table(&m.and(&fa, &fb).unwrap()), a & b);
                assert_eq!(table(&m.or(&fa, &fb).unwrap()), a | b);
                assert_eq!(table(&m.and_not(&fa, &fb).unwrap()), a & !b);
                assert_eq!(table(&m.xor(&fa, &fb).unwrap()), a ^ b);
                assert_eq!(table(&m.iff(&fa, &fb).unwrap()), !(a ^ b));
                assert_eq!(table(&m.implies(&fa, &fb).unwrap()), !a | b);
                assert_eq!(
                    table(&m.and_exists(&fa, &fb, &gone).unwrap()),
                    exists(a & b)
                );
                assert_eq!(
                    table(&m.implies_forall(&fa, &fb, &gone).unwrap()),
                    !exists(a & !b)
                );
                let chosen = m.ite(&bits[0], &fa, &fb).unwrap();
                assert_eq!(table(&chosen), a & 0xaaaa | b & 0x5555);
            }
        }
    }
    on::<Biodivine>();
    on::<SharedStore>();
}

/// A deadline ends an operation that would take hours, and leaves all functions as they were.
#[test]
fn a_deadline_ends_an_operation() {
    use linewright_core::deadline::{Deadline, StopReason};

    let m = SharedStore::new(&Order::natural(60), &Limits::default()).unwrap();
    // Each sum has about 2^15 nodes in this order; their conjunction has 2^30.
    let sum = |range: std::ops::Range<u16>| {
        range.fold(m.constant(false), |sum, i| {
            let a = m.literal(Bit(2 * i), true);
            let b = m.literal(Bit(2 * (i + 30)), true);
            m.xor(&sum, &m.and(&a, &b).unwrap()).unwrap()
        })
    };
    let (a, b) = (sum(0..15), sum(15..30));
    let before = m.export(&[&a, &b]);
    let late = m.with_limits(&Limits {
        deadline: Deadline::from_now(std::time::Duration::from_millis(100)),
        ..Limits::default()
    });
    assert_eq!(late.and(&a, &b), Err(Limit::Stopped(StopReason::Time)));
    assert_eq!(m.export(&[&a, &b]), before);
}
