//! The composition of a coordinator and its actions: what fits is discharged, and each kind of
//! mismatch is found.
//!
//! The machine below is sound. Each test changes one thing in its text and names the finding that
//! must appear; that the unchanged text has none shows that the finding comes from the change.

use linewright::contract;
use linewright::game::{self, Limits, Outcome};
use linewright::mealy::{self, extract::extract, verify::verify};
use linewright::station::composition::{self, Composition, Discharger};

const CELL: &str = r"
type Command = {none, grab, drop}
type Job = {none, carry, fetch}

contract Grab {
    input command: Command
    input grip, there: bool
    output stage: 0..2
    output grabbed: bool
    define requested = command = grab
    assume open: always (requested -> not grip)
    assume held: always (requested and not grabbed -> next requested)
    assume comes: always eventually (there or not requested)
    guarantee rest: stage = 0
    guarantee reset: always (not requested -> next stage = 0)
    guarantee go: always (requested -> next stage = (if there then min(stage + 1, 2) else stage))
    guarantee report: always (grabbed <-> stage = 2)
    guarantee completes: always eventually (not requested or grabbed)
}

contract Drop {
    input command: Command
    input grip: bool
    output dropped: bool
    define requested = command = drop
    assume gripped: always (requested -> grip)
    guarantee rest: not dropped
    guarantee go: always (next dropped <-> requested)
    guarantee completes: always eventually (not requested or dropped)
}

moore contract Lead {
    input job: Job
    input executed: bool
    output command: Command
    output grip, last, done: bool
    define finished = command != none and executed
    assume served: always eventually (command = none or executed)
    assume first: job in {none, carry, fetch}
    assume empty: always (done -> next job = none or not grip)
    guarantee start: command = none and not grip and not last and not done
    guarantee ask: always (next command =
        (if command != none then (if executed then none else command)
         else if job = none or done then none else if grip then drop else grab))
    guarantee grips: always (next grip <-> (if finished then command = grab else grip))
    guarantee end: always (next done <-> finished and (command = drop or job = fetch))
    guarantee marks: always (last <-> false)
    guarantee completes: always eventually command = none
}

machine Cell {
    signal there: bool = true
    coordinator lead: Lead {
        job = operation
        executed = if lead.command = grab then grab.grabbed else if lead.command = drop then put.dropped else false
    }
    action grab: Grab when lead.command = grab { command = lead.command  grip = lead.grip }
    action put: Drop when lead.command = drop { command = lead.command  grip = lead.grip }
    operation carry: grab, put
    operation fetch: grab
    done lead.done
}
";

fn compose(text: &str) -> Composition {
    let files = [("cell.lw".to_owned(), text.to_owned())];
    let (library, findings) = contract::load(&files, &|_, _| Err("no imports".to_owned()));
    let errors: Vec<_> = findings.iter().map(|f| (f.code.id, &f.message)).collect();
    assert_eq!(library.machines.len(), 1, "{errors:?}");
    let machine = &library.machines[0];
    let limits = Limits::default();
    let controllers: Vec<mealy::Controller> = machine
        .components
        .iter()
        .map(|c| {
            let Outcome::Realizable(won) = game::solve(&c.specification, &limits) else {
                panic!("{} is not realizable", c.name);
            };
            let controller = extract(&c.specification, &won, &limits).unwrap();
            assert_eq!(verify(&c.specification, &controller, &limits), Ok(Ok(())));
            controller.into()
        })
        .collect();
    composition::check(machine, &controllers.iter().collect::<Vec<_>>())
}

/// The ids and messages of the findings when `from` is replaced by `to`.
#[track_caller]
fn changed(from: &str, to: &str) -> Vec<String> {
    assert!(CELL.contains(from), "the text has no {from}");
    let found = compose(&CELL.replace(from, to)).findings;
    found
        .into_iter()
        .map(|f| format!("{}: {}", f.code.id, f.message))
        .collect()
}

#[track_caller]
fn finds(from: &str, to: &str, code: &str, words: &str) {
    let found = changed(from, to);
    assert!(
        found
            .iter()
            .any(|f| f.starts_with(code) && f.contains(words)),
        "wanted {code} with {words:?}, found {found:#?}"
    );
}

#[test]
fn what_fits_is_discharged_by_name() {
    let composition = compose(CELL);
    assert_eq!(composition.findings, []);
    let by = |component: &str, assumption: &str| {
        let mut found = composition.discharges.iter();
        let found = found.find(|d| d.component == component && d.assumption == assumption);
        found.map(|d| d.by.clone())
    };
    assert_eq!(by("lead", "first"), Some(Discharger::Plant));
    assert_eq!(by("lead", "empty"), Some(Discharger::Line));
    assert_eq!(by("grab", "comes"), Some(Discharger::Plant));
    assert_eq!(by("grab", "open"), Some(Discharger::Coordinator));
    assert_eq!(
        by("lead", "served"),
        Some(Discharger::Guarantee(
            "grab: completes, put: completes".to_owned()
        ))
    );
    assert_eq!(composition.discharges.len(), 7);
}

#[test]
fn a_request_that_is_dropped_is_found() {
    // The coordinator may withdraw the request at any time.
    finds(
        "(if command != none then (if executed then none else command)",
        "(if command != none then none",
        "LW303",
        "`held` of `grab`",
    );
}

#[test]
fn a_gripper_in_the_wrong_state_is_found() {
    finds(
        "else if grip then drop else grab",
        "else if grip then drop else drop",
        "LW303",
        "`gripped` of `put`",
    );
}

