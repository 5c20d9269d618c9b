//! A play with its history and the commands of the person.

use super::command::{self, Command, HELP, Part};
use super::legal::{EnumerationLimit, Moves, Rule, Values};
use super::opponent::{Opponent, Position};
use super::show;
use super::values::{listed, resolve, shown_variables};
use super::why::{RulePrinter, Verdict, verdict, verdict_of_leaving};
use linewright_core::drawing::timing;
use linewright_core::gr1::{Owner, Specification, VarId, diagram};
use linewright_core::source::SourceMap;
use serde_json::{Value, json};

/// A play between a person and an opponent.
#[derive(Debug)]
pub struct Session<'a> {
    pub(super) specification: &'a Specification,
    pub(super) printer: RulePrinter<'a>,
    opponent: Opponent,
    /// Values of all variables in each step so far.
    pub(super) steps: Vec<Vec<i64>>,
    /// The steps of the plays that were ended by a reset.
    earlier: Vec<Vec<Vec<i64>>>,
    /// Positions of the opponent: before each step, and the current one.
    positions: Vec<Position>,
    /// Values of the last refused move; `None` if a move was made since then.
    refused: Option<Values>,
    /// State of the random number generator.
    random_state: u64,
}

/// Result of a command.
#[derive(Debug, Clone, PartialEq)]
pub struct Reply {
    /// Text for a person.
    pub text: String,
    /// JSON for a program: one object per step made, or one object with the text.
    pub lines: Vec<Value>,
    /// Action that the caller has to perform.
    pub effect: Effect,
}

