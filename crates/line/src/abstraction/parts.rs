//! What every place assumes of its neighbors and guarantees: one Moore contract per place.
//!
//! Two guarantees rest on proofs about the machines' contracts: a station's service ends, and parts
//! on a belt reach its end. How long this takes is left out. A third guarantee follows from how the
//! runner moves parts (see [`crate`]): a place with room takes a waiting part. The runner moves it
//! at once; in steps of unknown length, this means "eventually".

use super::shape::PlaceKind;
use super::vocabulary::{Model, Phase, Queue};
use super::words::{all, any, becomes, choose, count, is, later, stays, sum, within};
use linewright_algebra::system::Component;
use linewright_core::gr1::{BinaryOp, Expr, Formula, Side, Timing, VarId};
use linewright_core::source::Span;
use linewright_language::contract::line::Line;

/// Creates a formula with a name and a description.
pub(super) fn formula(span: Span, name: &str, text: &str, expr: &Expr) -> Formula {
    Formula {
        defines: false,
        name: name.to_owned(),
        requirement: None,
        expr: expr.simplify(),
        span,
        text: text.to_owned(),
    }
}

/// The contract of a place. If `settled` is given, everything that takes time waits until this
/// expression holds, that is, until everything that moves at once has moved.
pub(super) fn part(
    model: Model<'_>,
    line: &Line,
    place: usize,
    settled: Option<&Expr>,
) -> Component {
    let declared = &model.shape.places[place];
    let mut writer = Writer {
        model,
        place,
        span: line.nodes[declared.node].span,
        assumptions: Side::default(),
        guarantees: Side::default(),
    };
    writer.neighbours();
    match &declared.kind {
        PlaceKind::Station { .. } => writer.station(),
        PlaceKind::Conveyor { .. } | PlaceKind::Room { .. } => writer.queue(),
        PlaceKind::Supply { part, .. } => writer.supply(*part),
        PlaceKind::End { .. } => {}
    }
    writer.takes();
    if let Some(settled) = settled {
        writer.in_time(settled);
    }
    let vars = model.vars(place);
    let mut drives: Vec<VarId> = Vec::new();
    drives.extend(vars.phase);
    drives.extend(vars.bills.iter().flatten().map(|(v, _)| *v));
    match &vars.queue {
        Some(Queue::Count(count, _)) => drives.push(*count),
        Some(Queue::Slots(slots, _)) => drives.extend(slots),
        None => {}
    }
    drives.extend(vars.end);
    drives.extend(vars.open);
    drives.extend(vars.in_line.map(|(v, _)| v));
    drives.extend(vars.earlier.iter().map(|(_, _, v)| *v));
    drives.extend(vars.takes);
    Component {
        name: declared.name.clone(),
        timing: Timing::Moore,
        drives,
        assumptions: writer.assumptions,
        guarantees: writer.guarantees,
        definitions: Side::default(),
        completions: Side::default(),
    }
}

struct Writer<'a> {
    model: Model<'a>,
    place: usize,
    span: Span,
    assumptions: Side,
    guarantees: Side,
}

