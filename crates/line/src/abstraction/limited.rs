//! Lines in which a supply limits the number of its parts: a proof in small steps that it keeps
//! admitting new parts.
//!
//! Whether a joining station receives its next part of a limited type depends on the whole line:
//! the supply can release the part only when others have left the line, and they leave it only
//! after they have been joined. A proof for all places at once takes minutes and explains nothing.
//! The argument in words is short:
//!
//! 1. The supply's count equals the number of its parts in the places.
//! 2. While the supply releases nothing, one place after the other, starting with the first,
//!    becomes free of its parts and stays free.
//! 3. When all places are free, the count is 0, and the supply releases a part. So it releases
//!    parts again and again.
//! 4. So the first place receives a part again and again, then the next place, and so on up to the
//!    station that joins the part.
//!
//! Each step is one lemma about one place and its predecessor.

use super::book::ClaimBuilder;
use super::requirements::{COMPONENTS_GO_ON, GOES_ON, NO_CIRCULAR_WAIT, NO_OVERFLOW, NO_PART_LOST};
use super::shape::PlaceKind;
use super::vocabulary::{Model, Phase, Queue};
use super::words::{all, an, count, is, later, sum};
use linewright_algebra::proof::Reach;
use linewright_algebra::system::FormulaRef;
use linewright_core::gr1::{BinaryOp, Expr, FormulaKind, VarId};
use std::collections::{BTreeMap, BTreeSet};

/// A supply that limits the number of its parts in the line, and where these parts can be.
pub(super) struct LimitedSupply<'a> {
    model: Model<'a>,
    supply: usize,
    part: usize,
    in_line: VarId,
    most: u32,
    /// Where its parts can be. Each stage follows its predecessors, unless parts can go round in a
    /// cycle.
    stages: Vec<Stage>,
    /// Whether its parts can go round in a cycle.
    is_round: bool,
}

/// A part type at a place.
struct Stage {
    at: Spot,
    /// Predecessors, as indices into `stages`; empty if parts come from the supply.
    from: Vec<usize>,
}

/// A possible location of a part of a type.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Spot {
    place: usize,
    kind: usize,
    /// If the part waits to be joined: the task and the line of the task's bill.
    bill: Option<(usize, usize)>,
}

impl<'a> LimitedSupply<'a> {
    /// Analyzes a supply with a limit; `None` if the supply has no limit.
    pub fn new(model: Model<'a>, supply: usize) -> Option<Self> {
        let (in_line, most) = model.vars(supply).in_line?;
        let PlaceKind::Supply { part, .. } = model.shape.places[supply].kind else {
            return None;
        };
        let mut before: BTreeMap<Spot, BTreeSet<Spot>> = BTreeMap::new();
        let mut open: Vec<(Option<Spot>, Spot)> = spots_after(model, supply, part)
            .map(|to| (None, to))
            .collect();
        while let Some((from, to)) = open.pop() {
            let is_new = !before.contains_key(&to);
            before.entry(to).or_default().extend(from);
            if is_new {
                open.extend(after(model, to).into_iter().map(|next| (Some(to), next)));
            }
        }
        let mut order: Vec<Spot> = Vec::new();
        while let Some((next, _)) = before
            .iter()
            .find(|(spot, from)| !order.contains(spot) && from.iter().all(|f| order.contains(f)))
        {
            order.push(*next);
        }
        let is_round = order.len() < before.len();
        if is_round {
            order = before.keys().copied().collect();
        }
        let stage = |at: &Spot| Stage {
            at: *at,
            from: (0..order.len())
                .filter(|i| before[at].contains(&order[*i]))
                .collect(),
        };
        Some(Self {
            stages: order.iter().map(stage).collect(),
            model,
            supply,
            part,
            in_line,
            most,
            is_round,
        })
    }

    /// Whether the proof covers this component of a joining station.
    pub fn brings(&self, place: usize, task: usize, line: usize) -> bool {
        let wanted = (place, Some((task, line)));
        !self.is_round
            && self
                .stages
                .iter()
                .any(|s| (s.at.place, s.at.bill) == wanted)
    }

    /// Adds the lemmas about the supply. `others` are pairs of a place and a lemma about another
    /// component there.
    pub fn add(&self, book: &mut ClaimBuilder<'_>, others: &[(usize, FormulaRef)]) {
        let cycles = self.cycles();
        let joins = !self.is_round && self.stages.iter().any(|s| s.at.bill.is_some());
        if cycles.is_empty() && !joins {
            return;
        }
        let counted = self.counts(book);
        let mut known = BTreeSet::from([counted]);
        for cycle in cycles {
            known.insert(self.never_overrun(book, &cycle, counted));
        }
        book.rests_on(NO_CIRCULAR_WAIT, known);
        if joins {
            let gone = self.drains(book, others);
            let gives = self.gives_again(book, counted, gone);
            self.comes(book, gives);
        }
    }

