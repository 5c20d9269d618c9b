//! Reads `.spc` files of gr1c, for GR(1) games and for reachability games.
//!
//! ```text
//! ENV: x y [0,3];           # variables, Boolean unless a domain [0,n] follows
//! SYS: z;
//! ENVINIT: !x;              # a formula over the environment's variables
//! ENVTRANS: [](x -> x') & [](y' < 3);
//! ENVGOAL: []<>x;
//! SYSINIT: z;
//! SYSTRANS: [](z -> x');
//! SYSGOAL: []<>!z & []<>z;  # or <>z in a reachability game
//! ```
//!
//! Sections can be omitted, empty, and in any order. This reader accepts more than gr1c: a section
//! can begin within a line, and `&` and the operator of the next formula can be on different
//! lines.
//!
//! # Initial conditions
//!
//! For every initial choice of the environment that satisfies `ENVINIT`, the system needs one that
//! satisfies `SYSINIT`. This is the tool's default, `ALL_ENV_EXIST_SYS_INIT`. `SYSINIT` should
//! refer to the system's variables only; other variables are accepted with a note.
//!
//! # Reachability
//!
//! `<>p` has to be reached once; afterwards no guarantee applies. An internal variable `reached`
//! remembers that the goal was reached:
//!
//! ```text
//! initially        reached <-> p          always   reached' <-> reached | p'
//! each transition  reached | φ            goal     reached
//! ```
//!
//! As in a GR(1) game, the system also wins if the environment has no move, or if from some step on
//! it never reaches one of its goals again. With `<>False` these are the only ways to win.

use super::infix::{self, Dialect, Infix, Token, Word};
use super::names::{Names, Part, Section, one_line, quoted};
use linewright_core::diagnostics::codes;
use linewright_core::gr1::{BinaryOp, Domain, Expr, Formula, Owner};
use std::ops::Range;

const SECTIONS: [Section; 6] = [
    section(Owner::Environment, Part::Initial, "ENVINIT"),
    section(Owner::Environment, Part::Transition, "ENVTRANS"),
    section(Owner::Environment, Part::Goal, "ENVGOAL"),
    section(Owner::System, Part::Initial, "SYSINIT"),
    section(Owner::System, Part::Transition, "SYSTRANS"),
    section(Owner::System, Part::Goal, "SYSGOAL"),
];

const fn section(owner: Owner, part: Part, name: &'static str) -> Section {
    Section { owner, part, name }
}

const HEADS: &str = "sections are ENV, SYS, ENVINIT, ENVTRANS, ENVGOAL, SYSINIT, SYSTRANS and SYSGOAL, each followed by `:` and ended by `;`";

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Head {
    Variables(Owner),
    Formulas(Section),
}

fn head(name: &str) -> Option<Head> {
    match name {
        "ENV" => Some(Head::Variables(Owner::Environment)),
        "SYS" => Some(Head::Variables(Owner::System)),
        _ => SECTIONS
            .into_iter()
            .find(|s| s.name == name)
            .map(Head::Formulas),
    }
}

/// Reads a file into `names`; returns whether it describes a reachability game.
pub(super) fn read(names: &mut Names<'_>) -> bool {
    let tokens = infix::words(names.text, 0..names.text.len(), Dialect::Spc);
    let sections = sections(names, &tokens);
    // Formulas can appear before the declarations of their variables.
    for (head, _, body) in &sections {
        if let Head::Variables(owner) = head {
            variables(names, *owner, body);
        }
    }
    if names.specification().variables.is_empty() && names.findings.is_empty() {
        names.syntax(
            0..0,
            "no variable is declared",
            "declare at least one after `ENV:` or `SYS:`",
        );
    }
    let mut reader = Reader {
        names,
        initial: Vec::new(),
        reach: None,
        repeated: None,
    };
    for (head, place, body) in &sections {
        if let Head::Formulas(section) = head {
            reader.section(*section, place, body);
        }
    }
    let reach = reader.reach.take();
    if let Some(goal) = &reach {
        lower_reachability(names, goal);
    }
    reach.is_some()
}

type SectionTokens<'a> = (Head, Range<usize>, &'a [Token]);

