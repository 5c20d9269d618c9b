//! The patterns that Spectra files import from `DwyerPatterns.spectra`.
//!
//! Maoz and Ringert (GR(1) Synthesis for LTL Specification Patterns, ESEC/FSE 2015) translated the
//! patterns of Dwyer, Avrunin and Corbett (Patterns in Property Specifications for Finite-State
//! Verification, ICSE 1999) to automata. An automaton visits an accepting state infinitely often if
//! and only if the formula of its pattern holds. Names, parameters and formulas are those of Maoz
//! and Ringert; [`ltl`] builds the automata from the formulas. As in their translation, a safety
//! pattern is also expressed by justice only.

use linewright_automata::ltl::{self, Formula, Formulas, Node};
use linewright_automata::symbolic::Automaton;

/// Name of the published file.
pub(super) const FILE: &str = "DwyerPatterns.spectra";

/// A pattern of the published file.
#[derive(Debug, PartialEq, Eq)]
pub struct PublishedPattern {
    /// Name in the file.
    pub name: &'static str,
    /// One letter for each parameter, in order.
    pub parameters: &'static str,
    /// LTL formula over the parameters, with `! & | -> U W X F G`.
    pub formula: &'static str,
}

const fn published(
    name: &'static str,
    parameters: &'static str,
    formula: &'static str,
) -> PublishedPattern {
    PublishedPattern {
        name,
        parameters,
        formula,
    }
}

