//! Past operators, counters and patterns as monitors, compared with their definitions on every
//! lasso of up to six positions.

mod circuit;
mod games;
mod logic;
mod past;
mod patterns;
mod play;
mod text;
mod words;

use linewright::gr1::monitors::{Monitors, Origin, Pattern, Scope};
use linewright::gr1::{Expr, VarId};
use patterns::{Case, cases};
use play::Player;
use rayon::prelude::*;
use std::collections::BTreeSet;
use words::{Lanes, Lassos, every_lasso, same};

/// Maximum number of positions of a lasso.
const LONGEST: usize = 6;

fn monitors_of(case: &Case) -> (Monitors, Player) {
    let variables = case.names.len();
    let mut monitors = Monitors::new(VarId(variables as u32), []);
    let obligations = monitors.pattern(&case.pattern, &case.scope, &Origin::default());
    let player = Player::new(variables, &monitors, &obligations, None);
    (monitors, player)
}

/// The obligations of each pattern hold exactly where its formula does, also when they are split up
/// to be assumed.
#[test]
fn patterns_mean_their_formulas() {
    compare_with_formulas(LONGEST - 1);
}

#[test]
#[ignore = "takes a minute: cargo test --test solver monitors:: -- --ignored"]
fn patterns_mean_their_formulas_on_longer_lassos() {
    compare_with_formulas(LONGEST);
}

fn compare_with_formulas(longest: usize) {
    let count = |case: &Case| {
        let meaning = logic::read(&case.meaning, &case.names);
        let (_, player) = monitors_of(case);
        let (mut kept_some, mut broken_some) = (false, false);
        let count = every_lasso(case.names.len(), longest, &mut |lassos| {
            let expected = meaning.on(lassos)[0];
            let kept = player.kept(lassos);
            for (what, found) in [("kept", kept.guaranteed), ("assumed", kept.assumed)] {
                if let Some(lane) = (!same(expected, found)).first() {
                    panic!(
                        "{} on {}: {} is {}, {what} {}",
                        case.name,
                        lassos.show(lane, &case.names),
                        case.meaning,
                        expected.at(lane),
                        found.at(lane)
                    );
                }
            }
            kept_some |= expected.first().is_some();
            broken_some |= (!expected).first().is_some();
        });
        assert!(kept_some && broken_some, "{} says nothing", case.name);
        count
    };
    let cases = cases(0..=3);
    let lassos: u64 = cases.par_iter().map(count).sum();
    println!("{} formulas, {lassos} lassos", cases.len());
    assert_eq!(cases.len(), 25 + 10 * 4);
}

/// The table in the module's documentation is correct, and its numbers are minimal: this many pasts
/// must be distinguished, since some future is correct after one of them and wrong after the other.
/// (A past after which every future is wrong needs no state.)
#[test]
fn monitors_have_few_bits() {
    let bits = |case: &Case| -> u32 {
        let (monitors, _) = monitors_of(case);
        let sizes = monitors.variables().map(|v| v.domain.size());
        sizes.map(|size| (size - 1).ilog2() + 1).sum()
    };
    let all = cases(0..=0);
    let plain = &all[..25];
    let absence = [0, 2, 1, 2, 1];
    let expected = [
        absence,
        [1, 1, 2, 1, 1],
        absence,
        [1, 2, 2, 2, 1],
        [1, 2, 2, 2, 2],
    ];
    for (case, expected) in plain.iter().zip(expected.concat()) {
        assert_eq!(bits(case), expected, "{}", case.name);
        let pasts = pasts_that_differ(case);
        let needed = pasts.next_power_of_two().ilog2();
        assert_eq!(needed, expected, "{}: {pasts} pasts", case.name);
    }
    // A bound needs one counter, and a bit if the scope must be known.
    let bits = |pattern: &Pattern, scope: &Scope| {
        let mut monitors = Monitors::new(VarId(9), []);
        monitors.pattern(pattern, scope, &Origin::default());
        monitors
            .variables()
            .map(|v| v.domain.size())
            .product::<u64>()
    };
    let var = |v| Expr::now(VarId(v));
    let response = Pattern::Response {
        trigger: var(0),
        answer: var(1),
        within: Some(6),
    };
    assert_eq!(bits(&response, &Scope::Globally), 7);
    assert_eq!(bits(&response, &Scope::After(var(2))), 2 * 7);
    assert_eq!(bits(&response, &Scope::Between(var(2), var(3))), 2 * 8);
}

