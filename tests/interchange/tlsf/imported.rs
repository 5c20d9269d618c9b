//! The output of `linewright import` for a TLSF file means the same.

use super::{file, reload, sound, verdict};
use linewright::interchange::contract;

/// Names that are valid in the format but not in Linewright's language: its words, apostrophes,
/// `@`, elements of a bus beside a similar name.
#[test]
fn names_of_the_language_are_others_in_the_contract() {
    let main = "INPUTS { next; always; input; mod; r[2]; a'; a@; } OUTPUTS { guarantee; not; r_0; then; X1; broken; }
        ASSUME { G (next -> X !next); G F !always; }
        GUARANTEE { G (next && r[0] -> X guarantee); G (always -> F not); !then W input; G (r_0 <-> a' && a@); G (mod -> broken); X1; }";
    for semantics in ["Mealy", "Moore", "Mealy,Strict", "Moore,Strict"] {
        let target = semantics.split(',').next().unwrap_or(semantics);
        let specification = sound(&file(semantics, target, main));
        let printed = reload(&contract::write(&specification, "test.tlsf"));
        assert_eq!(verdict(&printed), verdict(&specification), "{semantics}");
        assert_eq!(printed.variables.len(), specification.variables.len());
    }
}
