//! From pest's pairs to the syntax tree.
//!
//! Every rule of the grammar has one function here of nearly its name. The grammar guarantees which children a pair has; where one is
//! missing all the same, [`Children::next`] stops with a message that asks for a report.

use super::ast::{
    Argument, BinaryOp, Binding, Component, ConstDecl, Contract, ContractItem, Counted, Domain,
    DomainKind, Expr, ExprKind, File, Header, Import, Item, Line, LineItem, Machine, MachineItem,
    Name, Ownership, Parameter, Quantifier, StationItem, Supply, TypeDecl, Typed,
};
use super::parser::{Rule, explain};
use crate::diagnostics::{Diagnostic, codes};
use crate::source::{FileId, Span};
use pest::iterators::{Pair, Pairs};

pub(super) struct Builder {
    pub tree: File,
    pub findings: Vec<Diagnostic>,
    file: FileId,
}

/// The children of a pair without punctuation.
struct Children<'a> {
    pairs: std::iter::Peekable<std::vec::IntoIter<Pair<'a, Rule>>>,
}

impl<'a> Children<'a> {
    fn of(pair: Pair<'a, Rule>) -> Self {
        let pairs: Vec<_> = pair
            .into_inner()
            .filter(|p| {
                !matches!(
                    p.as_rule(),
                    Rule::close_paren
                        | Rule::close_bracket
                        | Rule::close_brace
                        | Rule::colon
                        | Rule::equals
                ) && !is_keyword(p.as_rule())
            })
            .collect();
        Self {
            pairs: pairs.into_iter().peekable(),
        }
    }

    fn next(&mut self) -> Pair<'a, Rule> {
        self.pairs.next().unwrap_or_else(|| {
            unreachable!("the grammar and its builder disagree; please report this")
        })
    }

    fn take(&mut self, rule: Rule) -> Option<Pair<'a, Rule>> {
        self.pairs.next_if(|p| p.as_rule() == rule)
    }

    fn rest(self) -> impl Iterator<Item = Pair<'a, Rule>> {
        self.pairs
    }
}

impl Builder {
    pub fn new(file: FileId) -> Self {
        Self {
            tree: File::default(),
            findings: Vec::new(),
            file,
        }
    }

    pub fn file(&mut self, pairs: Pairs<'_, Rule>) {
        for pair in pairs.flat_map(Pair::into_inner) {
            match pair.as_rule() {
                Rule::import => {
                    let item = self.import(pair);
                    self.tree.items.push(Item::Import(item));
                }
                Rule::type_decl => {
                    let item = self.type_decl(pair);
                    self.tree.items.push(Item::Type(item));
                }
                Rule::const_decl => {
                    let item = self.const_decl(pair);
                    self.tree.items.push(Item::Const(item));
                }
                Rule::contract => {
                    let item = self.contract(pair);
                    self.tree.items.push(Item::Contract(item));
                }
                Rule::machine => {
                    let item = self.machine(pair);
                    self.tree.items.push(Item::Machine(item));
                }
                Rule::line => {
                    let item = self.line(pair);
                    self.tree.items.push(Item::Line(item));
                }
                Rule::bad_item => self.bad(&pair),
                _ => {}
            }
        }
    }

    fn span(&self, pair: &Pair<'_, Rule>) -> Span {
        let span = pair.as_span();
        let trimmed = span.as_str().trim_end();
        Span::new(self.file, span.start(), span.start() + trimmed.len())
    }

    fn bad(&mut self, pair: &Pair<'_, Rule>) {
        let finding = explain(
            self.file,
            pair.as_span().start(),
            pair.as_str(),
            pair.as_rule(),
        );
        self.findings.push(finding);
    }

    fn name(&self, pair: &Pair<'_, Rule>) -> Name {
        Name {
            text: pair.as_str().trim().to_owned(),
            span: self.span(pair),
        }
    }

    /// A natural number; one that does not fit is a finding.
    fn integer(&mut self, pair: &Pair<'_, Rule>) -> i64 {
        let text = pair.as_str().trim();
        match text.parse::<i64>() {
            Ok(value) if value <= 1 << 53 => value,
            _ => {
                let finding = Diagnostic::error(
                    codes::NUMBER_RANGE,
                    self.span(pair),
                    format!("{text} is too large"),
                )
                .with_help("the largest number is 9007199254740992");
                self.findings.push(finding);
                0
            }
        }
    }

