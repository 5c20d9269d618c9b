//! Past operators, counters and patterns as monitors, against their definitions on every lasso of up to six positions.

#[path = "monitors/circuit.rs"]
mod circuit;
#[path = "monitors/logic.rs"]
mod logic;
#[path = "monitors/past.rs"]
mod past;
#[path = "monitors/patterns.rs"]
mod patterns;
#[path = "monitors/play.rs"]
mod play;
#[path = "monitors/words.rs"]
mod words;

use linewright::gr1::VarId;
use linewright::gr1::monitors::{Monitors, Origin};
use patterns::{Case, cases};
use play::Player;
use rayon::prelude::*;
use words::{every_lasso, same};

/// No lasso has more positions.
const LONGEST: usize = 6;

fn monitors_of(case: &Case) -> (Monitors, Player) {
    let variables = case.names.len();
    let mut monitors = Monitors::new(VarId(variables as u32), []);
    let obligations = monitors.pattern(&case.pattern, &case.scope, &Origin::default());
    let player = Player::new(variables, &monitors, &obligations, None);
    (monitors, player)
}

/// The obligations of each pattern hold exactly where its formula does, also when they are taken apart to be assumed.
#[test]
fn patterns_mean_their_formulas() {
    let count = |case: &Case| {
        let meaning = logic::read(&case.meaning, &case.names);
        let (_, player) = monitors_of(case);
        let (mut kept_some, mut broken_some) = (false, false);
        let count = every_lasso(case.names.len(), LONGEST, &mut |lassos| {
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
