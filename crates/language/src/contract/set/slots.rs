//! The numbers of a line or layout that can be set: their names, and where their values are in the
//! tree.
//!
//! [`for_each`] visits them in a fixed order. Names are given in tiers: a name that an earlier tier
//! has given belongs to it alone, so `belt.power` is the power of the conveyor and not that of its
//! machine. Within a tier, a short name can stand for several numbers; their full names tell them
//! apart.

use linewright_core::source::Span;
use linewright_syntax::ast::{
    self, Argument, Between, Component, Copies, Expr, Failures, LineItem, MachineItem, Name,
    PartCount, Role, StationItem, Supply, TimeValue, TypedDecl,
};
use linewright_syntax::{Value, ValueSyntax};
use std::collections::{BTreeMap, BTreeSet};

/// Declarations of machines that replace the shared ones, by the place of the machine's name in a
/// station or conveyor.
pub(in crate::contract) type Variants = BTreeMap<Span, ast::Machine>;

/// A number that can be set.
pub(super) struct Slot<'t> {
    /// Names, the shortest first.
    pub names: Vec<String>,
    /// Syntax of its value.
    pub syntax: ValueSyntax,
    /// The present value; `None` if the statement is absent and has a default.
    pub present: Option<Present>,
    /// Where the resolver may report a wrong value, if not at the value itself.
    pub reported_at: Option<Span>,
    /// Replaces the value, or adds the statement.
    pub set: Box<dyn FnOnce(Value) + 't>,
}

/// A value in the tree.
#[derive(Debug, Clone, Copy)]
pub(super) enum Present {
    /// Its place in the file.
    Text(Span),
    /// The same, of a time for each step of an action.
    PerStep(Span),
    /// A whole number.
    Count(u64),
}

/// Visits all numbers that can be set of the line or layout whose name is at `owner`: `items` are
/// the file's own declarations, and `machines` those that are visible in the file. A machine whose
/// numbers were changed for one place is added to `variants`.
pub(super) fn for_each(
    items: &mut [ast::Item],
    owner: Span,
    machines: &BTreeMap<&str, &ast::Machine>,
    variants: &mut Variants,
    visit: &mut dyn FnMut(Slot<'_>),
) {
    let mut slots = Slots {
        given: BTreeSet::new(),
        tier: Vec::new(),
        visit,
    };
    for item in items.iter_mut() {
        match item {
            ast::Item::Line(l) if l.name.span == owner => slots.line(l, machines, variants),
            ast::Item::Layout(l) if l.name.span == owner => slots.layout(l),
            _ => {}
        }
    }
    slots.end_tier();
    for item in items {
        if let ast::Item::Const(c) = item {
            slots.expression([c.name.text.clone()], &mut c.value);
        }
    }
}

/// The expression of a value; the parser has checked its kind.
pub(super) fn expression(value: Value) -> (Expr, bool) {
    match value {
        Value::Expression(value, words) => (value, words),
        _ => unreachable!("another syntax was asked for"),
    }
}

/// Whether an expression contains a name.
fn has_name(value: &Expr) -> bool {
    let mut found = false;
    value.for_each_path(&mut |_| found = true);
    found
}

/// Whether an expression contains a number.
pub(super) fn has_number(value: &Expr) -> bool {
    use ast::ExprKind::{Int, Quantity};
    matches!(value.kind, Int(_) | Quantity(..)) || value.children().into_iter().any(has_number)
}

/// Whether an expression contains a number with a unit.
fn has_unit(value: &Expr) -> bool {
    let children = value.children();
    matches!(&value.kind, ast::ExprKind::Quantity(_, unit) if !unit.is_empty())
        || children.into_iter().any(has_unit)
}

fn duration(value: Value) -> (TimeValue, bool) {
    match value {
        Value::Time(value, words) => (value, words),
        _ => unreachable!("another syntax was asked for"),
    }
}

fn parts_between(value: Value) -> Between {
    match value {
        Value::Parts(between) => between,
        _ => unreachable!("another syntax was asked for"),
    }
}

pub(super) fn count(value: &Value) -> u64 {
    match value {
        Value::Count(count) => *count,
        _ => unreachable!("another syntax was asked for"),
    }
}

/// How a station or conveyor uses its machine.
pub(super) struct MachineUse<'u> {
    /// Name of the station or conveyor.
    pub owner: &'u str,
    /// Whether it performs operations, so that times and powers have an effect.
    works: bool,
    /// Whether the machine's failures have an effect.
    fails: bool,
    /// Parameters that every call of an operation sets, so that the default has no effect.
    always: &'u BTreeSet<String>,
}