    // ---- declarations ------------------------------------------------------------------------------------------------

    fn import(&mut self, pair: Pair<'_, Rule>) -> Import {
        let target = Children::of(pair).next();
        let span = self.span(&target);
        let text = target.as_str().trim();
        let dotted = target.as_rule() == Rule::path;
        Import {
            path: text.trim_matches('"').to_owned(),
            dotted,
            span,
        }
    }

    fn doc(children: &mut Children<'_>) -> String {
        let Some(doc) = children.take(Rule::doc) else {
            return String::new();
        };
        let lines: Vec<&str> = doc
            .into_inner()
            .map(|l| {
                let text = l.as_str().trim_start_matches('/');
                text.strip_prefix(' ').unwrap_or(text).trim_end()
            })
            .collect();
        lines.join("\n")
    }

    fn type_decl(&mut self, pair: Pair<'_, Rule>) -> TypeDecl {
        let mut c = Children::of(pair);
        Self::doc(&mut c);
        TypeDecl {
            name: self.name(&c.next()),
            domain: self.domain(c.next()),
        }
    }

    fn const_decl(&mut self, pair: Pair<'_, Rule>) -> ConstDecl {
        let mut c = Children::of(pair);
        Self::doc(&mut c);
        ConstDecl {
            name: self.name(&c.next()),
            domain: c.take(Rule::domain).map(|d| self.domain(d)),
            value: self.expr(c.next()),
        }
    }

    fn parameters(&mut self, pair: Option<Pair<'_, Rule>>) -> Vec<Parameter> {
        let Some(pair) = pair else { return Vec::new() };
        let pairs: Vec<_> = Children::of(pair).rest().collect();
        pairs
            .into_iter()
            .map(|p| {
                let mut c = Children::of(p);
                Parameter {
                    name: self.name(&c.next()),
                    domain: self.domain(c.next()),
                    default: c.take(Rule::expression).map(|e| self.expr(e)),
                }
            })
            .collect()
    }

    fn arguments(&mut self, pair: Option<Pair<'_, Rule>>) -> Vec<Argument> {
        let Some(pair) = pair else { return Vec::new() };
        let pairs: Vec<_> = Children::of(pair).rest().collect();
        pairs
            .into_iter()
            .map(|p| {
                let mut c = Children::of(p);
                Argument {
                    name: self.name(&c.next()),
                    value: self.expr(c.next()),
                }
            })
            .collect()
    }

    fn codes(&self, pair: Option<Pair<'_, Rule>>) -> Vec<Name> {
        pair.map(|p| Children::of(p).rest().map(|c| self.name(&c)).collect())
            .unwrap_or_default()
    }

    fn header(&mut self, doc: String, c: &mut Children<'_>) -> Header {
        let name = self.name(&c.next());
        let parameters = c.take(Rule::parameters);
        Header {
            doc,
            name,
            parameters: self.parameters(parameters),
            codes: self.codes(c.take(Rule::implements)),
        }
    }

    // ---- contracts ---------------------------------------------------------------------------------------------------

    fn contract(&mut self, pair: Pair<'_, Rule>) -> Contract {
        let mut c = Children::of(pair);
        let doc = Self::doc(&mut c);
        let moore = c.take(Rule::moore).is_some();
        let header = self.header(doc, &mut c);
        let mut items = Vec::new();
        for item in c.rest() {
            match item.as_rule() {
                Rule::variables => items.push(self.variables(item)),
                Rule::define => {
                    let mut c = Children::of(item);
                    Self::doc(&mut c);
                    items.push(ContractItem::Define {
                        name: self.name(&c.next()),
                        value: self.expr(c.next()),
                    });
                }
                Rule::formula => items.push(self.formula(item)),
                Rule::type_decl => items.push(ContractItem::Type(self.type_decl(item))),
                Rule::const_decl => items.push(ContractItem::Const(self.const_decl(item))),
                _ => self.bad(&item),
            }
        }
        Contract {
            header,
            moore,
            items,
        }
    }

