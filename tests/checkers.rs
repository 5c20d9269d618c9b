//! Who checks the checkers: the verifier of machines, the verifier of counterstrategies and the certifier of functions are given
//! artefacts that are wrong in each way their definitions forbid, and have to name the clause; and they are made wrong
//! themselves, place by place, which has to be noticed.
//!
//! | file | what it holds |
//! |---|---|
//! | `definition` | the definitions, by enumeration: the set of clauses that an artefact breaks |
//! | `artefacts` | right artefacts of the repository's contracts and of random specifications, and changes to them |
//! | `witness` | whether the play that a verifier shows is one that breaks the clause it names |
//! | `../proof/checker.rs` | the checker of proofs |
//! | `switch` | which of the mutants that `mutation` has made is on |

#[path = "checkers/artefacts.rs"]
mod artefacts;
#[path = "proof/checker.rs"]
#[allow(dead_code, reason = "proofs are small here: all is counted through")]
mod checker;
#[path = "checkers/definition.rs"]
mod definition;
#[path = "oracle/game.rs"]
#[allow(dead_code, reason = "only its evaluator is used")]
mod game;
#[path = "oracle/random.rs"]
#[allow(dead_code, reason = "only its specifications are used")]
mod random;
#[path = "support/mod.rs"]
mod support;
#[path = "checkers/switch.rs"]
mod switch;
#[path = "checkers/witness.rs"]
mod witness;

use artefacts::Artefact;
use linewright::game::{Limit, Limits};
use linewright::gr1::{Owner, Specification};
use linewright::mealy::{certify, verify};
use random::Random;
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
    mutation::mutants! { "src/mealy/verify/mod.rs", "src/mealy/certify.rs", "tests/proof/checker.rs" }
}

/// An artefact, and what may be said of it.
struct Case {
    specification: Specification,
    artefact: Artefact,
    limits: Limits,
    /// The clauses that it breaks, as they are printed; nothing where it is right.
    broken: BTreeSet<String>,
}

const ACCEPTED: &str = "accepted";

impl Case {
    /// Whether a verdict is right. A play that does not show what is said is none.
    fn allows(&self, verdict: &str) -> bool {
        self.broken.contains(verdict) || self.broken.is_empty() && verdict == ACCEPTED
    }
}

/// What the copy of the checker says; with a play, whether that shows it.
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
        Artefact::Proof(document, tried) => {
            let extent = if *tried {
                copies::checker::Extent::Some {
                    seed: 1,
                    states: TRIED,
                    inputs: TRIED,
                }
            } else {
                copies::checker::Extent::All
            };
            let found = copies::checker::accepts(specification, document, extent);
            let clause = |clause: copies::checker::Clause| first_word(&format!("{clause:?}"));
            found.map_or_else(clause, |()| ACCEPTED.to_owned())
        }
    }
}

/// Where states and inputs are tried and not counted through: often enough that all of some forty are met.
const TRIED: u64 = 600;

fn first_word(clause: &str) -> String {
    clause.split('(').next().unwrap_or(clause).to_owned()
}

/// What the checkers themselves say.
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
        // Parts of the verifiers, of which the copies are asked.
        Artefact::Graph(..) | Artefact::Formulas(..) => verdict(case),
        Artefact::Proof(document, _) => {
            let found = checker::accepts(specification, document, checker::Extent::All);
            clause(Ok(found.map_err(|c| first_word(&format!("{c:?}")))))
        }
    }
}