/// Splits a file into sections: head, range of the head, and tokens of the body.
fn sections<'a>(names: &mut Names<'_>, tokens: &'a [Token]) -> Vec<SectionTokens<'a>> {
    let head_at = |names: &Names<'_>, i: usize| match (&tokens.get(i), tokens.get(i + 1)) {
        (Some((Word::Name, range)), Some((Word::Colon, _))) => head(&names.text[range.clone()]),
        _ => None,
    };
    let mut found = Vec::new();
    let mut i = 0;
    while i < tokens.len() {
        let place = tokens[i].1.clone();
        let Some(head) = head_at(names, i) else {
            // Report only one finding up to the next section.
            let word = quoted(&names.text[place.clone()]);
            names.syntax(place, format!("expected a section, found `{word}`"), HEADS);
            while i < tokens.len() && head_at(names, i).is_none() {
                i += 1;
            }
            continue;
        };
        let start = i + 2;
        let mut end = start;
        while end < tokens.len()
            && tokens[end].0 != Word::Semicolon
            && head_at(names, end).is_none()
        {
            end += 1;
        }
        if tokens.get(end).is_none_or(|t| t.0 != Word::Semicolon) {
            let last = tokens[end - 1].1.clone();
            names.syntax(
                last,
                "the section ends here without `;`",
                "end each section with `;`",
            );
            i = end;
        } else {
            i = end + 1;
        }
        found.push((head, place, &tokens[start..end]));
    }
    found
}

/// Reads declarations such as `x y [0,3] z`.
fn variables(names: &mut Names<'_>, owner: Owner, body: &[Token]) {
    let mut i = 0;
    while let Some((word, range)) = body.get(i) {
        i += 1;
        if *word != Word::Name {
            let found = quoted(&names.text[range.clone()]);
            names.syntax(
                range.clone(),
                format!("expected a variable, found `{found}`"),
                "separate names with spaces, and write a domain `[0,n]` after its variable",
            );
            // Report a malformed domain only once.
            while body.get(i).is_some_and(|t| t.0 != Word::Name) {
                i += 1;
            }
            continue;
        }
        let mut domain = Some(Domain::Bool);
        if body.get(i).is_some_and(|t| t.0 == Word::OpenBracket) {
            let Some(
                [
                    (_, start),
                    (Word::Number, low),
                    (Word::Comma, _),
                    (Word::Number, high),
                    (Word::CloseBracket, end),
                ],
            ) = body.get(i..i + 5)
            else {
                // The next iteration reports the bracket.
                continue;
            };
            let place = start.start..end.end;
            i += 5;
            domain = domain_of(names, low, high, place);
        } else if body.get(i).is_some_and(|t| t.0 == Word::Always) {
            continue;
        }
        let name = &names.text[range.clone()];
        match domain {
            Some(domain) => names.declare(owner, name, domain, range.clone()),
            None => names.declare_refused(owner, name, range.clone()),
        }
    }
}

fn domain_of(
    names: &mut Names<'_>,
    low: &Range<usize>,
    high: &Range<usize>,
    place: Range<usize>,
) -> Option<Domain> {
    let text = names.text;
    let (a, b) = (
        names.number(&text[low.clone()], low.clone()),
        names.number(&text[high.clone()], high.clone()),
    );
    let (a, b) = (a?, b?);
    if a != 0 {
        names.error(
            codes::DOMAIN_EMPTY,
            place,
            "the domain does not begin with 0",
            format!("write [0,{}] and count from 0", b.saturating_sub(a).max(0)),
        );
        return None;
    }
    names.domain(a, b, place)
}

/// A goal that has to be reached once.
struct Reach {
    goal: Expr,
    range: Range<usize>,
}

struct Reader<'n, 't> {
    names: &'n mut Names<'t>,
    /// Names of the initial sections so far, with the ranges of their heads.
    initial: Vec<(&'static str, Range<usize>)>,
    reach: Option<Reach>,
    /// Range of a system goal with `[]<>`.
    repeated: Option<Range<usize>>,
}

impl Reader<'_, '_> {
    fn section(&mut self, section: Section, place: &Range<usize>, body: &[Token]) {
        if section.part != Part::Initial {
            if !body.is_empty() {
                for part in parts(body) {
                    self.temporal(section, part);
                }
            }
            return;
        }
        let earlier = self
            .initial
            .iter()
            .find(|(name, _)| *name == section.name)
            .cloned();
        if let Some((name, first)) = earlier {
            let first = self.names.span(first);
            self.names.syntax(
                place.clone(),
                format!("the section {name} appears twice"),
                "join the two formulas with `&`",
            );
            if let Some(finding) = self.names.findings.last_mut() {
                finding.labels.push((first, "the first one".to_owned()));
            }
            return;
        }
        if body.is_empty() {
            return;
        }
        self.initial.push((section.name, place.clone()));
        self.initial_condition(section, body);
    }