    fn variables(&mut self, pair: Pair<'_, Rule>) -> ContractItem {
        let mut c = Children::of(pair);
        Self::doc(&mut c);
        let ownership = match c.next().as_str().trim() {
            "input" => Ownership::Input,
            "output" => Ownership::Output,
            _ => Ownership::Internal,
        };
        let mut names = Vec::new();
        while let Some(name) = c.take(Rule::name) {
            names.push(self.name(&name));
        }
        ContractItem::Variables {
            ownership,
            names,
            domain: self.domain(c.next()),
        }
    }

    fn formula(&mut self, pair: Pair<'_, Rule>) -> ContractItem {
        let mut c = Children::of(pair);
        Self::doc(&mut c);
        let guarantee = c.next().as_str().trim() == "guarantee";
        let (mut name, mut requirement) = (None, None);
        if let Some(label) = c.take(Rule::label) {
            let mut label = Children::of(label);
            name = label.take(Rule::name).map(|n| self.name(&n));
            requirement = label
                .take(Rule::requirement_id)
                .map(|r| Children::of(r).next().as_str().trim().to_owned());
        }
        ContractItem::Formula {
            guarantee,
            name,
            requirement,
            expr: self.expr(c.next()),
        }
    }

    // ---- machines ----------------------------------------------------------------------------------------------------

    fn machine(&mut self, pair: Pair<'_, Rule>) -> Machine {
        let mut c = Children::of(pair);
        let doc = Self::doc(&mut c);
        let header = self.header(doc, &mut c);
        let mut items = Vec::new();
        for item in c.rest() {
            let rule = item.as_rule();
            if rule == Rule::bad_machine_item {
                self.bad(&item);
            } else {
                items.push(self.machine_item(rule, item));
            }
        }
        Machine { header, items }
    }

    fn machine_item(&mut self, rule: Rule, item: Pair<'_, Rule>) -> MachineItem {
        match rule {
            Rule::m_component => return MachineItem::Component(self.component(item)),
            Rule::m_property => return MachineItem::Property(self.typed(item)),
            Rule::m_parameter => return MachineItem::Parameter(self.typed(item)),
            Rule::m_signal => return MachineItem::Signal(self.typed(item)),
            Rule::m_abstract => return MachineItem::Abstract(self.typed(item)),
            Rule::const_decl => return MachineItem::Const(self.const_decl(item)),
            Rule::type_decl => return MachineItem::Type(self.type_decl(item)),
            _ => {}
        }
        let mut c = Children::of(item);
        match rule {
            Rule::m_step => MachineItem::Step(self.expr(c.next())),
            Rule::m_idle => MachineItem::IdlePower(self.expr(c.next())),
            Rule::m_power => MachineItem::Power(self.expr(c.next())),
            Rule::m_limit => MachineItem::Limit(self.expr(c.next())),
            Rule::m_failures => MachineItem::Failures(self.expr(c.next()), self.expr(c.next())),
            Rule::m_operation => {
                Self::doc(&mut c);
                let name = self.name(&c.next());
                let codes = self.codes(c.take(Rule::implements));
                let sequence = c.rest().map(|n| self.name(&n)).collect();
                MachineItem::Operation {
                    name,
                    codes,
                    sequence,
                }
            }
            Rule::m_write => {
                let name = self.name(&c.next());
                let index = c
                    .take(Rule::index)
                    .map(|i| self.expr(Children::of(i).next()));
                MachineItem::Write {
                    name,
                    index,
                    value: self.expr(c.next()),
                }
            }
            _ => MachineItem::Done(self.expr(c.next())),
        }
    }

    fn typed(&mut self, pair: Pair<'_, Rule>) -> Typed {
        let mut c = Children::of(pair);
        let doc = Self::doc(&mut c);
        let name = self.name(&c.next());
        let domain = self.domain(c.next());
        let values: Vec<_> = c.rest().collect();
        Typed {
            doc,
            name,
            domain,
            values: values.into_iter().map(|v| self.expr(v)).collect(),
        }
    }

