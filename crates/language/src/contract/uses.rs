//! Findings for unused declarations (LW111), and for two names that seem to mean the same (LW113).
//!
//! Both are found in the syntax tree alone, so they are reported in addition to other errors. But a
//! syntax error can hide a use of a declaration, and an undeclared name can be a misspelled use.
//! [`PossibleUses`] collects such errors; they suppress these findings.

mod alike;
mod mentions;

use linewright_core::diagnostics::{Diagnostic, Spelling, codes};
use linewright_core::source::{SourceMap, Span};
use linewright_syntax::ast::{self, ContractItem, Item, MachineItem, Ownership};
pub(super) use mentions::Mentions;

/// Errors that can hide a use of a declaration.
pub(super) struct PossibleUses<'d> {
    /// Positions of syntax errors.
    pub syntax: Vec<Span>,
    /// Undeclared names and their positions.
    pub unknown: Vec<(Spelling<'d>, Span)>,
    /// Names that are declared twice, and their positions.
    pub duplicates: Vec<(&'d str, Span)>,
    /// Positions of all errors.
    pub errors: Vec<Span>,
}

impl PossibleUses<'_> {
    /// Returns whether an error makes it doubtful that a declaration is unused, so that it must not
    /// be reported: an error within its scope may hide a use of it, or the declaration contains an
    /// error itself. `end` is the position of the declaration's last part, `extent` its scope.
    fn covers(&self, name: &ast::Name, end: Span, extent: Span) -> bool {
        let within = |span: &Span| extent.contains(*span);
        let own = name.span.to(end);
        let known = Spelling::of(&name.text);
        self.syntax.iter().any(within)
            || self
                .unknown
                .iter()
                .any(|(unknown, span)| within(span) && unknown.is_close(&known))
            || self
                .duplicates
                .iter()
                .any(|(duplicate, span)| within(span) && *duplicate == name.text)
            || self.errors.iter().any(|span| own.contains(*span))
    }
}

/// Returns the finding for an unused declaration.
fn unused(name: &ast::Name, message: String, help: &str) -> Diagnostic {
    Diagnostic::warning(codes::UNUSED, name.span, message).with_help(help)
}

/// Returns the findings for a contract: unused declarations, and two names that seem to mean the
/// same. `extent` is the text of the whole contract.
pub(super) fn contract(
    contract: &ast::Contract,
    extent: Span,
    sources: &SourceMap,
    doubt: &PossibleUses<'_>,
) -> Vec<Diagnostic> {
    let mut used = Mentions::default();
    used.contract(contract);
    let mut findings = alike::find(contract, sources, |name| {
        !used.has(&name.text) && !doubt.covers(name, name.span, extent)
    });
    let shown = |findings: &[Diagnostic], name: &ast::Name| {
        findings.iter().any(|f| f.span == Some(name.span))
    };
    let mut add = |name: &ast::Name, end: Span, message: String, help: &str| {
        if !used.has(&name.text) && !doubt.covers(name, end, extent) && !shown(&findings, name) {
            findings.push(unused(name, message, help));
        }
    };
    for parameter in &contract.header.parameters {
        let name = &parameter.name;
        let message = format!("nothing uses the parameter `{}`", name.text);
        let end = parameter_end(parameter);
        add(
            name,
            end,
            message,
            "use it in a domain or a formula, or remove it",
        );
    }
    for item in &contract.items {
        match item {
            ContractItem::Variables {
                ownership,
                names,
                domain,
            } => {
                let help = if *ownership == Ownership::Input {
                    "use it in a formula, or remove it"
                } else {
                    "constrain it with a guarantee, or remove it"
                };
                for name in names {
                    let message = format!("no formula mentions `{}`", name.text);
                    add(name, domain.span, message, help);
                }
            }
            ContractItem::Define(d) => {
                let message = format!("nothing uses the definition `{}`", d.name.text);
                add(&d.name, d.value.span, message, "use it, or remove it");
            }
            ContractItem::Counter(c) => {
                let message = format!("nothing uses the counter `{}`", c.name.text);
                add(&c.name, c.counts.span, message, "use it, or remove it");
            }
            ContractItem::Const(c) => {
                let message = format!("nothing uses the constant `{}`", c.name.text);
                add(&c.name, c.value.span, message, "use it, or remove it");
            }
            ContractItem::Type(t) if !used.has_label_of(&t.domain) => {
                let message = format!("nothing uses the type `{}`", t.name.text);
                add(&t.name, t.domain.span, message, "use it, or remove it");
            }
            ContractItem::Type(_) | ContractItem::Formula { .. } => {}
        }
    }
    for item in &contract.items {
        if let ContractItem::Define(define) = item {
            findings.extend(formals(define));
        }
    }
    findings
}

/// Marks the names of unbound inputs of contracts as used, because such an input is connected to
/// the signal of the same name. Returns whether there was a contract.
fn mark_inputs<'a, 'c>(
    used: &mut Mentions<'a>,
    contracts: impl Iterator<Item = &'c &'a ast::Contract>,
    bound: impl Fn(&str) -> bool,
) -> bool
where
    'a: 'c,
{
    let mut any = false;
    for contract in contracts {
        any = true;
        for item in &contract.items {
            if let ContractItem::Variables {
                ownership: Ownership::Input,
                names,
                ..
            } = item
            {
                let free = names.iter().filter(|n| !bound(&n.text));
                free.for_each(|n| used.name(&n.text));
            }
        }
    }
    any
}