/// An action that the caller has to perform, since a session uses neither files nor terminals.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Effect {
    /// Nothing.
    Nothing,
    /// Run the commands of this file.
    Replay(String),
    /// Write a text to a file: file name and text.
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
        let positions = vec![opponent.start()];
        Self {
            specification,
            printer: RulePrinter {
                specification,
                sources,
            },
            opponent,
            steps: Vec::new(),
            earlier: Vec::new(),
            positions,
            refused: None,
            random_state: seed,
        }
    }

    /// Values of all variables in each step so far: of the plays that a reset ended, and last those
    /// of the current one.
    pub fn plays(&self) -> Vec<&[Vec<i64>]> {
        let earlier = self.earlier.iter().map(Vec::as_slice);
        earlier.chain([self.steps.as_slice()]).collect()
    }

    /// The side that the person plays.
    pub fn person(&self) -> Owner {
        self.opponent.person()
    }

    /// The person's role: `plant` or `machine`.
    pub fn role(&self) -> &'static str {
        show::role(self.person())
    }

    /// Introduction: the roles, and the opponent's values in step 0 if it moves first.
    pub fn opening(&self) -> String {
        show::opening(self) + &self.first_values_text()
    }

    /// The introduction as JSON.
    pub fn opening_line(&self) -> Value {
        show::opening_object(self)
    }

    /// Executes a line of input. After an error the play is unchanged, except that a refused move
    /// is remembered for `why`, and that `random` keeps the steps it has made.
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
            Command::Save { test, file } => {
                let text = self.saved(test, &file);
                effect(Effect::Save(file, text))
            }
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
                    format!(
                        "cannot take back {count} steps: only {} were made",
                        self.steps.len()
                    )
                })?;
                self.back_to(left);
                said(self.current_step())
            }
            Command::Reset => {
                if !self.steps.is_empty() {
                    self.earlier.push(self.steps.clone());
                }
                self.back_to(0);
                said(self.current_step())
            }
        }
    }

    /// Values of the upcoming step that are known already.
    pub(super) fn known(&self) -> Vec<Option<i64>> {
        let mut known = vec![None; self.specification.variables.len()];
        if let Some(values) = self.first_values() {
            for (variable, value) in values {
                known[variable.index()] = Some(value);
            }
        }
        known
    }

    /// The opponent's values in the upcoming step, if it moves first.
    pub(super) fn first_values(&self) -> Option<Values> {
        let position = self.positions.last();
        let position = position.filter(|_| self.opponent.moves_first())?;
        let values = self.opponent.first_values(position)?;
        Some(
            self.variables_of(show::other(self.person()))
                .zip(values)
                .collect(),
        )
    }

    /// The person's moves in the upcoming step.
    pub(super) fn legal_moves(&self) -> Moves<'a> {
        let before = self.steps.last().map(Vec::as_slice);
        Moves::new(self.specification, self.person(), before, &self.known())
    }

    /// Why the play is over; `None` if it is not.
    pub fn over(&self) -> Option<String> {
        if let Some((last, earlier)) = self.steps.split_last() {
            let before = earlier.last().map(Vec::as_slice);
            let broken = self.printer.broken(self.person(), before, last);
            if !broken.is_empty() {
                let known: Vec<Option<i64>> = last.iter().copied().map(Some).collect();
                let rules: Vec<_> = broken.iter().collect();
                let rules = self.printer.rules(&rules, before, &known);
                return Some(format!("The {} has lost: it broke\n{rules}", self.role()));
            }
        }
        let moves = self.legal_moves();
        match verdict(&moves, &[]) {
            Ok(Verdict::Each(rules) | Verdict::Together(rules)) => {
                let before = self.steps.last().map(Vec::as_slice);
                let rules = self.printer.rules(&rules, before, &self.known());
                let end = match self.person() {
                    Owner::System => "has lost",
                    Owner::Environment => "can no longer keep the assumptions",
                };
                Some(format!(
                    "The {} {end}: no move can keep\n{rules}",
                    self.role()
                ))
            }
            Ok(Verdict::Legal(_)) | Err(EnumerationLimit) => None,
        }
    }

    fn variables_of(&self, side: Owner) -> impl Iterator<Item = VarId> + use<'a> {
        let specification = self.specification;
        let all = (0..specification.variables.len() as u32).map(VarId);
        all.filter(move |v| specification.variable(*v).owner == side)
    }

    fn step(&mut self, fixed: &[(VarId, i64)]) -> Result<Reply, String> {
        if let Some(over) = self.over() {
            return Err(format!("{over}to go back, enter `undo`"));
        }
        let found = self.legal_moves().find_with_successor(fixed);
        match found {
            Ok(Some(values)) => self.make(&values),
            Ok(None) => {
                let why = self.why_not(fixed);
                self.refused = Some(fixed.to_vec());
                Err(format!("this move is not legal; {why}"))
            }
            Err(EnumerationLimit) => Err(
                "completing this move takes too long: give values for more variables".to_owned(),
            ),
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
        let moved: Vec<i64> = self.variables_of(self.person()).filter_map(of).collect();
        let answer = self
            .positions
            .last()
            .and_then(|p| self.opponent.answer(p, &moved));
        let Some((answer, position)) = answer else {
            return Err(
                "the opponent has no answer to this legal move; this is a fault of linewright: please report it \
                 with the contract"
                    .to_owned(),
            );
        };
        let mut step = vec![0; self.specification.variables.len()];
        let own = self.variables_of(self.person()).zip(moved);
        let others = self.variables_of(show::other(self.person())).zip(answer);
        for (variable, value) in own.chain(others) {
            step[variable.index()] = value;
        }
        let opponent_first = self.opponent.moves_first();
        self.steps.push(step);
        self.positions.push(position);
        self.refused = None;
        let over = self.over();
        let mut text = show::step(self, opponent_first);
        text += &self.first_values_text();
        text += over.as_deref().unwrap_or_default();
        Ok(Reply {
            text,
            lines: vec![show::step_object(self, over.as_deref())],
            effect: Effect::Nothing,
        })
    }

    /// Text with the opponent's values in the upcoming step; empty if the opponent does not move
    /// first.
    fn first_values_text(&self) -> String {
        let given = self.first_values().unwrap_or_default();
        if given.is_empty() {
            return String::new();
        }
        show::first_values(self, &given)
    }

    /// Text that shows the current step after steps were taken back.
    fn current_step(&self) -> String {
        match self.steps.len() {
            0 => format!("before step 0\n{}", self.first_values_text()),
            made => format!("after step {}\n{}", made - 1, self.first_values_text()),
        }
    }

    fn back_to(&mut self, steps: usize) {
        self.steps.truncate(steps);
        self.positions.truncate(steps + 1);
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
            let mut moves = self.legal_moves();
            let variables = &self.specification.variables;
            let chosen: Vec<i64> = variables
                .iter()
                .map(|v| v.domain.low() + (draw(&mut self.random_state) % v.domain.size()) as i64)
                .collect();
            moves.prefer(|v| chosen[v.index()]);
            let values = match moves.find_with_successor(&[]) {
                Ok(Some(values)) => values,
                Ok(None) => return Err("there is no legal move".to_owned()),
                Err(EnumerationLimit) => return Err("finding a move takes too long".to_owned()),
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
        let moves = self.legal_moves();
        let limits = |r: &&Rule<'_>| r.residual != linewright_core::gr1::Expr::TRUE;
        let rules: Vec<_> = moves.rules.iter().filter(limits).collect();
        let leaving: Vec<_> = moves.leaving.iter().collect();
        if rules.is_empty() && leaving.is_empty() {
            return "no rule limits this move\n".to_owned();
        }
        let mut text = String::new();
        if !rules.is_empty() {
            let before = self.steps.last().map(Vec::as_slice);
            let rules = self.printer.rules(&rules, before, &self.known());
            text = format!("these rules limit this move:\n{rules}");
        }
        if !leaving.is_empty() {
            let rules = self.printer.leaving(&leaving, &self.known());
            text = text + "no step can follow a move that breaks one of these rules:\n" + &rules;
        }
        text
    }

    fn why_not(&self, fixed: &[(VarId, i64)]) -> String {
        let moves = self.legal_moves();
        let before = self.steps.last().map(Vec::as_slice);
        let known = self.known();
        let rules = |rules: &[&Rule<'_>]| self.printer.rules(rules, before, &known);
        match verdict(&moves, fixed) {
            Ok(Verdict::Legal(values)) => {
                // Prefers a legal move after which the play can continue.
                let values = match verdict_of_leaving(&moves, fixed) {
                    Ok(Verdict::Each(rules) | Verdict::Together(rules)) => {
                        return self.explain_last_move(&moves, fixed, &rules);
                    }
                    Ok(Verdict::Legal(values)) => values,
                    Err(EnumerationLimit) => values,
                };
                let own = shown_variables(self.specification, self.person());
                let values: Values = values
                    .into_iter()
                    .filter(|(v, _)| own.contains(v))
                    .collect();
                let values = listed(self.specification, &values);
                format!("this move is legal: {values}\n")
            }
            Ok(Verdict::Each(found)) => match found.as_slice() {
                [only] => format!("this rule forbids it:\n{}", rules(&[only])),
                found => format!("each of these rules forbids it:\n{}", rules(found)),
            },
            Ok(Verdict::Together(found)) => {
                format!("these rules together forbid it:\n{}", rules(&found))
            }
            Err(EnumerationLimit) => {
                "deciding this takes too long: give values for more variables\n".to_owned()
            }
        }
    }

    /// Explains that a move is legal, but that these rules prevent any step from following it. Some
    /// of them are rules for leaving the step.
    fn explain_last_move(
        &self,
        moves: &Moves<'_>,
        fixed: &[(VarId, i64)],
        rules: &[&Rule<'_>],
    ) -> String {
        let mut known = self.known();
        for (variable, value) in fixed {
            known[variable.index()] = Some(*value);
        }
        let is_leaving = |r: &&Rule<'_>| moves.leaving.iter().any(|l| std::ptr::eq(l, *r));
        let (leaving, within): (Vec<&Rule<'_>>, Vec<&Rule<'_>>) =
            rules.iter().copied().partition(is_leaving);
        let before = self.steps.last().map(Vec::as_slice);
        format!(
            "this move is legal, but {}: no step after it can keep\n{}{}",
            self.consequence_of_last_move(),
            self.printer.leaving(&leaving, &known),
            self.printer.rules(&within, before, &known)
        )
    }

    /// The consequence of a move that no step can follow, as a phrase without a subject.
    pub(super) fn consequence_of_last_move(&self) -> &'static str {
        match self.person() {
            Owner::System => "loses",
            Owner::Environment => "leads to a broken assumption",
        }
    }

    fn expect(&self, parts: &[Part]) -> Result<(), String> {
        let wanted = resolve(self.specification, None, parts)?;
        let Some(step) = self.steps.last() else {
            return Err("`expect` needs a step: make a move first".to_owned());
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
            "expected {} in step {}, but found {}",
            listed(self.specification, &expected),
            self.steps.len() - 1,
            listed(self.specification, &found)
        ))
    }

    /// The play so far for a file: a timing diagram if its name ends in `.svg`, else a script.
    fn saved(&self, test: bool, file: &str) -> String {
        if !std::path::Path::new(file)
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("svg"))
        {
            return self.script(test);
        }
        let known = |step: &Vec<i64>| step.iter().copied().map(Some).collect();
        let steps: Vec<Vec<Option<i64>>> = self.steps.iter().map(known).collect();
        let diagram = diagram::of_steps(self.specification, &steps, None);
        timing::render(&self.specification.name, &diagram)
    }

    /// The moves so far as a script; with `test`, also the opponent's values as expectations.
    fn script(&self, test: bool) -> String {
        let own: Vec<VarId> = self.variables_of(self.person()).collect();
        let others = shown_variables(self.specification, show::other(self.person()));
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
