//! Evaluates names and calls: parameters, definitions, signals and labels.

use super::super::ast::{Binary, Definition, Kind, Tree};
use super::super::ltl::{Op, Place};
use super::super::value::{ScopeBinding, Value};
use super::{Expander, Result, Scope, Site};
use crate::names::quoted;
use linewright_core::diagnostics::{codes, nearest};
use std::ops::Range;

impl<'f> Expander<'f, '_> {
    pub(super) fn name(
        &mut self,
        name: &'f str,
        tree: &'f Tree,
        scope: Scope<'_>,
        site: u32,
    ) -> Result<Value> {
        match ScopeBinding::find(scope, name) {
            Some(value) => Ok(value),
            None => match self.resolve(name, tree, site)? {
                // Copy the signal's node, so that the copy has the location of this use.
                Value::Formula(f) if matches!(self.formulas.op(f), Op::Atom(_)) => {
                    let op = self.formulas.op(f).clone();
                    let place = Place::new(&tree.range, site);
                    Ok(Value::Formula(self.formulas.make(op, place)))
                }
                value => Ok(value),
            },
        }
    }

    pub(super) fn resolve(&mut self, name: &'f str, tree: &'f Tree, site: u32) -> Result<Value> {
        if let Some(value) = self.known.get(name) {
            return Ok(value.clone());
        }
        if let Some(definition) = self.globals.definitions.get(&(name, 0)).copied() {
            let value = self.cases(definition, tree, None, site)?;
            self.known.insert(&definition.name, value.clone());
            return Ok(value);
        }
        if let Some(value) = self.globals.signals.get(name) {
            return Ok(value.clone());
        }
        if let Some((e, l)) = self.globals.labels.get(name) {
            return Ok(Value::Label(*e, *l));
        }
        self.unknown(name, &tree.range, site, usize::MAX)
    }

    pub(super) fn unknown<T>(
        &mut self,
        name: &str,
        range: &Range<usize>,
        site: u32,
        count: usize,
    ) -> Result<T> {
        let of_name = |n: &&(&str, usize)| n.0 == name;
        let wanted = self.globals.definitions.keys().find(of_name).map(|d| d.1);
        if let Some(wanted) = wanted {
            let got = if count == usize::MAX { 0 } else { count };
            return self.fail(
                codes::ARGUMENT,
                range,
                site,
                format!(
                    "`{}` takes {wanted} argument{}, not {got}",
                    quoted(name),
                    if wanted == 1 { "" } else { "s" }
                ),
                "write one argument for each parameter",
            );
        }
        let globals = &self.globals;
        let all = globals
            .definitions
            .keys()
            .map(|d| d.0)
            .chain(globals.signals.keys().copied())
            .chain(globals.labels.keys().copied());
        let help = match nearest(&quoted(name), all) {
            Some(near) => format!("did you mean `{near}`?"),
            None if count == usize::MAX => {
                "declare it as a signal in INPUTS or OUTPUTS, or define it under PARAMETERS or DEFINITIONS".to_owned()
            }
            None => "define it under DEFINITIONS".to_owned(),
        };
        self.fail(
            codes::NAME_UNKNOWN,
            range,
            site,
            format!("`{}` is not declared", quoted(name)),
            help,
        )
    }

    pub(super) fn call(
        &mut self,
        name: &'f str,
        arguments: &'f [Tree],
        tree: &'f Tree,
        scope: Scope<'_>,
        site: u32,
    ) -> Result<Value> {
        let Some(definition) = self
            .globals
            .definitions
            .get(&(name, arguments.len()))
            .copied()
        else {
            return self.unknown(name, &tree.range, site, arguments.len());
        };
        let mut values = Vec::new();
        for argument in arguments {
            values.push(self.value(argument, scope, site)?);
        }
        let inner = self.site(&tree.range, site, String::new());
        let names = definition.arguments.iter().map(String::as_str);
        self.with(names.zip(values).collect(), None, &mut |s, scope| {
            s.cases(definition, tree, scope, inner)
        })
    }

    pub(super) fn site(&mut self, range: &Range<usize>, outer: u32, with: String) -> u32 {
        self.sites.push(Site {
            range: range.clone(),
            outer,
            with,
        });
        self.sites.len() as u32 - 1
    }

    /// Runs `run` with additional bindings.
    pub(super) fn with<T>(
        &mut self,
        names: Vec<(&str, Value)>,
        scope: Scope<'_>,
        run: &mut dyn FnMut(&mut Self, Scope<'_>) -> Result<T>,
    ) -> Result<T> {
        let mut names = names;
        match names.pop() {
            None => run(self, scope),
            Some((name, value)) => {
                let bound = ScopeBinding {
                    name,
                    value,
                    outer: scope,
                };
                self.with(names, Some(&bound), run)
            }
        }
    }

    /// The value of the first case whose guard applies.
    pub(super) fn cases(
        &mut self,
        definition: &'f Definition,
        tree: &'f Tree,
        scope: Scope<'_>,
        site: u32,
    ) -> Result<Value> {
        for case in &definition.cases {
            let Kind::Binary(Binary::Colon, guard, value) = &case.kind else {
                return self.value(case, scope, site);
            };
            let mut bound = Vec::new();
            if self.guard(guard, scope, site, &mut bound)? {
                return self.with(bound, scope, &mut |s, scope| s.value(value, scope, site));
            }
        }
        self.fail(
            codes::ARGUMENT,
            &tree.range,
            site,
            format!("no case of `{}` applies here", quoted(&definition.name)),
            "add a case `otherwise : ...` at its end",
        )
    }
}
