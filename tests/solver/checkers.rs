//! Tests of the checkers: the verifier of machines, the verifier of counterstrategies and the
//! certifier of functions are given artefacts that are wrong in each way their definitions forbid,
//! and must name the clause; and they are mutated themselves, place by place, which must be
//! detected.
//!
//! | file | content |
//! |---|---|
//! | `definition` | the definitions, by enumeration: the set of clauses that an artefact violates |
//! | `artefacts` | correct artefacts of the repository's contracts and of random specifications, and changes to them |
//! | `witness` | whether the play shown by a verifier violates the clause it names |
//! | `../checker.rs` | the checker of proofs |
//! | `../switch.rs` | the active one of the mutants made by `mutation` |
//! | `equivalent` | the undetectable mutants, with the reason for each |

mod artefacts;
mod definition;
mod equivalent;
mod witness;

use crate::random::Random;
use crate::{checker, random, switch};
use artefacts::{Artefact, Tried};
use linewright::game::{Limit, Limits};
use linewright::gr1::{Owner, Specification};
use linewright::mealy::{certify, verify};
use std::collections::{BTreeMap, BTreeSet};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::OnceLock;
use std::time::Instant;

/// The checkers with a switch at every place that can be made wrong.
mod copies {
    #[allow(unused_imports, reason = "what the copies find beside them")]
    use crate::{game, random};
    #[allow(unused_imports, reason = "what the copies find beside them")]
    use linewright::mealy::{Cube, Machine, Port, Transition, functions};
    mutation::mutants! { "crates/solver/src/mealy/verify/mod.rs", "crates/solver/src/mealy/certify.rs", "tests/solver/checker.rs" }
}

/// An artefact with its correct verdicts.
struct Case {
    specification: Specification,
    artefact: Artefact,
    limits: Limits,
    /// The clauses that it violates, as printed; empty if it is correct. A checker names one of
    /// them.
    broken: BTreeSet<String>,
    /// Whether it violates a single clause, and none of a later stage.
    alone: bool,
}

const ACCEPTED: &str = "accepted";

impl Case {
    /// Whether a verdict is correct. A play that does not show its violation is not.
    fn allows(&self, verdict: &str) -> bool {
        self.broken.contains(verdict) || self.broken.is_empty() && verdict == ACCEPTED
    }
}

/// Verdict of the checker's copy; with a play, whether that shows the violation.
fn verdict(case: &Case) -> String {
    let (specification, limits) = (&case.specification, &case.limits);
    match &case.artefact {
        Artefact::Machine(machine) => {
            match copies::verify::verify(specification, machine, limits) {
                Ok(Ok(())) => ACCEPTED.to_owned(),
                Ok(Err(v)) => witness::machine(
                    specification,
                    machine,
                    format!("{:?}", v.clause),
                    &v.trace,
                    v.repeats_from,
                ),
                Err(limit) => format!("{limit:?}"),
            }
        }
        Artefact::Counterstrategy(machine) => {
            match copies::verify::verify_counterstrategy(specification, machine, limits) {
                Ok(Ok(())) => ACCEPTED.to_owned(),
                Ok(Err(v)) => {
                    let clause = format!("{:?}", v.clause);
                    witness::counterstrategy(
                        specification,
                        machine,
                        clause,
                        &v.trace,
                        v.repeats_from,
                    )
                }
                Err(limit) => format!("{limit:?}"),
            }
        }
        Artefact::Functions(functions) => {
            match copies::certify::certify(specification, functions, limits) {
                Ok(Ok(())) => ACCEPTED.to_owned(),
                Ok(Err(fault)) => format!("{:?}", fault.clause),
                Err(limit) => format!("{limit:?}"),
            }
        }
        Artefact::Graph(edges, met) => witness::cycle(edges, *met),
        Artefact::Formulas(formulas, values) => witness::formulas(specification, formulas, values),
        Artefact::Product(of) => witness::product(specification, of, limits),
        Artefact::Proof(document, tried) => {
            let some = |states, inputs| copies::checker::Extent::Some {
                seed: 1,
                states,
                inputs,
            };
            let extent = match tried {
                Tried::All => copies::checker::Extent::All,
                Tried::Some => some(TRIED, TRIED),
                Tried::StatesOnly => some(TRIED_ALONE, 0),
            };
            let found = copies::checker::accepts(specification, document, extent);
            let clause = |clause: copies::checker::Clause| first_word(&format!("{clause:?}"));
            found.map_or_else(clause, |()| ACCEPTED.to_owned())
        }
    }
}

