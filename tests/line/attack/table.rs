//! Statistics of an attack.

use super::judge::Judged;
use super::runs::Failure;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::path::Path;

/// Maximum number of kinds of failures that are examined.
const MOST_KINDS: usize = 25;

/// Counters.
#[derive(Debug, Default)]
pub struct Table {
    pub machines: usize,
    pub lines: usize,
    pub proved: usize,
    /// Number of lines proved under some premises.
    pub with_premises: usize,
    /// Of these, those with a run in which a premise does not hold.
    pub premise_missed: usize,
    /// Not proved, and failing in some run.
    pub failing: usize,
    /// Not proved, and not runnable.
    pub not_runnable: usize,
    /// By first reason, the number of lines not proved, and of those that fail.
    reasons: BTreeMap<String, (usize, usize)>,
    /// Number of rejected machines by first code.
    refused: BTreeMap<String, usize>,
    pub without_reason: Vec<String>,
    /// Proved lines that fail, and checks that ended without a verdict: description and file.
    pub broken: Vec<String>,
    kinds: BTreeMap<String, usize>,
}

impl Table {
    pub fn line(&mut self, name: &str, judged: &Judged, failures: Option<&BTreeSet<Failure>>) {
        self.lines += 1;
        let fails = failures.is_some_and(|f| !f.is_empty());
        if judged.is_proved() {
            self.proved += 1;
            if !judged.premises.is_empty() {
                self.with_premises += 1;
                self.premise_missed += usize::from(fails);
            }
            return;
        }
        if judged.errors.is_empty() && judged.reasons.is_empty() {
            self.without_reason.push(name.to_owned());
        }
        let entry = self.reasons.entry(judged.reason()).or_default();
        entry.0 += 1;
        entry.1 += usize::from(fails);
        self.failing += usize::from(fails);
        self.not_runnable += usize::from(failures.is_none());
    }

    pub fn unproved_that_ran(&self) -> usize {
        self.lines - self.proved - self.not_runnable
    }

    pub fn refused(&mut self, codes: &[String]) {
        *self.refused.entry(codes[0].clone()).or_default() += 1;
    }

    /// Whether this failure is new, and the number of kinds is within the limit: then a file is
    /// reduced.
    pub fn is_new(&self, kind: &str, said: &str) -> bool {
        !self.kinds.contains_key(&key(kind, said)) && self.kinds.len() < MOST_KINDS
    }

    /// Records a wrong verdict, and keeps the file that shows it.
    pub fn broken(&mut self, seed: u64, kind: &str, said: &str, text: &str, kept: Option<&Path>) {
        let key = key(kind, said);
        let first = format!("// {kind}, batch {seed}: {}\n", said.replace('\n', " "));
        let count = self.kinds.entry(key).or_default();
        *count += 1;
        if let Some(folder) = kept
            && *count <= 2
        {
            std::fs::create_dir_all(folder).expect("a folder");
            let file = folder.join(format!("{kind}-{seed}-{}.lw", self.broken.len()));
            std::fs::write(file, first.clone() + text).expect("a file");
        }
        self.broken.push(first + text);
    }
}

/// A description of the failure, general enough to recognize it again.
fn key(kind: &str, said: &str) -> String {
    let said: String = said.chars().take(70).collect();
    format!("{kind}: {said}")
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{} machines, {} lines: {} proved ({} with premises, which {} runs missed), {} not; of these {} fail, {} cannot be run",
            self.machines,
            self.lines,
            self.proved,
            self.with_premises,
            self.premise_missed,
            self.lines - self.proved,
            self.failing,
            self.not_runnable,
        )?;
        for (reason, (count, failing)) in &self.reasons {
            writeln!(f, "  {reason:<24} {count:>6} not proved {failing:>6} fail")?;
        }
        writeln!(f, "  machines that were refused: {:?}", self.refused)?;
        for (kind, count) in &self.kinds {
            writeln!(f, "  WRONG {count:>5} {kind}")?;
        }
        Ok(())
    }
}
