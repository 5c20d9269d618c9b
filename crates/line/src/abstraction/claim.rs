//! The claim about a line, and what it takes as given.
//!
//! What is given is what no place can guarantee: parts come in at all, and the properties of parts
//! send them each way again and again, so that a replacement is eventually good. This does not
//! promise that parts arrive anywhere: a decision stays until it is used, and if it is never needed
//! again, it can be `no_more`. (This value is a guess about the future, with one right answer in
//! every run: a place that needs the decision after all cannot proceed.)

use super::lemmas;
use super::losses;
use super::parts::formula;
use super::requirements::{
    COMPONENTS_GO_ON, GOES_ON, NO_CIRCULAR_WAIT, NO_OVERFLOW, NO_PART_LOST, orders_are_finished,
};
use super::shape::PlaceKind;
use super::vocabulary::{Model, Phase, Queue};
use super::words::{all, an, any, becomes, count, is, later, stays, sum};
use linewright_algebra::proof::{Claim, Exports};
use linewright_algebra::system::System;
use linewright_core::gr1::{BinaryOp, Expr, Formula, Side};
use linewright_language::contract::line::Line;

/// Builds the claim of a line whose places have these contracts.
pub(super) fn claim(model: Model<'_>, line: &Line, system: &System) -> Claim {
    let mut claim = Claim {
        given: given(model, line),
        goal: goal(model, line),
        exports: Exports::Never,
        ..Claim::default()
    };
    lemmas::add(model, line, system, &mut claim);
    claim
}

fn given(model: Model<'_>, line: &Line) -> Side {
    let mut given = Side::default();
    for (&(place, part), &decision) in &model.vocabulary.decisions {
        let declared = &model.shape.places[place];
        let span = line.nodes[declared.node].span;
        let kind = &model.shape.types[part];
        let vars = model.vars(place);
        let used = if let Some(phase) = vars.phase {
            let at = |wanted: Phase| {
                vars.phases
                    .iter()
                    .position(|p| *p == wanted)
                    .map_or(0, |i| i + 1)
            };
            let work = at(Phase::Work(part));
            is(phase, work).and(becomes(phase, work).not())
        } else {
            let offers = |to: &usize| model.offers(place, part, *to);
            let offered = any(model.shape.to(place, part).iter().map(offers));
            offered.clone().not().and(later(&offered))
        };
        let name = format!("{}_keeps_the_way_of_{kind}", declared.name);
        let text = format!(
            "the way chosen for the next {kind} from {} stays the same until a {kind} takes it, unless {} sends on no more {kind} parts",
            declared.name, declared.name
        );
        let none = model.shape.to(place, part).len();
        let rule =
            becomes(decision, none).or(is(decision, none).not().and(used.or(stays(decision))));
        given.safety.push(formula(span, &name, &text, &rule));
        let to_all = model.shape.to(place, part);
        let ways = declared.ways.iter().find(|ways| ways.part == part);
        for exit in ways.iter().flat_map(|ways| &ways.exits) {
            let is_loss = |to: &usize| losses::is_loss(line, model.shape.places[*to].node);
            if to_all.iter().all(|to| exit.to.contains(to)) || exit.to.iter().any(is_loss) {
                continue;
            }
            let names = exit
                .to
                .iter()
                .map(|to| model.shape.places[*to].name.as_str());
            let names: Vec<&str> = names.collect();
            let name = format!("{}_sends_{kind}_to_{}", declared.name, names.join("_or_"));
            let text = format!(
                "as long as {} passes on {kind} parts, one of them eventually goes to {}",
                declared.name,
                names.join(" or ")
            );
            let chosen = to_all
                .iter()
                .enumerate()
                .filter(|(_, to)| exit.to.contains(to));
            let sent = any(chosen.map(|(way, _)| is(decision, way))).or(is(decision, none));
            given.justice.push(formula(span, &name, &text, &sent));
        }
        // A place with a machine of its own may leave a part waiting although it has room.
        let takes_in_the_end = |to| !model.has_machine(to);
        let vain = any(ways
            .iter()
            .flat_map(|ways| ways.open())
            .map(|(to, exit)| model.waits_in_vain(place, part, to, &exit.to, takes_in_the_end)));
        if vain != Expr::FALSE {
            let name = format!("{}_sends_{kind}_where_there_is_room", declared.name);
            let text = format!(
                "{} does not keep {} for a full place for ever while another one has room that \
                 would do",
                declared.name,
                an(kind)
            );
            given.justice.push(formula(span, &name, &text, &vain.not()));
        }
        let in_order = ways.iter().flat_map(|ways| ways.open());
        let in_order = all(in_order
            .filter(|(_, exit)| exit.in_order)
            .map(|(to, exit)| passes_only_full(model, place, part, to, &exit.to)));
        if in_order != Expr::TRUE {
            let name = format!("{}_sends_{kind}_to_the_first_with_room", declared.name);
            let text = format!(
                "{} passes {} on to the first place in the list that has room",
                declared.name,
                an(kind)
            );
            given.safety.push(formula(span, &name, &text, &in_order));
        }
    }
    for (place, declared) in model.shape.places.iter().enumerate() {
        let PlaceKind::Supply { part, .. } = &declared.kind else {
            continue;
        };
        let comes = model.may_offer(place).not();
        let name = format!("{}_goes_on", declared.name);
        let text = format!(
            "{} eventually has another {}",
            declared.name, model.shape.types[*part]
        );
        let span = line.nodes[declared.node].span;
        given.justice.push(formula(span, &name, &text, &comes));
    }
    given
}

