//! Records, arrays of any type, units and definitions with parameters: a contract that uses them
//! means the same as one written in full.

use linewright::contract::load;
use linewright::diagnostics::Severity;
use linewright::gr1::{Formula, Side, Specification, eval};

/// The specification of the only contract of a file. Its variables are compared by index.
fn read(text: &str) -> Specification {
    let files = [("test.lw".to_owned(), text.to_owned())];
    let (library, findings) = load(&files, &|_, _| Err("no imports".to_owned()));
    let mut errors = findings.iter().filter(|f| f.severity == Severity::Error);
    assert!(errors.next().is_none(), "{text}\n{findings:#?}");
    (*library.contracts[0].specification).clone()
}

/// A pseudorandom number, always the same for the same seed.
fn scrambled(seed: u64) -> u64 {
    let mut x = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

fn valuation(specification: &Specification, seed: u64) -> Vec<i64> {
    let variables = specification.variables.iter().enumerate();
    variables
        .map(|(i, v)| {
            let size = v.domain.high() - v.domain.low() + 1;
            let draw = scrambled(seed ^ scrambled(i as u64 + 1)) % size as u64;
            v.domain.low() + draw as i64
        })
        .collect()
}

/// Both contracts hold in the same steps. `differ` counts how often each formula is true and false,
/// so that no comparison is about a constant.
fn same(short: &str, long: &str) {
    let (a, b) = (read(short), read(long));
    let domains = |s: &Specification| -> Vec<(i64, i64)> {
        s.variables
            .iter()
            .map(|v| (v.domain.low(), v.domain.high()))
            .collect()
    };
    assert_eq!(domains(&a), domains(&b), "{short}\n{long}");
    let lists = |side: &Side| {
        [
            side.initial.clone(),
            side.invariants.clone(),
            side.safety.clone(),
            side.justice.clone(),
        ]
    };
    for (a_side, b_side) in [
        (&a.assumptions, &b.assumptions),
        (&a.guarantees, &b.guarantees),
    ] {
        for (x, y) in lists(a_side).iter().zip(&lists(b_side)) {
            let (mut held, mut failed) = (false, false);
            for round in 0..4000 {
                let (now, next) = (valuation(&a, 2 * round), valuation(&a, 2 * round + 1));
                let all = |list: &[Formula]| list.iter().all(|f| eval::holds(&f.expr, &now, &next));
                assert_eq!(all(x), all(y), "{short}\n{long}\n{now:?} {next:?}");
                held |= all(x);
                failed |= !all(x);
            }
            assert!(x.is_empty() || held && failed, "always the same: {short}");
        }
    }
}

#[test]
fn records_are_their_members() {
    same(
        "type Place = record { x: 0..3, y: 0..2 }
         contract C {
             input goal: Place
             output at: Place
             output slots: array[2] of Place
             output which: 0..1
             guarantee first: at = {y = 1, x = 2} or at = goal
             guarantee moves: always (next at = goal or next at.x = at.x)
             guarantee holds: always (slots[which] = at or slots[which].x > goal.y)
             guarantee chosen: always (if which = 0 then slots[0] else goal) = slots[1]
         }",
        "contract C {
             input goal_x: 0..3
             input goal_y: 0..2
             output x: 0..3
             output y: 0..2
             output x0: 0..3
             output y0: 0..2
             output x1: 0..3
             output y1: 0..2
             output which: 0..1
             guarantee first: (x = 2 and y = 1) or (x = goal_x and y = goal_y)
             guarantee moves: always ((next x = goal_x and next y = goal_y) or next x = x)
             guarantee holds: always (if which = 0 then (x0 = x and y0 = y) or x0 > goal_y else (x1 = x and y1 = y) or x1 > goal_y)
             guarantee chosen: always (if which = 0 then x0 = x1 and y0 = y1 else goal_x = x1 and goal_y = y1)
         }",
    );
}

#[test]
fn members_may_stand_in_any_order() {
    same(
        "contract C {
             input a: record {x: 0..3, y: 0..3}
             output b: record {y: 0..3, x: 0..3}
             guarantee g: always (next (a = b) or b = a)
         }",
        "contract C {
             input ax: 0..3
             input ay: 0..3
             output by: 0..3
             output bx: 0..3
             guarantee g: always ((next ax = next bx and next ay = next by) or (ax = bx and ay = by))
         }",
    );
}

