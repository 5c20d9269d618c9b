//! A play with its history and the commands of the person.

use super::command::{self, Command, HELP, Part};
use super::legal::{EnumerationLimit, Moves, Rule, Values};
use super::opponent::{Opponent, Place};
use super::show;
use super::values::{listed, resolve, shown};
use super::why::{RulePrinter, Verdict, verdict, verdict_of_leaving};
use linewright_core::gr1::{Owner, Specification, VarId};
use linewright_core::source::SourceMap;
use serde_json::{Value, json};

/// A play.
#[derive(Debug)]
pub struct Session<'a> {
    pub(super) specification: &'a Specification,
    pub(super) book: RulePrinter<'a>,
    opponent: Opponent,
    /// Values of all variables in each step so far.
    pub(super) steps: Vec<Vec<i64>>,
    /// Positions of the opponent before each step, and the current one.
    places: Vec<Place>,
    /// Values of the last refused move, until the next move.
    refused: Option<Values>,
    chance: u64,
}

/// Result of a command.
#[derive(Debug, Clone, PartialEq)]
pub struct Reply {
    /// Text for a person.
    pub text: String,
    /// JSON for a program: one object per step made, or one for a message.
    pub lines: Vec<Value>,
    /// Action left to the caller.
    pub effect: Effect,
}

/// An action that the caller has to perform, since the session does not.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Effect {
    /// Nothing.
    Nothing,
    /// Run the commands of this file.
    Replay(String),
    /// Write a text to a file: file name, then text.
    Save(String, String),
    /// End the session.
    Quit,
}

impl<'a> Session<'a> {
    /// Starts a play before its first step. The same seed gives the same random moves.
    pub fn new(
        specification: &'a Specification,
        sources: &'a SourceMap,
        opponent: Opponent,
        seed: u64,
    ) -> Self {
        let places = vec![opponent.start()];
        Self {
            specification,
            book: RulePrinter {
                specification,
                sources,
            },
            opponent,
            steps: Vec::new(),
            places,
            refused: None,
            chance: seed,
        }
    }

    /// The side that the person plays.
    pub fn person(&self) -> Owner {
        self.opponent.person()
    }

