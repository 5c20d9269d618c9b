//! The scope of a file: its own declarations and those of everything that it imports.

use super::elaborate::{Elaborator, FileNames, Findings, Names, fitted_value};
use super::set::Variants;
use super::shape::Shape;
use super::table::Tables;
use super::units::Unit;
use super::value::{Term, Type, Value};
use crate::order::Skills;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::gr1::{Domain, Time, show_value};
use linewright_core::source::Span;
use linewright_syntax::ast;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Declarations that are visible in a file, by name.
#[derive(Default, Clone)]
pub(super) struct Scope<'a> {
    pub contracts: BTreeMap<&'a str, &'a ast::Contract>,
    pub machines: BTreeMap<&'a str, &'a ast::Machine>,
    /// Machines that replace the declared ones at single places of a line.
    pub variants: Option<&'a Variants>,
    /// The tables that statements name.
    pub tables: Option<&'a Tables>,
    /// Skill sets; `None` for those that cannot be used because of errors.
    pub skills: BTreeMap<&'a str, Option<Arc<Skills>>>,
    /// Places of the layouts.
    pub layouts: BTreeMap<&'a str, Span>,
    /// Places of the recipes.
    pub recipes: BTreeMap<&'a str, Span>,
    types: Vec<&'a ast::TypeDecl>,
    constants: Vec<&'a ast::ConstDecl>,
    defines: BTreeMap<String, &'a ast::Define>,
    /// Source position at which each name is declared.
    places: BTreeMap<&'a str, Span>,
    /// Values of constants; empty before [`Scope::evaluate`].
    pub values: BTreeMap<String, Value>,
    pub named_types: BTreeMap<String, Type>,
    pub shapes: BTreeMap<String, Shape>,
    /// Names of types and constants that could not be evaluated; the findings give the reasons.
    broken: BTreeSet<String>,
}

impl<'a> Scope<'a> {
    /// Creates a scope without declarations. `variants` replace declared machines at single places;
    /// `tables` are those that statements name.
    pub fn with(variants: &'a Variants, tables: &'a Tables) -> Self {
        Self {
            variants: Some(variants),
            tables: Some(tables),
            ..Self::default()
        }
    }

    /// Adds the declarations of one file. `skills` are its resolved skill sets, in order. Reports
    /// names that are already declared.
    pub fn add(
        &mut self,
        file: &'a ast::File,
        skills: &[Option<Arc<Skills>>],
        findings: &mut Vec<Diagnostic>,
    ) {
        let mut skills = skills.iter();
        for item in &file.items {
            let set = match item {
                ast::Item::Skills(_) => skills.next().cloned().flatten(),
                _ => None,
            };
            let name = match item {
                ast::Item::Import(_) | ast::Item::Realize(_) => continue,
                ast::Item::Type(d) => &d.name,
                ast::Item::Const(d) => &d.name,
                ast::Item::Define(d) => &d.name,
                ast::Item::Contract(d) => &d.header.name,
                ast::Item::Machine(d) => &d.header.name,
                ast::Item::Line(d) => &d.name,
                ast::Item::Skills(d) => &d.name,
                ast::Item::Layout(d) => &d.name,
                ast::Item::Recipe(d) => &d.name,
            };
            if let Some(first) = self.places.get(name.text.as_str()) {
                findings.push(duplicate_name(name, *first));
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
                ast::Item::Define(d) => {
                    findings.extend(duplicate_formals(d));
                    self.defines.insert(d.name.text.clone(), d);
                }
                ast::Item::Skills(d) => {
                    self.skills.insert(&d.name.text, set);
                }
                ast::Item::Layout(d) => {
                    self.layouts.insert(&d.name.text, d.name.span);
                }
                ast::Item::Recipe(d) => {
                    self.recipes.insert(&d.name.text, d.name.span);
                }
                ast::Item::Import(_) | ast::Item::Line(_) | ast::Item::Realize(_) => {}
            }
        }
    }

    /// Evaluates the types and constants, in the order of their dependencies.
    pub fn evaluate(&mut self, findings: &mut Vec<Diagnostic>) {
        let mut e = Elaborator::default();
        let types = self.types.iter().copied().map(Decl::Type);
        let constants = self.constants.iter().copied().map(Decl::Constant);
        let decls: Vec<_> = types.chain(constants).collect();
        evaluate_all(&mut e, &decls);
        findings.append(&mut e.findings.list);
        self.values = std::mem::take(&mut e.names.constants);
        self.named_types = std::mem::take(&mut e.names.types);
        self.shapes = std::mem::take(&mut e.names.shapes);
        self.broken = std::mem::take(&mut e.names.broken);
    }