/// A part from `place` goes to `to` only if the places before it in the list are full, or other
/// parts wait for their room. Only places that always take a part when they have room count: a
/// station can be down or off shift.
fn passes_only_full(
    model: Model<'_>,
    place: usize,
    part: usize,
    to: usize,
    exit: &[usize],
) -> Expr {
    let (Some(takes), Some(from)) = (
        model.vars(to).takes,
        model.shape.places[to].from.iter().position(|f| *f == place),
    ) else {
        return Expr::TRUE;
    };
    let before = exit.iter().take_while(|other| **other != to);
    let sure = before.filter(|other| model.takes_at_once(**other));
    let free = any(sure.map(|&other| {
        let others = model.shape.places[other].from.iter();
        let nobody_else = others
            .filter(|from| **from != place)
            .map(|from| model.offers_any(*from, other).not());
        model.room(other, part).and(all(nobody_else))
    }));
    let taken = becomes(takes, from + 1).and(model.offers(place, part, to));
    taken.and(free).not().simplify()
}

fn goal(model: Model<'_>, line: &Line) -> Side {
    let mut goal = Side::default();
    for (place, declared) in model.shape.places.iter().enumerate() {
        let span = line.nodes[declared.node].span;
        let name = &declared.name;
        let push = |list: &mut Vec<Formula>, what: &str, text: String, expr: Expr| {
            let formula = formula(span, &format!("{what}_at_{name}"), &text, &expr);
            if formula.expr != Expr::TRUE {
                list.push(formula);
            }
        };
        let text = format!(
            "a part that arrives at {name} stays there until it moves to exactly one other place"
        );
        push(&mut goal.safety, NO_PART_LOST, text, kept(model, place));
        let text = format!("{name} takes only parts that it has room for");
        push(&mut goal.invariants, NO_OVERFLOW, text, fits(model, place));
        for (what, text, expr) in going_on(model, place) {
            push(&mut goal.justice, what, text, expr);
        }
    }
    let text = "something can move, or a station is working";
    let moves = any((0..model.shape.places.len()).map(|place| can_go_on(model, place)));
    goal.invariants
        .push(formula(line.span, NO_CIRCULAR_WAIT, text, &moves));
    for &product in &model.shape.products {
        let places = model.shape.places.iter().enumerate();
        let finished = any(places.filter_map(|(place, declared)| match &declared.kind {
            PlaceKind::End { finishes, .. } if finishes.contains(&product) => {
                Some(model.arrives(place, product))
            }
            _ => None,
        }));
        let text = format!(
            "{} is finished again and again, as long as more are ordered",
            an(&model.shape.types[product])
        );
        let name = orders_are_finished(model.shape, product);
        goal.justice
            .push(formula(line.span, &name, &text, &finished));
    }
    goal
}

/// Number of parts in a place; `None` for supplies and ends, which cannot lose any.
fn load(model: Model<'_>, place: usize) -> Option<Expr> {
    let vars = model.vars(place);
    if let Some(phase) = vars.phase {
        let bills = vars.bills.iter().flatten().map(|(v, _)| Expr::now(*v));
        return Some(sum([count([is(phase, 0).not()])].into_iter().chain(bills)));
    }
    match vars.queue.as_ref()? {
        Queue::Count(held, _) => Some(Expr::now(*held)),
        Queue::Slots(slots, _) => Some(count(slots.iter().map(|s| is(*s, 0).not()))),
    }
}