/// Number of states and inputs to try instead of enumerating them: enough to meet all of six.
const TRIED: u64 = 60;

/// Number of states to try without inputs: of some forty.
const TRIED_ALONE: u64 = 600;

fn first_word(clause: &str) -> String {
    clause.split('(').next().unwrap_or(clause).to_owned()
}

/// Verdict of the checkers themselves.
fn said(case: &Case) -> String {
    let (specification, limits) = (&case.specification, &case.limits);
    let clause = |found: Result<Result<(), String>, Limit>| match found {
        Ok(Ok(())) => ACCEPTED.to_owned(),
        Ok(Err(clause)) => clause,
        Err(limit) => format!("{limit:?}"),
    };
    match &case.artefact {
        Artefact::Machine(machine) => {
            let found = verify::verify(specification, machine, limits);
            clause(found.map(|f| f.map_err(|v| format!("{:?}", v.clause))))
        }
        Artefact::Counterstrategy(machine) => {
            let found = verify::verify_counterstrategy(specification, machine, limits);
            clause(found.map(|f| f.map_err(|v| format!("{:?}", v.clause))))
        }
        Artefact::Functions(functions) => {
            let found = certify::certify(specification, functions, limits);
            clause(found.map(|f| f.map_err(|v| format!("{:?}", v.clause))))
        }
        // Parts of the verifiers, tested in their copies.
        Artefact::Graph(..) | Artefact::Formulas(..) | Artefact::Product(_) => verdict(case),
        Artefact::Proof(document, tried) => {
            let extent = match tried {
                Tried::StatesOnly => checker::Extent::Some {
                    seed: 1,
                    states: TRIED_ALONE,
                    inputs: 0,
                },
                Tried::All | Tried::Some => checker::Extent::All,
            };
            let found = checker::accepts(specification, document, extent);
            clause(Ok(found.map_err(|c| first_word(&format!("{c:?}")))))
        }
    }
}

/// The clauses that an artefact violates, as printed.
struct Breaks {
    named: BTreeSet<String>,
    alone: bool,
}

impl Breaks {
    fn only(named: BTreeSet<String>) -> Self {
        let alone = named.len() == 1;
        Self { named, alone }
    }
}

impl<C: std::fmt::Debug> From<definition::Found<C>> for Breaks {
    fn from(found: definition::Found<C>) -> Self {
        Self {
            named: found.named.iter().map(|c| format!("{c:?}")).collect(),
            alone: found.named.len() == 1 && found.later.is_empty(),
        }
    }
}

/// The clauses that an artefact violates, and possible steps.
fn broken(
    specification: &Specification,
    artefact: &Artefact,
) -> Option<(Breaks, definition::Product)> {
    let none = definition::Product::default();
    Some(match artefact {
        Artefact::Machine(machine) => {
            let (found, product) = definition::machine(specification, machine);
            (found.into(), product)
        }
        Artefact::Counterstrategy(machine) => {
            let (found, product) = definition::counterstrategy(specification, machine);
            (found.into(), product)
        }
        Artefact::Functions(functions) => {
            let found = definition::functions(specification, functions)?;
            (found.into(), none)
        }
        Artefact::Graph(edges, met) => {
            let cycle = definition::fair_cycle(edges, *met);
            let found = cycle.then(|| "a cycle".to_owned());
            (Breaks::only(found.into_iter().collect()), none)
        }
        Artefact::Formulas(..) | Artefact::Product(_) => (Breaks::only(BTreeSet::new()), none),
        Artefact::Proof(document, tried) => {
            let mut found = definition::proof(specification, document);
            if *tried != Tried::All && !found.named.contains("Form") {
                // Random states come in another order.
                found.named.append(&mut found.later);
            }
            if *tried == Tried::StatesOnly {
                found.named.remove("Answer");
            }
            let alone = found.named.len() == 1 && found.later.is_empty();
            let named = found.named;
            (Breaks { named, alone }, none)
        }
    })
}