    // ---- 1. the count ---------------------------------------------------------------------

    /// Converts a number of parts of a type to the number of supplied parts in them.
    fn weighed(&self, kind: usize, number: Expr) -> Expr {
        let content = self.model.shape.contents[kind][self.part];
        let content = i64::try_from(content).unwrap_or(i64::MAX);
        Expr::binary(BinaryOp::Mul, Expr::Const(content), number).simplify()
    }

    /// Number of supplied parts in the selected places.
    fn total(&self, places: impl Fn(usize) -> bool) -> Expr {
        let there = self.stages.iter().filter(|s| places(s.at.place));
        sum(there.map(|s| self.weighed(s.at.kind, self.held(&s.at))))
    }

    /// Adds the lemma that the supply's count equals the number of its parts in the places.
    fn counts(&self, book: &mut ClaimBuilder<'_>) -> FormulaRef {
        let (model, part) = (self.model, &self.model.shape.types[self.part]);
        let name = &model.shape.places[self.supply].name;
        let places: BTreeSet<usize> = self.stages.iter().map(|s| s.at.place).collect();
        let mut from = BTreeSet::new();
        from.extend(book.goal(NO_PART_LOST, self.supply));
        for place in &places {
            let all = book.guarantees(*place);
            from.extend(all.filter(|at| at.kind != FormulaKind::Justice));
            from.extend(book.goal(NO_PART_LOST, *place));
        }
        let mut left = Vec::new();
        for (end, declared) in model.shape.places.iter().enumerate() {
            if let PlaceKind::End { leaves, .. } = &declared.kind {
                let content = |kind: &&usize| model.shape.contents[**kind][self.part];
                left.extend(leaves.iter().filter(|k| content(k) > 0).map(|kind| {
                    let one = count([model.arrives(end, *kind)]);
                    self.weighed(*kind, one)
                }));
            }
        }
        let total = self.total(|_| true);
        let came = sum([total.clone(), count([model.leaves(self.supply)])]);
        let kept = later(&total);
        let kept = sum([kept].into_iter().chain(left)).equals(came);
        let text = format!(
            "each {part} that {name} releases is in one place, by itself or joined to others, until it leaves the line"
        );
        let title = format!("{part}_goes_from_place_to_place");
        let kept = book.lemma(
            self.supply,
            FormulaKind::Safety,
            (&title, &text),
            &kept,
            from,
            Reach::Named,
        );

        let mut from = BTreeSet::from([kept]);
        from.extend(book.guarantees(self.supply));
        from.extend(book.goal(NO_OVERFLOW, self.supply));
        for place in &places {
            let all = book.guarantees(*place);
            from.extend(all.filter(|at| at.kind == FormulaKind::Initial));
        }
        let counted = Expr::now(self.in_line).equals(total);
        let title = format!("{name}_counts_right");
        let text = format!("the count of {name} equals the number of its parts in the line");
        book.lemma(
            self.supply,
            FormulaKind::Invariant,
            (&title, &text),
            &counted,
            from,
            Reach::Named,
        )
    }

    /// The cycles in which its parts can be: sets of places in which parts can move from each place
    /// to every other.
    fn cycles(&self) -> BTreeSet<BTreeSet<usize>> {
        let places: BTreeSet<usize> = self.stages.iter().map(|s| s.at.place).collect();
        let mut cycles = all_cycles(self.model);
        cycles.retain(|cycle| !cycle.is_disjoint(&places));
        cycles
    }

    /// Adds the lemma that a cycle never holds more of the supply's parts than the limit.
    fn never_overrun(
        &self,
        book: &mut ClaimBuilder<'_>,
        cycle: &BTreeSet<usize>,
        counted: FormulaRef,
    ) -> FormulaRef {
        let held = self.total(|place| cycle.contains(&place));
        let few = Expr::binary(BinaryOp::Le, held, Expr::Const(i64::from(self.most)));
        let names: Vec<&str> = cycle
            .iter()
            .map(|p| self.model.shape.places[*p].name.as_str())
            .collect();
        let text = format!(
            "at most {} of {} are in {}, by themselves or joined to others",
            self.most,
            self.model.shape.types[self.part],
            names.join(", ")
        );
        let part = &self.model.shape.types[self.part];
        let name = format!("{}_are_never_overrun_by_{part}", names.join("_"));
        let from = BTreeSet::from([counted]);
        book.lemma(
            self.supply,
            FormulaKind::Invariant,
            (&name, &text),
            &few,
            from,
            Reach::Near,
        )
    }

    // ---- 2. and 3. the line empties, then new parts come ------------------------------

