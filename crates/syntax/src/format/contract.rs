//! Prints declarations and contracts.

use super::super::ast::{
    Argument, ConstDecl, Contract, ContractItem, Counter, Define, Expr, ExprKind, Header, Name,
    OperationCall, Ownership, Parameter, TypeDecl,
};
use super::printer::Printer;
use linewright_core::source::Span;

impl Printer<'_> {
    pub(super) fn type_decl(&mut self, t: &TypeDecl) {
        self.put("type ");
        self.name(&t.name);
        self.put(" = ");
        self.domain(&t.domain);
    }

    pub(super) fn const_decl(&mut self, c: &ConstDecl) {
        self.put("const ");
        self.name(&c.name);
        let mut before = c.name.span;
        if let Some(domain) = &c.domain {
            self.put(": ");
            self.domain(domain);
            before = domain.span;
        }
        self.value(before, &c.value);
    }

    pub(super) fn define(&mut self, d: &Define) {
        self.put("define ");
        self.name(&d.name);
        let mut before = d.name.span;
        if let Some(last) = d.formals.last() {
            before = last.domain.as_ref().map_or(last.name.span, |d| d.span);
            self.sequence(
                ["(", ")"],
                d.name.span,
                &d.formals,
                |f| {
                    f.name
                        .span
                        .to(f.domain.as_ref().map_or(f.name.span, |d| d.span))
                },
                |p, f| {
                    p.name(&f.name);
                    if let Some(domain) = &f.domain {
                        p.put(": ");
                        p.domain(domain);
                    }
                },
            );
        }
        self.value(before, &d.value);
    }

    pub(super) fn header(&mut self, h: &Header) {
        self.name(&h.name);
        if !h.parameters.is_empty() {
            let span = |p: &Parameter| {
                let end = p.default.as_ref().map_or(p.domain.span, |d| d.span);
                p.name.span.to(end)
            };
            self.sequence(
                ["(", ")"],
                h.name.span,
                &h.parameters,
                span,
                |p, parameter| {
                    p.name(&parameter.name);
                    p.put(": ");
                    p.domain(&parameter.domain);
                    if let Some(default) = &parameter.default {
                        p.put(" = ");
                        p.expression(default);
                    }
                },
            );
        }
        self.codes(&h.codes);
    }

    pub(super) fn codes(&mut self, codes: &[Name]) {
        if !codes.is_empty() {
            self.put(" implements ");
            self.list(codes, |n| n.span, Self::name);
        }
    }

    /// Prints elements separated by commas, without brackets.
    pub(super) fn list<T>(
        &mut self,
        items: &[T],
        span: impl Fn(&T) -> Span,
        mut print: impl FnMut(&mut Self, &T),
    ) {
        self.level(|p, level| {
            for (i, item) in items.iter().enumerate() {
                if i > 0 {
                    p.put(",");
                    p.nest += usize::from(i == 1);
                    let forced = p.broken(span(&items[i - 1]), span(item));
                    p.gap(level, true, forced);
                }
                print(p, item);
            }
        });
    }

    pub(super) fn argument(&mut self, a: &Argument) {
        self.name(&a.name);
        self.put(" = ");
        self.expression(&a.value);
    }

    /// Prints `(cells = 8)`, or nothing if there are no arguments. `before` is the place of the
    /// text before the bracket.
    pub(super) fn arguments(&mut self, before: Span, arguments: &[Argument]) {
        if !arguments.is_empty() {
            let span = |a: &Argument| a.name.span.to(a.value.span);
            self.sequence(["(", ")"], before, arguments, span, Self::argument);
        }
    }

    pub(super) fn performed(&mut self, p: &OperationCall) {
        self.name(&p.name);
        self.arguments(p.name.span, &p.arguments);
    }

    pub(super) fn contract(&mut self, place: Span, c: &Contract) {
        self.doc(&c.header.doc);
        self.put(if c.moore {
            "moore contract "
        } else {
            "contract "
        });
        self.header(&c.header);
        self.block(place, &c.items, true, |p, _, item| p.contract_item(item));
    }

    /// Prints a formula's name and requirement.
    pub(super) fn label(&mut self, name: Option<&Name>, requirement: Option<&str>) {
        if let Some(name) = name {
            self.name(name);
        }
        if let Some(requirement) = requirement {
            self.put(if name.is_some() { " [" } else { "[" });
            self.put(requirement);
            self.put("]");
        }
        if name.is_some() || requirement.is_some() {
            self.put(": ");
        }
    }

    fn contract_item(&mut self, item: &ContractItem) {
        match item {
            ContractItem::Variables {
                ownership,
                names,
                domain,
            } => {
                self.put(match ownership {
                    Ownership::Input => "input ",
                    Ownership::Output => "output ",
                    Ownership::Internal => "internal ",
                });
                self.list(names, |n| n.span, Self::name);
                self.put(": ");
                self.domain(domain);
            }
            ContractItem::Define(d) => self.define(d),
            ContractItem::Counter(c) => self.counter(c),
            ContractItem::Formula {
                guarantee,
                name,
                requirement,
                expr,
            } => {
                self.put(if *guarantee { "guarantee " } else { "assume " });
                self.label(name.as_ref(), requirement.as_deref());
                self.expression(expr);
            }
            ContractItem::Type(t) => self.type_decl(t),
            ContractItem::Const(c) => self.const_decl(c),
        }
    }

    fn counter(&mut self, c: &Counter) {
        self.put("counter ");
        self.name(&c.name);
        self.put(": ");
        self.domain(&c.domain);
        self.clause("counts ", c.domain.span, &c.counts);
        if let Some(resets) = &c.resets {
            self.clause("resets ", c.counts.span, resets);
        }
    }

    /// Prints a keyword and an expression, on a new line if necessary.
    pub(super) fn clause(&mut self, word: &str, before: Span, e: &Expr) {
        let forced = self.broken(before, e.span);
        self.nest = 1;
        self.gap(0, true, forced);
        self.put(word);
        self.expression(e);
        self.nest = 0;
    }

    /// Returns whether a value is a list or a record and the author ended the line after its
    /// opening bracket.
    pub(super) fn opens_wide(&self, e: &Expr) -> bool {
        let open = Span {
            end: e.span.start,
            ..e.span
        };
        match &e.kind {
            ExprKind::List(items) => items.first().is_some_and(|i| self.broken(open, i.span)),
            ExprKind::Record(items) => items
                .first()
                .is_some_and(|i| self.broken(open, i.name.span)),
            _ => false,
        }
    }
}