fn kind(artefact: &Artefact) -> &'static str {
    match artefact {
        Artefact::Machine(_) => "machine",
        Artefact::Counterstrategy(_) => "counterstrategy",
        Artefact::Functions(_) => "functions",
        Artefact::Proof(..) => "proof",
        Artefact::Graph(..) => "graph",
        Artefact::Formulas(..) => "formulas",
        Artefact::Product(_) => "product",
    }
}

/// Maximum number of cases of a kind that violate the same clause.
const MOST_ALIKE: usize = 20;

/// Number of random specifications.
const SPECIFICATIONS: u64 = 240;

/// Number of changes to each artefact.
const CHANGES: usize = 60;

/// Number of artefacts of a kind to test with limits, and of those with an output that nothing
/// mentions.
const LIMITED: usize = 40;

/// Whether a clause is reported only after everything was examined, like the absence of errors.
fn last(clause: &str) -> bool {
    clause == "MachineWins"
        || clause.starts_with("StarvedAssumption")
        || clause.starts_with("Justice")
}

fn has_spare(specification: &Specification) -> bool {
    specification.variables.iter().any(|v| v.name == "spare")
}

/// Artefacts with as little work as they need and with less, and correct ones with numbers that are
/// too large.
fn limited(cases: &[Case]) -> Vec<Case> {
    let mut found = Vec::new();
    let mut counts: BTreeMap<(&str, bool), usize> = BTreeMap::new();
    for case in cases {
        let kind = kind(&case.artefact);
        if !matches!(kind, "machine" | "counterstrategy") || !case.broken.iter().all(|b| last(b)) {
            continue;
        }
        let right = case.broken.is_empty();
        let spare = has_spare(&case.specification);
        let count = counts
            .entry((if right { kind } else { "wrong" }, spare))
            .or_default();
        *count += 1;
        let with = |specification: &Specification, most: Option<u64>, broken: &[&str]| Case {
            specification: specification.clone(),
            artefact: case.artefact.clone(),
            limits: Limits {
                max_nodes: most,
                ..Limits::default()
            },
            broken: broken.iter().map(|b| (*b).to_owned()).collect(),
            alone: false,
        };
        if right && *count < 8 {
            for specification in artefacts::too_large(&case.specification) {
                found.push(with(&specification, None, &["Size"]));
            }
        }
        if *count > LIMITED || (!right && kind == "machine") {
            continue;
        }
        let least = |most: &u64| said(&with(&case.specification, Some(*most), &[])) != "Size";
        if let Some(enough) = (1..500).find(least).filter(|e| *e > 1) {
            let broken: Vec<&str> = case.broken.iter().map(String::as_str).collect();
            found.push(with(&case.specification, Some(enough), &broken));
            found.push(with(&case.specification, Some(enough - 1), &["Size"]));
        }
    }
    found
}

/// Number of products of a kind, of proofs with states tried without their steps, of games that
/// end, and of counterstrategies whose machine has only goals.
const FURTHER: usize = 60;

/// Number of states of a machine.
fn states(artefact: &Artefact) -> usize {
    match artefact {
        Artefact::Machine(machine) | Artefact::Counterstrategy(machine) => machine.states.len(),
        _ => 0,
    }
}

/// Further questions about existing artefacts.
fn further(cases: &[Case]) -> Vec<(Specification, Artefact)> {
    let mut counts: BTreeMap<(&str, bool), usize> = BTreeMap::new();
    let mut found = Vec::new();
    for case in cases {
        let mut specification = case.specification.clone();
        let artefact = match &case.artefact {
            Artefact::Functions(functions)
                if case.broken.is_empty() && specification.name != "wide" =>
            {
                let mut r = Random::new(found.len() as u64);
                let variants = artefacts::variants(&mut r, &specification, functions);
                let artefact = |f| Artefact::Functions(Box::new(f));
                found.extend(variants.into_iter().map(|(s, f)| (s, artefact(f))));
                continue;
            }
            right @ (Artefact::Machine(_) | Artefact::Counterstrategy(_))
                if case.broken.is_empty() && states(&case.artefact) > 1 =>
            {
                Artefact::Product(Box::new(right.clone()))
            }
            Artefact::Proof(document, Tried::All) if case.broken.contains("Answer") => {
                Artefact::Proof(document.clone(), Tried::StatesOnly)
            }
            wrong @ Artefact::Counterstrategy(_)
                if case.broken.iter().any(|b| b.starts_with("Assumption")) =>
            {
                specification = artefacts::goals_alone(&specification);
                wrong.clone()
            }
            right @ Artefact::Proof(_, Tried::Some) if case.broken.is_empty() => {
                specification = artefacts::ended(&specification);
                right.clone()
            }
            _ => continue,
        };
        let label = (kind(&case.artefact), case.broken.is_empty());
        let count = counts.entry(label).or_default();
        *count += 1;
        if *count <= FURTHER {
            found.push((specification, artefact));
        }
    }
    found
}