pub(super) struct Slots<'v> {
    /// Names that earlier tiers have given.
    given: BTreeSet<String>,
    /// Names of this tier.
    tier: Vec<String>,
    visit: &'v mut dyn FnMut(Slot<'_>),
}

impl Slots<'_> {
    /// Ends a tier of names.
    pub(super) fn end_tier(&mut self) {
        self.given.append(&mut self.tier.drain(..).collect());
    }

    pub(super) fn slot(
        &mut self,
        names: impl IntoIterator<Item = String>,
        syntax: ValueSyntax,
        present: Option<Present>,
        set: impl FnOnce(Value),
    ) {
        self.slot_at(names, syntax, present, None, set);
    }

    pub(super) fn slot_at(
        &mut self,
        names: impl IntoIterator<Item = String>,
        syntax: ValueSyntax,
        present: Option<Present>,
        reported_at: Option<Span>,
        set: impl FnOnce(Value),
    ) {
        let names = names.into_iter().filter(|name| !self.given.contains(name));
        let names: Vec<String> = names.collect();
        if !names.is_empty() {
            self.tier.extend(names.iter().cloned());
            (self.visit)(Slot {
                names,
                syntax,
                present,
                reported_at,
                set: Box::new(set),
            });
        }
    }

    pub(super) fn expression(&mut self, names: impl IntoIterator<Item = String>, value: &mut Expr) {
        let present = Some(Present::Text(value.span));
        self.slot(names, ValueSyntax::Expression, present, |new| {
            *value = expression(new).0;
        });
    }

    fn duration(&mut self, names: impl IntoIterator<Item = String>, value: &mut TimeValue) {
        let present = Some(Present::Text(value.span()));
        self.slot(names, ValueSyntax::Time, present, |new| {
            *value = duration(new).0;
        });
    }

    /// A whole number; `at` is the place at which the resolver reports a wrong one.
    fn count(&mut self, names: impl IntoIterator<Item = String>, value: &mut u64, at: Span) {
        let present = Some(Present::Count(*value));
        self.slot_at(names, ValueSyntax::Count, present, Some(at), |new| {
            *value = count(&new);
        });
    }

    fn optional_count(&mut self, name: String, value: &mut Option<u64>, at: Span) {
        let present = value.map(Present::Count);
        self.slot_at([name], ValueSyntax::Count, present, Some(at), |new| {
            *value = Some(count(&new));
        });
    }

    fn line(
        &mut self,
        line: &mut ast::Line,
        machines: &BTreeMap<&str, &ast::Machine>,
        variants: &mut Variants,
    ) {
        self.ways(line);
        self.end_tier();
        let shifts = line.items.iter_mut();
        self.shifts(
            "",
            shifts.filter_map(|item| match item {
                LineItem::Shift(shift) => Some(shift),
                _ => None,
            }),
        );
        for item in &mut line.items {
            match item {
                LineItem::Const(c) => self.expression([c.name.text.clone()], &mut c.value),
                LineItem::Part {
                    name,
                    bill,
                    properties,
                } => {
                    self.counted(&name.text, bill);
                    for property in properties {
                        let full = format!("{}.{}", name.text, property.name.text);
                        self.bounds(&full, &mut property.domain);
                        self.declared(full, property);
                    }
                }
                LineItem::Source {
                    name, supply, most, ..
                } => {
                    if let Supply::Every {
                        interval,
                        random,
                        limit,
                    } = supply
                    {
                        let present = Some(Present::Text(interval.span()));
                        let every = format!("{}.every", name.text);
                        self.slot([every], ValueSyntax::Interval, present, |new| {
                            let (new, word) = duration(new);
                            // A distribution takes the place of `random`.
                            *random = word || *random && matches!(new, TimeValue::Value(_));
                            *interval = new;
                        });
                        self.optional_count(format!("{}.limit", name.text), limit, name.span);
                    }
                    self.optional_count(format!("{}.at_most", name.text), most, name.span);
                }
                LineItem::Store { name, stock } => self.counted(&name.text, stock),
                LineItem::Buffer {
                    name,
                    capacity,
                    dwell,
                    shelf_life,
                    ..
                } => {
                    let name_of = |what: &str| format!("{}.{what}", name.text);
                    self.count([name_of("capacity")], capacity, name.span);
                    let present = dwell.as_ref().map(|dwell| Present::Text(dwell.span()));
                    self.slot([name_of("dwell")], ValueSyntax::Time, present, |new| {
                        *dwell = Some(duration(new).0);
                    });
                    let present = shelf_life.as_ref().map(|life| Present::Text(life.span));
                    let names = [name_of("shelf_life")];
                    self.slot(names, ValueSyntax::Expression, present, |new| {
                        *shelf_life = Some(expression(new).0);
                    });
                }
                LineItem::Conveyor {
                    name,
                    machine,
                    options,
                } => self.conveyor(name, machine, options, machines, variants),
                LineItem::Station {
                    name,
                    machine,
                    times,
                    items,
                } => {
                    let present = Some(Present::Count(times.map_or(1, |times| times.count)));
                    let names = [format!("{}.times", name.text)];
                    let span = name.span;
                    self.slot_at(names, ValueSyntax::Count, present, Some(span), |new| {
                        let count = count(&new);
                        *times = Some(Copies { count, span });
                    });
                    self.station(&name.text, machine, items, machines, variants);
                }
                LineItem::Requirement {
                    name,
                    bound,
                    per_hour,
                    span,
                    ..
                } => {
                    let names = [name.text.clone(), format!("{}.bound", name.text)];
                    let present = Some(Present::Text(bound.span));
                    self.slot_at(names, ValueSyntax::Bound, present, Some(*span), |new| {
                        let (new, words) = expression(new);
                        *bound = new;
                        *per_hour |= words;
                    });
                }
                LineItem::Limit(value, products) => {
                    let present = Some(Present::Text(value.span));
                    self.slot(["limit".to_owned()], ValueSyntax::Limit, present, |new| {
                        let (new, words) = expression(new);
                        // A bare number is in the present unit.
                        *products = words || *products && !has_unit(&new);
                        *value = new;
                    });
                }
                _ => {}
            }
        }
    }

    fn counted(&mut self, owner: &str, list: &mut [PartCount]) {
        for part in list {
            let name = format!("{owner}.{}", part.name.text);
            self.count([name], &mut part.count, part.name.span);
        }
    }

    /// A declaration `name: T = e`.
    fn declared(&mut self, name: String, declared: &mut TypedDecl) {
        match declared.values.first_mut() {
            Some(value) => self.expression([name], value),
            None => self.slot([name], ValueSyntax::Expression, None, |new| {
                declared.values.push(expression(new).0);
            }),
        }
    }

    fn conveyor(
        &mut self,
        name: &Name,
        machine: &mut Option<(Name, Vec<Argument>)>,
        options: &mut Vec<(Name, Expr)>,
        machines: &BTreeMap<&str, &ast::Machine>,
        variants: &mut Variants,
    ) {
        let (name, at) = (name.text.as_str(), Some(name.span));
        for (word, value) in options.iter_mut() {
            let names = [format!("{name}.{}", word.text)];
            let present = Some(Present::Text(value.span));
            self.slot_at(names, ValueSyntax::Expression, present, at, |new| {
                *value = expression(new).0;
            });
        }
        self.end_tier();
        if let Some((machine, arguments)) = machine {
            let used = MachineUse {
                owner: name,
                works: false,
                fails: false,
                always: &BTreeSet::new(),
            };
            self.machine(&used, machine, arguments, machines, variants);
            self.end_tier();
        }
        for word in ["places", "pitch", "speed", "power"] {
            if options.iter().all(|(option, _)| option.text != word) {
                let names = [format!("{name}.{word}")];
                self.slot_at(names, ValueSyntax::Expression, None, at, |new| {
                    let value = expression(new).0;
                    let text = word.to_owned();
                    let span = value.span;
                    options.push((Name { text, span }, value));
                });
            }
        }
    }

    fn station(
        &mut self,
        name: &str,
        machine: &mut Option<(Name, Vec<Argument>)>,
        items: &mut Vec<StationItem>,
        machines: &BTreeMap<&str, &ast::Machine>,
        variants: &mut Variants,
    ) {
        let statement = |word: &str| format!("{name}.{word}");
        let is_failure = |item: &StationItem| matches!(item, StationItem::Failures(_));
        let modes = items.iter().filter(|item| is_failure(item)).count();
        let typed = |item: &&StationItem| matches!(item, StationItem::Takes { part: Some(_), .. });
        let one_takes = !items
            .iter()
            .any(|i| matches!(i, StationItem::Takes { part: None, .. }))
            && items.iter().filter(typed).count() == 1;
        for item in items.iter_mut() {
            match item {
                StationItem::Takes { duration, part } => match part {
                    None => self.duration([statement("takes")], duration),
                    Some(part) => {
                        let short = one_takes.then(|| statement("takes"));
                        let full = format!("{name}.takes.{}", part.text);
                        self.duration(short.into_iter().chain([full]), duration);
                    }
                },
                StationItem::Setup(value) => self.duration([statement("setup")], value),
                StationItem::Power(value) => self.expression([statement("power")], value),
                StationItem::IdlePower(value) => self.expression([statement("idle_power")], value),
                StationItem::Failures(mode) => self.failures(name, modes, mode),
                _ => {}
            }
        }
        self.changes_of_parts(name, items);
        let shifts = items.iter_mut().filter_map(|item| match item {
            StationItem::Shift(shift) => Some(shift),
            _ => None,
        });
        self.shifts(&statement(""), shifts);
        // Parameters that every call sets itself: the machine's default has no effect.
        let mut always: Option<BTreeSet<String>> = None;
        for item in items.iter() {
            if let StationItem::Perform { operations, .. } = item {
                for call in operations {
                    let set = call.arguments.iter().map(|a| a.name.text.clone());
                    let set: BTreeSet<String> = set.collect();
                    always = Some(always.map_or_else(|| set.clone(), |a| &a & &set));
                }
            }
        }
        let always = always.unwrap_or_default();
        for item in items.iter_mut() {
            let StationItem::Perform { operations, part } = item else {
                continue;
            };
            for call in operations {
                let operation = &call.name.text;
                for Argument {
                    name: argument,
                    value,
                } in &mut call.arguments
                {
                    let argument = &argument.text;
                    let short = always.contains(argument).then(|| statement(argument));
                    let full = [
                        format!("{name}.{operation}.{argument}"),
                        format!("{name}.{}.{operation}.{argument}", part.text),
                    ];
                    self.expression(short.into_iter().chain(full), value);
                }
            }
        }
        self.end_tier();
        let has_machine = machine.is_some();
        if let Some((machine, arguments)) = machine {
            let used = MachineUse {
                owner: name,
                works: true,
                fails: modes == 0,
                always: &always,
            };
            self.machine(&used, machine, arguments, machines, variants);
            self.end_tier();
        }
        if !items.iter().any(|i| matches!(i, StationItem::Setup(_))) {
            self.slot([statement("setup")], ValueSyntax::Time, None, |new| {
                items.push(StationItem::Setup(duration(new).0));
            });
        }
        if has_machine {
            return;
        }
        if !items.iter().any(|i| matches!(i, StationItem::Power(_))) {
            self.slot([statement("power")], ValueSyntax::Expression, None, |new| {
                items.push(StationItem::Power(expression(new).0));
            });
        }
        if !items.iter().any(|i| matches!(i, StationItem::IdlePower(_))) {
            let names = [statement("idle_power")];
            self.slot(names, ValueSyntax::Expression, None, |new| {
                items.push(StationItem::IdlePower(expression(new).0));
            });
        }
    }

    /// A failure mode of a station, or of its machine. `modes` is the number of modes.
    fn failures(&mut self, owner: &str, modes: usize, mode: &mut Failures) {
        let named = mode.name.as_ref().map(|n| format!("{owner}.{}", n.text));
        let names = |word: &str| -> Vec<String> {
            let short = (modes == 1 || named.is_none()).then(|| format!("{owner}.{word}"));
            let full = named.as_ref().map(|mode| format!("{mode}.{word}"));
            short.into_iter().chain(full).collect()
        };
        match &mut mode.between {
            Between::Time(time) => self.duration(names("mtbf"), time),
            between => {
                let present = match between {
                    Between::DrawnParts(count) => Present::Text(count.span()),
                    Between::Parts(count) => Present::Count(*count),
                    Between::Time(time) => Present::Text(time.span()),
                };
                let at = Some(mode.span);
                self.slot_at(
                    names("every"),
                    ValueSyntax::Parts,
                    Some(present),
                    at,
                    |new| {
                        *between = parts_between(new);
                    },
                );
            }
        }
        self.duration(names("mttr"), &mut mode.mttr);
    }

    /// The numbers of the machine of one station or conveyor.
    fn machine(
        &mut self,
        used: &MachineUse<'_>,
        machine: &Name,
        arguments: &mut Vec<Argument>,
        machines: &BTreeMap<&str, &ast::Machine>,
        variants: &mut Variants,
    ) {
        let Some(shared) = machines.get(machine.text.as_str()) else {
            return;
        };
        for parameter in &shared.header.parameters {
            let name = format!("{}.{}", used.owner, parameter.name.text);
            let given = arguments
                .iter_mut()
                .find(|a| a.name.text == parameter.name.text);
            if let Some(argument) = given {
                self.expression([name], &mut argument.value);
                continue;
            }
            // A default with names has a meaning only within the machine.
            let default = parameter.default.as_ref().filter(|d| !has_name(d));
            let present = default.map(|default| Present::Text(default.span));
            self.slot([name], ValueSyntax::Expression, present, |new| {
                let value = expression(new).0;
                let text = parameter.name.text.clone();
                let span = value.span;
                arguments.push(Argument {
                    name: Name { text, span },
                    value,
                });
            });
        }
        self.end_tier();
        let mut own = (*shared).clone();
        self.statements(used, &mut own.items);
        self.actions(used, &mut own.items);
        self.wiring(used, &mut own.items);
        self.absent_statements(used, &mut own.items);
        if own != **shared {
            variants.insert(machine.span, own);
        }
    }

    /// Statements of a machine for all its actions.
    fn statements(&mut self, used: &MachineUse<'_>, items: &mut [MachineItem]) {
        let owner = used.owner;
        let statement = |word: &str| format!("{owner}.{word}");
        let modes = items.iter();
        let modes = modes.filter(|i| matches!(i, MachineItem::Failures(_)));
        let modes = modes.count();
        for item in items {
            let (word, value) = match item {
                MachineItem::Step(value) if used.works => ("step", value),
                MachineItem::Power(value) if used.works => ("power", value),
                MachineItem::Limit(value) if used.works => ("limit", value),
                MachineItem::IdlePower(value) => ("idle_power", value),
                MachineItem::Const(c) => (c.name.text.as_str(), &mut c.value),
                MachineItem::Failures(mode) if used.fails => {
                    self.failures(owner, modes, mode);
                    continue;
                }
                MachineItem::Parameter(parameter) => {
                    if !used.always.contains(&parameter.name.text) {
                        self.declared(statement(&parameter.name.text), parameter);
                    }
                    continue;
                }
                _ => continue,
            };
            self.expression([statement(word)], value);
        }
        self.end_tier();
    }

    /// Times and powers of a machine's actions, and the arguments of their contracts.
    fn actions(&mut self, used: &MachineUse<'_>, items: &mut [MachineItem]) {
        let mut actions: Vec<&mut Component> = items.iter_mut().filter_map(action).collect();
        let is_only = actions.len() == 1;
        let name = |c: &Name, word: &str| {
            let short = format!("{}.{word}", used.owner);
            [short, format!("{}.{}.{word}", used.owner, c.text)]
        };
        for c in &mut actions {
            if let Some((time, per_step)) = &mut c.time
                && used.works
            {
                let present = Some(if *per_step {
                    Present::PerStep(time.span)
                } else {
                    Present::Text(time.span)
                });
                let names = name(&c.name, "time");
                self.slot(names, ValueSyntax::ActionTime, present, |new| {
                    let (new, words) = expression(new);
                    *time = new;
                    *per_step |= words;
                });
            }
            if let Some(power) = &mut c.power
                && used.works
            {
                self.expression(name(&c.name, "power"), power);
            }
            for argument in &mut c.arguments {
                self.expression(name(&c.name, &argument.name.text), &mut argument.value);
            }
        }
        self.end_tier();
        // Absent statements; an action without `when` can have neither time nor power.
        for c in actions {
            if c.when.is_none() || !used.works {
                continue;
            }
            if c.time.is_none() {
                let names = name(&c.name, "time");
                let names = names.into_iter().skip(usize::from(!is_only));
                self.slot(names, ValueSyntax::ActionTime, None, |new| {
                    c.time = Some(expression(new));
                });
            }
            if c.power.is_none() {
                let [_, full] = name(&c.name, "power");
                self.slot([full], ValueSyntax::Expression, None, |new| {
                    c.power = Some(expression(new).0);
                });
            }
        }
        self.end_tier();
    }

    /// Statements that a machine lacks and that have a default.
    fn absent_statements(&mut self, used: &MachineUse<'_>, items: &mut Vec<MachineItem>) {
        type Statement = (&'static str, fn(Expr) -> MachineItem);
        const STATEMENTS: [Statement; 4] = [
            ("idle_power", MachineItem::IdlePower),
            ("power", MachineItem::Power),
            ("step", MachineItem::Step),
            ("limit", MachineItem::Limit),
        ];
        let kind = |item: &MachineItem| std::mem::discriminant(item);
        let effective = if used.works { STATEMENTS.len() } else { 1 };
        for (word, make) in &STATEMENTS[..effective] {
            let names = [format!("{}.{word}", used.owner)];
            let placeholder = make(Expr {
                kind: ast::ExprKind::Unknown,
                span: Span::default(),
            });
            if !items.iter().any(|item| kind(item) == kind(&placeholder)) {
                self.slot(names, ValueSyntax::Expression, None, |new| {
                    items.push(make(expression(new).0));
                });
            }
        }
    }
}

fn action(item: &mut MachineItem) -> Option<&mut Component> {
    match item {
        MachineItem::Component(c) if c.role == Role::Action => Some(c),
        _ => None,
    }
}