    fn component(&mut self, pair: Pair<'_, Rule>) -> Component {
        let mut c = Children::of(pair);
        Self::doc(&mut c);
        let coordinator = c.next().as_str().trim() == "coordinator";
        let name = self.name(&c.next());
        let contract = self.name(&c.next());
        let arguments = c.take(Rule::arguments);
        let arguments = self.arguments(arguments);
        let when = c.take(Rule::expression).map(|e| self.expr(e));
        let mut component = Component {
            coordinator,
            name,
            contract,
            arguments,
            when,
            time: None,
            power: None,
            bindings: Vec::new(),
        };
        for item in c.rest() {
            match item.as_rule() {
                Rule::c_time => {
                    let mut c = Children::of(item);
                    let value = self.expr(c.next());
                    component.time = Some((value, c.take(Rule::per_step).is_some()));
                }
                Rule::c_power => component.power = Some(self.expr(Children::of(item).next())),
                Rule::c_binding => {
                    let mut c = Children::of(item);
                    let name = self.name(&c.next());
                    let index = c.take(Rule::integer).map(|i| self.integer(&i));
                    component.bindings.push(Binding {
                        name,
                        index,
                        value: self.expr(c.next()),
                    });
                }
                _ => self.bad(&item),
            }
        }
        component
    }

    // ---- lines -------------------------------------------------------------------------------------------------------

    fn line(&mut self, pair: Pair<'_, Rule>) -> Line {
        let mut c = Children::of(pair);
        let doc = Self::doc(&mut c);
        let name = self.name(&c.next());
        let mut items = Vec::new();
        for item in c.rest() {
            let rule = item.as_rule();
            match rule {
                Rule::bad_line_item => self.bad(&item),
                Rule::const_decl => items.push(LineItem::Const(self.const_decl(item))),
                Rule::l_station => items.push(self.station(item)),
                _ => items.push(self.line_item(rule, item)),
            }
        }
        Line { doc, name, items }
    }

    fn counted(&mut self, pair: Pair<'_, Rule>) -> Counted {
        let mut c = Children::of(pair);
        let count = self.integer(&c.next()) as u64;
        Counted {
            count,
            name: self.name(&c.next()),
        }
    }

    fn line_item(&mut self, rule: Rule, item: Pair<'_, Rule>) -> LineItem {
        let span = self.span(&item);
        let mut c = Children::of(item);
        Self::doc(&mut c);
        match rule {
            Rule::l_limit => {
                let value = self.expr(c.next());
                LineItem::Limit(value, c.take(Rule::products).is_some())
            }
            Rule::l_shift => LineItem::Shift(self.expr(c.next()), self.expr(c.next())),
            Rule::l_product => LineItem::Product(self.name(&c.next())),
            Rule::l_part => {
                let name = self.name(&c.next());
                let bill = c.take(Rule::bill).map(Children::of);
                let bill = bill
                    .map(|b| b.rest().collect::<Vec<_>>())
                    .unwrap_or_default();
                let bill = bill.into_iter().map(|p| self.counted(p)).collect();
                let properties: Vec<_> = c.rest().collect();
                LineItem::Part {
                    name,
                    bill,
                    properties: properties.into_iter().map(|p| self.typed(p)).collect(),
                }
            }
            Rule::l_source => {
                let name = self.name(&c.next());
                let part = self.name(&c.next());
                let supply = c.next();
                let supply = if supply.as_rule() == Rule::on_order {
                    Supply::OnOrder
                } else {
                    let mut c = Children::of(supply);
                    let random = c.take(Rule::random).is_some();
                    let seconds = self.expr(c.next());
                    let limit = c.take(Rule::integer).map(|i| self.integer(&i) as u64);
                    Supply::Every {
                        seconds,
                        random,
                        limit,
                    }
                };
                LineItem::Source { name, part, supply }
            }
            Rule::l_store => {
                let name = self.name(&c.next());
                let stock: Vec<_> = c.rest().collect();
                LineItem::Store {
                    name,
                    stock: stock.into_iter().map(|p| self.counted(p)).collect(),
                }
            }
            Rule::l_sink => LineItem::Sink {
                name: self.name(&c.next()),
                rejects: c.take(Rule::rejects).is_some(),
                reorder: c
                    .take(Rule::reorder)
                    .map(|r| self.name(&Children::of(r).next())),
            },
            Rule::l_buffer => {
                let name = self.name(&c.next());
                let capacity = self.integer(&c.next()) as u64;
                LineItem::Buffer { name, capacity }
            }
            Rule::l_conveyor => {
                let name = self.name(&c.next());
                let machine = c.take(Rule::path).map(|p| self.name(&p));
                let arguments = c.take(Rule::arguments);
                let arguments = self.arguments(arguments);
                let options: Vec<_> = c.rest().collect();
                let options = options
                    .into_iter()
                    .map(|o| {
                        let mut c = Children::of(o);
                        (self.name(&c.next()), self.expr(c.next()))
                    })
                    .collect();
                LineItem::Conveyor {
                    name,
                    machine: machine.map(|m| (m, arguments)),
                    options,
                }
            }
            Rule::l_route => {
                let part = self.name(&c.next());
                let mut stops = Vec::new();
                while let Some(stop) = c.take(Rule::name) {
                    stops.push(self.name(&stop));
                }
                let when = c.take(Rule::expression).map(|e| self.expr(e));
                LineItem::Route { part, stops, when }
            }
            _ => {
                let name = self.name(&c.next());
                let mut metric = Children::of(c.next());
                LineItem::Requirement {
                    name,
                    metric: self.name(&metric.next()),
                    of: metric.take(Rule::name).map(|n| self.name(&n)),
                    op: binary_op(c.next().as_str()),
                    bound: self.expr(c.next()),
                    per_hour: c.take(Rule::per_hour).is_some(),
                    span,
                }
            }
        }
    }