/// Number of pasts of at most two steps with different futures, as far as short lassos show it.
fn pasts_that_differ(case: &Case) -> usize {
    let variables = case.names.len();
    let meaning = logic::read(&case.meaning, &case.names);
    let letters = 1 << variables;
    let letter = |number: usize| -> Vec<Lanes> {
        let lanes = |v: usize| [Lanes::NONE, Lanes::ALL][number >> v & 1];
        (0..variables).map(lanes).collect()
    };
    let mut pasts = vec![Vec::new()];
    pasts.extend((0..letters).map(|a| vec![letter(a)]));
    pasts.extend((0..letters * letters).map(|n| vec![letter(n % letters), letter(n / letters)]));
    let futures = |past: &Vec<Vec<Lanes>>| {
        let mut right = Vec::new();
        every_lasso(variables, 2, &mut |lassos| {
            let whole = Lassos {
                letters: [past.clone(), lassos.letters.clone()].concat(),
                back: past.len() + lassos.back,
            };
            right.push(meaning.on(&whole)[0].0);
        });
        right
    };
    let different: BTreeSet<Vec<[u64; 4]>> = pasts.iter().map(futures).collect();
    let possible = different.iter().filter(|f| f.iter().any(|x| *x != [0; 4]));
    possible.count()
}

/// Equal parts of different formulas share one monitor; names are free ones.
#[test]
fn equal_pieces_are_shared() {
    let taken = ["once_1", "waiting_2"].map(str::to_owned);
    let mut monitors = Monitors::new(VarId(3), taken);
    let origin = Origin::default();
    let [p, q, r] = [0, 1, 2].map(|v| Expr::now(VarId(v)));
    let scope = Scope::After(q.clone());
    monitors.pattern(&Pattern::Absence(p.clone()), &scope, &origin);
    monitors.pattern(&Pattern::Universality(r.clone()), &scope, &origin);
    assert_eq!(monitors.all().len(), 1);
    let once = monitors.once(&q, &origin);
    assert_eq!(monitors.previous(&once, &origin), Expr::now(VarId(3)));
    assert_eq!(monitors.all().len(), 1);
    monitors.pattern(&Pattern::Existence(p.clone(), None), &scope, &origin);
    monitors.pattern(&Pattern::Existence(r, None), &scope, &origin);
    let names: Vec<&str> = monitors.variables().map(|v| v.name.as_str()).collect();
    assert_eq!(names, ["once_2", "waiting_1", "waiting_3"]);
    // If the past does not matter, nothing is stored.
    for constant in [Expr::TRUE, Expr::FALSE] {
        assert_eq!(monitors.once(&constant, &origin), constant);
        assert_eq!(monitors.historically(&constant, &origin), constant);
        assert_eq!(monitors.since(&p, &constant, &origin), constant);
    }
    assert_eq!(monitors.since(&Expr::FALSE, &p, &origin), p);
    assert_eq!(monitors.all().len(), 3);
}

/// Precedence after q differs from Dwyer's formula, but is never weaker, and the same if q holds
/// once.
#[test]
fn after_q_the_first_q_is_meant() {
    let names = ['p', 'q', 's'];
    let ours = logic::read("!q W (q & (!p W s))", &names);
    let dwyers = logic::read("G !q or F (q & (!p W s))", &names);
    let mut different = false;
    every_lasso(3, LONGEST, &mut |lassos| {
        let [ours, dwyers] = [&ours, &dwyers].map(|f| f.on(lassos)[0]);
        assert_eq!((ours & !dwyers).first(), None);
        different |= (dwyers & !ours).first().is_some();
        let cycle = lassos.letters[lassos.back..].iter();
        let often = cycle.fold(Lanes::NONE, |often, letter| often | letter[1]);
        let mut twice = often;
        let mut once = Lanes::NONE;
        for letter in &lassos.letters[..lassos.back] {
            twice = twice | (once & letter[1]);
            once = once | letter[1];
        }
        assert_eq!((!twice & !same(ours, dwyers)).first(), None);
    });
    assert!(different);
}