/// All published patterns, including aliases from older files.
pub static PATTERNS: [PublishedPattern; 56] = [
    published("P_is_false_globally", "p", "G !p"),
    published("P_is_false_before_R", "pr", "F r -> (!p U r)"),
    published("P_is_false_after_Q", "pq", "G (q -> G !p)"),
    published(
        "P_is_false_between_Q_and_R",
        "pqr",
        "G ((q & !r & F r) -> (!p U r))",
    ),
    published(
        "P_is_false_after_Q_until_R",
        "pqr",
        "G ((q & !r) -> (!p W r))",
    ),
    published("P_becomes_true_globally", "p", "F p"),
    published("P_becomes_true_before_R", "pr", "!r W (p & !r)"),
    published("P_becomes_true_After_Q", "qp", "G !q | F (q & F p)"),
    published(
        "P_becomes_true_between_Q_and_R",
        "pqr",
        "G ((q & !r) -> (!r W (p & !r)))",
    ),
    published(
        "P_becomes_true_after_Q_until_R",
        "pqr",
        "G ((q & !r) -> (!r U (p & !r)))",
    ),
    published(
        "P_occures_at_most_twice_globally",
        "p",
        "!p W (p W (!p W (p W G !p)))",
    ),
    published(
        "P_occures_at_most_twice_before_R",
        "pr",
        "F r -> ((!p & !r) U (r | ((p & !r) U (r | ((!p & !r) U (r | ((p & !r) U (r | (!p U r)))))))))",
    ),
    published(
        "P_occures_at_most_twice_after_Q",
        "pq",
        "!q W (q & (!p W (p W (!p W (p W G !p)))))",
    ),
    published(
        "P_occures_at_most_twice_between_Q_and_R",
        "pqr",
        "G ((q & F r) -> ((!p & !r) U (r | ((p & !r) U (r | ((!p & !r) U (r | ((p & !r) U (r | (!p U r))))))))))",
    ),
    published("P_is_true_globally", "p", "G p"),
    published("P_is_true_before_R", "pr", "F r -> (p U r)"),
    published("P_is_true_after_Q", "pq", "G (q -> G p)"),
    published(
        "P_is_true_between_Q_and_R",
        "pqr",
        "G ((q & !r & F r) -> (p U r))",
    ),
    published(
        "P_is_true_After_Q_until_R",
        "pqr",
        "G ((q & !r) -> (p W r))",
    ),
    published("S_precedes_to_P_globally", "sp", "!p W s"),
    published("S_precedes_to_P_before_R", "spr", "F r -> (!p U (s | r))"),
    published(
        "S_precedes_to_P_between_Q_and_R",
        "spqr",
        "G ((q & !r & F r) -> (!p U (s | r)))",
    ),
    published(
        "S_precedes_to_P_after_Q_until_R",
        "spqr",
        "G ((q & !r) -> (!p W (s | r)))",
    ),
    published("S_responds_to_P_globally", "sp", "G (p -> F s)"),
    published(
        "S_responds_to_P_before_R",
        "spr",
        "F r -> ((p -> (!r U (s & !r))) U r)",
    ),
    published("S_responds_to_P_after_Q", "spq", "G (q -> G (p -> F s))"),
    published(
        "S_responds_to_P_between_Q_and_R",
        "spqr",
        "G ((q & !r & F r) -> ((p -> (!r U (s & !r))) U r))",
    ),
    published(
        "S_responds_to_P_after_Q_until_R",
        "spqr",
        "G ((q & !r) -> ((p -> (!r U (s & !r))) W r))",
    ),
    published(
        "S_and_T_precedes_to_P_globally",
        "stp",
        "F p -> (!p U (!p & s & X (!p U t)))",
    ),
    published(
        "S_and_T_precedes_to_P_before_R",
        "stpr",
        "F r -> (!p U (r | (!p & s & X (!p U t))))",
    ),
    published(
        "S_and_T_precedes_to_P_after_Q",
        "stpq",
        "G !q | (!q U ((q & F p) -> (!p U (!p & s & X (!p U t)))))",
    ),
    published(
        "S_and_T_precedes_to_P_between_Q_and_R",
        "stpqr",
        "G ((q & F r) -> (!p U (r | (!p & s & X (!p U t)))))",
    ),
    published(
        "S_and_T_precedes_to_P_after_Q_until_R",
        "stpqr",
        "G (q -> (F p -> (!p U (r | (!p & s & X (!p U t))))))",
    ),
    published(
        "P_precedes_S_and_T_globally",
        "pst",
        "F (s & X F t) -> (!s U p)",
    ),
    published(
        "P_precedes_S_and_T_before_R",
        "pstr",
        "F r -> (!(s & !r & X (!r U (t & !r))) U (p | r))",
    ),
    published(
        "P_precedes_S_and_T_after_q",
        "pstq",
        "!q W (q & (F (s & X F t) -> (!s U p)))",
    ),
    published(
        "P_precedes_S_and_T_between_q_and_R",
        "pstqr",
        "G ((q & F r) -> (!(s & !r & X (!r U (t & !r))) U (p | r)))",
    ),
    published(
        "P_precedes_S_and_T_after_q_until_R",
        "pstqr",
        "G (q -> ((!(s & !r & X (!r U (t & !r))) U (p | r)) | G !(s & X F t)))",
    ),
    published(
        "P_responds_to_S_and_T_globally",
        "pst",
        "G ((s & X F t) -> X F (t & F p))",
    ),
    published(
        "P_responds_to_S_and_T_before_r",
        "pstr",
        "F r -> (((s & X (!r U t)) -> X (!r U (t & F p))) U r)",
    ),
    published(
        "P_responds_to_S_and_T_after_Q",
        "pstq",
        "G (q -> G ((s & X F t) -> X (!t U (t & F p))))",
    ),
    published(
        "P_responds_to_S_and_T_between_Q_and_R",
        "pstqr",
        "G ((q & F r) -> (((s & X (!r U t)) -> X (!r U (t & F p))) U r))",
    ),
    published(
        "P_responds_to_S_and_T_after_Q_until_R",
        "pstqr",
        "G (q -> (((s & X (!r U t)) -> X (!r U (t & F p))) W r))",
    ),
    published(
        "S_and_T_responds_to_P_globally",
        "stp",
        "G (p -> F (s & X F t))",
    ),
    published(
        "S_and_T_responds_to_P_before_R",
        "stpr",
        "F r -> ((p -> (!r U (s & !r & X (!r U t)))) U r)",
    ),
    published(
        "S_and_T_responds_to_P_after_q",
        "stpq",
        "G (q -> G (p -> (s & X F t)))",
    ),
    published(
        "S_and_T_responds_to_P_between_q_and_R",
        "stpqr",
        "G ((q & F r) -> ((p -> (!r U (s & !r & X (!r U t)))) U r))",
    ),
    published(
        "S_and_T_without_Z_responds_to_P_globally",
        "stzp",
        "G (p -> F (s & !z & X (!z U t)))",
    ),
    published(
        "S_and_T_without_Z_responds_to_P_before_R",
        "stzpr",
        "F r -> ((p -> (!r U (s & !r & !z & X ((!r & !z) U t)))) U r)",
    ),
    published(
        "S_and_T_without_Z_responds_to_P_after_Q",
        "stzpq",
        "G (q -> G (p -> (s & !z & X (!z U t))))",
    ),
    published(
        "S_and_T_without_Z_responds_to_P_between_Q_and_R",
        "stzpqr",
        "G ((q & F r) -> ((p -> (!r U (s & !r & !z & X ((!r & !z) U t)))) U r))",
    ),
    // Aliases from older files.
    published("notP_globally", "p", "G !p"),
    published("notP_beforeR", "pr", "F r -> (!p U r)"),
    published(
        "pBecomesTrue_betweenQandR",
        "pqr",
        "G ((q & !r) -> (!r W (p & !r)))",
    ),
    published("pHolds_afterQuntilR", "pqr", "G ((q & !r) -> (p W r))"),
    published("pRespondsToS", "ps", "G (p -> F s)"),
];