    fn station(&mut self, pair: Pair<'_, Rule>) -> LineItem {
        let mut c = Children::of(pair);
        Self::doc(&mut c);
        let name = self.name(&c.next());
        let machine = self.name(&c.next());
        let arguments = c.take(Rule::arguments);
        let arguments = self.arguments(arguments);
        let mut items = Vec::new();
        for item in c.rest() {
            let rule = item.as_rule();
            if rule == Rule::bad_station_item {
                self.bad(&item);
                continue;
            }
            let mut c = Children::of(item);
            items.push(match rule {
                Rule::s_perform => {
                    let mut operations = Vec::new();
                    while let Some(p) = c.take(Rule::performed) {
                        let mut p = Children::of(p);
                        let name = self.name(&p.next());
                        let arguments = p.take(Rule::arguments);
                        operations.push((name, self.arguments(arguments)));
                    }
                    StationItem::Perform {
                        operations,
                        part: self.name(&c.next()),
                    }
                }
                Rule::s_setup => StationItem::Setup(self.expr(c.next())),
                Rule::m_failures => StationItem::Failures(self.expr(c.next()), self.expr(c.next())),
                _ => {
                    let part = self.name(&c.next());
                    let probability = self.expr(c.next());
                    c.take(Rule::one_of);
                    StationItem::Defect {
                        part,
                        probability,
                        property: self.name(&c.next()),
                        value: self.expr(c.next()),
                    }
                }
            });
        }
        LineItem::Station {
            name,
            machine,
            arguments,
            items,
        }
    }

    // ---- types -------------------------------------------------------------------------------------------------------

    fn domain(&mut self, pair: Pair<'_, Rule>) -> Domain {
        let span = self.span(&pair);
        if pair.as_rule() == Rule::range {
            return self.range_domain(pair);
        }
        let inner = Children::of(pair).next();
        let kind = match inner.as_rule() {
            Rule::array_of => {
                let mut c = Children::of(inner);
                let length = self.expr(c.next());
                DomainKind::Array(length, Box::new(self.domain(c.next())))
            }
            Rule::labels => {
                DomainKind::Labels(Children::of(inner).rest().map(|n| self.name(&n)).collect())
            }
            Rule::range => return self.range_domain(inner),
            Rule::unit_type => DomainKind::Unit(inner.as_str().trim().to_owned()),
            _ => DomainKind::Named(self.name(&inner)),
        };
        Domain { kind, span }
    }

    fn range_domain(&mut self, pair: Pair<'_, Rule>) -> Domain {
        let span = self.span(&pair);
        let mut c = Children::of(pair);
        let low = self.expr(c.next());
        let high = self.expr(c.next());
        Domain {
            kind: DomainKind::Range(low, high),
            span,
        }
    }

    // ---- expressions -------------------------------------------------------------------------------------------------

