//! The figures of a run, computed from its log as CSV, and compared with the trace. Nothing of the
//! runner's accounts is used: only the rows, and what the file of the line says.

use super::{Row, controlled, logged, node, rows, uncontrolled};
use linewright::contract::line::{Line, NodeKind, declared_name};
use linewright::event_log::Format;
use linewright::line::Trace;
use linewright::line::trace::LeadTime;
use std::collections::{BTreeMap, BTreeSet};

/// Whether two figures are the same but for rounding.
fn same(a: f64, b: f64, what: &str) {
    let near = (a - b).abs() <= 1e-7 * a.abs().max(b.abs()).max(1e-3);
    assert!(near, "{what}: {a} from the log, {b} in the trace");
}

/// A number over time.
#[derive(Default, Clone)]
struct Level {
    count: f64,
    since: f64,
    area: f64,
    max: f64,
    full: f64,
}

impl Level {
    fn set(&mut self, time: f64, count: f64, capacity: f64) {
        self.area += self.count * (time - self.since);
        if (self.count - capacity).abs() < 0.5 {
            self.full += time - self.since;
        }
        self.since = time;
        self.count = count;
        self.max = self.max.max(count);
    }

    fn forget(&mut self, time: f64) {
        *self = Self {
            count: self.count,
            since: time,
            max: self.count,
            ..Self::default()
        };
    }
}

#[derive(Default, Clone)]
struct Part {
    kind: usize,
    entered_at: f64,
    visits: BTreeSet<String>,
    reworked: bool,
    reworked_inside: u64,
    is_worked: bool,
    worked_inside: u64,
    in_setup: bool,
}

impl Part {
    /// Number of single parts in it on which a station has worked.
    fn worked(&self) -> u64 {
        self.worked_inside.max(u64::from(self.is_worked))
    }

    /// Number of those on which a station has worked twice.
    fn reworked(&self) -> u64 {
        if self.reworked {
            self.worked()
        } else {
            self.reworked_inside
        }
    }
}

/// What the rows say about a node.
#[derive(Default, Clone)]
struct Account {
    seconds: BTreeMap<String, f64>,
    state: Option<(String, f64)>,
    visited: bool,
    joules: f64,
    ended: u64,
    work: f64,
    control: f64,
    lost: f64,
    charged: u64,
    aborted: u64,
    left: u64,
    lost_parts: u64,
    moved: f64,
    level: Level,
    arrived: BTreeMap<u64, f64>,
    waits: Vec<f64>,
    expired: u64,
    made: Option<f64>,
    blocked: f64,
}

/// Everything that the rows say.
struct Figures<'a> {
    line: &'a Line,
    accounts: Vec<Account>,
    parts: BTreeMap<u64, Part>,
    components: Vec<u64>,
    wip: Level,
    before: u64,
    entered: u64,
    finished: u64,
    consumed: u64,
    rejects: BTreeMap<usize, (u64, u64)>,
    leads: Vec<(usize, f64)>,
    stored: u64,
    makespan: f64,
    finished_single: u64,
    first_pass: u64,
    scrapped: u64,
    violations: u64,
    start: f64,
    end: f64,
    worked: Option<f64>,
}

impl<'a> Figures<'a> {
    fn new(line: &'a Line, rows: &[Row]) -> Self {
        let mut figures = Self {
            line,
            accounts: vec![Account::default(); line.nodes.len()],
            parts: BTreeMap::new(),
            components: Vec::new(),
            wip: Level::default(),
            before: 0,
            entered: 0,
            finished: 0,
            consumed: 0,
            rejects: BTreeMap::new(),
            leads: Vec::new(),
            stored: 0,
            makespan: 0.0,
            finished_single: 0,
            first_pass: 0,
            scrapped: 0,
            violations: 0,
            start: 0.0,
            end: 0.0,
            worked: None,
        };
        for row in rows {
            figures.read(row);
        }
        figures
    }