    /// The person's role: `plant` or `machine`.
    pub fn role(&self) -> &'static str {
        show::role(self.person())
    }

    /// Introduction: the roles, and known values of the first step.
    pub fn opening(&self) -> String {
        show::opening(self) + &self.begun()
    }

    /// The introduction as JSON.
    pub fn opening_line(&self) -> Value {
        show::opening_object(self)
    }

    /// Executes a line. An error is returned as text and changes nothing.
    pub fn run(&mut self, line: &str) -> Result<Reply, String> {
        let said = |text: String| {
            Ok(Reply {
                lines: vec![json!({"schema": show::SCHEMA, "text": text})],
                text,
                effect: Effect::Nothing,
            })
        };
        let effect = |effect: Effect| {
            Ok(Reply {
                text: String::new(),
                lines: Vec::new(),
                effect,
            })
        };
        match command::parse(line)? {
            Command::Nothing => effect(Effect::Nothing),
            Command::Quit => effect(Effect::Quit),
            Command::Replay(file) => effect(Effect::Replay(file)),
            Command::Save { test, file } => effect(Effect::Save(file, self.script(test))),
            Command::Help => said(HELP.to_owned()),
            Command::State => said(show::state(self)),
            Command::Moves => said(show::moves(self)),
            Command::Why => said(self.why()),
            Command::WhyNot(parts) => {
                let values = resolve(self.specification, Some(self.person()), &parts)?;
                said(self.why_not(&values))
            }
            Command::Expect(parts) => self.expect(&parts).and_then(|()| effect(Effect::Nothing)),
            Command::Move(parts) => {
                let values = resolve(self.specification, Some(self.person()), &parts)?;
                self.step(&values)
            }
            Command::Random(count) => self.random(count),
            Command::Undo(count) => {
                let left = self.steps.len().checked_sub(count).ok_or_else(|| {
                    format!("there are only {} steps to take back", self.steps.len())
                })?;
                self.back_to(left);
                said(self.now())
            }
            Command::Reset => {
                self.back_to(0);
                said(self.now())
            }
        }
    }

    /// Values of the upcoming step that are known already.
    pub(super) fn known(&self) -> Vec<Option<i64>> {
        let mut known = vec![None; self.specification.variables.len()];
        if let Some(values) = self.given() {
            for (variable, value) in values {
                known[variable.index()] = Some(value);
            }
        }
        known
    }

    /// The opponent's values in the upcoming step, if it moves first.
    pub(super) fn given(&self) -> Option<Values> {
        let place = self.places.last().filter(|_| self.opponent.begins())?;
        let values = self.opponent.given(place)?;
        Some(self.of(show::other(self.person())).zip(values).collect())
    }

    /// The person's moves in the upcoming step.
    pub(super) fn legal(&self) -> Moves<'a> {
        let before = self.steps.last().map(Vec::as_slice);
        Moves::new(self.specification, self.person(), before, &self.known())
    }

    /// Why the play is over, if it is.
    pub(super) fn over(&self) -> Option<String> {
        if let Some((last, earlier)) = self.steps.split_last() {
            let before = earlier.last().map(Vec::as_slice);
            let broken = self.book.broken(self.person(), before, last);
            if !broken.is_empty() {
                let known: Vec<Option<i64>> = last.iter().copied().map(Some).collect();
                let rules: Vec<_> = broken.iter().collect();
                let rules = self.book.rules(&rules, before, &known);
                return Some(format!("The {} has lost. Broken is\n{rules}", self.role()));
            }
        }
        let moves = self.legal();
        match verdict(&moves, &[]) {
            Ok(Verdict::Each(rules) | Verdict::Together(rules)) => {
                let before = self.steps.last().map(Vec::as_slice);
                let rules = self.book.rules(&rules, before, &self.known());
                let end = match self.person() {
                    Owner::System => "has lost",
                    Owner::Environment => "cannot keep its assumptions any more",
                };
                Some(format!(
                    "The {} {end}: no move is left that keeps\n{rules}",
                    self.role()
                ))
            }
            Ok(Verdict::Legal(_)) | Err(EnumerationLimit) => None,
        }
    }

    fn of(&self, side: Owner) -> impl Iterator<Item = VarId> + use<'a> {
        let specification = self.specification;
        let all = (0..specification.variables.len() as u32).map(VarId);
        all.filter(move |v| specification.variable(*v).owner == side)
    }

    fn step(&mut self, fixed: &[(VarId, i64)]) -> Result<Reply, String> {
        if let Some(over) = self.over() {
            return Err(format!("{over}`undo` takes a step back"));
        }
        let found = self.legal().find_lasting(fixed);
        match found {
            Ok(Some(values)) => self.make(&values),
            Ok(None) => {
                let why = self.why_not(fixed);
                self.refused = Some(fixed.to_vec());
                Err(format!("this move is not legal; {why}"))
            }
            Err(EnumerationLimit) => {
                Err("it takes too long to complete this move: give more of its values".to_owned())
            }
        }
    }

    /// Makes a legal move.
    fn make(&mut self, values: &[(VarId, i64)]) -> Result<Reply, String> {
        let of = |v: VarId| {
            values
                .iter()
                .find(|(own, _)| *own == v)
                .map(|(_, value)| *value)
        };
        let moved: Vec<i64> = self.of(self.person()).filter_map(of).collect();
        let answer = self
            .places
            .last()
            .and_then(|p| self.opponent.answer(p, &moved));
        let Some((answer, place)) = answer else {
            return Err(
                "the other player has no answer to this legal move. This is a fault of linewright: please report it \
                 together with the contract"
                    .to_owned(),
            );
        };
        let mut step = vec![0; self.specification.variables.len()];
        let own = self.of(self.person()).zip(moved);
        let others = self.of(show::other(self.person())).zip(answer);
        for (variable, value) in own.chain(others) {
            step[variable.index()] = value;
        }
        let began = self.opponent.begins();
        self.steps.push(step);
        self.places.push(place);
        self.refused = None;
        let over = self.over();
        let mut text = show::step(self, began);
        text += &self.begun();
        text += over.as_deref().unwrap_or_default();
        Ok(Reply {
            text,
            lines: vec![show::step_object(self, over.as_deref())],
            effect: Effect::Nothing,
        })
    }

    /// Known values of the upcoming step.
    fn begun(&self) -> String {
        let given = self.given().unwrap_or_default();
        if given.is_empty() {
            return String::new();
        }
        show::begun(self, &given)
    }

    /// Position after steps were taken back.
    fn now(&self) -> String {
        match self.steps.len() {
            0 => format!("before step 0\n{}", self.begun()),
            made => format!("after step {}\n{}", made - 1, self.begun()),
        }
    }

    fn back_to(&mut self, steps: usize) {
        self.steps.truncate(steps);
        self.places.truncate(steps + 1);
        self.refused = None;
    }

    fn random(&mut self, count: usize) -> Result<Reply, String> {
        let mut all = Reply {
            text: String::new(),
            lines: Vec::new(),
            effect: Effect::Nothing,
        };
        for made in 0..count {
            if let Some(over) = self.over() {
                if made == 0 {
                    return Err(over);
                }
                // The previous step already reported it.
                break;
            }
            let mut moves = self.legal();
            let variables = &self.specification.variables;
            let chosen: Vec<i64> = variables
                .iter()
                .map(|v| v.domain.low() + (draw(&mut self.chance) % v.domain.size()) as i64)
                .collect();
            moves.prefer(|v| chosen[v.index()]);
            let values = match moves.find_lasting(&[]) {
                Ok(Some(values)) => values,
                Ok(None) => return Err("there is no legal move".to_owned()),
                Err(EnumerationLimit) => return Err("it takes too long to find a move".to_owned()),
            };
            let reply = self.make(&values)?;
            all.text += &reply.text;
            all.lines.extend(reply.lines);
        }
        Ok(all)
    }

    fn why(&self) -> String {
        if let Some(refused) = &self.refused {
            return self.why_not(refused);
        }
        let moves = self.legal();
        let limits = |r: &&Rule<'_>| r.left != linewright_core::gr1::Expr::TRUE;
        let rules: Vec<_> = moves.rules.iter().filter(limits).collect();
        let leaving: Vec<_> = moves.leaving.iter().collect();
        if rules.is_empty() && leaving.is_empty() {
            return "no rule limits this move\n".to_owned();
        }
        let mut text = String::new();
        if !rules.is_empty() {
            let before = self.steps.last().map(Vec::as_slice);
            let rules = self.book.rules(&rules, before, &self.known());
            text = format!("these rules limit this move:\n{rules}");
        }
        if !leaving.is_empty() {
            let rules = self.book.leaving(&leaving, &self.known());
            text = text + "no step can follow a move that breaks one of these:\n" + &rules;
        }
        text
    }

    fn why_not(&self, fixed: &[(VarId, i64)]) -> String {
        let moves = self.legal();
        let before = self.steps.last().map(Vec::as_slice);
        let known = self.known();
        let rules = |rules: &[&Rule<'_>]| self.book.rules(rules, before, &known);
        match verdict(&moves, fixed) {
            Ok(Verdict::Legal(values)) => {
                // Prefers a legal move after which the play can go on.
                let values = match verdict_of_leaving(&moves, fixed) {
                    Ok(Verdict::Each(rules) | Verdict::Together(rules)) => {
                        return self.last(&moves, fixed, &rules);
                    }
                    Ok(Verdict::Legal(values)) => values,
                    Err(EnumerationLimit) => values,
                };
                let own = shown(self.specification, self.person());
                let values: Values = values
                    .into_iter()
                    .filter(|(v, _)| own.contains(v))
                    .collect();
                let values = listed(self.specification, &values);
                format!("this move is legal: {values}\n")
            }
            Ok(Verdict::Each(found)) => match found.as_slice() {
                [only] => format!("this forbids it:\n{}", rules(&[only])),
                found => format!("each of these forbids it:\n{}", rules(found)),
            },
            Ok(Verdict::Together(found)) => {
                format!("these forbid it together:\n{}", rules(&found))
            }
            Err(EnumerationLimit) => "it takes too long to find out: give more values\n".to_owned(),
        }
    }

    /// Message that a legal move is the last one because of these rules, some of which apply on
    /// leaving the step.
    fn last(&self, moves: &Moves<'_>, fixed: &[(VarId, i64)], rules: &[&Rule<'_>]) -> String {
        let mut known = self.known();
        for (variable, value) in fixed {
            known[variable.index()] = Some(*value);
        }
        let is_leaving = |r: &&Rule<'_>| moves.leaving.iter().any(|l| std::ptr::eq(l, *r));
        let (leaving, within): (Vec<&Rule<'_>>, Vec<&Rule<'_>>) =
            rules.iter().copied().partition(is_leaving);
        let before = self.steps.last().map(Vec::as_slice);
        format!(
            "this move is legal, and {}: no step can follow it that keeps\n{}{}",
            self.end_of_last_move(),
            self.book.leaving(&leaving, &known),
            self.book.rules(&within, before, &known)
        )
    }

    /// Consequence of a move that no step can follow.
    pub(super) fn end_of_last_move(&self) -> &'static str {
        match self.person() {
            Owner::System => "loses",
            Owner::Environment => "gives up the assumptions",
        }
    }

    fn expect(&self, parts: &[Part]) -> Result<(), String> {
        let wanted = resolve(self.specification, None, parts)?;
        let Some(step) = self.steps.last() else {
            return Err("there is no step yet whose values could be expected".to_owned());
        };
        let is = |v: &VarId| (*v, step[v.index()]);
        let (mut expected, mut found) = (Values::new(), Values::new());
        for (variable, value) in wanted {
            if step[variable.index()] != value {
                expected.push((variable, value));
                found.push(is(&variable));
            }
        }
        if expected.is_empty() {
            return Ok(());
        }
        Err(format!(
            "expected {} in step {}, but there {}",
            listed(self.specification, &expected),
            self.steps.len() - 1,
            listed(self.specification, &found)
        ))
    }

    /// The moves so far as a script.
    fn script(&self, test: bool) -> String {
        let own: Vec<VarId> = self.of(self.person()).collect();
        let others = shown(self.specification, show::other(self.person()));
        let mut text = format!("# {} as the {}\n", self.specification.name, self.role());
        for step in &self.steps {
            let values = |list: &[VarId]| {
                let values: Values = list.iter().map(|v| (*v, step[v.index()])).collect();
                listed(self.specification, &values)
            };
            if own.is_empty() {
                text += "random\n";
            } else {
                text = text + &values(&own) + "\n";
            }
            if test && !others.is_empty() {
                text = text + "expect " + &values(&others) + "\n";
            }
        }
        text
    }
}

/// The next pseudorandom number (Steele, Lea and Flood, "Fast splittable pseudorandom number
/// generators", 2014).
fn draw(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}