#[test]
fn arrays_of_arrays_are_long_arrays() {
    same(
        "contract C {
             input row: 0..1
             input column: 0..2
             output cells: array[2] of array[3] of 0..3
             guarantee first: forall r in cells: cells[r][0] = r
             guarantee bounded: always (cells[row][column] < 3 or next cells[row][2] = cells[0][column])
             guarantee equal: always (cells[0] = cells[1] or cells[1][column] = 2)
             guarantee total: always eventually (sum r in cells: cells[r][1]) > 2
         }",
        "contract C {
             input row: 0..1
             input column: 0..2
             output cells: array[6] of 0..3
             guarantee first: cells[0] = 0 and cells[3] = 1
             guarantee bounded: always (cells[3 * row + column] < 3 or next cells[3 * row + 2] = cells[column])
             guarantee equal: always ((forall i in 0..2: cells[i] = cells[3 + i]) or cells[3 + column] = 2)
             guarantee total: always eventually (cells[1] + cells[4] > 2)
         }",
    );
}

#[test]
fn units_are_converted_exactly() {
    same(
        "const NEAR = 0.5 cm
         contract C {
             input a: 0..30 mm
             input b: 0..3 cm
             input t: 0..2 min
             output c: 0..(3 * 10) mm
             output d: 1 mm..1 cm
             output wait: 0..120 s
             guarantee first: c <= 2 cm and wait = 1 min
             guarantee near: always (abs(a - b) <= NEAR -> c in {5 mm, 1 cm} or c in 2 cm..25 mm)
             guarantee sums: always (a + b > 3 cm or 2 * d = next c)
             guarantee parts: always (c / 1 cm = 2 or c mod 1 cm = 3 mm or c / 2 > d)
             guarantee least: always min(a, b, 25 mm) <= max(d, 0)
             guarantee time: always (if a > b then t else 30 s) >= wait
             guarantee choice: always (next c >= (if a > b then 2 cm else if d > 5 mm then 12 mm else 0 mm))
         }",
        "contract C {
             input a: 0..30
             input b: 0..3
             input t: 0..2
             output c: 0..30
             output d: 1..10
             output wait: 0..120
             guarantee first: c <= 20 and wait = 60
             guarantee near: always (abs(a - 10 * b) <= 5 -> c in {5, 10} or c in 20..25)
             guarantee sums: always (a + 10 * b > 30 or 2 * d = next c)
             guarantee parts: always (c / 10 = 2 or c mod 10 = 3 or c / 2 > d)
             guarantee least: always min(a, 10 * b, 25) <= max(d, 0)
             guarantee time: always (if a > 10 * b then 60 * t else 30) >= wait
             guarantee choice: always (next c >= (if a > 10 * b then 20 else if d > 5 then 12 else 0))
         }",
    );
}

#[test]
fn definitions_mean_the_same_wherever_they_are_used() {
    same(
        "const N = 2
         define big(x) = x >= N
         define apart(x: 0..5, y: 0..5) = abs(x - y) >= N and big(x)
         contract C(limit: 0..5 = 4) {
             input a: 0..5
             output N: 0..5
             output h: array[3] of 0..5
             define small(x) = x < limit
             define twin(i, p: bool) = h[i] = h[2 - i] and p
             guarantee hides: always (big(a) or N = 1)
             guarantee steps: always (next apart(a, N) -> small(N) and apart(N, next a))
             guarantee all: always forall i in h: twin(i, big(h[i])) or small(next h[i])
             guarantee i_is_bound: always exists i in 0..2: twin(2 - i, i > 0)
         }",
        "contract C(limit: 0..5 = 4) {
             input a: 0..5
             output n: 0..5
             output h: array[3] of 0..5
             guarantee hides: always (a >= 2 or n = 1)
             guarantee steps: always ((abs(next a - next n) >= 2 and next a >= 2) ->
                 n < 4 and abs(n - next a) >= 2 and n >= 2)
             guarantee all: always forall i in 0..2: (h[i] = h[2 - i] and h[i] >= 2) or next h[i] < 4
             guarantee i_is_bound: always exists i in 0..2: h[2 - i] = h[i] and i > 0
         }",
    );
}