    /// Adds each conjunct as a formula of its own, so that an unrealizable core can point to single
    /// conjuncts.
    fn initial_condition(&mut self, section: Section, body: &[Token]) {
        if section.owner == Owner::System {
            let outside = body.iter().find(|(word, range)| {
                *word == Word::Name
                    && self
                        .names
                        .find(&self.names.text[range.clone()])
                        .is_some_and(|(v, _)| self.names.owner(v) == Owner::Environment)
            });
            if let Some((_, range)) = outside {
                self.names.note(
                    codes::OWN_TOOL,
                    range.clone(),
                    "gr1c refuses a SYSINIT that names a variable of the environment; here the system chooses after it has seen that variable",
                    "to make the file readable by both tools, name only variables of `SYS:`",
                );
            }
        }
        for piece in conjuncts(body) {
            self.formula(section, piece, span_of(piece));
        }
    }

    fn formula(&mut self, section: Section, tokens: &[Token], place: Range<usize>) {
        let term = infix::formula(self.names, tokens, place.clone(), Dialect::Spc);
        if section.part == Part::Goal && term.is_some_and(|t| self.names.terms.has_next(t)) {
            self.names.note(
                codes::OWN_TOOL,
                place.clone(),
                "gr1c refuses primed variables in goals; here a transition can meet a goal",
                "to make the file readable by both tools, remember the transition in a variable",
            );
        }
        self.names.formula(section, term, place);
    }

    /// Reads one formula with its operator: `[]p`, `[]<>p` or `<>p`.
    fn temporal(&mut self, section: Section, tokens: &[Token]) {
        let place = span_of(tokens);
        let word = |i: usize| tokens.get(i).map(|t| t.0);
        if (word(0), word(1)) == (Some(Word::Eventually), Some(Word::Always)) {
            let operator = tokens[0].1.start..tokens[1].1.end;
            self.names.error(
                codes::NOT_GR1,
                operator,
                infix::PERSISTENCE,
                settling(section.owner),
            );
            return;
        }
        let (operator, rest) = match (word(0), word(1)) {
            (Some(Word::Always), Some(Word::Eventually)) => ("[]<>", &tokens[2..]),
            (Some(Word::Always), _) => ("[]", &tokens[1..]),
            (Some(Word::Eventually), _) => ("<>", &tokens[1..]),
            _ => ("", tokens),
        };
        let fits = match (section.part, section.owner) {
            (Part::Transition, _) => operator == "[]",
            (_, Owner::Environment) => operator == "[]<>",
            (_, Owner::System) => operator == "[]<>" || operator == "<>",
        };
        if !fits {
            let wanted = match (section.part, section.owner) {
                (Part::Transition, _) => "`[]`",
                (_, Owner::Environment) => "`[]<>`",
                (_, Owner::System) => "`[]<>`, or with `<>` for a goal that is reached once",
            };
            let head = tokens.first().map_or(place, |t| t.1.clone());
            let message = format!(
                "this formula of {} does not begin with {wanted}",
                section.name
            );
            let help = format!(
                "join the formulas of a section with `&`, and begin each one with {wanted}"
            );
            self.names.syntax(head, message, help);
            return;
        }
        if section == SECTIONS[5] && !self.is_one_kind(operator, &place) {
            return;
        }
        if operator == "<>" {
            let Some(term) = infix::formula(self.names, rest, place.clone(), Dialect::Spc) else {
                self.names.forget();
                return;
            };
            if self.names.terms.has_next(term) {
                self.names.error(
                    codes::NOT_GR1,
                    place,
                    "a goal that is reached once cannot refer to next values",
                    "remember the transition in a variable, and make that variable the goal",
                );
            } else if let Some(goal) = self.names.tree(term, &place) {
                self.reach = Some(Reach { goal, range: place });
            }
            self.names.forget();
        } else {
            self.formula(section, rest, place);
        }
    }