/// Correct and wrong artefacts; the same in every run.
fn cases() -> &'static [Case] {
    static CASES: OnceLock<Vec<Case>> = OnceLock::new();
    CASES.get_or_init(|| {
        let mut cases: Vec<Case> = Vec::new();
        let mut alike: BTreeMap<(&str, String), usize> = BTreeMap::new();
        let mut keep = |specification: &Specification, artefact: &Artefact, broken: Breaks| {
            let kinds: BTreeSet<&str> = broken
                .named
                .iter()
                .map(|b| b.split('(').next().unwrap_or(b))
                .collect();
            let variables = &specification.variables;
            let of = |owner: Owner| variables.iter().filter(|v| v.owner == owner).count().min(2);
            let spare = has_spare(specification);
            let wide = specification.name == "wide";
            let assumed = match artefact {
                Artefact::Functions(f) => f.names.len().min(2),
                _ => 0,
            };
            let sides = (
                of(Owner::Environment),
                of(Owner::System),
                spare,
                wide,
                assumed,
            );
            let label = format!("{kinds:?} {:?} {sides:?}", specification.timing);
            let count = alike.entry((kind(artefact), label)).or_insert(0);
            *count += 1;
            let most = if wide {
                15
            } else if broken.named.iter().all(|b| last(b)) {
                3 * MOST_ALIKE
            } else {
                MOST_ALIKE
            };
            if *count <= most {
                cases.push(Case {
                    specification: specification.clone(),
                    artefact: artefact.clone(),
                    limits: Limits::default(),
                    broken: broken.named,
                    alone: broken.alone,
                });
            }
        };
        for (seed, specification) in artefacts::specifications(SPECIFICATIONS).iter().enumerate() {
            let mut r = Random::new(seed as u64);
            for right in artefacts::right(specification) {
                let (wrong, product) = broken(specification, &right).expect("codes with a meaning");
                assert!(
                    wrong.named.is_empty(),
                    "{:?} of {right:#?}\n{specification:#?}",
                    wrong.named
                );
                keep(specification, &right, wrong);
                let value = |n: usize| product.nodes[n].1.clone();
                let steps: Vec<[Vec<i64>; 2]> = product
                    .edges
                    .iter()
                    .map(|(a, b)| [value(*a), value(*b)])
                    .collect();
                for _ in 0..CHANGES {
                    let (mut specification, mut artefact) = (specification.clone(), right.clone());
                    for _ in 0..=r.below(2) {
                        artefacts::change(&mut r, &mut specification, &mut artefact, &steps);
                    }
                    if let Some((broken, _)) = broken(&specification, &artefact) {
                        keep(&specification, &artefact, broken);
                    }
                }
            }
        }
        let (specification, right) = artefacts::wide();
        let further_wide = artefacts::at_words(&right);
        let right = Artefact::Functions(Box::new(right));
        keep(&specification, &right, Breaks::only(BTreeSet::new()));
        let mut r = Random::new(1);
        for _ in 0..40 * CHANGES {
            let (mut specification, mut artefact) = (specification.clone(), right.clone());
            artefacts::change(&mut r, &mut specification, &mut artefact, &[]);
            if let Some((broken, _)) = broken(&specification, &artefact) {
                keep(&specification, &artefact, broken);
            }
        }
        let further_wide = further_wide.into_iter().map(|functions| {
            let artefact = Artefact::Functions(Box::new(functions));
            (specification.clone(), artefact)
        });
        let further: Vec<_> = further_wide.chain(further(&cases)).collect();
        for (specification, artefact) in further {
            let Some((found, _)) = broken(&specification, &artefact) else {
                continue;
            };
            cases.push(Case {
                specification,
                artefact,
                limits: Limits::default(),
                broken: found.named,
                alone: false,
            });
        }
        for seed in 0..400 {
            let mut r = Random::new(seed);
            let specification = random::specification_with_goals(&mut r);
            for artefact in [
                artefacts::graph(&mut r),
                artefacts::formulas(&mut r, &specification),
            ] {
                let (broken, _) = broken(&specification, &artefact).expect("an answer");
                cases.push(Case {
                    specification: specification.clone(),
                    artefact,
                    limits: Limits::default(),
                    broken: broken.named,
                    alone: broken.alone,
                });
            }
        }
        let limited = limited(&cases);
        cases.extend(limited);
        cases
    })
}