    fn read(&mut self, row: &Row) {
        let time = row.time;
        match row.what.as_str() {
            "counting" => {
                self.forget(time);
                self.worked = row.seconds;
                return;
            }
            "run_ended" => {
                self.end = time;
                self.close(time);
                self.worked = row.seconds.map(|end| end - self.worked.unwrap_or(0.0));
                return;
            }
            _ => {}
        }
        let index = node(self.line, &row.node);
        let kind = self.line.parts.iter();
        let kind = kind.clone().position(|part| part.name == row.part_type);
        let account = &mut self.accounts[index];
        account.joules += row.joules.unwrap_or(0.0);
        let number = row.part.unwrap_or(0);
        let capacity = match self.line.nodes[index].kind {
            NodeKind::Buffer { capacity, .. } => f64::from(capacity),
            _ => -1.0,
        };
        match row.what.as_str() {
            "violation" => self.violations += 1,
            "state" => {
                if let Some((state, since)) = account.state.replace((row.other.clone(), time)) {
                    *account.seconds.entry(state).or_default() += time - since;
                }
            }
            "made" => account.made = Some(time),
            "entered" => self.enter(number, kind.unwrap(), time),
            "arrived" => {
                account.visited = true;
                account.arrived.insert(number, time);
                account.level.set(time, account.level.count + 1.0, capacity);
            }
            "left" => {
                account.left += 1;
                account.moved += row.seconds.unwrap_or(0.0);
                account.level.set(time, account.level.count - 1.0, capacity);
                account
                    .waits
                    .extend(account.arrived.remove(&number).map(|since| time - since));
                if let Some(made) = account.made.take() {
                    account.blocked += time - made;
                }
                let to = &self.line.nodes[node(self.line, &row.other)].kind;
                account.lost_parts += u64::from(matches!(to, NodeKind::Sink { reject: true, .. }));
            }
            "moved" => account.moved += row.seconds.unwrap(),
            "setup_started" => {
                self.visit(number, index);
                self.parts.get_mut(&number).unwrap().in_setup = true;
            }
            "started" => {
                let part = self.parts.get_mut(&number).unwrap();
                if !std::mem::take(&mut part.in_setup) {
                    self.visit(number, index);
                }
            }
            "ended" => {
                account.ended += 1;
                self.parts.get_mut(&number).unwrap().is_worked = true;
                account.work += row.seconds.unwrap();
                account.control += row.control_seconds.unwrap_or(0.0);
            }
            "aborted" => account.aborted += 1,
            "failed" => account.lost += row.seconds.unwrap(),
            "consumed" => {
                self.components.push(number);
                self.consumed += 1;
                self.wip.set(time, self.wip.count - 1.0, -1.0);
            }
            "finished" => self.finish(number, index, time),
            "rejected" => {
                if matches!(self.line.nodes[index].kind, NodeKind::Buffer { .. }) {
                    account.expired += 1;
                    account.level.set(time, account.level.count - 1.0, capacity);
                }
                self.rejects.entry(kind.unwrap()).or_default().0 += 1;
                self.wip.set(time, self.wip.count - 1.0, -1.0);
                if !row.other.is_empty() {
                    self.scrapped += self.parts[&number].worked().max(1);
                    self.accounts[node(self.line, &row.other)].charged += 1;
                }
            }
            "reordered" => {
                self.rejects.entry(kind.unwrap()).or_default().1 += row.value.unwrap() as u64;
            }
            "place" | "repaired" | "changed" | "defect" => {}
            what => panic!("{what} is unknown"),
        }
    }

    fn enter(&mut self, number: u64, kind: usize, time: f64) {
        let components = std::mem::take(&mut self.components);
        let components = components.iter().map(|part| &self.parts[part]);
        let entered_at = components.clone().map(|part| part.entered_at);
        let entered_at = entered_at.fold(time, f64::min);
        let worked = components.clone().map(Part::worked);
        let reworked = components.map(Part::reworked);
        let part = Part {
            kind,
            entered_at,
            worked_inside: worked.sum(),
            reworked_inside: reworked.sum(),
            ..Part::default()
        };
        self.parts.insert(number, part);
        self.entered += 1;
        self.wip.set(time, self.wip.count + 1.0, -1.0);
    }

