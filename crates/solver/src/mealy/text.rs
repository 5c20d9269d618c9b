//! Formats guards for readers.
//!
//! The cubes of a guard are disjoint and have one interval per input. To shorten the text, cubes
//! that differ in only one input are combined, so that `cmd in {none, pick} & grip | cmd = move &
//! grip` becomes `cmd != turn & grip`.

use super::{Cube, Guard, Machine, Port};
use linewright_core::gr1::{Domain, show_value};

/// Values of one input: ascending intervals with gaps between them.
pub type Values = Vec<(i64, i64)>;

/// Guards with more cubes than this are not combined, because combining takes cubic time.
const MAX_CUBES: usize = 200;

/// Returns the disjunction of some guards: for every combined cube, the values of each input.
pub fn guard_values(machine: &Machine, guards: &[&Guard]) -> Vec<Vec<Values>> {
    let mut cubes: Vec<Vec<Values>> = guards
        .iter()
        .flat_map(|g| &g.0)
        .map(|c| values(machine, c))
        .collect();
    if cubes.len() <= MAX_CUBES {
        while combine_cubes(&mut cubes) {}
    }
    cubes
}

/// Formats the disjunction of some guards, with cubes merged where possible: for each cube, the
/// list of its tests. An empty list means that the cube is always true.
pub fn guard_parts(machine: &Machine, guards: &[&Guard]) -> Vec<Vec<String>> {
    let cubes = guard_values(machine, guards);
    let show = |cube: Vec<Values>| -> Vec<String> {
        let pairs = machine.inputs.iter().zip(cube);
        pairs.filter_map(|(p, v)| show_test(p, &v)).collect()
    };
    cubes.into_iter().map(show).collect()
}

/// Returns the values of every input that a cube allows.
fn values(machine: &Machine, cube: &Cube) -> Vec<Values> {
    let ports = machine.inputs.iter();
    let mut all: Vec<Values> = ports
        .map(|p| vec![(p.domain.low(), p.domain.high())])
        .collect();
    for test in &cube.0 {
        all[test.input] = vec![(test.low, test.high)];
    }
    all
}

/// Combines the first two cubes that differ in only one input; returns false if none do.
fn combine_cubes(cubes: &mut Vec<Vec<Values>>) -> bool {
    for a in 0..cubes.len() {
        for b in a + 1..cubes.len() {
            let mut differing = (0..cubes[a].len()).filter(|i| cubes[a][*i] != cubes[b][*i]);
            let (first, second) = (differing.next(), differing.next());
            let (Some(input), None) = (first, second) else {
                continue;
            };
            let mut union = [&cubes[a][input][..], &cubes[b][input][..]].concat();
            union.sort_unstable();
            let mut merged: Values = Vec::new();
            for (low, high) in union {
                match merged.last_mut() {
                    Some(last) if last.1 + 1 >= low => last.1 = last.1.max(high),
                    _ => merged.push((low, high)),
                }
            }
            cubes[a][input] = merged;
            cubes.remove(b);
            return true;
        }
    }
    false
}

/// Formats the test of one input; `None` if every value is allowed.
fn show_test(port: &Port, values: &Values) -> Option<String> {
    let (name, domain) = (&port.name, &port.domain);
    let (low, high) = (domain.low(), domain.high());
    let show = |value: i64| show_value(domain, value, &port.unit);
    if values[..] == [(low, high)] {
        return None;
    }
    if let Some(missing) = missing_value(values, low, high)
        && high - low > 1
    {
        return Some(format!("{name} != {}", show(missing)));
    }
    Some(match (values[..].as_ref(), domain) {
        ([(a, b)], Domain::Bool) if a == b => {
            format!("{}{name}", if *a == 0 { "!" } else { "" })
        }
        ([(a, b)], _) if a == b => format!("{name} = {}", show(*a)),
        (_, Domain::Enum { .. }) => {
            let all = values.iter().flat_map(|(a, b)| *a..=*b);
            let labels: Vec<String> = all.map(|v| domain.show(v)).collect();
            format!("{name} in {{{}}}", labels.join(", "))
        }
        ([(a, b)], _) if *a == low => format!("{name} <= {}", show(*b)),
        ([(a, b)], _) if *b == high => format!("{name} >= {}", show(*a)),
        ([(a, b)], _) => format!("{} <= {name} <= {}", show(*a), show(*b)),
        _ => {
            let pieces = values.iter();
            let pieces: Vec<String> = pieces
                .map(|(a, b)| {
                    if a == b {
                        show(*a)
                    } else {
                        format!("{a}..{}", show(*b))
                    }
                })
                .collect();
            format!("{name} in {{{}}}", pieces.join(", "))
        }
    })
}

/// Returns the value from `low` to `high` that `values` omits, if it omits exactly one.
fn missing_value(values: &Values, low: i64, high: i64) -> Option<i64> {
    match values[..] {
        [(a, b)] if a == low && b == high - 1 => Some(high),
        [(a, b)] if a == low + 1 && b == high => Some(low),
        [(a, b), (c, d)] if a == low && d == high && c == b + 2 => Some(b + 1),
        _ => None,
    }
}