/// No part is lost: what was in the place and what arrives is there afterwards, except for what
/// goes to one other place. Only waiting parts are taken.
fn kept(model: Model<'_>, place: usize) -> Expr {
    let mut rules = Vec::new();
    for to in model.shape.after(place) {
        rules.push(model.taken(place, to).implies(model.offers_any(place, to)));
    }
    if let Some(load) = load(model, place) {
        let vars = model.vars(place);
        let out = model
            .shape
            .after(place)
            .into_iter()
            .map(|to| model.taken(place, to));
        let mut after = sum([load.clone(), count([model.arrives_any(place)])]);
        after = Expr::binary(BinaryOp::Sub, after, count(out));
        // Joining `n` parts leaves one.
        for (value, task) in &vars.joins {
            let bill = vars.bills[*task].iter().map(|(_, n)| i64::from(*n));
            let fewer = Expr::Const(bill.sum::<i64>() - 1);
            let joined = count(vars.takes.map(|takes| is(takes, *value)));
            after = Expr::binary(
                BinaryOp::Sub,
                after,
                Expr::binary(BinaryOp::Mul, joined, fewer),
            );
        }
        rules.push(later(&load).equals(after));
    }
    all(rules)
}

/// There is room for every part that is taken.
fn fits(model: Model<'_>, place: usize) -> Expr {
    let vars = model.vars(place);
    let mut rules = Vec::new();
    for from in &model.shape.places[place].from {
        let types = model.shape.between(*from, place);
        let taken = model.taken(*from, place);
        rules.extend(types.map(|part| {
            let comes = taken.clone().and(model.offers(*from, part, place));
            comes.implies(model.room(place, part)).simplify()
        }));
    }
    for (value, _) in &vars.joins {
        let joined = any(vars.takes.map(|takes| is(takes, *value)));
        rules.push(joined.implies(model.free(place)));
    }
    if let Some((in_line, most)) = vars.in_line {
        let more = Expr::binary(
            BinaryOp::Lt,
            Expr::now(in_line),
            Expr::Const(i64::from(most)),
        );
        rules.push(model.leaves(place).implies(more));
    }
    all(rules)
}

/// The goals that parts in a place proceed: name, description and formula of each.
fn going_on(model: Model<'_>, place: usize) -> Vec<(&'static str, String, Expr)> {
    let vars = model.vars(place);
    let name = &model.shape.places[place].name;
    let mut found = Vec::new();
    if let Some(phase) = vars.phase {
        let text = format!("a part that {name} works on eventually leaves it");
        found.push((GOES_ON, text, is(phase, 0)));
        for bill in vars.bills.iter().filter(|b| !b.is_empty()) {
            let text = format!("components that wait in {name} are eventually joined");
            let none = all(bill.iter().map(|(v, _)| is(*v, 0)));
            found.push((COMPONENTS_GO_ON, text, none));
        }
    } else if vars.queue.is_some() {
        let text = format!("the parts in {name} eventually leave it, one after the other");
        found.push((GOES_ON, text, model.empty(place).or(model.leaves(place))));
    } else if let PlaceKind::Supply { part, .. } = model.shape.places[place].kind {
        let kind = &model.shape.types[part];
        let text = format!("every {kind} that {name} has eventually enters the line");
        let offered = any(model
            .shape
            .after(place)
            .into_iter()
            .map(|to| model.offers_any(place, to)));
        found.push((GOES_ON, text, offered.not().or(model.leaves(place))));
    }
    found
}

/// Something can move at this place, or a part is in work.
fn can_go_on(model: Model<'_>, place: usize) -> Expr {
    let vars = model.vars(place);
    let mut ways = Vec::new();
    if let Some(takes) = vars.takes {
        ways.push(is(takes, 0).not());
        ways.push(model.owes(place));
    }
    if let Some(phase) = vars.phase {
        let work = vars
            .phases
            .iter()
            .enumerate()
            .filter(|(_, p)| matches!(p, Phase::Work(_)));
        ways.extend(work.map(|(i, _)| is(phase, i + 1)));
    }
    let takes_in_the_end = |to| !model.has_machine(to);
    for of_part in &model.shape.places[place].ways {
        let open = of_part.open();
        ways.extend(open.map(|(to, exit)| {
            model.waits_in_vain(place, of_part.part, to, &exit.to, takes_in_the_end)
        }));
    }
    ways.push(model.may_offer(place));
    ways.extend(vars.open.map(|open| Expr::now(open).not()));
    any(ways)
}