    /// Adds the lemmas that, while the supply releases nothing, place after place becomes free of
    /// its parts and stays free. Returns the last of these lemmas.
    fn drains(
        &self,
        book: &mut ClaimBuilder<'_>,
        others: &[(usize, FormulaRef)],
    ) -> Option<FormulaRef> {
        let model = self.model;
        let gives = model.leaves(self.supply);
        let part = &model.shape.types[self.part];
        let supply = &model.shape.places[self.supply].name;
        let mut rid: Vec<Expr> = Vec::new();
        let (mut stays, mut drains) = (None, None);
        for stage in &self.stages {
            let place = stage.at.place;
            rid.push(self.held(&stage.at).equals(Expr::Const(0)));
            let here = self.name(&stage.at);
            let mut about: BTreeSet<FormulaRef> = self.near(book, stage);
            about.extend(stays);

            let gone = all(rid.clone());
            let on = after(model, stage.at)
                .into_iter()
                .filter(|to| to.place != place)
                .map(|to| {
                    let offered = model.offers(place, stage.at.kind, to.place);
                    model.taken(place, to.place).and(offered).not()
                });
            let stay = later(&gone).and(all(on));
            let stay = gone.clone().and(gives.clone().not()).implies(stay);
            let name = format!("{part}_stays_gone_up_to_{here}");
            let text = format!(
                "while {supply} releases nothing and the places up to the {here} hold none of its parts, they stay that way, and none comes from there"
            );
            let safe = about
                .iter()
                .copied()
                .filter(|at| at.kind != FormulaKind::Justice)
                .collect();
            let words = (name.as_str(), text.as_str());
            let next = book.lemma(place, FormulaKind::Safety, words, &stay, safe, Reach::Named);

            about.extend(drains);
            about.extend(book.given(place));
            about.extend(book.goal(GOES_ON, place));
            let here_too = others
                .iter()
                .filter(|(p, _)| *p == place && stage.at.bill.is_some());
            about.extend(here_too.map(|(_, lemma)| *lemma));
            let again = gives.clone().or(gone);
            let name = format!("{part}_is_gone_up_to_{here}");
            let text = format!(
                "{supply} releases a part, or all places up to the {here} eventually hold none of its parts"
            );
            let words = (name.as_str(), text.as_str());
            let next_one = book.lemma(
                place,
                FormulaKind::Justice,
                words,
                &again,
                about,
                Reach::Named,
            );
            drains = Some(next_one);
            stays = Some(next);
        }
        drains
    }

    /// Adds the lemma that the supply releases a part again and again.
    fn gives_again(
        &self,
        book: &mut ClaimBuilder<'_>,
        counted: FormulaRef,
        gone: Option<FormulaRef>,
    ) -> FormulaRef {
        let name = &self.model.shape.places[self.supply].name;
        let mut from: BTreeSet<FormulaRef> = book.guarantees(self.supply).collect();
        from.extend(book.given(self.supply));
        from.extend(book.goal(GOES_ON, self.supply));
        from.insert(counted);
        from.extend(gone);
        let gives = self.model.leaves(self.supply);
        let title = format!("{name}_gives_again");
        let text = format!("{name} admits another part to the line, again and again");
        let words = (title.as_str(), text.as_str());
        book.lemma(
            self.supply,
            FormulaKind::Justice,
            words,
            &gives,
            from,
            Reach::Named,
        )
    }

    // ---- 4. on to the stations that join it -----------------------------------------------------

    /// Adds the lemmas that released parts reach place after place, up to the stations that join
    /// them.
    fn comes(&self, book: &mut ClaimBuilder<'_>, gives: FormulaRef) {
        let mut wanted: BTreeSet<usize> = (0..self.stages.len())
            .filter(|i| self.stages[*i].at.bill.is_some())
            .collect();
        for i in (0..self.stages.len()).rev() {
            if wanted.contains(&i) {
                wanted.extend(&self.stages[i].from);
            }
        }
        let mut known: BTreeMap<usize, FormulaRef> = BTreeMap::new();
        for (i, stage) in self.stages.iter().enumerate() {
            if !wanted.contains(&i) {
                continue;
            }
            let place = stage.at.place;
            let mut from = self.near(book, stage);
            from.insert(gives);
            for before in &stage.from {
                let before = self.stages[*before].at.place;
                from.extend(book.guarantees(before));
                from.extend(book.given(before));
                from.extend(book.goal(GOES_ON, before));
                from.extend(book.goal(COMPONENTS_GO_ON, before));
            }
            from.extend(stage.from.iter().filter_map(|i| known.get(i)));
            let there = match stage.at.bill {
                Some((task, line)) => {
                    let (there, most) = self.model.vars(place).bills[task][line];
                    is(there, most as usize)
                }
                None => self.held(&stage.at).equals(Expr::Const(0)).not(),
            };
            let (kind, name) = (
                &self.model.shape.types[stage.at.kind],
                &self.model.shape.places[place].name,
            );
            let text = match stage.at.bill {
                Some(_) => format!("again and again, {name} receives a {kind} to join"),
                None => format!("{} arrives at {name}, again and again", an(kind)),
            };
            let reach = match stage.at.bill {
                Some(_) => Reach::Near,
                None => Reach::Named,
            };
            let title = match &self.model.shape.types[self.part] {
                part if part == kind => format!("{kind}_comes_to_{name}"),
                part => format!("{part}_in_{kind}_comes_to_{name}"),
            };
            let lemma = book.lemma(
                place,
                FormulaKind::Justice,
                (&title, &text),
                &there,
                from,
                reach,
            );
            known.insert(i, lemma);
        }
    }

