//! Prints a specification as a contract in Linewright's own language. Both have the same verdict.
//!
//! A transition formula that refers to current values only is weaker than an invariant: it has to
//! hold only in steps that have a successor. The language expresses this with `next true -> ...`.
//! The writer omits this prefix if no safety assumption restricts the environment's moves, because
//! every step has a successor then. It replaces names that the language does not allow, and lists
//! them in comments.

use super::write::is_truth;
use super::{Format, labels};
use linewright_core::gr1::{
    BinaryOp, Domain, Expr, Formula, Owner, Side, Specification, Time, Timing, UnaryOp,
};
use linewright_core::rename::renamed;
use linewright_core::source::FileId;
use linewright_syntax::{format, is_reserved, parse};
use std::fmt::Write as _;

/// Maximum number of operands in one chain of `and` or `or`; longer chains are grouped in
/// parentheses.
const CHAIN: usize = 100;
/// Nesting depth from which a subexpression becomes a `define`.
const DEEP: usize = 40;

/// Names that the language allows but that look like a function or a type. They are replaced, too.
const MISLEADING: [&str; 5] = ["min", "max", "abs", "bool", "array"];

fn is_name(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        && !is_reserved(name)
        && !MISLEADING.contains(&name)
}

/// Prints `specification` as a contract.
///
/// `origin` is the text of the comment in the first line; the function [`origin`] composes it.
pub fn write(specification: &Specification, origin: &str) -> String {
    let variables = specification.variables.iter().map(|v| v.name.as_str());
    let name = renamed([specification.name.as_str()], "Contract", is_name)
        .pop()
        .unwrap_or_else(|| "Contract".to_owned());
    let formulas = || {
        let sides = [&specification.assumptions, &specification.guarantees];
        sides.into_iter().flat_map(Side::all)
    };
    // Variables, formulas, labels and defines get distinct names, so that readers cannot confuse
    // them.
    let all: Vec<&str> = variables
        .chain(formulas().map(|f| f.name.as_str()))
        .collect();
    let mut names = renamed(all, "v_", is_name);
    let formula_names = names.split_off(specification.variables.len());
    let used: Vec<String> = names.iter().chain(&formula_names).cloned().collect();
    let kept = labels::kept(specification, &|l| {
        is_name(l) && !used.iter().any(|name| name == l)
    });
    let words = kept.iter().flatten().flat_map(|labels| labels.iter());
    let mut printer = Printer {
        specification,
        names: &names,
        labels: &kept,
        used: used.iter().chain(words).cloned().collect(),
        defines: Vec::new(),
    };
    let mut body = String::new();
    let mut formula_names = formula_names.into_iter();
    let assumptions = &specification.assumptions;
    let has_successor = assumptions.safety.is_empty() && assumptions.invariants.is_empty();
    for (keyword, side) in [
        ("assume", &specification.assumptions),
        ("guarantee", &specification.guarantees),
    ] {
        let mut lines = String::new();
        for (temporal, formulas) in [
            ("", &side.initial),
            ("always ", &side.invariants),
            ("always transition", &side.safety),
            ("always eventually ", &side.justice),
        ] {
            for formula in formulas {
                let name = formula_names.next().unwrap_or_default();
                let text = printer.formula(formula);
                let text = match temporal {
                    "" => text,
                    "always transition" if has_successor || formula.expr.mentions_next() => {
                        format!("always ({text})")
                    }
                    "always transition" => format!("always (next true -> ({text}))"),
                    temporal => format!("{temporal}({text})"),
                };
                let _ = writeln!(lines, "    {keyword} {name}: {text}");
            }
        }
        if !lines.is_empty() {
            body.push('\n');
            body.push_str(&lines);
        }
    }
    let mut text = format!("// {}\n", super::names::one_line(origin));
    for ((variable, name), kept) in specification.variables.iter().zip(&names).zip(&kept) {
        if *name != variable.name {
            let _ = writeln!(text, "// renamed: {} is {name} here", variable.name);
        }
        if let (Domain::Enum { labels, .. }, None) = (&variable.domain, kept) {
            let labels = labels.iter().enumerate().map(|(i, l)| format!("{i} {l}"));
            let _ = writeln!(
                text,
                "// {name} is numbered: {}",
                labels.collect::<Vec<_>>().join(", ")
            );
        }
    }
    let moore = if specification.timing == Timing::Moore {
        "moore "
    } else {
        ""
    };
    let _ = writeln!(text, "{moore}contract {name} {{");
    for ((variable, name), kept) in specification.variables.iter().zip(&names).zip(&kept) {
        let owner = match (variable.owner, variable.internal) {
            (Owner::Environment, _) => "input",
            (Owner::System, false) => "output",
            (Owner::System, true) => "internal",
        };
        let domain = match (&variable.domain, kept) {
            (Domain::Bool, _) => "bool".to_owned(),
            (_, Some(labels)) => format!("{{{}}}", labels.join(", ")),
            (domain, None) => format!("{}..{}", domain.low(), domain.high()),
        };
        let _ = writeln!(text, "    {owner} {name}: {domain}");
    }
    if !printer.defines.is_empty() {
        text.push('\n');
    }
    for (name, define) in &printer.defines {
        let _ = writeln!(text, "    define {name} = {define}");
    }
    text.push_str(&body);
    text.push_str("}\n");
    formatted(text)
}