impl PublishedPattern {
    /// The automaton over the parameters; `None` if it is too large. No pattern of the table is too
    /// large.
    pub(super) fn automaton(&self) -> Option<Automaton> {
        let mut reader = Letters {
            parameters: self.parameters,
            rest: self.formula.as_bytes(),
            formulas: Formulas::default(),
        };
        let formula = reader.implication()?;
        ltl::buchi(&reader.formulas, formula, self.parameters.len()).ok()
    }
}

/// Recursive-descent parser for the formulas of the table. Its methods return `None` for a syntax
/// error.
struct Letters {
    parameters: &'static str,
    rest: &'static [u8],
    formulas: Formulas,
}

impl Letters {
    fn take(&mut self, sign: &str) -> bool {
        self.rest = self.rest.trim_ascii_start();
        match self.rest.strip_prefix(sign.as_bytes()) {
            Some(rest) => {
                self.rest = rest;
                true
            }
            None => false,
        }
    }

    fn implication(&mut self) -> Option<Node> {
        let left = self.disjunction()?;
        if self.take("->") {
            let right = self.implication()?;
            return Some(self.formulas.implies(left, right));
        }
        Some(left)
    }

    fn disjunction(&mut self) -> Option<Node> {
        let mut left = self.conjunction()?;
        while self.take("|") {
            let right = self.conjunction()?;
            left = self.formulas.node(Formula::Or(vec![left, right]));
        }
        Some(left)
    }

    fn conjunction(&mut self) -> Option<Node> {
        let mut left = self.until()?;
        while self.take("&") {
            let right = self.until()?;
            left = self.formulas.node(Formula::And(vec![left, right]));
        }
        Some(left)
    }

    fn until(&mut self) -> Option<Node> {
        let left = self.unary()?;
        if self.take("U") {
            let right = self.until()?;
            return Some(self.formulas.node(Formula::Until(left, right)));
        }
        if self.take("W") {
            let right = self.until()?;
            return Some(self.formulas.node(Formula::Weak(left, right)));
        }
        Some(left)
    }

    fn unary(&mut self) -> Option<Node> {
        if self.take("!") {
            let inner = self.unary()?;
            return Some(self.formulas.not(inner));
        }
        if self.take("X") {
            let inner = self.unary()?;
            return Some(self.formulas.node(Formula::Next(inner)));
        }
        if self.take("F") {
            let inner = self.unary()?;
            return Some(self.formulas.eventually(inner));
        }
        if self.take("G") {
            let inner = self.unary()?;
            return Some(self.formulas.always(inner));
        }
        if self.take("(") {
            let inner = self.implication()?;
            return self.take(")").then_some(inner);
        }
        let (letter, rest) = self.rest.split_first()?;
        let place = self.parameters.bytes().position(|p| p == *letter)?;
        self.rest = rest;
        Some(self.formulas.node(Formula::Atom(place, true)))
    }
}
