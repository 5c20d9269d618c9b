//! Propositional formulas over two states, specifications, and their text in three languages.

use std::fmt::Write as _;
use std::ops::{BitAnd, BitOr, Not};

/// Language of a specification.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Prefix notation of slugs.
    Slugsin,
    /// Input of gr1c.
    Spc,
    Spectra,
}

#[derive(Clone)]
pub enum Formula {
    Variable(String),
    NextVariable(String),
    False,
    Not(Box<Formula>),
    Binary(Operator, Box<(Formula, Formula)>),
}

#[derive(Clone, Copy, PartialEq)]
pub enum Operator {
    And,
    Or,
    Implies,
    Iff,
}

impl Formula {
    fn binary(operator: Operator, left: &Self, right: impl Into<Self>) -> Self {
        Self::Binary(operator, Box::new((left.clone(), right.into())))
    }

    pub fn implies(&self, right: impl Into<Self>) -> Self {
        Self::binary(Operator::Implies, self, right)
    }

    pub fn iff(&self, right: impl Into<Self>) -> Self {
        Self::binary(Operator::Iff, self, right)
    }

    /// The same formula in the next state.
    pub fn next(&self) -> Self {
        match self {
            Self::Variable(name) => Self::NextVariable(name.clone()),
            Self::NextVariable(name) => panic!("{name} has two nexts"),
            Self::False => Self::False,
            Self::Not(inner) => !inner.next(),
            Self::Binary(operator, sides) => {
                Self::binary(*operator, &sides.0.next(), sides.1.next())
            }
        }
    }

    fn write(&self, format: Format, out: &mut String) {
        match self {
            Self::Variable(name) => *out += name,
            Self::NextVariable(name) if format == Format::Spectra => {
                let _ = write!(out, "next({name})");
            }
            Self::NextVariable(name) => {
                let _ = write!(out, "{name}'");
            }
            Self::False => {
                *out += match format {
                    Format::Slugsin => "0",
                    Format::Spc => "False",
                    Format::Spectra => "false",
                }
            }
            Self::Not(inner) => {
                *out += if format == Format::Slugsin { "! " } else { "!" };
                inner.write(format, out);
            }
            Self::Binary(operator, sides) if format == Format::Slugsin => {
                *out += match operator {
                    Operator::And => "& ",
                    Operator::Or => "| ",
                    Operator::Implies => "| ! ",
                    Operator::Iff => "! ^ ",
                };
                sides.0.write(format, out);
                *out += " ";
                sides.1.write(format, out);
            }
            Self::Binary(operator, sides) => {
                *out += "(";
                sides.0.write(format, out);
                *out += match operator {
                    Operator::And => " & ",
                    Operator::Or => " | ",
                    Operator::Implies => " -> ",
                    Operator::Iff => " <-> ",
                };
                sides.1.write(format, out);
                *out += ")";
            }
        }
    }

    fn text(&self, format: Format) -> String {
        let mut out = String::new();
        self.write(format, &mut out);
        out
    }
}

impl From<&Formula> for Formula {
    fn from(formula: &Formula) -> Self {
        formula.clone()
    }
}

impl Not for &Formula {
    type Output = Formula;

    fn not(self) -> Formula {
        Formula::Not(Box::new(self.clone()))
    }
}

impl Not for Formula {
    type Output = Formula;

    fn not(self) -> Formula {
        !&self
    }
}

/// Implements an operator for formulas and references to them.
macro_rules! operator {
    ($trait:ident, $method:ident, $operator:ident) => {
        impl<R: Into<Formula>> $trait<R> for &Formula {
            type Output = Formula;

            fn $method(self, right: R) -> Formula {
                Formula::binary(Operator::$operator, self, right)
            }
        }

        impl<R: Into<Formula>> $trait<R> for Formula {
            type Output = Formula;

            fn $method(self, right: R) -> Formula {
                (&self).$method(right)
            }
        }
    };
}

operator!(BitAnd, bitand, And);
operator!(BitOr, bitor, Or);

/// Returns the number of bits of the values below `count`.
pub fn bits(count: usize) -> u32 {
    (count - 1).ilog2() + 1
}

/// Returns the conjunction of at least one formula.
pub fn all(formulas: impl Iterator<Item = Formula>) -> Formula {
    formulas
        .reduce(|left, right| left & right)
        .expect("a formula")
}

/// The formula that `bits`, lowest bit first, have a value.
pub fn number(bits: &[Formula], value: usize) -> Formula {
    let literal = |(i, bit): (usize, &Formula)| {
        if value >> i & 1 == 1 {
            bit.clone()
        } else {
            !bit
        }
    };
    all(bits.iter().enumerate().map(literal))
}

