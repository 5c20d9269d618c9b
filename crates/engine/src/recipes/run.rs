//! Runs of what is to be made: a plan is carried out, or a controller coordinates the cell, with
//! station libraries for the resources that are machines.

use super::machine::{self, RecipeMachine, Stopped};
use super::stations::Stations;
use crate::internal::Fault;
use linewright_core::diagnostics::Diagnostic;
use linewright_line::random::{Purpose, Stream};
use linewright_recipe::model::{self, Demand};
use linewright_recipe::plan::{Execution, Plan};
use linewright_recipe::run::{self, Performance, Plant, Run};
use std::str::FromStr;

/// Maximum number of positions of a plan in a run: a recipe with a loop may never end.
pub const MAX_POSITIONS: usize = 100;

/// How the tests of a run end.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Tests {
    /// Random seed. All transitions that can follow a test are equally probable.
    pub seed: u64,
    /// Tests that always end in the same way.
    pub fixed: Vec<FixedTest>,
}

/// A test that always ends in the same way.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FixedTest {
    /// State of the recipe in which the product is tested.
    pub from: String,
    /// State of the recipe that follows.
    pub to: String,
}

impl FromStr for FixedTest {
    type Err = String;

    /// Parses `b=d`.
    fn from_str(text: &str) -> Result<Self, String> {
        let states = text.split_once('=').map(|(a, b)| (a.trim(), b.trim()));
        match states {
            Some((from, to)) if !from.is_empty() && !to.is_empty() => Ok(Self {
                from: from.to_owned(),
                to: to.to_owned(),
            }),
            _ => Err("write the state of the test and the one that follows, such as `b=d`".into()),
        }
    }
}

impl FixedTest {
    /// Returns whether the test is one of this recipe.
    pub fn is_of(&self, recipe: &model::Recipe) -> bool {
        let mut leaving = recipe.transitions.iter().filter(|t| t.from == self.from);
        leaving.any(|t| t.to == self.to)
    }
}

/// Carries out a plan for a layout whose model is `layout`.
///
/// # Errors
/// A station library returns an error.
pub fn run(
    layout: &model::Layout,
    demands: &[Demand],
    plan: &Plan,
    stations: &mut Stations<'_>,
    tests: &Tests,
) -> Result<Run, Box<Diagnostic>> {
    let recipes = plan.products.iter().map(|d| &demands[*d].recipe);
    let mut cell = Cell::new(recipes.collect(), stations, tests);
    run::run(layout, demands, plan, &mut cell, MAX_POSITIONS)
}

/// Lets the controller of a recipe coordinate a layout whose model is `layout`. It must be one that
/// [`machine::build`] has made for them.
///
/// # Errors
/// A station library returns an error.
pub fn coordinate(
    layout: &model::Layout,
    recipe: &model::Recipe,
    controller: &RecipeMachine,
    execution: Execution,
    stations: &mut Stations<'_>,
    tests: &Tests,
) -> Result<Run, Box<Diagnostic>> {
    let mut cell = Cell::new(vec![recipe], stations, tests);
    let run = machine::run(
        layout,
        recipe,
        controller,
        &mut cell,
        execution,
        MAX_POSITIONS,
    );
    run.map_err(|stopped| match stopped {
        Stopped::Plant(finding) => finding,
        Stopped::Machine(message) => {
            let doing = format!("running `{}` on `{}`", recipe.name, layout.name);
            Box::new(Fault::detected(doing, message).finding(None))
        }
    })
}

/// A cell that makes products.
struct Cell<'a, 'l> {
    /// The recipe of each product.
    recipes: Vec<&'a model::Recipe>,
    stations: &'a mut Stations<'l>,
    fixed: &'a [FixedTest],
    /// Random numbers of each product.
    streams: Vec<Stream>,
}

impl<'a, 'l> Cell<'a, 'l> {
    fn new(
        recipes: Vec<&'a model::Recipe>,
        stations: &'a mut Stations<'l>,
        tests: &'a Tests,
    ) -> Self {
        let streams = (0..recipes.len())
            .map(|product| Stream::new(tests.seed, Purpose::Tests, &product.to_string()));
        Self {
            streams: streams.collect(),
            recipes,
            stations,
            fixed: &tests.fixed,
        }
    }
}

impl Plant for Cell<'_, '_> {
    type Error = Box<Diagnostic>;

    fn perform(
        &mut self,
        resource: usize,
        transition: usize,
    ) -> Result<Option<Performance>, Box<Diagnostic>> {
        self.stations.perform(resource, transition)
    }

    fn test(&mut self, product: usize, transitions: &[usize]) -> usize {
        // A draw for each test, so that a fixed test changes no other.
        let drawn = self.streams[product].below(transitions.len() as u64) as usize;
        let recipe = self.recipes[product];
        let is_fixed = |number: &&usize| {
            let transition = &recipe.transitions[**number];
            let same = |f: &FixedTest| f.from == transition.from && f.to == transition.to;
            self.fixed.iter().any(same)
        };
        *transitions
            .iter()
            .find(is_fixed)
            .unwrap_or(&transitions[drawn])
    }
}