    /// The candidates for the proof of a lemma about a stage: the guarantees of its place, and the
    /// goals that no part is lost there or in its predecessors.
    fn near(&self, book: &ClaimBuilder<'_>, stage: &Stage) -> BTreeSet<FormulaRef> {
        let place = stage.at.place;
        let mut from: BTreeSet<FormulaRef> = book.guarantees(place).collect();
        let before = stage.from.iter().map(|i| self.stages[*i].at.place);
        for place in before.chain([place]) {
            from.extend(book.goal(NO_PART_LOST, place));
        }
        from
    }

    fn name(&self, at: &Spot) -> String {
        let (place, kind) = (
            &self.model.shape.places[at.place].name,
            &self.model.shape.types[at.kind],
        );
        match at.bill {
            Some(_) => format!("{kind}_to_be_joined_at_{place}"),
            None => format!("{kind}_at_{place}"),
        }
    }

    /// Number of parts at a spot.
    fn held(&self, at: &Spot) -> Expr {
        let vars = self.model.vars(at.place);
        if let Some((task, line)) = at.bill {
            return Expr::now(vars.bills[task][line].0);
        }
        if let Some(phase) = vars.phase {
            let phases = vars.phases.iter().enumerate();
            let own = phases.filter(|(_, p)| match p {
                Phase::Work(kind) | Phase::Done(kind, _) => *kind == at.kind,
            });
            return count([super::words::any(own.map(|(i, _)| is(phase, i + 1)))]);
        }
        match &vars.queue {
            Some(Queue::Count(held, _)) => Expr::now(*held),
            Some(Queue::Slots(slots, types)) => {
                let label = types.iter().position(|kind| *kind == at.kind);
                count(slots.iter().filter_map(|s| Some(is(*s, label? + 1))))
            }
            None => Expr::Const(0),
        }
    }
}

/// Where a part of a type can go next from a place.
fn spots_after(model: Model<'_>, place: usize, kind: usize) -> impl Iterator<Item = Spot> {
    let to = model.shape.to(place, kind).iter();
    to.flat_map(move |to| {
        let mut found = Vec::new();
        let mut add = |bill| {
            found.push(Spot {
                place: *to,
                kind,
                bill,
            });
        };
        match &model.shape.places[*to].kind {
            PlaceKind::Station { tasks } => {
                for (task, work) in tasks.iter().enumerate() {
                    if work.plain && work.part == kind {
                        add(None);
                    }
                    let lines = work
                        .bill
                        .iter()
                        .enumerate()
                        .filter(|(_, (component, _))| *component == kind);
                    lines.for_each(|(line, _)| add(Some((task, line))));
                }
            }
            PlaceKind::Conveyor { .. } | PlaceKind::Room { .. } => add(None),
            PlaceKind::Supply { .. } | PlaceKind::End { .. } => {}
        }
        found
    })
}

/// Where a part can go next.
fn after(model: Model<'_>, at: Spot) -> Vec<Spot> {
    let Some((task, _)) = at.bill else {
        return spots_after(model, at.place, at.kind).collect();
    };
    let PlaceKind::Station { tasks } = &model.shape.places[at.place].kind else {
        return Vec::new();
    };
    vec![Spot {
        place: at.place,
        kind: tasks[task].part,
        bill: None,
    }]
}

/// Sets of places in which parts can move from each place to every other.
fn all_cycles(model: Model<'_>) -> BTreeSet<BTreeSet<usize>> {
    let reached = |from: usize| {
        let mut seen = BTreeSet::new();
        let mut open = vec![from];
        while let Some(place) = open.pop() {
            let after = model.shape.after(place).into_iter();
            open.extend(after.filter(|to| seen.insert(*to)));
        }
        seen
    };
    let reached: Vec<BTreeSet<usize>> = (0..model.shape.places.len()).map(reached).collect();
    (0..reached.len())
        .filter(|place| reached[*place].contains(place))
        .map(|place| {
            let back = reached[place].iter().copied();
            back.filter(|other| reached[*other].contains(&place))
                .collect()
        })
        .collect()
}