/// The variables and formulas of the environment or of the system.
#[derive(Default)]
pub struct Player {
    /// Names and initial values.
    variables: Vec<(String, bool)>,
    safety: Vec<Formula>,
    liveness: Vec<Formula>,
}

impl Player {
    /// Declares a variable.
    pub fn declare(&mut self, name: impl Into<String>, initially: bool) -> Formula {
        let name = name.into();
        self.variables.push((name.clone(), initially));
        Formula::Variable(name)
    }

    /// Declares variables that are initially false.
    pub fn declare_all(&mut self, names: impl Iterator<Item = String>) -> Vec<Formula> {
        names.map(|name| self.declare(name, false)).collect()
    }

    pub fn always(&mut self, formula: Formula) {
        self.safety.push(formula);
    }

    pub fn always_eventually(&mut self, formula: impl Into<Formula>) {
        self.liveness.push(formula.into());
    }

    fn names(&self) -> impl Iterator<Item = &str> {
        self.variables.iter().map(|(name, _)| name.as_str())
    }

    fn initial(&self, format: Format) -> Vec<String> {
        let literal = |(name, initially): &(String, bool)| {
            let variable = Formula::Variable(name.clone());
            if *initially { variable } else { !variable }.text(format)
        };
        self.variables.iter().map(literal).collect()
    }
}

fn texts(formulas: &[Formula], format: Format) -> Vec<String> {
    formulas
        .iter()
        .map(|formula| formula.text(format))
        .collect()
}

pub fn print(name: &str, env: &Player, sys: &Player, format: Format) -> String {
    match format {
        Format::Slugsin => print_slugsin(env, sys),
        Format::Spc => print_spc(env, sys),
        Format::Spectra => print_spectra(name, env, sys),
    }
}

fn print_slugsin(env: &Player, sys: &Player) -> String {
    let format = Format::Slugsin;
    let names = |player: &Player| player.names().map(String::from).collect();
    let sections: [(&str, Vec<String>); 8] = [
        ("INPUT", names(env)),
        ("OUTPUT", names(sys)),
        ("ENV_INIT", env.initial(format)),
        ("SYS_INIT", sys.initial(format)),
        ("ENV_TRANS", texts(&env.safety, format)),
        ("SYS_TRANS", texts(&sys.safety, format)),
        ("ENV_LIVENESS", texts(&env.liveness, format)),
        ("SYS_LIVENESS", texts(&sys.liveness, format)),
    ];
    let section = |(title, lines): &(_, Vec<_>)| format!("[{title}]\n{}\n\n", lines.join("\n"));
    sections.iter().map(section).collect()
}

fn print_spc(env: &Player, sys: &Player) -> String {
    let players = [("ENV", env), ("SYS", sys)];
    let mut out = String::new();
    for (name, player) in players {
        let names = player.names().collect::<Vec<_>>().join(" ");
        let _ = writeln!(out, "{name}: {names};");
    }
    for (name, player) in players {
        let wrap = |temporal: &str, formulas: &[Formula]| {
            let texts = texts(formulas, Format::Spc);
            texts
                .iter()
                .map(|text| format!("{temporal}({text})"))
                .collect::<Vec<_>>()
        };
        let [initial, safety, liveness] = [
            player.initial(Format::Spc),
            wrap("[]", &player.safety),
            wrap("[]<>", &player.liveness),
        ]
        .map(|lines| lines.join("\n & "));
        let _ = write!(
            out,
            "\n{name}INIT: {initial};\n{name}TRANS: {safety};\n{name}GOAL: {liveness};\n"
        );
    }
    out
}

fn print_spectra(name: &str, env: &Player, sys: &Player) -> String {
    let format = Format::Spectra;
    let mut out = format!("spec {name}\n\n");
    for (owner, player) in [("env", env), ("sys", sys)] {
        out.extend(
            player
                .names()
                .map(|name| format!("{owner} boolean {name};\n")),
        );
    }
    for (keyword, player) in [("assumption", env), ("guarantee", sys)] {
        let sections = [
            ("ini", player.initial(format)),
            ("trans", texts(&player.safety, format)),
            ("alwEv", texts(&player.liveness, format)),
        ];
        for (kind, lines) in &sections {
            out.extend(
                lines
                    .iter()
                    .map(|line| format!("{keyword} {kind} {line};\n")),
            );
        }
    }
    out
}