    fn visit(&mut self, number: u64, index: usize) {
        let name = declared_name(&self.line.nodes[index].name).to_owned();
        let part = self.parts.get_mut(&number).unwrap();
        part.reworked |= !part.visits.insert(name);
    }

    fn finish(&mut self, number: u64, index: usize, time: f64) {
        let part = &self.parts[&number];
        self.finished += 1;
        self.wip.set(time, self.wip.count - 1.0, -1.0);
        self.finished_single += part.worked();
        self.first_pass += part.worked().saturating_sub(part.reworked());
        if self.line.is_product(part.kind) {
            self.leads.push((part.kind, time - part.entered_at));
            self.makespan = time;
            let stored = matches!(self.line.nodes[index].kind, NodeKind::Store { .. });
            self.stored += u64::from(stored);
        }
    }

    /// The warm-up ends.
    fn forget(&mut self, time: f64) {
        self.start = time;
        self.wip.forget(time);
        self.before = self.wip.count as u64;
        (self.entered, self.finished, self.consumed) = (0, 0, 0);
        (self.finished_single, self.first_pass, self.scrapped) = (0, 0, 0);
        self.rejects.clear();
        self.leads.clear();
        (self.stored, self.makespan) = (0, 0.0);
        for account in &mut self.accounts {
            let mut level = account.level.clone();
            level.forget(time);
            *account = Account {
                level,
                state: account.state.take().map(|(state, _)| (state, time)),
                visited: account.visited,
                arrived: std::mem::take(&mut account.arrived),
                made: account.made.map(|_| time),
                ..Account::default()
            };
        }
    }

    fn close(&mut self, time: f64) {
        self.wip.set(time, self.wip.count, -1.0);
        for (account, node) in self.accounts.iter_mut().zip(&self.line.nodes) {
            let capacity = match node.kind {
                NodeKind::Buffer { capacity, .. } => f64::from(capacity),
                _ => -1.0,
            };
            account.level.set(time, account.level.count, capacity);
            if let Some((state, since)) = account.state.take() {
                *account.seconds.entry(state).or_default() += time - since;
            }
            if let Some(made) = account.made {
                account.blocked += time - made;
            }
        }
    }

    fn compare(&self, trace: &Trace) {
        let counted = self.end - self.start;
        let rate = |count: usize, seconds: f64| {
            if seconds > 0.0 {
                count as f64 * 3600.0 / seconds
            } else {
                0.0
            }
        };
        let share = |seconds: f64| {
            if counted > 0.0 {
                seconds / counted
            } else {
                0.0
            }
        };
        same(self.end, trace.seconds, "end");
        same(self.start, trace.warm_up, "warm-up");
        same(self.makespan, trace.makespan, "makespan");
        assert_eq!(self.leads.len() as u64, trace.products);
        assert_eq!(self.stored, trace.stored);
        same(
            rate(self.leads.len(), counted),
            trace.throughput_per_hour,
            "throughput",
        );
        let on_shift = self.worked.map(|seconds| rate(self.leads.len(), seconds));
        assert_eq!(on_shift.is_some(), trace.throughput_on_shift.is_some());
        same(
            on_shift.unwrap_or(0.0),
            trace.throughput_on_shift.unwrap_or(0.0),
            "throughput on shift",
        );
        same(share(self.wip.area), trace.wip.mean, "WIP");
        assert_eq!(self.wip.max as u64, trace.wip.max);
        let rejected: u64 = self.rejects.values().map(|(count, _)| count).sum();
        let parts = [
            (self.before, trace.parts.before),
            (self.entered, trace.parts.entered),
            (self.finished, trace.parts.finished),
            (rejected, trace.parts.rejected),
            (self.consumed, trace.parts.consumed),
            (self.wip.count as u64, trace.parts.in_progress),
            (self.finished_single, trace.yields.finished),
            (self.first_pass, trace.yields.first_pass),
            (self.scrapped, trace.yields.scrapped),
            (self.violations, trace.violation_count),
        ];
        for (number, (ours, theirs)) in parts.into_iter().enumerate() {
            assert_eq!(ours, theirs, "count {number}");
        }
        lead_times(self.leads.iter().map(|(_, lead)| *lead), &trace.lead_time);
        for product in &trace.by_type {
            let leads = self.leads.iter().filter(|(kind, _)| *kind == product.part);
            let leads = leads.map(|(_, lead)| *lead);
            assert_eq!(leads.clone().count() as u64, product.products);
            lead_times(leads, &product.lead_time);
        }
        let rejects = self.rejects.iter().filter(|(_, (count, _))| *count > 0);
        let rejects: Vec<_> = rejects.map(|(kind, (a, b))| (*kind, *a, *b)).collect();
        let theirs = trace.rejects.iter().map(|r| (r.part, r.count, r.reordered));
        assert_eq!(rejects, theirs.collect::<Vec<_>>());
        same(
            self.accounts.iter().map(|account| account.joules).sum(),
            trace.joules,
            "energy",
        );
        self.compare_stations(trace);
        self.compare_places(trace);
    }