    /// Returns an elaborator with this scope's types, constants and defines.
    pub fn elaborator(&self) -> Elaborator<'a> {
        let mut names = Names::default();
        names.constants.clone_from(&self.values);
        names.types.clone_from(&self.named_types);
        names.shapes.clone_from(&self.shapes);
        names.defines.clone_from(&self.defines);
        names.broken.clone_from(&self.broken);
        names.of_file = FileNames {
            constants: self.values.clone(),
            defines: self.defines.clone(),
        };
        Elaborator {
            tables: self.tables,
            ..Elaborator::new(names)
        }
    }
}

/// A declaration that is evaluated before the formulas.
#[derive(Clone, Copy)]
pub(super) enum Decl<'a> {
    Type(&'a ast::TypeDecl),
    Constant(&'a ast::ConstDecl),
}

impl<'a> Decl<'a> {
    fn name(self) -> &'a ast::Name {
        match self {
            Self::Type(d) => &d.name,
            Self::Constant(d) => &d.name,
        }
    }

    /// Returns the names that the declaration mentions.
    fn mentioned_names(self) -> Vec<&'a str> {
        let mut names = Vec::new();
        match self {
            Self::Type(d) => names_of_domain(&d.domain, &mut names),
            Self::Constant(d) => {
                if let Some(domain) = &d.domain {
                    names_of_domain(domain, &mut names);
                }
                names_of(&d.value, &mut names);
            }
        }
        names
    }
}

fn names_of_domain<'a>(domain: &'a ast::Domain, names: &mut Vec<&'a str>) {
    match &domain.kind {
        ast::DomainKind::Range(low, high, _) => {
            names_of(low, names);
            names_of(high, names);
        }
        ast::DomainKind::Array(length, of) => {
            names_of(length, names);
            names_of_domain(of, names);
        }
        ast::DomainKind::Record(members) => {
            for (_, domain) in members {
                names_of_domain(domain, names);
            }
        }
        ast::DomainKind::Named(name) => names.push(&name.text),
        ast::DomainKind::Labels(_) | ast::DomainKind::Unit(_) => {}
    }
}

fn names_of<'a>(e: &'a ast::Expr, names: &mut Vec<&'a str>) {
    if let ast::ExprKind::Path(path) = &e.kind
        && let Some(first) = path.first()
    {
        names.push(&first.text);
    }
    if let ast::ExprKind::Quantifier(_, _, domain, _) = &e.kind {
        names_of_domain(domain, names);
    }
    for child in e.children() {
        names_of(child, names);
    }
}

/// Evaluates declarations in the order of their dependencies, independent of their order in the
/// file. Reports a declaration that depends on itself. A declaration that could not be evaluated is
/// added to the elaborator's `broken` names.
pub(super) fn evaluate_all<'a>(e: &mut Elaborator<'a>, decls: &[Decl<'a>]) {
    let by_name: BTreeMap<&str, usize> = decls
        .iter()
        .enumerate()
        .map(|(i, d)| (d.name().text.as_str(), i))
        .collect();
    let needs: Vec<Vec<usize>> = decls
        .iter()
        .map(|d| {
            let names = d.mentioned_names();
            names
                .iter()
                .filter_map(|n| by_name.get(n).copied())
                .collect()
        })
        .collect();
    // Depth-first search without recursion, since a chain of constants can be long.
    let mut entered = vec![false; decls.len()];
    let mut finished = vec![false; decls.len()];
    for start in 0..decls.len() {
        let mut path = vec![(start, 0)];
        while let Some((at, next)) = path.pop() {
            if finished[at] {
                continue;
            }
            entered[at] = true;
            if let Some(needed) = needs[at].get(next).copied() {
                path.push((at, next + 1));
                if !entered[needed] {
                    path.push((needed, 0));
                } else if !finished[needed] {
                    let name = decls[needed].name();
                    if e.names.broken.insert(name.text.clone()) {
                        e.findings.error_with(
                            codes::NAME_DUPLICATE,
                            name.span,
                            format!("`{}` is defined in terms of itself", name.text),
                            "break the cycle: give one of these declarations a value that does not depend on the others",
                        );
                    }
                }
                continue;
            }
            finished[at] = true;
            let name = decls[at].name();
            if e.names.broken.contains(&name.text) {
                continue;
            }
            let done = match decls[at] {
                Decl::Type(d) => type_decl(e, d),
                Decl::Constant(d) => constant(e, d),
            };
            if done.is_none() {
                e.names.broken.insert(name.text.clone());
                e.names.constants.remove(&name.text);
            }
        }
    }
    // The errors were reported here. The elaborator becomes tainted again when a broken name is
    // used.
    e.findings.tainted = false;
}