    fn expr(&mut self, pair: Pair<'_, Rule>) -> Expr {
        let span = self.span(&pair);
        let rule = pair.as_rule();
        match rule {
            Rule::expression | Rule::parenthesis | Rule::wide => {
                self.expr(Children::of(pair).next())
            }
            Rule::iff
            | Rule::disjunction
            | Rule::exclusive
            | Rule::conjunction
            | Rule::additive
            | Rule::product => self.chain(pair),
            Rule::implication => self.implication(pair),
            Rule::negation => self.negation(pair),
            Rule::comparison => self.comparison(pair),
            Rule::signed => self.signed(pair),
            Rule::postfix => self.postfix(pair),
            Rule::conditional => {
                let mut c = Children::of(pair);
                let (a, b, e) = (self.boxed(&mut c), self.boxed(&mut c), self.boxed(&mut c));
                make(ExprKind::If(a, b, e), span)
            }
            Rule::quantifier => {
                let mut c = Children::of(pair);
                let kind = match c.next().as_str().trim() {
                    "forall" => Quantifier::Forall,
                    "exists" => Quantifier::Exists,
                    "count" => Quantifier::Count,
                    _ => Quantifier::Sum,
                };
                let name = self.name(&c.next());
                let domain = Box::new(self.domain(c.next()));
                make(
                    ExprKind::Quantifier(kind, name, domain, self.boxed(&mut c)),
                    span,
                )
            }
            Rule::wide_always | Rule::wide_eventually => {
                let mut c = Children::of(pair);
                c.next();
                let body = self.boxed(&mut c);
                make(
                    if rule == Rule::wide_always {
                        ExprKind::Always(body)
                    } else {
                        ExprKind::Eventually(body)
                    },
                    span,
                )
            }
            _ => self.atom(pair),
        }
    }

    fn boxed(&mut self, c: &mut Children<'_>) -> Box<Expr> {
        Box::new(self.expr(c.next()))
    }

    /// `a op b op c`: one of the levels that group to the left. `and` and `or` are halved instead, which keeps long
    /// conjunctions shallow.
    fn chain(&mut self, pair: Pair<'_, Rule>) -> Expr {
        let mut c = Children::of(pair);
        let mut operands = vec![self.expr(c.next())];
        let mut ops = Vec::new();
        while let Some(op) = c.pairs.next() {
            ops.push(binary_op(op.as_str()));
            operands.push(self.expr(c.next()));
        }
        if ops
            .iter()
            .all(|o| matches!(o, BinaryOp::And | BinaryOp::Or))
            && !ops.is_empty()
        {
            return balanced(ops[0], operands);
        }
        self.limit(&operands);
        let mut operands = operands.into_iter();
        let first = operands
            .next()
            .unwrap_or_else(|| unreachable!("a chain has an operand"));
        ops.into_iter()
            .zip(operands)
            .fold(first, |a, (op, b)| binary(op, a, b))
    }

    fn implication(&mut self, pair: Pair<'_, Rule>) -> Expr {
        let mut operands: Vec<Expr> = Vec::new();
        for p in Children::of(pair).rest() {
            if p.as_rule() != Rule::implies_op {
                operands.push(self.expr(p));
            }
        }
        self.limit(&operands);
        operands
            .into_iter()
            .rev()
            .reduce(|b, a| binary(BinaryOp::Implies, a, b))
            .unwrap_or_else(|| unreachable!("an implication has an operand"))
    }

    /// Chains that cannot be halved make deep trees; refuse what would be deeper than any real formula.
    fn limit(&mut self, operands: &[Expr]) {
        if let Some(last) = operands.get(500) {
            self.findings.push(
                Diagnostic::error(
                    codes::SYNTAX,
                    last.span,
                    "this chain of operators has more than 500 operands",
                )
                .with_help("give parts of it names with `define`, or use `sum`"),
            );
        }
    }

    fn negation(&mut self, pair: Pair<'_, Rule>) -> Expr {
        let mut c = Children::of(pair);
        let mut prefixes = Vec::new();
        while let Some(prefix) = c.take(Rule::prefix) {
            let span = self.span(&prefix);
            let inner = Children::of(prefix).next();
            prefixes.push((inner.as_rule(), inner.as_str().trim() == "GF", span));
        }
        if let Some((_, _, span)) = prefixes.get(100) {
            self.findings.push(Diagnostic::error(
                codes::SYNTAX,
                *span,
                "more than 100 prefixes in a row",
            ));
            prefixes.truncate(1);
        }
        let body = self.expr(c.next());
        prefixes
            .into_iter()
            .rev()
            .fold(body, |body, (rule, both, span)| {
                let whole = span.to(body.span);
                let body = Box::new(body);
                match rule {
                    Rule::not_op => make(ExprKind::Not(body), whole),
                    Rule::tight_always if both => {
                        let inner = make(ExprKind::Eventually(body), whole);
                        make(ExprKind::Always(Box::new(inner)), whole)
                    }
                    Rule::tight_always => make(ExprKind::Always(body), whole),
                    _ => make(ExprKind::Eventually(body), whole),
                }
            })
    }