/// Formats the text as `fmt` does. Returns it unchanged if the parser rejects it as too deeply
/// nested.
fn formatted(text: String) -> String {
    let (file, findings) = parse(FileId::default(), &text);
    if !findings.is_empty() {
        return text;
    }
    format::format_checked(&file, &text).unwrap_or(text)
}

/// The text of the comment that names the imported file and the tool of its format.
pub fn origin(file: &str, format: Format) -> String {
    format!(
        "Imported from {file}, a specification for {}.",
        format.tool()
    )
}

struct Printer<'s> {
    specification: &'s Specification,
    names: &'s [String],
    /// For each variable, the labels that its values are printed with; `None` if they are printed
    /// as numbers or truth values.
    labels: &'s [Option<&'s [String]>],
    used: Vec<String>,
    defines: Vec<(String, String)>,
}

/// A printed expression.
struct Printed {
    text: String,
    depth: usize,
    /// How tightly the text binds. This decides where it needs parentheses.
    binds: Binds,
}

/// How tightly an expression binds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Binds {
    /// The expression needs parentheses unless it is a whole formula.
    Loosely,
    /// A comparison or a negation: needs no parentheses as an operand of `and`, `or` or `->`.
    AsOperand,
    /// Needs no parentheses as an operand of any operator.
    Tightly,
}

