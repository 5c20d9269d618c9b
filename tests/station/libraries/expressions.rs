//! Random expressions, computed by emitted C and by direct evaluation.
//!
//! All functions of a test go into one C file, warnings are errors, and the program prints its
//! results.

#![expect(clippy::float_cmp, reason = "the two must agree to the last bit")]

use crate::differential::Random;
use crate::fixtures::op;
use linewright::contract::machine::{RealBinary, RealExpr, RealUnary};
use linewright::gr1::interval::{Interval, interval};
use linewright::gr1::{BinaryOp, Expr, Time, UnaryOp, VarId, eval};
use linewright::station::emit::expression;
use std::fmt::Write;
use std::process::Command;

/// Variables 0 to 2 are integers, 3 and 4 are booleans.
const VARIABLES: u32 = 5;
const RANGES: [(i64, i64); 5] = [(-3, 4), (0, 6), (1, 3), (0, 1), (0, 1)];

fn variable(random: &mut Random, from: u32, to: u32) -> Expr {
    let time = if random.below(2) == 0 {
        Time::Now
    } else {
        Time::Next
    };
    Expr::Var(
        VarId(from + random.below(u64::from(to - from)) as u32),
        time,
    )
}

fn truth(random: &mut Random, depth: u32) -> Expr {
    if depth == 0 {
        return match random.below(8) {
            0 => Expr::TRUE,
            1 => Expr::FALSE,
            _ => variable(random, 3, VARIABLES),
        };
    }
    let d = depth - 1;
    let connectives = [
        BinaryOp::And,
        BinaryOp::Or,
        BinaryOp::Implies,
        BinaryOp::Eq,
        BinaryOp::Ne,
    ];
    let comparisons = [
        BinaryOp::Eq,
        BinaryOp::Ne,
        BinaryOp::Lt,
        BinaryOp::Le,
        BinaryOp::Gt,
        BinaryOp::Ge,
    ];
    match random.below(11) {
        0..=3 => op(
            connectives[random.below(5) as usize],
            truth(random, d),
            truth(random, d),
        ),
        4..=6 => op(
            comparisons[random.below(6) as usize],
            number(random, d),
            number(random, d),
        ),
        7 => truth(random, d).not(),
        8 => Expr::If(
            Box::new(truth(random, d)),
            Box::new(truth(random, d)),
            Box::new(truth(random, d)),
        ),
        9 => {
            // Equal sides but for the order of the operands, of which compilers warn.
            let commutes = [BinaryOp::Add, BinaryOp::Mul, BinaryOp::Min, BinaryOp::Max];
            let sign = commutes[random.below(4) as usize];
            let (a, b) = (number(random, 0), number(random, 0));
            op(
                comparisons[random.below(6) as usize],
                op(sign, a.clone(), b.clone()),
                op(sign, b, a),
            )
        }
        _ => {
            // A chain, which must not nest.
            let sign = connectives[random.below(2) as usize];
            (0..4)
                .map(|_| truth(random, 0))
                .reduce(|a, b| op(sign, a, b))
                .unwrap()
        }
    }
}

fn number(random: &mut Random, depth: u32) -> Expr {
    if depth == 0 {
        return match random.below(10) {
            0 => Expr::Const(random.below(1 << 40) as i64 - (1 << 39)),
            1..=4 => Expr::Const(random.below(13) as i64 - 6),
            _ => variable(random, 0, 3),
        };
    }
    let d = depth - 1;
    let plain = [
        BinaryOp::Add,
        BinaryOp::Sub,
        BinaryOp::Mul,
        BinaryOp::Min,
        BinaryOp::Max,
    ];
    match random.below(12) {
        0..=5 => op(
            plain[random.below(5) as usize],
            number(random, d),
            number(random, d),
        ),
        6..=7 => {
            let divisors = [-7, -3, -2, -1, 1, 2, 5];
            let divisor = Expr::Const(divisors[random.below(7) as usize]);
            let sign = [BinaryOp::Div, BinaryOp::Mod][random.below(2) as usize];
            op(sign, number(random, d), divisor)
        }
        8 => Expr::Unary(UnaryOp::Neg, Box::new(number(random, d))),
        9 => Expr::Unary(UnaryOp::Abs, Box::new(number(random, d))),
        10 => Expr::If(
            Box::new(truth(random, d)),
            Box::new(number(random, d)),
            Box::new(number(random, d)),
        ),
        // A truth value as a number, as in arithmetic over booleans.
        _ => truth(random, d),
    }
}