impl Writer<'_> {
    fn initial(&mut self, name: &str, text: &str, expr: &Expr) {
        self.guarantees
            .initial
            .push(formula(self.span, name, text, expr));
    }

    fn safety(&mut self, name: &str, text: &str, expr: &Expr) {
        self.guarantees
            .safety
            .push(formula(self.span, name, text, expr));
    }

    fn justice(&mut self, name: &str, text: &str, expr: &Expr) {
        self.guarantees
            .justice
            .push(formula(self.span, name, text, expr));
    }

    fn name(&self, place: usize) -> &str {
        &self.model.shape.places[place].name
    }

    /// Adds the assumptions about the neighbors.
    fn neighbours(&mut self) {
        let (model, place) = (self.model, self.place);
        for from in &model.shape.places[place].from {
            let types = model.shape.between(*from, place);
            let kept = types.map(|part| {
                let offered = model.offers(*from, part, place);
                let still = later(&offered);
                offered.and(model.taken(*from, place).not()).implies(still)
            });
            let name = format!("{}_holds_what_it_offers", self.name(*from));
            let text = format!(
                "{} keeps its waiting part until that is taken",
                self.name(*from)
            );
            let rule = formula(self.span, &name, &text, &all(kept));
            if rule.expr != Expr::TRUE {
                self.assumptions.safety.push(rule);
            }
        }
        for to in model.shape.after(place) {
            let taken = model.taken(place, to);
            let rule = later(&taken).implies(model.offers_any(place, to).and(taken.clone().not()));
            let name = format!("{}_takes_what_is_offered", self.name(to));
            let text = format!(
                "{} takes from here only parts that wait to go there, and each of them once",
                self.name(to)
            );
            let first = format!("{name}_at_first");
            self.assumptions
                .safety
                .push(formula(self.span, &name, &text, &rule));
            let text = format!("{} takes nothing at first", self.name(to));
            self.assumptions
                .initial
                .push(formula(self.span, &first, &text, &taken.not()));
        }
    }

    /// Adds that events that take time happen only when nothing can move at once any more. Supplies
    /// are exempt, unless they lead only to sinks and stores, because their next part comes at once
    /// if it is overdue or has just been brought. So are buffers in which parts rest: the next part
    /// may have rested long enough when the first one leaves.
    fn in_time(&mut self, settled: &Expr) {
        let (model, place) = (self.model, self.place);
        let is_supply = matches!(model.shape.places[place].kind, PlaceKind::Supply { .. });
        let may_be_overdue = is_supply && !model.shape.leads_to_ends_only(place);
        let rests = matches!(
            model.shape.places[place].kind,
            PlaceKind::Room { dwells: true, .. }
        );
        if may_be_overdue || rests || !model.takes_time(place) {
            return;
        }
        let vars = model.vars(place);
        let mut still = Vec::new();
        if let Some(phase) = vars.phase {
            let work = vars
                .phases
                .iter()
                .enumerate()
                .filter(|(_, p)| matches!(p, Phase::Work(_)));
            still.extend(work.map(|(i, _)| is(phase, i + 1).implies(becomes(phase, i + 1))));
        }
        still.extend(vars.end.map(|end| is(end, 0).implies(becomes(end, 0))));
        still.extend(
            vars.open
                .map(|open| Expr::now(open).not().implies(Expr::next(open).not())),
        );
        self.safety(
            "lets_others_move_first",
            "work that takes time ends only when nothing in the line can move at once",
            &settled.clone().or(all(still)),
        );
    }

    /// Adds which part is taken, and when.
    fn takes(&mut self) {
        let (model, place) = (self.model, self.place);
        let vars = model.vars(place);
        let Some(takes) = vars.takes else { return };
        self.initial(
            "takes_nothing_at_first",
            "nothing is taken in the first step",
            &is(takes, 0),
        );
        let from = model.shape.places[place].from.iter().enumerate();
        let offered =
            from.map(|(i, from)| becomes(takes, i + 1).implies(model.offers_any(*from, place)));
        let join = vars
            .joins
            .iter()
            .map(|(value, task)| becomes(takes, *value).implies(model.complete(place, *task)));
        self.safety(
            "takes_only_what_is_offered",
            "it takes a part only from a place where one waits for it, and joins only complete bills",
            &all(offered.chain(join)),
        );
        // Whether there is room for what this taker offers; always true for sinks and stores.
        let roomy = |taker: usize| {
            if let Some(&from) = model.shape.places[place].from.get(taker - 1) {
                let types = model.shape.between(from, place);
                all(types.map(|part| {
                    model
                        .offers(from, part, place)
                        .implies(model.room(place, part))
                }))
            } else {
                model.free(place)
            }
        };
        let with_room = model
            .takers(place)
            .map(|t| becomes(takes, t).implies(roomy(t)));
        self.safety(
            "takes_only_with_room",
            "it takes a part only while there is room for it, and joins only while it is free",
            &all(with_room),
        );
        self.safety(
            "one_at_a_time",
            "after a step in which a part was taken, none is taken in the next",
            &is(takes, 0).or(becomes(takes, 0)),
        );
        self.turns();
        if matches!(model.shape.places[place].kind, PlaceKind::End { .. }) {
            // There is always room, so no part has to wait for others.
            for (i, from) in model.shape.places[place].from.iter().enumerate() {
                let waits = model.offers_any(*from, place);
                let name = format!("takes_from_{}_in_the_end", self.name(*from));
                let text = format!(
                    "if a part at {} waits to come here, it is eventually taken",
                    self.name(*from)
                );
                let taken = is(takes, i + 1);
                self.justice(&name, &text, &taken.or(waits.not()));
            }
            return;
        }
        let text = match model.shape.places[place].kind {
            PlaceKind::Conveyor { places, sure, .. } if sure < places => format!(
                "if a part waits to come here, one is eventually taken, as long as fewer than {sure} are on it or the first \
                 one has not reached the end"
            ),
            _ => "if a part waits to come here and there is room for it, one is eventually taken"
                .to_owned(),
        };
        self.justice(
            "takes_in_the_end",
            &text,
            &is(takes, 0).not().or(model.owes(place).not()),
        );
    }

    /// Adds that the part that has waited longest goes first.
    fn turns(&mut self) {
        let (model, place) = (self.model, self.place);
        let vars = model.vars(place);
        let (Some(takes), false) = (vars.takes, vars.earlier.is_empty()) else {
            return;
        };
        let waits = |taker: usize| {
            let waits = match vars.joins.iter().find(|(value, _)| *value == taker) {
                Some((_, task)) => model.complete(place, *task),
                None => model.offers_any(model.shape.places[place].from[taker - 1], place),
            };
            waits.and(is(takes, taker).not())
        };
        let mut rules = Vec::new();
        for (a, b, earlier) in &vars.earlier {
            let (wa, wb) = (waits(*a), waits(*b));
            rules.push(
                wa.clone()
                    .and(wb.clone().not())
                    .implies(Expr::next(*earlier)),
            );
            rules.push(
                wb.clone()
                    .and(wa.clone().not())
                    .implies(Expr::next(*earlier).not()),
            );
            rules.push(wa.and(wb).implies(stays(*earlier)));
            let first = |this: usize, other: usize, other_first: Expr| {
                becomes(takes, this).implies(other_first.and(model.may_take(place, other)).not())
            };
            rules.push(first(*a, *b, Expr::now(*earlier).not()));
            rules.push(first(*b, *a, Expr::now(*earlier)));
        }
        // Parts that begin to wait at the same instant are in an arbitrary, but consistent order.
        let order = |x: usize, y: usize| {
            vars.earlier
                .iter()
                .find(|(a, b, _)| (*a, *b) == (x, y))
                .map(|e| e.2)
        };
        let mut initial = Vec::new();
        for (a, b, ab) in &vars.earlier {
            for (c, d, bc) in vars.earlier.iter().filter(|(c, _, _)| c == b) {
                debug_assert_eq!(c, b);
                if let Some(ac) = order(*a, *d) {
                    let order = |time: fn(VarId) -> Expr| {
                        let forth = time(*ab).and(time(*bc)).implies(time(ac));
                        forth.and(time(ac).implies(time(*ab).or(time(*bc))))
                    };
                    initial.push(order(Expr::now));
                    rules.push(order(Expr::next));
                }
            }
        }
        if !initial.is_empty() {
            self.initial(
                "some_order_at_first",
                "waiting parts form a queue, in any order",
                &all(initial),
            );
        }
        self.safety(
            "first_come_first_served",
            "of the waiting parts that there is room for, the one that has waited longest is taken",
            &all(rules),
        );
    }

    fn station(&mut self) {
        let (model, place) = (self.model, self.place);
        let vars = model.vars(place);
        let (Some(phase), PlaceKind::Station { tasks }) =
            (vars.phase, &model.shape.places[place].kind)
        else {
            return;
        };
        let value = |wanted: Phase| {
            vars.phases
                .iter()
                .position(|p| *p == wanted)
                .map_or(0, |i| i + 1)
        };
        let bills = vars.bills.iter().flatten();
        let empty = all(bills.map(|(v, _)| is(*v, 0)));
        self.initial(
            "starts_empty",
            "it is free and empty at first",
            &is(phase, 0).and(empty),
        );

        let mut begins = Vec::new();
        let mut untouched = vec![is(phase, 0)];
        for ways in &model.shape.places[place].ways {
            let part = ways.part;
            let plain = tasks.iter().any(|t| t.plain && t.part == part);
            let served = model
                .arrives(place, part)
                .and(model.lacks(place, part).not());
            let joined = vars
                .joins
                .iter()
                .filter(|(_, task)| tasks[*task].part == part);
            let joined = joined.filter_map(|(value, _)| Some(is(vars.takes?, *value)));
            let begun = any(joined.chain(plain.then_some(served)));
            begins.push(
                begun
                    .clone()
                    .implies(becomes(phase, value(Phase::Work(part)))),
            );
            untouched.push(begun.not());
        }
        self.safety(
            "works_on_what_it_takes",
            "it begins to work on the part that it takes or joins",
            &all(begins),
        );
        self.safety(
            "stays_free",
            "without a part it stays free",
            &all(untouched).implies(becomes(phase, 0)),
        );

        let (mut works, mut holds, mut hands) = (Vec::new(), Vec::new(), Vec::new());
        for (index, at) in vars.phases.iter().enumerate() {
            let now = is(phase, index + 1);
            match *at {
                Phase::Work(part) => {
                    let done = model
                        .shape
                        .to(place, part)
                        .iter()
                        .enumerate()
                        .map(|(way, to)| {
                            let goes = becomes(phase, value(Phase::Done(part, *to)));
                            let decided = model.vocabulary.decisions.get(&(place, part));
                            decided.map_or(Expr::TRUE, |d| is(*d, way)).and(goes)
                        });
                    works.push(
                        now.implies(any([becomes(phase, index + 1)].into_iter().chain(done))),
                    );
                }
                Phase::Done(_, to) => {
                    let taken = model.taken(place, to);
                    holds.push(
                        now.clone()
                            .and(taken.clone().not())
                            .implies(becomes(phase, index + 1)),
                    );
                    hands.push(now.and(taken).implies(becomes(phase, 0)));
                }
            }
        }
        self.safety(
            "chooses_a_way",
            "when its work on a part ends, the part waits for the place that its properties determine",
            &all(works),
        );
        self.safety(
            "holds_what_it_offers",
            "a part that waits stays until it is taken",
            &all(holds),
        );
        self.safety(
            "hands_over_at_once",
            "a part that is taken leaves, and the station is free",
            &all(hands),
        );
        self.bills();
        let working = vars
            .phases
            .iter()
            .enumerate()
            .filter(|(_, p)| matches!(p, Phase::Work(_)));
        let working = any(working.map(|(i, _)| is(phase, i + 1)));
        self.justice(
            "ends_its_work",
            "its work on every part eventually ends",
            &working.not(),
        );
    }

    /// Adds that components wait in their places and disappear when they are joined.
    fn bills(&mut self) {
        let (model, place) = (self.model, self.place);
        let vars = model.vars(place);
        let (Some(takes), PlaceKind::Station { tasks }) =
            (vars.takes, &model.shape.places[place].kind)
        else {
            return;
        };
        let mut rules = Vec::new();
        for (task, bill) in vars.bills.iter().enumerate() {
            let joined = vars.joins.iter().filter(|(_, t)| *t == task);
            let joined = any(joined.map(|(value, _)| is(takes, *value)));
            for (line, (there, most)) in bill.iter().enumerate() {
                let part = tasks[task].bill[line].0;
                let comes = model
                    .arrives(place, part)
                    .and(model.component_place(place, part, task, line));
                let more = within(sum([Expr::now(*there), count([comes])]), i64::from(*most));
                let then = Expr::If(
                    Box::new(joined.clone()),
                    Box::new(Expr::Const(0)),
                    Box::new(more),
                );
                rules.push(Expr::next(*there).equals(then));
            }
        }
        if !rules.is_empty() {
            self.safety(
                "collects_components",
                "a component that it takes waits in its place until all are there and are joined",
                &all(rules),
            );
        }
    }

    fn queue(&mut self) {
        let (model, place) = (self.model, self.place);
        let vars = model.vars(place);
        let Some(queue) = &vars.queue else { return };
        let out = model.leaves(place);
        let (start, rule) = match queue {
            Queue::Count(held, capacity) => {
                let came = sum([Expr::now(*held), count([model.arrives_any(place)])]);
                let after = Expr::binary(BinaryOp::Sub, came, count([out]));
                (
                    is(*held, 0),
                    Expr::next(*held).equals(within(after, i64::from(*capacity))),
                )
            }
            Queue::Slots(slots, types) => {
                let new = types.iter().enumerate();
                let new =
                    new.map(|(i, part)| (model.arrives(place, *part), Expr::Const(i as i64 + 1)));
                let new = choose(new.collect(), Expr::Const(0));
                // Contents of a slot after the first part has left, if it leaves.
                let moved = |i: usize| {
                    let next = slots.get(i + 1).map_or(Expr::Const(0), |s| Expr::now(*s));
                    Expr::If(
                        Box::new(out.clone()),
                        Box::new(next),
                        Box::new(Expr::now(slots[i])),
                    )
                };
                let rules = slots.iter().enumerate().map(|(i, slot)| {
                    let free = moved(i).equals(Expr::Const(0));
                    let behind = if i == 0 {
                        Expr::TRUE
                    } else {
                        moved(i - 1).equals(Expr::Const(0)).not()
                    };
                    let then = choose(
                        vec![(free.clone().not(), moved(i)), (behind, new.clone())],
                        Expr::Const(0),
                    );
                    Expr::next(*slot).equals(then)
                });
                (all(slots.iter().map(|s| is(*s, 0))), all(rules))
            }
        };
        let ends = vars
            .end
            .map(|end| is(end, 0))
            .into_iter()
            .chain(vars.open.map(Expr::now));
        self.initial(
            "starts_empty",
            "it is empty at first",
            &all([start].into_iter().chain(ends)),
        );
        if let Some(open) = vars.open {
            let came = model.arrives_any(place);
            let rule = (came.clone().implies(Expr::next(open).not()))
                .and(came.not().and(Expr::now(open)).implies(Expr::next(open)));
            self.safety(
                "clears_its_first_place",
                "each part that enters occupies the first place for some time; then the place is free until the next part enters",
                &rule,
            );
            self.justice(
                "clears_in_the_end",
                "its first place eventually becomes free again",
                &Expr::now(open),
            );
        }
        self.safety(
            "keeps_parts_in_order",
            "a part that is taken joins the end of the queue, the first one leaves when it is taken, the others stay",
            &rule,
        );
        if let Some(end) = vars.end {
            let travels = matches!(model.shape.places[place].kind, PlaceKind::Conveyor { .. });
            self.end(end, &|part| model.first_is(place, part), if travels {
                "the first part eventually reaches the end, and waits for the place that its properties determine"
            } else {
                "the first part waits for the place that its properties determine"
            });
            let came = is(end, 0).not().or(model.empty(place));
            let text = if travels {
                "parts on it eventually reach its end"
            } else {
                "the first part in it eventually waits for its next place"
            };
            self.justice("brings_to_the_end", text, &came);
        }
    }

    /// Adds which part is offered, if the contents of the place do not determine this. `there`
    /// states when a part of a type can be offered.
    fn end(&mut self, end: VarId, there: &dyn Fn(usize) -> Expr, text: &str) {
        let (model, place) = (self.model, self.place);
        let vars = model.vars(place);
        let (mut holds, mut hands) = (Vec::new(), Vec::new());
        let mut comes = vec![becomes(end, 0)];
        for (index, (part, to)) in vars.offers.iter().enumerate() {
            let now = is(end, index + 1);
            let taken = model.taken(place, *to);
            holds.push(
                now.clone()
                    .and(taken.clone().not())
                    .implies(becomes(end, index + 1)),
            );
            hands.push(now.and(taken).implies(becomes(end, 0)));
            let way = model.shape.to(place, *part).iter().position(|t| t == to);
            let decided = model
                .vocabulary
                .decisions
                .get(&(place, *part))
                .zip(way)
                .map_or(Expr::TRUE, |(d, way)| is(*d, way));
            comes.push(all([becomes(end, index + 1), there(*part), decided]));
        }
        self.safety("brings_forward", text, &is(end, 0).implies(any(comes)));
        self.safety(
            "holds_what_it_offers",
            "a part that waits stays until it is taken",
            &all(holds),
        );
        self.safety(
            "hands_over_at_once",
            "a part that is taken no longer waits here",
            &all(hands),
        );
    }

    fn supply(&mut self, part: usize) {
        let (model, place) = (self.model, self.place);
        let vars = model.vars(place);
        let mut room = Expr::TRUE;
        if let Some((in_line, most)) = vars.in_line {
            room = Expr::binary(
                BinaryOp::Lt,
                Expr::now(in_line),
                Expr::Const(i64::from(most)),
            );
            self.initial(
                "counts_from_nothing",
                "nothing is in the line at first",
                &is(in_line, 0),
            );
            let mut left = Vec::new();
            for (end, declared) in model.shape.places.iter().enumerate() {
                let PlaceKind::End { leaves, .. } = &declared.kind else {
                    continue;
                };
                for kind in leaves
                    .iter()
                    .filter(|k| model.shape.contents[**k][part] > 0)
                {
                    let content =
                        i64::try_from(model.shape.contents[*kind][part]).unwrap_or(i64::MAX);
                    let left_here = count([model.arrives(end, *kind)]);
                    left.push(Expr::binary(BinaryOp::Mul, left_here, Expr::Const(content)));
                }
            }
            let came = sum([Expr::now(in_line), count([model.leaves(place)])]);
            let then = within(
                Expr::binary(BinaryOp::Sub, came, sum(left)),
                i64::from(most),
            );
            self.safety(
                "counts_what_is_in_the_line",
                "its count increases by one with each part it releases, and decreases with each that leaves the line",
                &Expr::next(in_line).equals(then),
            );
        }
        if let Some(end) = vars.end {
            self.initial("starts_without", "it has no part at first", &is(end, 0));
            self.end(
                end,
                &|_| room.clone(),
                "its next part eventually comes, but only while its limit allows it",
            );
        }
    }
}
