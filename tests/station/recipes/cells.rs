//! Recipes with their controllers: those of `examples/pad`, one with odd names, and random ones.

use crate::random_cells;
use crate::support::root;
use linewright::contract::load;
use linewright::engine::recipes::machine::{RecipeMachine, build};
use linewright_recipe::controller::Controller;
use linewright_recipe::model::{Layout, Recipe};
use linewright_recipe::realize::{Outcome, SearchLimits, realize};

/// Number of random cells.
const RANDOM: usize = 24;

/// Ports and labels that would have the same names, also where case does not count; what resources
/// with room for several parts have to know; an action that leads to two states; states in which
/// nothing may wait; two guards, a loop, and a duplicate.
const ODD: &str = "
layout Odd {
    resource done: Loader at s0 {
        s0 -> s1: load
        s1 -> s0: out
        nop s0, s1
    }
    resource int at s0 holds 2 {
        s0 -> s0: in
        s0 -> s1: wait, internal rise
        s1 -> s0: internal turn
        s1 -> s2: internal turn
        s2 -> s0: join
        s0 -> s0: look, store, good_ab
        nop s0
    }
    resource Int = int
    transport finished holds 2 {
        done -> int
    }
}

recipe R {
    part a: A, b: B, ab: AB
    start q0
    q0 -> q1: load()(a); wait(a)(a); load()(b); join(a, b)(ab); look(ab)(ab)
    q1 -> q2 when good(ab) at int, Int: store(ab)()
    q1 -> q3 when fair(ab)
    q1 -> q1 otherwise: wait(ab)(ab); look(ab)(ab)
    q3 -> q2 when good(ab): store(ab)()
    q3 -> q1 when good_ab(): look(ab)(ab)
    q3 -> q2 otherwise: good_ab(ab)(ab); store(ab)()
    end q2
}

realize R on Odd
";

/// A recipe on a layout, with its controller and the machine.
pub struct Made {
    pub layout: Layout,
    pub recipe: Recipe,
    pub controller: Controller,
    pub built: RecipeMachine,
}

impl Made {
    /// The machine, if there is one.
    fn new(layout: &Layout, recipe: &Recipe) -> Option<Self> {
        let outcome = realize(layout, recipe, SearchLimits::default());
        let Ok(Outcome::Realizable(controller)) = outcome else {
            return None;
        };
        let built = build(layout, recipe, &controller);
        let built = built.unwrap_or_else(|e| panic!("{e:?}\n{layout:#?}\n{recipe:#?}"));
        Some(Self {
            layout: layout.clone(),
            recipe: recipe.clone(),
            controller,
            built,
        })
    }
}

/// The machines of all statements `realize` of a text.
fn of_text(text: String) -> Vec<Made> {
    let other = |name: &str, _: &_| {
        let path = root().join("examples/pad").join(name);
        std::fs::read_to_string(path)
            .map(|text| (name.to_owned(), text))
            .map_err(|e| e.to_string())
    };
    let (library, findings) = load(&[("a.lw".to_owned(), text)], &other);
    assert!(findings.is_empty(), "{findings:#?}");
    let own = library.realizations.iter().filter(|r| {
        let file = library.sources.file(r.span.file);
        file.name == "a.lw"
    });
    let models = own.map(|r| {
        let layout = library.layout_at(r.layout_declared).expect("a layout");
        let recipe = library.recipe_at(r.recipes[0].declared).expect("a recipe");
        (&layout.model, &recipe.model)
    });
    models
        .filter_map(|(layout, recipe)| Made::new(layout, recipe))
        .collect()
}

/// The one with odd names.
pub fn odd() -> Made {
    of_text(ODD.to_owned()).swap_remove(0)
}

/// Those of the demonstrator, the odd one, and the first random ones with at least two vectors.
pub fn all() -> Vec<Made> {
    let mut all = vec![odd()];
    for name in ["hinge", "six", "parallel", "ten"] {
        let path = root().join(format!("examples/pad/{name}.lw"));
        all.extend(of_text(std::fs::read_to_string(path).expect("a file")));
    }
    assert_eq!(all.len(), 5);
    all.extend(random().take(RANDOM));
    all
}

/// The random ones with at least two vectors.
pub fn random() -> impl Iterator<Item = Made> {
    (0..).filter_map(|seed| {
        let (mut layout, recipe) = random_cells::cell(seed);
        layout.name = format!("Cell{seed}");
        Made::new(&layout, &recipe).filter(|m| m.controller.vectors() > 1)
    })
}