/// The clauses that an artefact breaks, and steps that can be taken.
fn broken(
    specification: &Specification,
    artefact: &Artefact,
) -> Option<(BTreeSet<String>, definition::Product)> {
    fn named<C: std::fmt::Debug>(clauses: &BTreeSet<C>) -> BTreeSet<String> {
        clauses.iter().map(|c| format!("{c:?}")).collect()
    }
    Some(match artefact {
        Artefact::Machine(machine) => {
            let (found, product) = definition::machine(specification, machine);
            (named(&found), product)
        }
        Artefact::Counterstrategy(machine) => {
            let (found, product) = definition::counterstrategy(specification, machine);
            (named(&found), product)
        }
        Artefact::Functions(functions) => {
            let found = definition::functions(specification, functions)?;
            (named(&found), definition::Product::default())
        }
        Artefact::Graph(edges, met) => {
            let cycle = definition::fair_cycle(edges, *met);
            let found = cycle.then(|| "a cycle".to_owned());
            (found.into_iter().collect(), definition::Product::default())
        }
        Artefact::Formulas(..) => (BTreeSet::new(), definition::Product::default()),
        Artefact::Proof(document, _) => (
            definition::proof(specification, document),
            definition::Product::default(),
        ),
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
    }
}

/// As many cases of a kind that break the same clause are kept.
const MOST_ALIKE: usize = 20;

/// As many random specifications.
const SPECIFICATIONS: u64 = 160;

/// As many changes to each artefact.
const CHANGES: usize = 60;

/// As many artefacts of a kind are looked at with limits.
const LIMITED: usize = 40;

/// Artefacts with as little work as they need and with less, and right ones with numbers that are too large.
fn limited(cases: &[Case]) -> Vec<Case> {
    let mut found = Vec::new();
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for case in cases {
        // These are told once all was looked at, as is that nothing is wrong.
        let last = |b: &String| b == "Won" || b.starts_with("Starved") || b.starts_with("Justice");
        let kind = kind(&case.artefact);
        if !matches!(kind, "machine" | "counterstrategy") || !case.broken.iter().all(last) {
            continue;
        }
        let right = case.broken.is_empty();
        let count = counts
            .entry(if right { kind } else { "wrong" })
            .or_default();
        *count += 1;
        let with = |specification: &Specification, most: Option<u64>, broken: &[&str]| Case {
            specification: specification.clone(),
            artefact: case.artefact.clone(),
            limits: Limits {
                most_nodes: most,
                ..Limits::default()
            },
            broken: broken.iter().map(|b| (*b).to_owned()).collect(),
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

/// Right and wrong artefacts; the same in every run.
fn cases() -> &'static [Case] {
    static CASES: OnceLock<Vec<Case>> = OnceLock::new();
    CASES.get_or_init(|| {
        let mut cases: Vec<Case> = Vec::new();
        let mut alike: BTreeMap<(&str, String), usize> = BTreeMap::new();
        let mut keep = |specification: &Specification,
                        artefact: &Artefact,
                        broken: BTreeSet<String>| {
            let kinds: BTreeSet<&str> = broken
                .iter()
                .map(|b| b.split('(').next().unwrap_or(b))
                .collect();
            let variables = &specification.variables;
            let of = |owner: Owner| variables.iter().filter(|v| v.owner == owner).count().min(2);
            let spare = variables.iter().any(|v| v.name == "spare");
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
            } else if broken.is_empty() {
                3 * MOST_ALIKE
            } else {
                MOST_ALIKE
            };
            if *count <= most {
                cases.push(Case {
                    specification: specification.clone(),
                    artefact: artefact.clone(),
                    limits: Limits::default(),
                    broken,
                });
            }
        };
        for (seed, specification) in artefacts::specifications(SPECIFICATIONS).iter().enumerate() {
            let mut r = Random::new(seed as u64);
            for right in artefacts::right(specification) {
                let (wrong, product) = broken(specification, &right).expect("codes with a meaning");
                assert!(
                    wrong.is_empty(),
                    "{wrong:?} of {right:#?}\n{specification:#?}"
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
        let right = Artefact::Functions(Box::new(right));
        keep(&specification, &right, BTreeSet::new());
        let mut r = Random::new(1);
        for _ in 0..40 * CHANGES {
            let (mut specification, mut artefact) = (specification.clone(), right.clone());
            artefacts::change(&mut r, &mut specification, &mut artefact, &[]);
            if let Some((broken, _)) = broken(&specification, &artefact) {
                keep(&specification, &artefact, broken);
            }
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
                    broken,
                });
            }
        }
        let limited = limited(&cases);
        cases.extend(limited);
        cases
    })
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
            count[usize::from(case.broken.len() == 1)] += 1;
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
}

/// One mutant, and whether something noticed it.
struct Trial {
    mutant: u32,
    killed: bool,
    /// How many cases come by its place.
    cases: usize,
}

#[test]
fn no_mutant_of_a_checker_survives() {
    let cases = cases();
    // What each case comes by, and what it costs.
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
    for (number, cases) in &survivors {
        let m = &copies::MUTANTS[*number as usize];
        println!(
            "survives ({cases}): {} | {} | {} | {} | {}",
            m.file, m.function, m.operator, m.right, m.wrong
        );
    }
    let (made, left) = (trials.len(), survivors.len());
    println!(
        "{made} mutants, {} killed, {left} survive, {:?}",
        made - left,
        clock.elapsed()
    );
}

/// Cases that ask more switches are left to the test of the clauses.
const MOST_WORK: u64 = 20_000;

/// Runs the cases that come by a mutant's place until one of them notices it, those first that noticed others.
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
    order.sort_by_key(|k| (std::cmp::Reverse(kills[*k]), *k));
    for k in order {
        let (i, _, asked) = &known[k];
        tried += 1;
        let run = || verdict(&cases[*i]);
        let (verdict, _) = switch::with(Some(mutant), 20 * asked + 10_000, || {
            catch_unwind(AssertUnwindSafe(run))
        });
        if verdict.is_err() || verdict.is_ok_and(|v| !cases[*i].allows(&v)) {
            kills[k] += 1;
            return Trial {
                mutant,
                killed: true,
                cases: tried,
            };
        }
    }
    Trial {
        mutant,
        killed: false,
        cases: tried,
    }
}