impl Printer<'_> {
    fn formula(&mut self, formula: &Formula) -> String {
        self.print(&formula.expr, true).text
    }

    /// Prints a subexpression: in parentheses if it binds more loosely than `wanted`, or as the
    /// name of a `define` if it nests too deeply.
    fn part(&mut self, expr: &Expr, truth: bool, wanted: Binds) -> Printed {
        let printed = self.print(expr, truth);
        if printed.depth >= DEEP {
            let name = self.define(printed.text);
            return Printed {
                text: name,
                depth: 0,
                binds: Binds::Tightly,
            };
        }
        if printed.binds >= wanted {
            return printed;
        }
        Printed {
            text: format!("({})", printed.text),
            depth: printed.depth + 1,
            binds: Binds::Tightly,
        }
    }

    fn define(&mut self, text: String) -> String {
        let taken = |name: &String| self.used.contains(name);
        let mut number = self.defines.len() + 1;
        let mut name = format!("part_{number}");
        while taken(&name) {
            number += 1;
            name = format!("part_{number}_");
        }
        self.used.push(name.clone());
        self.defines.push((name.clone(), text));
        name
    }

    /// Prints an expression. Its constants are truth values if `truth` is set, otherwise numbers.
    /// The recursion is as deep as the expression.
    fn print(&mut self, expr: &Expr, truth: bool) -> Printed {
        use BinaryOp as B;
        let leaf = |text: String| Printed {
            text,
            depth: 0,
            binds: Binds::Tightly,
        };
        let s = self.specification;
        match expr {
            Expr::Const(value) if truth => leaf((*value != 0).to_string()),
            Expr::Const(value) if *value < 0 => leaf(format!("(0 - {})", value.unsigned_abs())),
            Expr::Const(value) => leaf(value.to_string()),
            Expr::Var(v, time) => {
                let name = &self.names[v.index()];
                let text = match time {
                    Time::Now => name.clone(),
                    Time::Next => format!("next {name}"),
                };
                // A Boolean operand of arithmetic becomes a number, because the language does not
                // convert it.
                if s.variable(*v).domain == Domain::Bool && !truth {
                    return Printed {
                        text: format!("(if {text} then 1 else 0)"),
                        depth: 2,
                        binds: Binds::Tightly,
                    };
                }
                leaf(text)
            }
            Expr::Unary(UnaryOp::Not, a) => {
                let a = self.part(a, true, Binds::Tightly);
                Printed {
                    text: format!("not {}", a.text),
                    depth: a.depth,
                    binds: Binds::AsOperand,
                }
            }
            Expr::Unary(UnaryOp::Neg, a) => {
                let a = self.part(a, false, Binds::Tightly);
                Printed {
                    text: format!("0 - {}", a.text),
                    depth: a.depth,
                    binds: Binds::Loosely,
                }
            }
            Expr::Unary(UnaryOp::Abs, a) => {
                let a = self.part(a, false, Binds::Tightly);
                Printed {
                    text: format!("abs({})", a.text),
                    depth: a.depth + 1,
                    binds: Binds::Tightly,
                }
            }
            Expr::If(c, a, b) => {
                let (c, a, b) = (
                    self.part(c, true, Binds::Tightly),
                    self.part(a, truth, Binds::Tightly),
                    self.part(b, truth, Binds::Tightly),
                );
                Printed {
                    text: format!("if {} then {} else {}", c.text, a.text, b.text),
                    depth: c.depth.max(a.depth).max(b.depth) + 1,
                    binds: Binds::Loosely,
                }
            }
            Expr::Binary(op @ (B::Min | B::Max), a, b) => {
                let word = if *op == B::Min { "min" } else { "max" };
                let (a, b) = (
                    self.part(a, false, Binds::Tightly),
                    self.part(b, false, Binds::Tightly),
                );
                Printed {
                    text: format!("{word}({}, {})", a.text, b.text),
                    depth: a.depth.max(b.depth) + 1,
                    binds: Binds::Tightly,
                }
            }
            Expr::Binary(op @ (B::And | B::Or), ..) => {
                let mut operands = Vec::new();
                operands_of(*op, expr, &mut operands);
                let parts: Vec<Printed> = operands
                    .into_iter()
                    .map(|e| self.part(e, true, Binds::AsOperand))
                    .collect();
                chain(if *op == B::And { " and " } else { " or " }, parts)
            }
            Expr::Binary(op, a, b) => {
                let truths = matches!(op, B::Implies)
                    || matches!(op, B::Eq | B::Ne)
                        && is_truth(s, a)
                        && is_truth(s, b)
                        && !matches!((&**a, &**b), (Expr::Const(_), Expr::Const(_)));
                let comparison =
                    !truths && matches!(op, B::Eq | B::Ne | B::Lt | B::Le | B::Gt | B::Ge);
                let word = match op {
                    B::Implies => "->",
                    B::Eq if truths => "<->",
                    B::Ne if truths => "xor",
                    B::Eq => "=",
                    B::Ne => "!=",
                    B::Lt => "<",
                    B::Le => "<=",
                    B::Gt => ">",
                    B::Ge => ">=",
                    B::Add => "+",
                    B::Sub => "-",
                    B::Mul => "*",
                    B::Div => "/",
                    _ => "mod",
                };
                let wanted = if matches!(op, B::Implies) {
                    Binds::AsOperand
                } else {
                    Binds::Tightly
                };
                let labels = labels::of(a, self.labels).or_else(|| labels::of(b, self.labels));
                let mut operand = |e: &Expr| match (labels, e) {
                    (Some(labels), Expr::Const(value)) => {
                        leaf(labels::nth(labels, *value).cloned().unwrap_or_default())
                    }
                    _ => self.part(e, truths, wanted),
                };
                let (a, b) = (operand(a), operand(b));
                Printed {
                    text: format!("{} {word} {}", a.text, b.text),
                    depth: a.depth.max(b.depth),
                    binds: if comparison {
                        Binds::AsOperand
                    } else {
                        Binds::Loosely
                    },
                }
            }
        }
    }
}

/// Collects the operands of a chain of `op`, from left to right. The recursion is as deep as the
/// expression.
fn operands_of<'e>(op: BinaryOp, expr: &'e Expr, found: &mut Vec<&'e Expr>) {
    match expr {
        Expr::Binary(inner, a, b) if *inner == op => {
            operands_of(op, a, found);
            operands_of(op, b, found);
        }
        _ => found.push(expr),
    }
}

/// Joins operands with an operator; more than `CHAIN` operands are grouped in parentheses.
fn chain(sign: &str, mut parts: Vec<Printed>) -> Printed {
    loop {
        let grouped = parts.len() > CHAIN;
        let mut groups: Vec<Printed> = Vec::new();
        for group in parts.chunks(CHAIN) {
            let texts: Vec<&str> = group.iter().map(|p| p.text.as_str()).collect();
            let text = texts.join(sign);
            groups.push(Printed {
                text: if grouped { format!("({text})") } else { text },
                depth: group.iter().map(|p| p.depth).max().unwrap_or(0) + usize::from(grouped),
                binds: if grouped {
                    Binds::Tightly
                } else {
                    Binds::Loosely
                },
            });
        }
        parts = groups;
        if !grouped {
            break;
        }
    }
    let empty = Printed {
        text: String::new(),
        depth: 0,
        binds: Binds::Tightly,
    };
    parts.pop().unwrap_or(empty)
}