/// The names of an enum's clauses; adding one without updating this does not compile.
macro_rules! clauses {
    ($enum:ident: $($name:ident)*) => {{
        #[expect(dead_code, reason = "it is only compiled")]
        fn every(clause: &$enum) {
            match clause {
                $($enum::$name { .. } => (),)*
            }
        }
        &[$(stringify!($name)),*]
    }};
}

const OF_PLAYS: &[&str] = {
    use verify::Clause;
    clauses!(Clause: Ports Timing MissingTarget OutputCount Domain UnknownInput FirstMover NoTransition
        MissingTransition AmbiguousTransition Unanswered AnsweredTwice Guarantee Justice Assumption
        StarvedAssumption MachineWins)
};

/// Clauses that apply only to counterstrategies, and only to machines.
const OF_COUNTERSTRATEGIES: [&str; 6] = [
    "NoTransition",
    "Unanswered",
    "AnsweredTwice",
    "Assumption",
    "StarvedAssumption",
    "MachineWins",
];
const OF_MACHINES: [&str; 4] = [
    "MissingTransition",
    "AmbiguousTransition",
    "Guarantee",
    "Justice",
];

const OF_FUNCTIONS: &[&str] = {
    use certify::Clause;
    clauses!(Clause: Ports Diagram SetOfStates LayerAssumption OutputDependency OutputTwice OutputMissing
        ModeDependency ModeLayer ModeMissing AssumptionCheck Domain Invariant Layers LegalInputRefused
        IllegalInputAccepted Initial InitialRegion Safety GoalSwitch GoalMissed LayerMissed MovesAway
        UnjustifiedWait OutsideLayers)
};

const OF_PROOFS: &[&str] = {
    use checker::Clause;
    clauses!(Clause: Form Start Region Layer Answer Reached Within)
};

/// All clauses, with the kinds of artefacts to which they apply.
fn all_clauses() -> Vec<(&'static str, &'static str)> {
    let without =
        |others: &'static [&str]| OF_PLAYS.iter().filter(move |name| !others.contains(name));
    let machine = without(&OF_COUNTERSTRATEGIES).map(|name| ("machine", *name));
    let counterstrategy = without(&OF_MACHINES).map(|name| ("counterstrategy", *name));
    let functions = OF_FUNCTIONS.iter().map(|name| ("functions", *name));
    let proof = OF_PROOFS.iter().map(|name| ("proof", *name));
    machine
        .chain(counterstrategy)
        .chain(functions)
        .chain(proof)
        .collect()
}

#[test]
fn each_clause_is_named_when_it_is_broken() {
    let clock = Instant::now();
    let cases = cases();
    println!("{} cases in {:?}", cases.len(), clock.elapsed());
    let mut alone: BTreeMap<(&str, String), [usize; 2]> = BTreeMap::new();
    let mut wrong = 0;
    for case in cases {
        let said = said(case);
        if !case.allows(&said) {
            wrong += 1;
            if wrong < 4 {
                println!(
                    "{} is said of what breaks {:?}\n{:#?}\n{:#?}",
                    said, case.broken, case.artefact, case.specification
                );
            }
        }
        for clause in &case.broken {
            let name = clause.split('(').next().unwrap_or(clause).to_owned();
            let count = alone.entry((kind(&case.artefact), name)).or_default();
            count[usize::from(case.alone)] += 1;
        }
        if case.broken.is_empty() {
            alone
                .entry((kind(&case.artefact), "right".to_owned()))
                .or_default()[1] += 1;
        }
    }
    println!(
        "{:16} {:18} {:>6} {:>12}",
        "artefact", "clause", "alone", "with others"
    );
    for ((kind, clause), [others, alone]) in &alone {
        println!("{kind:16} {clause:18} {alone:6} {others:12}");
    }
    assert_eq!(wrong, 0);
    let never: Vec<_> = all_clauses()
        .into_iter()
        .filter(|(kind, clause)| {
            let found = alone.get(&(*kind, (*clause).to_owned()));
            found.is_none_or(|[_, alone]| *alone == 0)
        })
        .collect();
    assert!(never.is_empty(), "nothing breaks these alone: {never:?}");
}

