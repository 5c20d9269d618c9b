//! Expressions that the program prints (suggestions, counterstrategies, tables) are read again as
//! the same.

use linewright::contract::load;
use linewright::diagnostics::Severity;
use linewright::gr1::{BinaryOp, Expr, Specification, Time, UnaryOp, VarId, eval, text};
use std::fmt::Write as _;

/// Variables of all kinds of domains, and `r`, to which each formula is compared.
const HEADER: &str = "\
type Colour = {red, green, blue}
contract Test {
    input p, q: bool
    input n: 0..3
    input c: Colour
    input t: 0..3 s
    output r: bool
";

fn read(text: &str) -> Specification {
    let files = [("test.lw".to_owned(), text.to_owned())];
    let (library, findings) = load(&files, &|_, _| Err("no imports".to_owned()));
    let errors: Vec<_> = findings
        .iter()
        .filter(|f| f.severity == Severity::Error)
        .collect();
    assert!(errors.is_empty(), "{text}\n{errors:#?}");
    (*library.contracts[0].specification).clone()
}

/// Draws typed expressions; the same seed gives the same ones.
struct Draw(u64);

impl Draw {
    fn pick(&mut self, n: u64) -> u64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (self.0 >> 33) % n
    }

    fn binary(&mut self, ops: &[BinaryOp], a: Expr, b: Expr) -> Expr {
        Expr::binary(ops[self.pick(ops.len() as u64) as usize], a, b)
    }

    fn truth(&mut self, depth: usize) -> Expr {
        use BinaryOp as B;
        if depth == 0 {
            return match self.pick(3) {
                0 => Expr::Const(self.pick(2) as i64),
                v => Expr::Var(VarId(v as u32 - 1), Time::Now),
            };
        }
        let less = depth - 1;
        match self.pick(6) {
            0 => Expr::Unary(UnaryOp::Not, Box::new(self.truth(less))),
            1 => {
                let (a, b) = (self.truth(less), self.truth(less));
                self.binary(&[B::And, B::Or, B::Implies], a, b)
            }
            2 | 3 => {
                let (a, b) = (self.truth(less), self.truth(less));
                self.binary(&[B::Eq, B::Ne], a, b)
            }
            4 => Expr::If(
                Box::new(self.truth(less)),
                Box::new(self.truth(less)),
                Box::new(self.truth(less)),
            ),
            _ => {
                // A number, a label, or a number of seconds: with a variable on one side at least.
                let variable = 2 + self.pick(3) as u32;
                let a = Expr::Var(VarId(variable), Time::Now);
                let b = match self.pick(3) {
                    0 if variable == 2 => self.number(less),
                    1 => Expr::Var(VarId(variable), Time::Now),
                    _ => Expr::Const(self.pick(3) as i64),
                };
                let ops = [B::Eq, B::Ne, B::Lt, B::Le, B::Gt, B::Ge];
                // Labels have no order.
                let ops = if variable == 3 { &ops[..2] } else { &ops[..] };
                if self.pick(2) == 0 {
                    self.binary(ops, a, b)
                } else {
                    self.binary(ops, b, a)
                }
            }
        }
    }

    fn number(&mut self, depth: usize) -> Expr {
        use BinaryOp as B;
        if depth == 0 {
            return match self.pick(2) {
                0 => Expr::Const(self.pick(7) as i64 - 3),
                _ => Expr::Var(VarId(2), Time::Now),
            };
        }
        let less = depth - 1;
        match self.pick(4) {
            0 => Expr::Unary(
                [UnaryOp::Neg, UnaryOp::Abs][self.pick(2) as usize],
                Box::new(self.number(less)),
            ),
            1 => Expr::If(
                Box::new(self.truth(less)),
                Box::new(self.number(less)),
                Box::new(self.number(less)),
            ),
            _ => {
                let (a, b) = (self.number(less), self.number(less));
                self.binary(&[B::Add, B::Sub, B::Mul, B::Min, B::Max], a, b)
            }
        }
    }
}

#[test]
fn printed_expressions_are_read_as_the_same() {
    let plain = read(&format!("{HEADER}    guarantee g: always r\n}}\n"));
    let mut draw = Draw(7);
    for batch in 0..60 {
        let drawn: Vec<Expr> = (0..50).map(|i| draw.truth(1 + i % 3)).collect();
        let mut source = HEADER.to_owned();
        for (i, expr) in drawn.iter().enumerate() {
            let printed = text::text(&plain, expr);
            let _ = writeln!(source, "    guarantee g{i}: always (({printed}) <-> r)");
        }
        source += "}\n";
        let again = read(&source);
        let formulas = &again.guarantees.invariants;
        for (i, expr) in drawn.iter().enumerate() {
            let name = format!("g{i}");
            let found = formulas.iter().find(|f| f.name == name);
            let found = &found.unwrap_or_else(|| panic!("{name} in {source}")).expr;
            for seed in 0..32 {
                let mut values: Vec<i64> = vec![draw.pick(2) as i64, draw.pick(2) as i64];
                values.extend([4, 3, 4, 2].map(|n| draw.pick(n) as i64));
                let meant = eval::holds(expr, &values, &[]) == (values[5] == 1);
                assert_eq!(
                    eval::holds(found, &values, &[]),
                    meant,
                    "batch {batch}, seed {seed}: {} with {values:?}",
                    text::text(&plain, expr)
                );
            }
        }
    }
}