    fn compare_stations(&self, trace: &Trace) {
        for station in &trace.stations {
            let account = &self.accounts[station.node];
            let seconds = |state: &str| account.seconds.get(state).copied().unwrap_or(0.0);
            let total: f64 = account.seconds.values().sum();
            let name = &station.name;
            let waits = if account.visited { "starved" } else { "idle" };
            let failed_off_shift = seconds("failed_off_shift");
            let mut shares = BTreeMap::from([
                ("busy", seconds("busy")),
                ("blocked", seconds("blocked")),
                ("failed", seconds("failed") + failed_off_shift),
                ("setup", seconds("setup")),
                ("idle", seconds("idle")),
                ("starved", 0.0),
            ]);
            *shares.get_mut(waits).unwrap() += seconds("starved");
            let s = station.shares;
            for (state, theirs) in [
                ("busy", s.busy),
                ("blocked", s.blocked),
                ("failed", s.failed),
                ("setup", s.setup),
                ("idle", s.idle),
                ("starved", s.starved),
            ] {
                if total > 0.0 {
                    same(shares[state] / total, theirs, &format!("{name} {state}"));
                }
            }
            same(seconds("busy"), station.busy_seconds, name);
            same(account.joules, station.joules, &format!("energy of {name}"));
            assert_eq!(account.ended, station.processed, "{name}");
            assert_eq!(account.charged, station.scrapped, "{name}");
            let parts = account.ended as f64;
            if let Some(work) = station.work_time {
                same(account.work / parts, work.seconds, name);
                same(account.control / parts, work.control_seconds, name);
            }
            if let Some(oee) = station.oee {
                let planned = total - seconds("idle") - failed_off_shift;
                let made = (account.ended + account.aborted) as f64;
                let busy = seconds("busy");
                same((busy / planned).min(1.0), oee.availability, name);
                same(
                    (1.0 - account.lost / busy).max(0.0),
                    oee.effectiveness,
                    name,
                );
                let quality = 1.0 - account.charged as f64 / made;
                same(quality.max(0.0), oee.quality, name);
            }
        }
        for machine in &trace.machines {
            let of_machine = |index: &usize| {
                let controlled = self.line.nodes[*index].machine();
                controlled.is_some_and(|m| m.name == machine.name)
            };
            let nodes = (0..self.accounts.len()).filter(of_machine);
            let joules: f64 = nodes.clone().map(|index| self.accounts[index].joules).sum();
            same(joules, machine.joules, &machine.name);
            let busy = nodes.map(|index| {
                let account = &self.accounts[index];
                account.moved + account.seconds.get("busy").copied().unwrap_or(0.0)
            });
            same(busy.sum(), machine.busy_seconds, &machine.name);
        }
    }