/// One mutant, and whether anything detected it.
struct Trial {
    mutant: u32,
    killed: bool,
    /// Whether it is detected only because it does not end.
    endless: bool,
    /// Number of cases that pass its place.
    cases: usize,
}

#[test]
fn no_mutant_of_a_checker_survives() {
    let start = Instant::now();
    let cases = cases();
    println!("cases made after {:?}", start.elapsed());
    // The places that each case passes, and its cost.
    let mut known: Vec<(usize, Vec<bool>, u64)> = Vec::new();
    for (i, case) in cases.iter().enumerate() {
        let (verdict, seen, asked) = switch::recorded(|| verdict(case));
        assert!(
            case.allows(&verdict),
            "{verdict} is said of what breaks {:?}\n{:#?}\n{:#?}",
            case.broken,
            case.artefact,
            case.specification
        );
        known.push((i, seen, asked));
    }
    known.retain(|(i, _, asked)| *asked <= MOST_WORK || cases[*i].specification.name == "wide");
    known.sort_by_key(|(i, _, asked)| (*asked, *i));
    let work: u64 = known.iter().map(|(_, _, asked)| asked).sum();
    println!("{} cases, which ask {work} switches", known.len());
    let hook = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        if !switch::is_on() {
            hook(info);
        }
    }));
    println!("all are right after {:?}", start.elapsed());
    let clock = Instant::now();
    let threads = 2;
    let known = &known;
    let trials = std::thread::scope(|scope| {
        let work = |begin: usize| {
            move || -> Vec<Trial> {
                let mutants = (begin..copies::MUTANTS.len()).step_by(threads);
                let mut kills = vec![0; known.len()];
                mutants
                    .map(|m| trial(m as u32, cases, known, &mut kills))
                    .collect()
            }
        };
        let handles: Vec<_> = (0..threads)
            .map(|begin| {
                let thread = std::thread::Builder::new().stack_size(1 << 28);
                thread.spawn_scoped(scope, work(begin)).expect("a thread")
            })
            .collect();
        handles
            .into_iter()
            .flat_map(|h| h.join().expect("no panic"))
            .collect::<Vec<_>>()
    });
    let mut table: BTreeMap<(&str, &str), [usize; 2]> = BTreeMap::new();
    let mut survivors = Vec::new();
    for trial in &trials {
        let mutant = &copies::MUTANTS[trial.mutant as usize];
        let row = table.entry((mutant.file, mutant.operator)).or_default();
        row[0] += 1;
        row[1] += usize::from(trial.killed);
        if trial.endless {
            let m = &copies::MUTANTS[trial.mutant as usize];
            println!(
                "without an end: {} | {} | {} | {} | {}",
                m.file, m.function, m.operator, m.right, m.wrong
            );
        }
        if !trial.killed {
            survivors.push((trial.mutant, trial.cases));
        }
    }
    survivors.sort_unstable();
    println!(
        "{:28} {:12} {:>5} {:>6}",
        "file", "operator", "made", "killed"
    );
    for ((file, operator), [made, killed]) in &table {
        println!("{file:28} {operator:12} {made:5} {killed:6}");
    }
    let (stale, noticed) = compare(&survivors);
    for row in equivalent::EQUIVALENT {
        let (function, right, wrong) = (row.function, row.right, row.wrong);
        println!(
            "equivalent: {} | {function} | {right} | {wrong}: {}",
            row.file, row.why
        );
    }
    let (made, left) = (trials.len(), survivors.len());
    println!(
        "{made} mutants, {} killed, {left} survive, {} of them equivalent, {:?}",
        made - left,
        left - noticed.len(),
        clock.elapsed()
    );
    assert!(
        noticed.is_empty(),
        "nothing notices:\n{}",
        noticed.join("\n")
    );
    assert!(
        stale.is_empty(),
        "said to be equivalent, and noticed or not there:\n{}",
        stale.join("\n")
    );
    assert!(
        (made - left) * 100 >= made * LEAST_KILLED,
        "too many are equivalent"
    );
}