#[test]
fn a_signal_that_never_comes_is_found() {
    finds(
        "signal there: bool = true",
        "signal there: bool = false",
        "LW303",
        "`comes` of `grab`",
    );
}

#[test]
fn a_signal_that_comes_now_and_then_is_enough() {
    assert_eq!(
        changed(
            "signal there: bool = true",
            "signal there: bool = false, false, true"
        ),
        [""; 0]
    );
}

#[test]
fn an_executed_flag_that_is_not_wired_is_found() {
    finds(
        "else if lead.command = drop then put.dropped else false",
        "else false",
        "LW303",
        "`served` of `lead`",
    );
}

#[test]
fn an_answer_one_step_later_needs_no_justice_guarantee() {
    assert_eq!(
        changed(
            "    guarantee completes: always eventually (not requested or dropped)\n",
            ""
        ),
        [""; 0]
    );
}

#[test]
fn an_operation_that_names_other_actions_is_found() {
    finds(
        "operation carry: grab, put",
        "operation carry: put, grab",
        "LW306",
        "`carry`",
    );
    finds(
        "operation carry: grab, put",
        "operation carry: grab, put, grab",
        "LW306",
        "`carry`",
    );
    finds(
        "operation carry: grab, put",
        "operation carry: grab",
        "LW306",
        "`carry`",
    );
}

#[test]
fn an_operation_that_never_ends_is_found() {
    // It holds the part for ever.
    finds(
        "else if grip then drop else grab",
        "else if grip then none else grab",
        "LW304",
        "`carry`",
    );
    // It drops and grabs again without ever reporting that it is done.
    finds("done lead.done", "done lead.last", "LW306", "`carry`");
}

#[test]
fn an_operation_that_cannot_begin_is_found() {
    finds(
        "assume first: job in {none, carry, fetch}\n    assume empty: always (done -> next job = none or not grip)",
        "assume first: job in {none, fetch}\n    assume empty: always (next job != carry)",
        "LW306",
        "can never begin",
    );
}

/// Two coordinators, each with its own kind of job; the job determines the request of an action.
const TWO: &str = "
moore contract Lead {
    input job: {none, near, far}
    input executed: bool
    output command, done: bool
    assume served: always eventually (not command or executed)
    guarantee start: not command and not done
    guarantee ask: always (next command <-> (if command then not executed else job != none and not done))
    guarantee report: always (next done <-> command and executed)
    guarantee completes: always eventually not command
}

moore contract Spin {
    input job: {none, face, near}
    input executed: bool
    output command, done: bool
    assume served: always eventually (not command or executed)
    assume apart: always (command -> next job != near)
    guarantee start: not command and not done
    guarantee ask: always (next command <-> (if command then not executed else job = face and not done))
    guarantee report: always (next done <-> command and executed)
    guarantee completes: always eventually not command
}

contract Go {
    input command: bool
    input to: 0..3
    output at: 0..3
    output arrived: bool
    assume held: always (command and not arrived -> next command and next to = to)
    guarantee start: at = 0
    guarantee moves: always (next at = (if not command or at = to then at else if at < to then at + 1 else at - 1))
    guarantee arrived: always (arrived <-> at = to)
    guarantee completes: always eventually (not command or arrived)
}

machine Pair {
    coordinator arm: Lead {
        job = operation
        executed = drive.arrived
    }
    coordinator table: Spin {
        job = operation
        executed = turn.arrived
    }
    action drive: Go when arm.command {
        command = arm.command
    }
    action turn: Go when table.command {
        command = table.command
        to = 2
    }
    operation near: drive(to = 1)
    operation far: drive(to = 3)
    operation face: turn
    done arm.done or table.done
}
";

#[test]
fn several_coordinators_fit_together() {
    let composition = compose(TWO);
    assert_eq!(composition.findings, []);
    let of = |component: &str, assumption: &str| {
        let mut all = composition.discharges.iter();
        let found = all.find(|d| d.component == component && d.assumption == assumption);
        found
            .unwrap_or_else(|| panic!("{component}.{assumption}"))
            .by
            .clone()
    };
    assert!(matches!(of("arm", "served"), Discharger::Guarantee(_)));
    assert!(matches!(of("table", "served"), Discharger::Guarantee(_)));
    // While the table turns, its operation goes on: `near` cannot be asked for.
    assert_ne!(of("table", "apart"), Discharger::Line);
    assert_eq!(of("drive", "held"), Discharger::Coordinator);
}

#[test]
fn several_coordinators_that_do_not_fit_are_found() {
    let changes = [
        // The table's job is attributed to the arm.
        (
            "operation face: turn",
            "operation face: drive(to = 0)",
            "LW306",
        ),
        // The arm never reports that it is done, and the table is not asked.
        ("done arm.done or table.done", "done table.done", "LW3"),
        // Nothing holds the request of the arm.
        ("to = 2", "to = if arm.command then 1 else 2", ""),
        (
            "(not command or executed)\n    assume apart",
            "executed\n    assume apart",
            "LW303",
        ),
    ];
    for (from, to, code) in changes {
        assert!(TWO.contains(from), "{from}");
        let found = compose(&TWO.replace(from, to)).findings;
        if code.is_empty() {
            assert_eq!(found, [], "{to}");
        } else {
            assert!(
                found.iter().any(|f| f.code.id.starts_with(code)),
                "{to}: {found:?}"
            );
        }
    }
}