fn type_decl<'a>(e: &mut Elaborator<'a>, decl: &'a ast::TypeDecl) -> Option<()> {
    let shape = match e.shape(&decl.domain)? {
        Shape::Scalar(Domain::Enum { labels, .. }, unit) => {
            let name = Some(decl.name.text.clone());
            Shape::Scalar(Domain::Enum { name, labels }, unit)
        }
        other => other,
    };
    e.names.types.insert(decl.name.text.clone(), shape.ty());
    e.names.shapes.insert(decl.name.text.clone(), shape);
    Some(())
}

fn constant<'a>(e: &mut Elaborator<'a>, decl: &'a ast::ConstDecl) -> Option<()> {
    // Only a constant without a declared type can be a real quantity of the plant. A declared type
    // determines the unit of its constant.
    let plant = decl.domain.is_none() && uses_units(&e.names, &decl.value);
    let real = std::mem::replace(&mut e.dialect.real, plant);
    let value = constant_value(e, decl);
    e.dialect.real = real;
    e.names.constants.insert(decl.name.text.clone(), value?);
    Some(())
}

fn constant_value<'a>(e: &mut Elaborator<'a>, decl: &'a ast::ConstDecl) -> Option<Value> {
    let Some(domain) = &decl.domain else {
        return e.value(&decl.value, None, Time::Now);
    };
    let shape = e.shape(domain)?;
    let expected = shape.ty();
    let value = e.value(&decl.value, Some(&expected), Time::Now)?;
    let value = fitted_value(decl.value.span, value, &expected, &mut e.findings)?;
    within(&mut e.findings, decl, &shape, &value)?;
    Some(value)
}

/// Returns `None` and reports an error if the value is outside the range of the declared type.
fn within(
    findings: &mut Findings,
    decl: &ast::ConstDecl,
    shape: &Shape,
    value: &Value,
) -> Option<()> {
    match (shape, value) {
        (Shape::Scalar(domain, unit), Value::Scalar(Term::Int(i), _)) if !domain.contains(*i) => {
            findings.error_with(
                codes::ARGUMENT,
                decl.value.span,
                format!(
                    "{} is outside {}",
                    show_value(domain, *i, unit.map_or("", Unit::name)),
                    domain.describe()
                ),
                "use a value in this range, or extend the range",
            );
            None
        }
        (Shape::Array(of, _), Value::Array(values)) => values
            .iter()
            .try_for_each(|v| within(findings, decl, of, v)),
        (Shape::Record(shapes), Value::Record(members)) => shapes
            .iter()
            .zip(members)
            .try_for_each(|((_, s), (_, v))| within(findings, decl, s, v)),
        _ => Some(()),
    }
}

/// Returns whether a constant is a real quantity of the plant: its value contains a unit or another
/// such constant.
fn uses_units(known: &Names<'_>, value: &ast::Expr) -> bool {
    match &value.kind {
        ast::ExprKind::Quantity(..) => true,
        ast::ExprKind::Path(names) => {
            let [name] = names.as_slice() else {
                return false;
            };
            known.constants.get(&name.text).is_some_and(Value::is_real)
        }
        _ => value.children().iter().any(|c| uses_units(known, c)),
    }
}

/// Returns findings for parameters of a define that have the same name.
pub(super) fn duplicate_formals(define: &ast::Define) -> Vec<Diagnostic> {
    let mut findings = Vec::new();
    for (i, formal) in define.formals.iter().enumerate() {
        let mut earlier = define.formals[..i].iter().map(|f| &f.name);
        if let Some(first) = earlier.find(|n| n.text == formal.name.text) {
            findings.push(duplicate_name(&formal.name, first.span));
        }
    }
    findings
}

/// Returns the finding for a second occurrence of a statement that is allowed only once.
pub(super) fn duplicate_statement(word: &str, here: Span, first: Span, help: &str) -> Diagnostic {
    Diagnostic::error(
        codes::NAME_DUPLICATE,
        here,
        format!("`{word}` appears twice"),
    )
    .with_label(first, "first here")
    .with_help(help)
}

/// Returns the finding for a name that is already declared.
pub(super) fn duplicate_name(name: &ast::Name, first: Span) -> Diagnostic {
    Diagnostic::error(
        codes::NAME_DUPLICATE,
        name.span,
        format!("`{}` is declared twice", name.text),
    )
    .with_label(first, "first declared here")
    .with_help("give one of the two another name")
}