    fn comparison(&mut self, pair: Pair<'_, Rule>) -> Expr {
        let span = self.span(&pair);
        let mut c = Children::of(pair);
        let first = self.expr(c.next());
        if let Some(membership) = c.take(Rule::membership) {
            let set = Children::of(membership).next();
            let mut inner = Children::of(set);
            if let Some(range) = inner.take(Rule::range) {
                let mut r = Children::of(range);
                let (low, high) = (self.boxed(&mut r), self.boxed(&mut r));
                return make(ExprKind::Within(Box::new(first), low, high), span);
            }
            let members: Vec<_> = inner.rest().collect();
            let members = members.into_iter().map(|m| self.expr(m)).collect();
            return make(ExprKind::Member(Box::new(first), members), span);
        }
        // `a < b < c` is `a < b and b < c`.
        let mut links: Vec<Expr> = Vec::new();
        let mut left = first;
        while let Some(op) = c.take(Rule::compare_op) {
            let right = self.expr(c.next());
            links.push(binary(binary_op(op.as_str()), left, right.clone()));
            left = right;
        }
        if links.is_empty() {
            left
        } else {
            balanced(BinaryOp::And, links)
        }
    }

    fn signed(&mut self, pair: Pair<'_, Rule>) -> Expr {
        let mut c = Children::of(pair);
        let mut signs = Vec::new();
        while let Some(sign) = c.take(Rule::sign) {
            let span = self.span(&sign);
            signs.push((Children::of(sign).next().as_rule(), span));
        }
        if let Some((_, span)) = signs.get(100) {
            self.findings.push(Diagnostic::error(
                codes::SYNTAX,
                *span,
                "more than 100 prefixes in a row",
            ));
            signs.truncate(1);
        }
        let body = self.expr(c.next());
        signs.into_iter().rev().fold(body, |body, (rule, span)| {
            let whole = span.to(body.span);
            let body = Box::new(body);
            make(
                if rule == Rule::minus {
                    ExprKind::Neg(body)
                } else {
                    ExprKind::Next(body)
                },
                whole,
            )
        })
    }

    fn postfix(&mut self, pair: Pair<'_, Rule>) -> Expr {
        let mut c = Children::of(pair);
        let mut expr = self.expr(c.next());
        for (count, p) in c.rest().enumerate() {
            let span = expr.span.to(self.span(&p));
            if count == 100 {
                self.findings.push(Diagnostic::error(
                    codes::SYNTAX,
                    span,
                    "more than 100 indices and primes in a row",
                ));
                break;
            }
            expr = if p.as_rule() == Rule::prime {
                make(ExprKind::Next(Box::new(expr)), span)
            } else {
                let index = self.expr(Children::of(p).next());
                make(ExprKind::Index(Box::new(expr), Box::new(index)), span)
            };
        }
        expr
    }

    fn atom(&mut self, pair: Pair<'_, Rule>) -> Expr {
        let pair = if pair.as_rule() == Rule::atom {
            Children::of(pair).next()
        } else {
            pair
        };
        let span = self.span(&pair);
        let kind = match pair.as_rule() {
            Rule::parenthesis => return self.expr(pair),
            Rule::boolean => ExprKind::Bool(pair.as_str().trim() == "true"),
            Rule::quantity => self.quantity(pair),
            Rule::list => {
                let members: Vec<_> = Children::of(pair).rest().collect();
                ExprKind::List(members.into_iter().map(|m| self.expr(m)).collect())
            }
            Rule::call => {
                let mut c = Children::of(pair);
                let name = self.name(&c.next());
                let arguments: Vec<_> = c.rest().collect();
                ExprKind::Call(name, arguments.into_iter().map(|a| self.expr(a)).collect())
            }
            _ => ExprKind::Path(Children::of(pair).rest().map(|n| self.name(&n)).collect()),
        };
        make(kind, span)
    }

