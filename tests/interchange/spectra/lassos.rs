//! Runs that repeat, and whether they keep a specification: its internal variables are found by
//! trying all their values.

use linewright::gr1::eval::holds;
use linewright::gr1::{Formula, Owner, Specification, VarId};
use linewright::interchange::{Format, read};
use linewright::source::FileId;
use std::collections::HashMap;

/// Letters, the last of which is followed by the letter `back`.
#[derive(Debug, Clone)]
pub struct Lasso {
    pub letters: Vec<Vec<i64>>,
    pub back: usize,
}

impl Lasso {
    /// The letter of a step.
    pub fn at(&self, step: usize) -> &[i64] {
        let count = self.letters.len();
        if step < count {
            return &self.letters[step];
        }
        &self.letters[self.back + (step - self.back) % (count - self.back)]
    }

    pub fn period(&self) -> usize {
        self.letters.len() - self.back
    }

    /// Whether no shorter lasso represents the same run.
    fn is_shortest(&self) -> bool {
        let cycle = &self.letters[self.back..];
        let rolled = self.back > 0 && self.letters.last() == self.letters.get(self.back - 1);
        let repeats = |part: usize| {
            cycle.len().is_multiple_of(part) && cycle.chunks(part).all(|c| c == &cycle[..part])
        };
        !rolled && !(1..cycle.len()).any(repeats)
    }
}

/// All lassos of up to `longest` letters over variables with these numbers of values, or 10,000
/// random ones if there are too many.
pub fn lassos(sizes: &[i64], longest: u32) -> Vec<Lasso> {
    let letters: i64 = sizes.iter().product();
    let count: i64 = (1..=longest)
        .map(|n| letters.saturating_pow(n).saturating_mul(i64::from(n)))
        .fold(0, i64::saturating_add);
    let letter = |mut number: i64| -> Vec<i64> {
        let digits = sizes.iter().map(|size| {
            let digit = number % size;
            number /= size;
            digit
        });
        digits.collect()
    };
    let mut found = Vec::new();
    // Those over two truth values are 30,948.
    if count <= 31_000 {
        for length in 1..=longest {
            for mut word in 0..letters.pow(length) {
                let mut run = Vec::new();
                for _ in 0..length {
                    run.push(letter(word % letters));
                    word /= letters;
                }
                for back in 0..length as usize {
                    let lasso = Lasso {
                        letters: run.clone(),
                        back,
                    };
                    if lasso.is_shortest() {
                        found.push(lasso);
                    }
                }
            }
        }
        return found;
    }
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut draw = |below: i64| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((state >> 33) % below as u64) as i64
    };
    for _ in 0..10_000 {
        let length = 1 + draw(i64::from(longest) + 4) as usize;
        let run: Vec<Vec<i64>> = (0..length).map(|_| letter(draw(letters))).collect();
        let back = draw(length as i64) as usize;
        found.push(Lasso { letters: run, back });
    }
    found
}

/// The values of two steps that follow one another.
type Pair = (Vec<i64>, Vec<i64>);

/// A specification with only inputs and internal variables, in which the internal variables are
/// determined.
pub struct Game {
    specification: Specification,
    /// All values of the internal variables, with inputs at 0.
    choices: Vec<Vec<i64>>,
    inputs: Vec<usize>,
    /// The next internal values after some, by the letters of the two steps.
    known: HashMap<(usize, Vec<i64>, Vec<i64>), Option<usize>>,
}

/// Reads a text, which must have no errors.
pub fn game(text: &str) -> Game {
    let reading = read(Format::Spectra, "test", FileId(0), text);
    let findings = reading.findings;
    let specification = reading
        .specification
        .unwrap_or_else(|| panic!("{text}\n{findings:#?}"));
    let mut choices = vec![vec![0; specification.variables.len()]];
    for (index, variable) in specification.variables.iter().enumerate() {
        if variable.owner == Owner::Environment {
            continue;
        }
        assert!(variable.internal, "{text}: {}", variable.name);
        let values = variable.domain.low()..=variable.domain.high();
        choices = choices
            .into_iter()
            .flat_map(|c| {
                values.clone().map(move |v| {
                    let mut c = c.clone();
                    c[index] = v;
                    c
                })
            })
            .collect();
    }
    assert!(choices.len() <= 1 << 12, "{text}: {} states", choices.len());
    let inputs = specification.inputs().map(VarId::index).collect();
    Game {
        specification,
        choices,
        inputs,
        known: HashMap::new(),
    }
}