fn parameter_end(parameter: &ast::Parameter) -> Span {
    let default = parameter.default.as_ref();
    default.map_or(parameter.domain.span, |e| e.span)
}

fn typed_end(typed: &ast::TypedDecl) -> Span {
    typed.values.last().map_or(typed.domain.span, |e| e.span)
}

/// Returns the findings for unused parameters of a definition.
fn formals(define: &ast::Define) -> Vec<Diagnostic> {
    let mut used = Mentions::default();
    used.expr(&define.value);
    let formals = define.formals.iter().map(|f| &f.name);
    let unused_ones = formals.filter(|name| !used.has(&name.text));
    unused_ones
        .map(|name| {
            let message = format!(
                "the definition `{}` does not use its parameter `{}`",
                define.name.text, name.text
            );
            unused(
                name,
                message,
                "use it, or remove it here and in the uses of the definition",
            )
        })
        .collect()
}

/// Marks the names of unbound properties, parameters, signals and abstractions of an inner machine
/// as used. Returns whether there was a machine with this name.
fn mark_plant<'a>(
    used: &mut Mentions<'a>,
    machines: &[&'a ast::Machine],
    name: &str,
    bound: impl Fn(&str) -> bool,
) -> bool {
    let mut any = false;
    for machine in machines.iter().filter(|m| m.header.name.text == name) {
        any = true;
        for item in &machine.items {
            if let MachineItem::Property(t)
            | MachineItem::Parameter(t)
            | MachineItem::Signal(t)
            | MachineItem::Abstract(t) = item
                && !bound(&t.name.text)
            {
                used.name(&t.name.text);
            }
        }
    }
    any
}

/// Returns the findings for unused declarations of a machine. `contracts` and `machines` are all
/// that the machine can use as components. Returns no findings if a component is unknown.
pub(super) fn machine<'a>(
    machine: &'a ast::Machine,
    contracts: &[&'a ast::Contract],
    machines: &[&'a ast::Machine],
    extent: Span,
    doubt: &PossibleUses<'_>,
) -> Vec<Diagnostic> {
    let mut used = Mentions::default();
    used.machine(machine);
    for item in &machine.items {
        if let MachineItem::Component(component) | MachineItem::Refines(component) = item {
            let name = &component.contract.text;
            let of_name = contracts.iter().filter(|c| c.header.name.text == *name);
            let bound = |name: &str| {
                let root = |b: &ast::Binding| b.name.text.split('.').next() == Some(name);
                component.bindings.iter().any(root)
            };
            let is_known = if component.is_machine() {
                mark_plant(&mut used, machines, name, bound)
            } else {
                mark_inputs(&mut used, of_name, bound)
            };
            if !is_known {
                // The inputs of an unknown component might be connected to any signal.
                return Vec::new();
            }
        }
    }
    let mut findings = Vec::new();
    let mut add = |name: &ast::Name, end: Span, what: &str| {
        if !used.has(&name.text) && !doubt.covers(name, end, extent) {
            let message = format!("nothing uses the {what} `{}`", name.text);
            findings.push(unused(name, message, "use it, or remove it"));
        }
    };
    for parameter in &machine.header.parameters {
        add(&parameter.name, parameter_end(parameter), "parameter");
    }
    for item in &machine.items {
        match item {
            MachineItem::Signal(t) => add(&t.name, typed_end(t), "signal"),
            MachineItem::Abstract(t) => add(&t.name, typed_end(t), "abstraction"),
            MachineItem::Parameter(t) => add(&t.name, typed_end(t), "parameter"),
            MachineItem::Const(c) => add(&c.name, c.value.span, "constant"),
            MachineItem::Type(t) if !used.has_label_of(&t.domain) => {
                add(&t.name, t.domain.span, "type");
            }
            _ => {}
        }
    }
    findings
}

/// Returns the findings for top-level declarations that neither the file nor an importing file
/// uses. A file without contracts, machines, lines and layouts is a library for other files, and is
/// not checked.
pub(super) fn file(
    tree: &ast::File,
    importers: &[&ast::File],
    extent: Span,
    doubt: &PossibleUses<'_>,
) -> Vec<Diagnostic> {
    let holds = |item: &Item| {
        matches!(
            item,
            Item::Contract(_) | Item::Machine(_) | Item::Line(_) | Item::Layout(_)
        )
    };
    if !tree.items.iter().any(holds) {
        return Vec::new();
    }
    let mut used = Mentions::default();
    used.file(tree);
    for importer in importers {
        used.file(importer);
    }
    let mut findings = Vec::new();
    let mut add = |name: &ast::Name, end: Span, what: &str| {
        if !used.has(&name.text) && !doubt.covers(name, end, extent) {
            let message = format!("nothing uses the {what} `{}`", name.text);
            findings.push(unused(
                name,
                message,
                "use it, or remove it; if an importing file uses it, check both files together",
            ));
        }
    };
    for item in &tree.items {
        match item {
            Item::Const(c) => add(&c.name, c.value.span, "constant"),
            Item::Type(t) if !used.has_label_of(&t.domain) => add(&t.name, t.domain.span, "type"),
            Item::Define(d) => add(&d.name, d.value.span, "definition"),
            _ => {}
        }
    }
    for item in &tree.items {
        if let Item::Define(define) = item {
            findings.extend(formals(define));
        }
    }
    findings
}
