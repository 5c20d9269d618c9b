//! Builds contracts: variables, defines, counters and formulas.

use super::super::ast::{Contract, ContractItem, Counter, Name, Ownership};
use super::super::parser::{Rule, begins_with_operator};
use super::{Builder, Children};
use pest::iterators::Pair;

impl Builder {
    pub(super) fn contract(&mut self, pair: Pair<'_, Rule>) -> Contract {
        let mut c = Children::of(pair);
        let doc = Self::doc(&mut c);
        let moore = c.take(Rule::moore).is_some();
        let header = self.header(doc, &mut c);
        let mut items = Vec::new();
        for item in c.rest() {
            self.place(&item);
            match item.as_rule() {
                Rule::variables => items.push(self.variables(item)),
                Rule::define => items.push(ContractItem::Define(self.define(item))),
                Rule::counter => items.push(ContractItem::Counter(self.counter(item))),
                Rule::formula => items.push(self.formula(item)),
                Rule::type_decl => items.push(ContractItem::Type(self.type_decl(item))),
                Rule::const_decl => items.push(ContractItem::Const(self.const_decl(item))),
                _ => {
                    // In `always a or`, the formula before the `or` is complete, but it is not the
                    // one that the author meant. Therefore it is removed.
                    if begins_with_operator(item.as_str())
                        && matches!(items.last(), Some(ContractItem::Formula { .. }))
                    {
                        items.pop();
                    }
                    self.bad(&item);
                }
            }
        }
        Contract {
            header,
            moore,
            items,
        }
    }

    pub(super) fn variables(&mut self, pair: Pair<'_, Rule>) -> ContractItem {
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

    fn counter(&mut self, pair: Pair<'_, Rule>) -> Counter {
        let mut c = Children::of(pair);
        Self::doc(&mut c);
        Counter {
            name: self.name(&c.next()),
            domain: self.domain(c.next()),
            counts: self.expr(c.next()),
            resets: c.take(Rule::expression).map(|e| self.expr(e)),
        }
    }

    /// Builds a formula's name and requirement.
    pub(super) fn label(&mut self, c: &mut Children<'_>) -> (Option<Name>, Option<String>) {
        let Some(label) = c.take(Rule::label) else {
            return (None, None);
        };
        let mut label = Children::of(label);
        let name = label.take(Rule::name).map(|n| self.name(&n));
        let requirement = label
            .take(Rule::requirement_id)
            .map(|r| Children::of(r).next().as_str().trim().to_owned());
        (name, requirement)
    }

    pub(super) fn formula(&mut self, pair: Pair<'_, Rule>) -> ContractItem {
        let mut c = Children::of(pair);
        Self::doc(&mut c);
        let guarantee = c.next().as_str().trim() == "guarantee";
        let (name, requirement) = self.label(&mut c);
        ContractItem::Formula {
            guarantee,
            name,
            requirement,
            expr: self.expr(c.next()),
        }
    }
}
