//! What is in sight in a file: its own declarations and those of everything that it imports.

use super::elaborate::Elaborator;
use super::value::{Term, Type, Value};
use crate::diagnostics::{Diagnostic, codes};
use crate::gr1::{Domain, Time};
use crate::source::Span;
use crate::syntax::ast;
use std::collections::BTreeMap;

/// Declarations by name.
#[derive(Default, Clone)]
pub(super) struct Scope<'a> {
    pub contracts: BTreeMap<&'a str, &'a ast::Contract>,
    pub machines: BTreeMap<&'a str, &'a ast::Machine>,
    types: Vec<&'a ast::TypeDecl>,
    constants: Vec<&'a ast::ConstDecl>,
    /// Where each name was declared.
    places: BTreeMap<&'a str, Span>,
    /// Values, once [`Scope::settle`] has run.
    pub values: BTreeMap<String, Value>,
    pub named_types: BTreeMap<String, Type>,
    pub named_domains: BTreeMap<String, Domain>,
}

impl<'a> Scope<'a> {
    /// Adds the declarations of one file. Names that are there already are findings.
    pub fn add(&mut self, file: &'a ast::File, findings: &mut Vec<Diagnostic>) {
        for item in &file.items {
            let name = match item {
                ast::Item::Import(_) => continue,
                ast::Item::Type(d) => &d.name,
                ast::Item::Const(d) => &d.name,
                ast::Item::Contract(d) => &d.header.name,
                ast::Item::Machine(d) => &d.header.name,
                ast::Item::Line(d) => &d.name,
            };
            if let Some(first) = self.places.get(name.text.as_str()) {
                findings.push(double(name, *first));
                continue;
            }
            self.places.insert(&name.text, name.span);
            match item {
                ast::Item::Type(d) => self.types.push(d),
                ast::Item::Const(d) => self.constants.push(d),
                ast::Item::Contract(d) => {
                    self.contracts.insert(&d.header.name.text, d);
                }
                ast::Item::Machine(d) => {
                    self.machines.insert(&d.header.name.text, d);
                }
                ast::Item::Import(_) | ast::Item::Line(_) => {}
            }
        }
    }

    /// Evaluates types and constants, in the order in which they were added.
    pub fn settle(&mut self, findings: &mut Vec<Diagnostic>) {
        let mut e = Elaborator::new();
        let mut types = self.types.clone();
        // A range may use a constant, an array of labels may use a type: constants that fail are tried again after the types.
        let mut waiting = Vec::new();
        for decl in &self.constants {
            constant(&mut e, decl, &mut waiting);
        }
        e.findings.clear();
        for decl in types.drain(..) {
            type_decl(&mut e, decl);
        }
        let mut again = Vec::new();
        for decl in waiting {
            constant(&mut e, decl, &mut again);
        }
        findings.append(&mut e.findings);
        self.values = std::mem::take(&mut e.constants);
        self.named_types = std::mem::take(&mut e.types);
        self.named_domains = std::mem::take(&mut e.named_domains);
    }

    /// An elaborator with this scope's types and constants in sight.
    pub fn elaborator(&self) -> Elaborator<'a> {
        let mut e = Elaborator::new();
        e.constants.clone_from(&self.values);
        e.types.clone_from(&self.named_types);
        e.named_domains.clone_from(&self.named_domains);
        e
    }
}

/// Declares a type within an elaborator.
pub(super) fn type_decl<'a>(e: &mut Elaborator<'a>, decl: &'a ast::TypeDecl) {
    if let Some((domain, length)) = e.domain(&decl.domain) {
        if length.is_some() {
            e.error_with(
                codes::TYPE_MISMATCH,
                decl.domain.span,
                "a named type is a range or a set of labels",
                "write `array[n] of ...` where the variable is declared",
            );
            return;
        }
        let domain = match domain {
            Domain::Enum { labels, .. } => Domain::Enum {
                name: Some(decl.name.text.clone()),
                labels,
            },
            other => other,
        };
        e.types.insert(decl.name.text.clone(), Type::of(&domain));
        e.named_domains.insert(decl.name.text.clone(), domain);
    }
}

/// Declares a constant within an elaborator; what cannot be evaluated goes to `waiting`.
pub(super) fn constant<'a>(
    e: &mut Elaborator<'a>,
    decl: &'a ast::ConstDecl,
    waiting: &mut Vec<&'a ast::ConstDecl>,
) {
    let real = std::mem::replace(&mut e.real, uses_units(&decl.value));
    let value = constant_value(e, decl);
    e.real = real;
    match value {
        Some(value) => {
            e.constants.insert(decl.name.text.clone(), value);
        }
        None => waiting.push(decl),
    }
}

fn constant_value<'a>(e: &mut Elaborator<'a>, decl: &'a ast::ConstDecl) -> Option<Value> {
    let Some(domain) = &decl.domain else {
        return e.value(&decl.value, None, Time::Now);
    };
    let (base, length) = e.domain(domain)?;
    let expected = match length {
        Some(n) => Type::Array(Box::new(Type::of(&base)), n),
        None => Type::of(&base),
    };
    let value = e.value(&decl.value, Some(&expected), Time::Now)?;
    if value.ty() != expected {
        e.error(
            codes::TYPE_MISMATCH,
            decl.value.span,
            format!(
                "expected {}, found {}",
                expected.describe(),
                value.ty().describe()
            ),
        );
        return None;
    }
    let members = match &value {
        Value::Array(members) => members.as_slice(),
        scalar @ Value::Scalar(..) => std::slice::from_ref(scalar),
    };
    for member in members {
        if let Value::Scalar(Term::Int(i), _) = member
            && !base.contains(*i)
        {
            e.error(
                codes::ARGUMENT,
                decl.value.span,
                format!("{i} is outside {}", base.describe()),
            );
            return None;
        }
    }
    Some(value)
}

/// Whether a constant is a plant's quantity.
fn uses_units(e: &ast::Expr) -> bool {
    match &e.kind {
        ast::ExprKind::Quantity(..) => true,
        ast::ExprKind::Binary(_, a, b) => uses_units(a) || uses_units(b),
        ast::ExprKind::Neg(a) => uses_units(a),
        ast::ExprKind::List(members) => members.iter().any(uses_units),
        _ => false,
    }
}

/// A name that is there already.
pub(super) fn double(name: &ast::Name, first: Span) -> Diagnostic {
    Diagnostic::error(
        codes::NAME_DOUBLE,
        name.span,
        format!("`{}` is declared twice", name.text),
    )
    .with_label(first, "first declared here")
    .with_help("give one of the two another name")
}