/// Minimum percentage of mutants that are detected; the others must be shown to be undetectable.
const LEAST_KILLED: usize = 98;

/// Mutants listed as equivalent are tried on one case in this many.
const EQUIVALENT_TRIED: usize = 3;

/// The row of a mutant in the table of equivalent ones.
fn row(mutant: u32) -> Option<&'static equivalent::Equivalent> {
    let all = copies::MUTANTS;
    let key = |m: &switch::Mutant| (m.file, m.function, m.right, m.wrong);
    let wanted = key(&all[mutant as usize]);
    let mut rows = equivalent::EQUIVALENT
        .iter()
        .filter(|e| (e.file, e.function, e.right, e.wrong) == wanted);
    let before = all[..=mutant as usize].iter();
    let number = before.filter(|m| key(m) == wanted).count();
    rows.find(|e| e.number == number)
}

/// Rows of the table of equivalent mutants that are not equivalent, and survivors missing from it;
/// as text.
fn compare(survivors: &[(u32, usize)]) -> (Vec<String>, Vec<String>) {
    let line = |e: &equivalent::Equivalent| {
        let (file, function, right, wrong) = (e.file, e.function, e.right, e.wrong);
        format!(
            "{file} | {function} | {right} | {wrong} | number {}",
            e.number
        )
    };
    let mut stale: Vec<String> = equivalent::EQUIVALENT.iter().map(line).collect();
    let mut missing = Vec::new();
    for (number, cases) in survivors {
        if let Some(row) = row(*number) {
            let row = line(row);
            stale.retain(|other| *other != row);
        } else {
            let m = &copies::MUTANTS[*number as usize];
            missing.push(format!(
                "{} | {} | {} | {} | {} | {cases} cases",
                m.file, m.function, m.operator, m.right, m.wrong
            ));
        }
    }
    (stale, missing)
}

/// Cases with more switch queries are left to the test of the clauses.
const MOST_WORK: u64 = 20_000;

/// Runs the cases that pass a mutant's place until one of them detects it, starting with those that
/// detected others.
fn trial(
    mutant: u32,
    cases: &[Case],
    known: &[(usize, Vec<bool>, u64)],
    kills: &mut [usize],
) -> Trial {
    let place = mutant as usize;
    let mut tried = 0;
    let comes_by = |k: &usize| known[*k].1.get(place).copied().unwrap_or(false);
    let mut order: Vec<usize> = (0..known.len()).filter(comes_by).collect();
    if row(mutant).is_some() {
        order.retain(|k| k % EQUIVALENT_TRIED == 0);
    }
    order.sort_by_key(|k| (std::cmp::Reverse(kills[*k]), *k));
    let mut long = None;
    let run = |k: usize, most: u64| {
        let case = &cases[known[k].0];
        let verdict = || catch_unwind(AssertUnwindSafe(|| verdict(case)));
        let (verdict, asked) = switch::with(Some(mutant), most, verdict);
        match verdict {
            _ if asked > most => Judgement::Nothing,
            Ok(verdict) if case.allows(&verdict) => Judgement::Right,
            _ => Judgement::Wrong,
        }
    };
    for k in order {
        tried += 1;
        match run(k, 20 * known[k].2 + 10_000) {
            Judgement::Right => {}
            Judgement::Wrong => {
                kills[k] += 1;
                return Trial {
                    mutant,
                    killed: true,
                    endless: false,
                    cases: tried,
                };
            }
            // It may only have more to do: other cases are tried first.
            Judgement::Nothing => long = long.or(Some(k)),
        }
    }
    let endless = long.is_some_and(|k| {
        let most = ENDLESS.max(100 * known[k].2);
        !matches!(run(k, most), Judgement::Right)
    });
    Trial {
        mutant,
        killed: endless,
        endless,
        cases: tried,
    }
}

/// Result of a mutant on a case.
enum Judgement {
    Right,
    Wrong,
    /// No result in the available time.
    Nothing,
}

/// Number of switch queries after which a run counts as endless, as does a hundred times the number
/// without a mutant.
const ENDLESS: u64 = 20 * MOST_WORK;