/// Compiles one file with all warnings as errors, runs it, and returns its lines.
fn run(source: &str) -> Vec<String> {
    let folder = tempfile::tempdir().unwrap();
    let profile = linewright::station::profile::Profile::assumed();
    for (name, text) in linewright::station::package::support(&profile) {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let file = folder.path().join("expressions.c");
    std::fs::write(&file, source).unwrap();
    let program = folder.path().join("expressions");
    let compiled = Command::new("cc")
        .args([
            "-std=c99",
            "-Wall",
            "-Wextra",
            "-Wconversion",
            "-Werror",
            "-O1",
            "-ffp-contract=off",
        ])
        .arg(&file)
        .arg("-o")
        .arg(&program)
        .arg("-lm")
        .output()
        .unwrap();
    let errors = String::from_utf8_lossy(&compiled.stderr);
    assert!(
        compiled.status.success(),
        "{}",
        errors.chars().take(3000).collect::<String>()
    );
    let output = Command::new(&program).output().unwrap();
    assert!(output.status.success());
    let text = String::from_utf8(output.stdout).unwrap();
    text.lines().map(str::to_owned).collect()
}

/// The helpers come from the header of the emitted machines.
fn prelude() -> String {
    let sizes = [
        "COMPONENTS",
        "PLANT",
        "OUTPUTS",
        "VALUES",
        "PROPERTIES",
        "OPERATIONS",
        "JUSTICE",
        "HANDLE_MARK",
    ];
    let sizes = sizes.map(|s| format!("#define LW_{s} 1\n")).concat();
    format!("#define LW_NUMBER int64_t\n{sizes}#include \"machine.h\"\n#include <stdio.h>\n\n")
}

#[test]
fn integer_expressions_mean_the_same_in_c() {
    let mut random = Random(42);
    let ranges = |v: VarId| Interval {
        low: RANGES[v.index()].0,
        high: RANGES[v.index()].1,
    };
    let mut cases = Vec::new();
    while cases.len() < 600 {
        let depth = 1 + (cases.len() % 5) as u32;
        let boolean = cases.len() % 2 == 0;
        let expr = if boolean {
            truth(&mut random, depth)
        } else {
            number(&mut random, depth)
        };
        // As in the resolver: nothing that could exceed an i64.
        if interval(&expr, &ranges).is_ok() {
            cases.push((boolean, expr));
        }
    }
    let samples: Vec<[Vec<i64>; 2]> = (0..40)
        .map(|_| {
            let mut draw = || {
                RANGES
                    .iter()
                    .map(|(l, h)| l + random.below((h - l + 1) as u64) as i64)
                    .collect()
            };
            [draw(), draw()]
        })
        .collect();
    let name = |v: VarId, t: Time| {
        let array = if t == Time::Now {
            "previous"
        } else {
            "current"
        };
        format!("{array}[{}]", v.index())
    };
    let mut source = prelude();
    for (i, (boolean, expr)) in cases.iter().enumerate() {
        let text = if *boolean {
            expression::truth(expr, &name)
        } else {
            expression::integer(expr, &name)
        };
        let _ = writeln!(
            source,
            "static int64_t f{i}(const int64_t *previous, const int64_t *current)\n{{\n    (void)previous;\n    (void)current;\n    return {text};\n}}"
        );
    }
    source.push_str("int main(void)\n{\n");
    let list = |values: &[i64]| {
        values
            .iter()
            .map(i64::to_string)
            .collect::<Vec<_>>()
            .join(", ")
    };
    let rows: Vec<String> = samples
        .iter()
        .map(|[a, b]| format!("{{ {{ {} }}, {{ {} }} }}", list(a), list(b)))
        .collect();
    let _ = writeln!(
        source,
        "    static const int64_t samples[][2][5] = {{ {} }};",
        rows.join(", ")
    );
    let _ = writeln!(source, "    for (int s = 0; s < {}; s++) {{", samples.len());
    for i in 0..cases.len() {
        let _ = writeln!(
            source,
            "        printf(\"%lld\\n\", (long long)f{i}(samples[s][0], samples[s][1]));"
        );
    }
    source.push_str("    }\n    return 0;\n}\n");
    let mut lines = run(&source).into_iter();
    for [now, next] in &samples {
        for (i, (_, expr)) in cases.iter().enumerate() {
            let expected = eval::eval(expr, now, next);
            assert_eq!(
                lines.next(),
                Some(expected.to_string()),
                "f{i}: {expr:?} on {now:?} {next:?}"
            );
        }
    }
    assert_eq!(lines.next(), None);
}

fn real(random: &mut Random, depth: u32) -> RealExpr {
    if depth == 0 {
        return match random.below(6) {
            0 | 1 => RealExpr::Number(
                [0.1, -2.5, 1e-300, 3.0, 90.0, 1e22, 0.0, -0.0, 1.0 / 3.0]
                    [random.below(9) as usize],
            ),
            2 => RealExpr::Wire(random.below(2) as usize),
            3 => RealExpr::Number(f64::from_bits(random.next() >> 1) % 1e6),
            _ => RealExpr::Property(random.below(3) as usize),
        };
    }
    let d = depth - 1;
    let unary = [
        RealUnary::Not,
        RealUnary::Neg,
        RealUnary::Abs,
        RealUnary::Floor,
        RealUnary::Ceil,
        RealUnary::Round,
    ];
    let binary = [
        RealBinary::And,
        RealBinary::Or,
        RealBinary::Implies,
        RealBinary::Eq,
        RealBinary::Ne,
        RealBinary::Lt,
        RealBinary::Le,
        RealBinary::Gt,
        RealBinary::Ge,
        RealBinary::Add,
        RealBinary::Sub,
        RealBinary::Mul,
        RealBinary::Div,
        RealBinary::Mod,
        RealBinary::Min,
        RealBinary::Max,
    ];
    match random.below(8) {
        0 | 1 => RealExpr::Unary(unary[random.below(6) as usize], Box::new(real(random, d))),
        2 => RealExpr::If(
            Box::new(real(random, d)),
            Box::new(real(random, d)),
            Box::new(real(random, d)),
        ),
        _ => RealExpr::Binary(
            binary[random.below(16) as usize],
            Box::new(real(random, d)),
            Box::new(real(random, d)),
        ),
    }
}

#[test]
fn real_expressions_mean_the_same_in_c() {
    let mut random = Random(43);
    let cases: Vec<RealExpr> = (0..600_u32).map(|i| real(&mut random, i % 5)).collect();
    let samples = [
        ([0.0, 1.0, 0.3], [0, 1]),
        ([-0.5, 2.5, 90.0], [-3, 7]),
        ([1e308, -1e-310, 180.000_000_1], [1 << 40, -1]),
        ([-1.5, 1.5, 7.25], [2, 0]),
    ];
    let mut source = prelude();
    let names = ["0".to_owned(), "1".to_owned()];
    for (i, expr) in cases.iter().enumerate() {
        let _ = writeln!(
            source,
            "static double f{i}(const double *properties, const int64_t *values)\n{{\n    (void)properties;\n    (void)values;\n    return {};\n}}",
            expression::real(expr, &names)
        );
    }
    source.push_str("static void show(double x)\n{\n    uint64_t bits;\n    union { double real; uint64_t bits; } u;\n    u.real = x;\n    bits = u.bits;\n    printf(\"%016llx\\n\", (unsigned long long)bits);\n}\n\nint main(void)\n{\n");
    for (properties, wires) in &samples {
        let p: Vec<String> = properties
            .iter()
            .map(|p| expression::real_literal(*p))
            .collect();
        let w: Vec<String> = wires.iter().map(|w| expression::literal(*w)).collect();
        let _ = writeln!(
            source,
            "    {{\n        const double p[] = {{ {} }};\n        const int64_t w[] = {{ {} }};",
            p.join(", "),
            w.join(", ")
        );
        for i in 0..cases.len() {
            let _ = writeln!(source, "        show(f{i}(p, w));");
        }
        source.push_str("    }\n");
    }
    source.push_str("    return 0;\n}\n");
    let mut lines = run(&source).into_iter();
    let mut nans = 0;
    for (properties, wires) in &samples {
        for (i, expr) in cases.iter().enumerate() {
            let expected = expr.eval(properties, wires);
            let got = f64::from_bits(u64::from_str_radix(&lines.next().unwrap(), 16).unwrap());
            nans += usize::from(expected.is_nan());
            // Which of two zeros a minimum returns is not specified, nor are the bits of a NaN.
            let same = expected == got || (expected.is_nan() && got.is_nan());
            assert!(same, "f{i}: {expr:?} is {expected:?} here and {got:?} in C");
        }
    }
    assert!(nans > 0, "what is not a number is part of the test");
}

#[test]
fn numbers_survive_the_way_through_c() {
    let mut random = Random(44);
    for _ in 0..100_000 {
        let value = f64::from_bits(random.next());
        if value.is_finite() {
            let text = expression::real_literal(value);
            let inner = text.trim_start_matches('(').trim_end_matches(')');
            assert_eq!(
                inner.parse::<f64>().unwrap().to_bits(),
                value.to_bits(),
                "{text}"
            );
            assert!(text.contains(['.', 'e']), "{text} is a double in C");
        }
    }
}