    /// Whether the system has either repeated goals or a single goal that is reached once. Reports
    /// a goal that breaks this rule.
    fn is_one_kind(&mut self, operator: &str, place: &Range<usize>) -> bool {
        let once = operator == "<>";
        let clash = match (&self.reach, &self.repeated) {
            (Some(first), _) => Some(first.range.clone()),
            (None, Some(first)) if once => Some(first.clone()),
            _ => None,
        };
        if !once {
            self.repeated.get_or_insert(place.clone());
        }
        let Some(first) = clash else {
            return true;
        };
        let first = self.names.span(first);
        self.names.syntax(
            place.clone(),
            "a reachability game cannot have a second goal",
            "join the goals in one formula, `<>(p & q)`, or require each repeatedly with `[]<>`",
        );
        if let Some(finding) = self.names.findings.last_mut() {
            finding.labels.push((first, "the other goal".to_owned()));
        }
        false
    }
}

/// The help for `<>[]p`.
fn settling(owner: Owner) -> &'static str {
    match owner {
        Owner::Environment => "write `[]<>p` in ENVGOAL: this weaker assumption is often enough",
        Owner::System => {
            "let the system signal when it has settled: declare `settled` in SYS, and write `[](settled -> settled') & [](settled -> p)` in SYSTRANS and `[]<>settled` in SYSGOAL"
        }
    }
}

/// Splits `[]p & []q` at each `&` that is before a temporal operator and outside of parentheses.
fn parts(body: &[Token]) -> Vec<&[Token]> {
    let temporal =
        |t: Option<&Token>| t.is_some_and(|t| matches!(t.0, Word::Always | Word::Eventually));
    split(body, |i| temporal(body.get(i + 1)))
}

/// Splits `p & q` into its conjuncts; other operators outside of parentheses prevent the split.
fn conjuncts(body: &[Token]) -> Vec<&[Token]> {
    let mut depth = 0usize;
    for (word, _) in body {
        match word {
            Word::Open | Word::OpenBracket => depth += 1,
            Word::Close | Word::CloseBracket => depth = depth.saturating_sub(1),
            Word::Infix(Infix::Iff | Infix::Op(BinaryOp::Or | BinaryOp::Implies)) if depth == 0 => {
                return vec![body];
            }
            _ => {}
        }
    }
    let pieces = split(body, |_| true);
    // Do not split a formula with a missing operand: the error is reported for the whole formula.
    if pieces.iter().any(|p| p.is_empty()) {
        vec![body]
    } else {
        pieces
    }
}

fn split(body: &[Token], mut here: impl FnMut(usize) -> bool) -> Vec<&[Token]> {
    let (mut found, mut start, mut depth) = (Vec::new(), 0, 0usize);
    for (i, (word, _)) in body.iter().enumerate() {
        match word {
            Word::Open | Word::OpenBracket => depth += 1,
            Word::Close | Word::CloseBracket => depth = depth.saturating_sub(1),
            Word::Infix(Infix::Op(BinaryOp::And)) if depth == 0 && here(i) => {
                found.push(&body[start..i]);
                start = i + 1;
            }
            _ => {}
        }
    }
    found.push(&body[start..]);
    found
}

fn span_of(tokens: &[Token]) -> Range<usize> {
    match (tokens.first(), tokens.last()) {
        (Some(first), Some(last)) => first.1.start..last.1.end,
        _ => 0..0,
    }
}

/// Adds the variable `reached` and its formulas; see the module's documentation.
fn lower_reachability(names: &mut Names<'_>, reach: &Reach) {
    let reached = names.helper("reached");
    let (span, text) = (
        names.span(reach.range.clone()),
        one_line(&names.text[reach.range.clone()]),
    );
    let formula = |expr| Formula {
        defines: false,
        name: "SYSGOAL 1".to_owned(),
        requirement: None,
        expr,
        span,
        text: text.clone(),
    };
    let side = &mut names.specification().guarantees;
    for formula in &mut side.safety {
        formula.expr = Expr::now(reached).or(formula.expr.clone());
    }
    let next = reach.goal.substitute(&mut |v, _| Expr::next(v));
    side.initial
        .push(formula(Expr::now(reached).equals(reach.goal.clone())));
    side.safety.push(formula(
        Expr::next(reached).equals(Expr::now(reached).or(next)),
    ));
    side.justice.push(formula(Expr::now(reached)));
}
