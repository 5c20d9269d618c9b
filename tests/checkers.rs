//! Who checks the checkers.

#[path = "checkers/switch.rs"]
mod switch;

/// Copies of the checkers that can be made wrong.
mod copies {
    use linewright::mealy::{Cube, Machine, Port, Transition, functions};
    mutation::mutants! { "src/mealy/verify/mod.rs", "src/mealy/certify.rs" }
}

#[test]
fn shows() {
    for (i, m) in copies::MUTANTS.iter().enumerate() {
        println!(
            "{i} {} {} {}: {}  =>  {}",
            m.file, m.function, m.operator, m.right, m.wrong
        );
    }
}