impl Game {
    fn full(&self, choice: usize, letter: &[i64]) -> Vec<i64> {
        let mut full = self.choices[choice].clone();
        for (index, value) in self.inputs.iter().zip(letter) {
            full[*index] = *value;
        }
        full
    }

    fn only(candidates: impl Iterator<Item = usize>) -> Option<usize> {
        let found: Vec<usize> = candidates.collect();
        assert!(found.len() <= 1, "not determined: {found:?}");
        found.first().copied()
    }

    fn all(formulas: &[Formula], now: &[i64], next: &[i64]) -> bool {
        formulas.iter().all(|f| holds(&f.expr, now, next))
    }

    fn step(&mut self, choice: usize, now: &[i64], next: &[i64]) -> Option<usize> {
        let key = (choice, now.to_vec(), next.to_vec());
        if let Some(found) = self.known.get(&key) {
            return *found;
        }
        let side = &self.specification.guarantees;
        let before = self.full(choice, now);
        let found = Self::only((0..self.choices.len()).filter(|c| {
            let after = self.full(*c, next);
            Self::all(&side.safety, &before, &after) && Self::all(&side.invariants, &after, &[])
        }));
        self.known.insert(key, found);
        found
    }

    /// The pairs of steps of a lasso with internal values, and the beginning of the repeated part;
    /// `None` if no internal values keep the guarantees other than justice.
    fn run(&mut self, lasso: &Lasso) -> Option<(Vec<Pair>, usize)> {
        let side = &self.specification.guarantees;
        let mut choice = Self::only((0..self.choices.len()).filter(|c| {
            let full = self.full(*c, lasso.at(0));
            Self::all(&side.initial, &full, &[]) && Self::all(&side.invariants, &full, &[])
        }))?;
        let (mut heads, mut run) = (HashMap::new(), Vec::new());
        for step in 0.. {
            let position = if step < lasso.letters.len() {
                step
            } else {
                lasso.back + (step - lasso.back) % lasso.period()
            };
            if position == lasso.back
                && let Some(start) = heads.insert(choice, step)
            {
                return Some((run, start));
            }
            let next = self.step(choice, lasso.at(step), lasso.at(step + 1))?;
            run.push((
                self.full(choice, lasso.at(step)),
                self.full(next, lasso.at(step + 1)),
            ));
            choice = next;
        }
        unreachable!("a run repeats")
    }

    fn repeated(justice: &[Formula], cycle: &[Pair]) -> bool {
        justice.iter().all(|f| {
            let mut steps = cycle.iter();
            steps.any(|(now, next)| holds(&f.expr, now, next))
        })
    }

    /// Whether the guarantees are kept on a lasso.
    pub fn kept(&mut self, lasso: &Lasso) -> bool {
        let Some((run, start)) = self.run(lasso) else {
            return false;
        };
        Self::repeated(&self.specification.guarantees.justice, &run[start..])
    }

    /// Whether the assumptions are kept on a lasso on which the internal variables can always
    /// continue.
    pub fn assumed(&mut self, lasso: &Lasso) -> bool {
        let (run, start) = self.run(lasso).expect("monitors do not get stuck");
        let side = &self.specification.assumptions;
        let mut steps = run.iter();
        Self::all(&side.initial, &run[0].0, &[])
            && steps.all(|(now, next)| {
                Self::all(&side.invariants, now, &[]) && Self::all(&side.safety, now, next)
            })
            && Self::repeated(&side.justice, &run[start..])
    }
}

/// Checks that a text is kept on exactly those lassos of its inputs for which `naive` holds;
/// returns their number, and how many keep it.
pub fn agrees(text: &str, sizes: &[i64], naive: impl Fn(&Lasso) -> bool) -> (usize, usize) {
    compared(text, sizes, naive, Game::kept)
}

/// The same for the assumptions of a text.
pub fn agrees_assumed(text: &str, sizes: &[i64], naive: impl Fn(&Lasso) -> bool) -> (usize, usize) {
    compared(text, sizes, naive, Game::assumed)
}

fn compared(
    text: &str,
    sizes: &[i64],
    naive: impl Fn(&Lasso) -> bool,
    ours: impl Fn(&mut Game, &Lasso) -> bool,
) -> (usize, usize) {
    let mut game = game(text);
    let (mut count, mut kept) = (0, 0);
    for lasso in lassos(sizes, 6) {
        let wanted = naive(&lasso);
        assert_eq!(ours(&mut game, &lasso), wanted, "{text}\n{lasso:?}");
        count += 1;
        kept += usize::from(wanted);
    }
    (count, kept)
}
