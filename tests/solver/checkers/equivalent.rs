//! The undetectable mutants: whatever is checked, the verdict is the same, and so is the play that
//! shows it.
//!
//! Most save time: a table of known results, or a test that avoids others. Later code does what
//! they omit.

/// An equivalent mutant.
pub struct Equivalent {
    pub file: &'static str,
    pub function: &'static str,
    pub right: &'static str,
    pub wrong: &'static str,
    /// Index among the mutants with this description in the function, in text order.
    pub number: usize,
    /// Why it is equivalent.
    pub why: &'static str,
}

const CERTIFY: &str = "crates/solver/src/mealy/certify.rs";
const COUNTER: &str = "crates/solver/src/mealy/verify/counter.rs";
const FAIR: &str = "crates/solver/src/mealy/verify/fair.rs";
const FORM: &str = "crates/solver/src/mealy/verify/form.rs";
const RESIDUAL: &str = "crates/solver/src/mealy/verify/residual.rs";
const VERIFY: &str = "crates/solver/src/mealy/verify/mod.rs";

pub const EQUIVALENT: &[Equivalent] = &[
    Equivalent {
        file: COUNTER,
        function: "leaf",
        right: "answers.edges.last() != Some(& edge)",
        wrong: "true",
        number: 1,
        why: "`close` leaves each edge of a node once, so an edge that is put down again goes there",
    },
    Equivalent {
        file: FAIR,
        function: "components",
        right: "0",
        wrong: "1",
        number: 1,
        why: "numbers of nodes are only compared with each other and with NEW, wherever they begin",
    },
    Equivalent {
        file: FAIR,
        function: "components",
        right: "0",
        wrong: "1",
        number: 2,
        why: "as `all but the first` below: the same nodes are roots",
    },
    Equivalent {
        file: FAIR,
        function: "components",
        right: "0 .. count",
        wrong: "all but the first",
        number: 1,
        why: "node 0 is met from another root, or lies on no cycle but its own edges: then it alone keeps the part NEW, \
              which is as good a name as any",
    },
    Equivalent {
        file: FORM,
        function: "of",
        right: "0",
        wrong: "1",
        number: 1,
        why: "whether justice is satisfied in step 0 is never asked: the node before it lies on no cycle",
    },
    Equivalent {
        file: RESIDUAL,
        function: "choose",
        right: "None => a",
        wrong: "None => b",
        number: 1,
        why: "this arm is taken where `a == b`",
    },
    Equivalent {
        file: RESIDUAL,
        function: "fix",
        right: "self.fixed.insert((id, key, value), result)",
        wrong: "",
        number: 1,
        why: "what is fixed depends on expression, key and value alone and is interned: done again, it has the same number",
    },
    Equivalent {
        file: RESIDUAL,
        function: "answer",
        right: "known != UNKNOWN",
        wrong: "false",
        number: 1,
        why: "formulas fixed again are the same, and `place` finds the place that their list has",
    },
    Equivalent {
        file: RESIDUAL,
        function: "answer",
        right: "self.branches [place as usize].children [slot] = child",
        wrong: "",
        number: 1,
        why: "an answer that is not noted is worked out again; `place` finds the place that the list has",
    },
    Equivalent {
        file: VERIFY,
        function: "context",
        right: "self.known.insert(place, Rc :: clone(& context))",
        wrong: "",
        number: 1,
        why: "a context depends on its place alone; one that is not noted is made again, with the same places",
    },
    Equivalent {
        file: VERIFY,
        function: "explore",
        right: "edges.last() != Some(& edge)",
        wrong: "true",
        number: 1,
        why: "`close` leaves each edge of a node once, so an edge that is put down again goes there",
    },
    Equivalent {
        file: CERTIFY,
        function: "possible",
        right: "self.kernel.is_false(& left)",
        wrong: "false",
        number: 1,
        why: "nothing and a promise is nothing: the last line says no just as well",
    },
    Equivalent {
        file: CERTIFY,
        function: "broken",
        right: "m.and_not(steps, cluster)",
        wrong: ":: core :: result :: Result :: < _, linewright :: game :: Limit > :: Ok((steps).clone())",
        number: 1,
        why: "a cluster is the conjunction of its formulas: of one that all steps keep, each formula is looked at in vain",
    },
    Equivalent {
        file: CERTIFY,
        function: "broken",
        right: "! m.is_false(& m.and_not(steps, cluster) ?)",
        wrong: "true",
        number: 1,
        why: "as above: formulas are looked at in their order, and those of a cluster that is kept are kept",
    },
    Equivalent {
        file: CERTIFY,
        function: "assumptions",
        right: "! rules.contains(f)",
        wrong: "true",
        number: 1,
        why: "a function that is one of the promises is false nowhere where they hold: it is asked for in vain",
    },
    Equivalent {
        file: CERTIFY,
        function: "assumptions",
        right: "! checked.contains(p)",
        wrong: "true",
        number: 1,
        why: "a promise that is one of the functions asked for is broken nowhere where they hold: it is looked at in vain",
    },
];