    fn quantity(&mut self, pair: Pair<'_, Rule>) -> ExprKind {
        let mut c = Children::of(pair);
        let number = c.next();
        let unit = c.take(Rule::unit).map(|u| u.as_str().trim().to_owned());
        match (number.as_rule(), unit) {
            (Rule::integer, None) => ExprKind::Int(self.integer(&number)),
            (_, unit) => {
                let value: f64 = number.as_str().trim().parse().unwrap_or(f64::INFINITY);
                if !value.is_finite() {
                    let span = self.span(&number);
                    self.findings.push(Diagnostic::error(
                        codes::NUMBER_RANGE,
                        span,
                        "this number is too large",
                    ));
                    return ExprKind::Quantity(0.0, String::new());
                }
                ExprKind::Quantity(value, unit.unwrap_or_default())
            }
        }
    }
}

/// Words that only hold a rule together.
fn is_keyword(rule: Rule) -> bool {
    matches!(
        rule,
        Rule::k_abstract
            | Rule::k_becomes
            | Rule::k_buffer
            | Rule::k_capacity
            | Rule::k_const
            | Rule::k_contract
            | Rule::k_conveyor
            | Rule::k_defect
            | Rule::k_define
            | Rule::k_done
            | Rule::k_else
            | Rule::k_every
            | Rule::k_failures
            | Rule::k_from
            | Rule::k_hour
            | Rule::k_idle
            | Rule::k_if
            | Rule::k_implements
            | Rule::k_import
            | Rule::k_in
            | Rule::k_limit
            | Rule::k_line
            | Rule::k_machine
            | Rule::k_mtbf
            | Rule::k_mttr
            | Rule::k_of
            | Rule::k_on
            | Rule::k_one
            | Rule::k_operation
            | Rule::k_order
            | Rule::k_parameter
            | Rule::k_part
            | Rule::k_per
            | Rule::k_perform
            | Rule::k_power
            | Rule::k_probability
            | Rule::k_product
            | Rule::k_property
            | Rule::k_reorder
            | Rule::k_requirement
            | Rule::k_route
            | Rule::k_setup
            | Rule::k_shift
            | Rule::k_signal
            | Rule::k_sink
            | Rule::k_source
            | Rule::k_station
            | Rule::k_step
            | Rule::k_steps
            | Rule::k_store
            | Rule::k_then
            | Rule::k_time
            | Rule::k_to
            | Rule::k_type
            | Rule::k_when
            | Rule::k_write
    )
}

fn make(kind: ExprKind, span: Span) -> Expr {
    Expr { kind, span }
}

fn binary(op: BinaryOp, a: Expr, b: Expr) -> Expr {
    let span = a.span.to(b.span);
    make(ExprKind::Binary(op, Box::new(a), Box::new(b)), span)
}

fn balanced(op: BinaryOp, mut operands: Vec<Expr>) -> Expr {
    while operands.len() > 1 {
        let mut halved = Vec::with_capacity(operands.len().div_ceil(2));
        let mut pairs = operands.into_iter();
        while let Some(a) = pairs.next() {
            halved.push(match pairs.next() {
                Some(b) => binary(op, a, b),
                None => a,
            });
        }
        operands = halved;
    }
    operands
        .pop()
        .unwrap_or_else(|| unreachable!("a chain has an operand"))
}

fn binary_op(text: &str) -> BinaryOp {
    match text.trim() {
        "<->" | "<=>" | "↔" | "⇔" | "iff" => BinaryOp::Iff,
        "->" | "=>" | "→" | "⇒" | "implies" => BinaryOp::Implies,
        "||" | "|" | "\\/" | "∨" | "or" => BinaryOp::Or,
        "xor" => BinaryOp::Xor,
        "&&" | "&" | "/\\" | "∧" | "and" => BinaryOp::And,
        "!=" | "≠" => BinaryOp::Ne,
        "<" => BinaryOp::Lt,
        "<=" | "≤" => BinaryOp::Le,
        ">" => BinaryOp::Gt,
        ">=" | "≥" => BinaryOp::Ge,
        "+" => BinaryOp::Add,
        "-" => BinaryOp::Sub,
        "*" => BinaryOp::Mul,
        "/" => BinaryOp::Div,
        "mod" => BinaryOp::Mod,
        _ => BinaryOp::Eq,
    }
}