    fn compare_places(&self, trace: &Trace) {
        let counted = self.end - self.start;
        let share = |seconds: f64| {
            if counted > 0.0 {
                seconds / counted
            } else {
                0.0
            }
        };
        for conveyor in &trace.conveyors {
            let account = &self.accounts[conveyor.node];
            assert_eq!(account.left, conveyor.carried);
            same(account.moved, conveyor.moving_seconds, &conveyor.name);
            same(account.joules, conveyor.joules, &conveyor.name);
        }
        for buffer in &trace.buffers {
            let account = &self.accounts[buffer.node];
            let name = &buffer.name;
            assert_eq!(account.left, buffer.passed, "{name}");
            assert_eq!(account.expired, buffer.expired, "{name}");
            assert_eq!(account.level.max as u64, buffer.longest, "{name}");
            same(share(account.level.area), buffer.length, name);
            same(share(account.level.full), buffer.full, name);
            let waits = &account.waits;
            let mean = waits.iter().sum::<f64>() / (waits.len() as f64).max(1.0);
            same(mean, buffer.wait, name);
            let longest = waits.iter().copied().fold(0.0, f64::max);
            same(longest, buffer.longest_wait, name);
        }
        for source in &trace.sources {
            let account = &self.accounts[source.node];
            assert_eq!(account.left, source.passed, "{}", source.name);
            same(share(account.blocked), source.blocked, &source.name);
            let lost = account.lost_parts as f64 / (account.left as f64).max(1.0);
            same(lost, source.lost, &source.name);
        }
    }
}

fn lead_times(leads: impl Iterator<Item = f64>, theirs: &LeadTime) {
    let mut leads: Vec<f64> = leads.collect();
    leads.sort_by(f64::total_cmp);
    if leads.is_empty() {
        assert_eq!(*theirs, LeadTime::default());
        return;
    }
    let rank = |share: f64| leads[((share * leads.len() as f64).ceil() as usize).max(1) - 1];
    same(
        leads.iter().sum::<f64>() / leads.len() as f64,
        theirs.mean,
        "mean lead time",
    );
    same(rank(0.5), theirs.p50, "median lead time");
    same(rank(0.95), theirs.p95, "95th percentile of the lead time");
    same(leads[leads.len() - 1], theirs.max, "longest lead time");
}

/// What happened in all runs, so that the comparison cannot become empty.
fn count_words(words: &mut BTreeMap<String, usize>, rows: &[Row]) {
    for row in rows {
        *words.entry(row.what.clone()).or_default() += 1;
    }
}

fn check(mut plant: linewright::line::Plant, words: &mut BTreeMap<String, usize>) {
    let line = plant.line().clone();
    let (trace, bytes) = logged(&mut plant, Format::Csv);
    let rows = rows(&bytes);
    count_words(words, &rows);
    Figures::new(&line, &rows).compare(&trace);
}

#[test]
fn figures_of_random_lines_follow_from_the_log() {
    let mut words = BTreeMap::new();
    for seed in 1..=100 {
        let warm_up = if seed % 2 == 0 { 0.2 } else { 0.0 };
        println!("line {seed}");
        check(uncontrolled(seed, warm_up), &mut words);
    }
    for seed in 1..=100 {
        let warm_up = if seed % 2 == 0 { 30.0 } else { 0.0 };
        println!("controlled line {seed}");
        check(controlled(seed, warm_up), &mut words);
    }
    println!("{words:?}");
    for word in [
        "made",
        "entered",
        "arrived",
        "consumed",
        "setup_started",
        "started",
        "ended",
        "changed",
        "defect",
        "left",
        "place",
        "finished",
        "rejected",
        "reordered",
        "failed",
        "repaired",
        "state",
        "moved",
        "violation",
        "counting",
        "run_ended",
    ] {
        let count = words.get(word).copied().unwrap_or(0);
        assert!(count >= 20, "{word}: {count}");
    }
}
