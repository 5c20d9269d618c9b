//! Common parts of all blocks: names and types of the ports, the control inputs and outputs, and
//! the frame of a call.

use super::names::{Names, comment, identifier, part, stem};
use super::text::{indented, wrap_condition};
use super::{Block, Enumeration, Initial, Parts, Section, Type, Variable, Width, literal};
use crate::emit::controller::Origin;
use crate::template::render;
use linewright_core::gr1::{Domain, Formula, Side, Specification, Timing, describe_domain};
use linewright_solver::mealy;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write;

/// An input or output of the controller as a variable of the block.
pub(super) struct Port<'a> {
    /// Name of the variable.
    pub name: String,
    /// Type of the variable.
    pub kind: Type,
    /// The labels of an enumeration, as declared.
    pub labels: Vec<String>,
    /// The port of the controller.
    pub of: &'a mealy::Port,
}

/// A block's ports, types, errors and names.
pub(super) struct Interface<'a> {
    contract: String,
    origin: &'a Origin,
    prefix: String,
    timing: Timing,
    specification: &'a Specification,
    names: Names,
    block: String,
    types: Vec<Enumeration>,
    /// Index in `types` of each enumeration.
    known: BTreeMap<(Option<String>, Vec<String>), usize>,
    /// Inputs in the order of the specification.
    pub inputs: Vec<Port<'a>>,
    /// Outputs and internal variables.
    pub outputs: Vec<Port<'a>>,
    own: BlockVariables,
    /// Type of the errors.
    errors: Enumeration,
    /// Error of each assumption, by the assumption's name.
    assumption_errors: BTreeMap<String, String>,
    /// Error for a value outside its domain, for each input that is not Boolean.
    domain_errors: Vec<Option<String>>,
}

/// The block's own variables that every form of controller uses.
#[derive(Serialize)]
pub(super) struct BlockVariables {
    pub enable: String,
    pub reset: String,
    pub stepped: String,
    pub error: String,
    pub error_id: String,
    /// Temporary variable: the reason why this step is refused, or `no_error`.
    pub refused: String,
    /// Error label that stands for no error.
    pub no_error: String,
}

/// The fields of `description.txt`.
#[derive(Serialize)]
struct Description<'a> {
    title: String,
    timing: &'static str,
    enable: &'a str,
    error: &'a str,
    error_id: &'a str,
    reset: &'a str,
    usage: Vec<String>,
    assumptions: Vec<String>,
    guarantees: Vec<String>,
}

/// The fields of `call.st`.
#[derive(Serialize)]
struct Call<'a> {
    #[serde(flatten)]
    own: &'a BlockVariables,
    /// Statements that reset state and outputs.
    reset_statements: String,
    /// Statements that refuse inputs outside their domains.
    checks: String,
    step: String,
}

impl<'a> Interface<'a> {
    /// Creates the interface of a controller.
    pub fn new(
        controller: &'a mealy::Controller,
        specification: &'a Specification,
        origin: &'a Origin,
    ) -> Self {
        let contract = controller.name();
        let prefix = stem(contract);
        let mut interface = Self {
            contract: contract.to_owned(),
            origin,
            prefix: prefix.clone(),
            timing: controller.timing(),
            specification,
            names: Names::default(),
            block: String::new(),
            types: Vec::new(),
            known: BTreeMap::new(),
            inputs: Vec::new(),
            outputs: Vec::new(),
            own: BlockVariables {
                enable: String::new(),
                reset: String::new(),
                stepped: String::new(),
                error: String::new(),
                error_id: String::new(),
                refused: String::new(),
                no_error: String::new(),
            },
            errors: Enumeration {
                name: String::new(),
                description: format!("Reason why {} refused a step.", comment(contract)),
                labels: Vec::new(),
            },
            assumption_errors: BTreeMap::new(),
            domain_errors: Vec::new(),
        };
        // Enumerations are named first: they need the same names in all blocks that share them, so
        // that outputs of one block can be connected to inputs of another.
        let ports = controller.inputs().iter().chain(controller.outputs());
        for port in ports {
            interface.declare(port);
        }
        interface.block = interface.names.unique(&format!("FB_{prefix}"));
        interface.errors.name = interface.names.unique(&format!("E_{prefix}_Error"));
        interface.own.no_error = interface.error("no_error", "");
        interface.inputs = interface.ports(controller.inputs());
        interface.outputs = interface.ports(controller.outputs());
        for place in 0..interface.inputs.len() {
            let port = &interface.inputs[place];
            let label = (port.kind != Type::Bool).then(|| {
                let name = format!("outside_{}", part(&port.of.name));
                let meaning = format!("{} has a value outside its domain", port.of.name);
                interface.error(&name, &meaning)
            });
            interface.domain_errors.push(label);
        }
        // On a conflict, names from the contract stay, and the block's own names get a number.
        interface.own = BlockVariables {
            enable: interface.fresh("enable"),
            reset: interface.fresh("reset"),
            stepped: interface.fresh("stepped"),
            error: interface.fresh("error"),
            error_id: interface.fresh("error_id"),
            refused: interface.fresh("refused"),
            no_error: interface.own.no_error,
        };
        interface
    }

    /// The block's own variables.
    pub fn own(&self) -> &BlockVariables {
        &self.own
    }

    /// Name of the error type.
    pub fn error_type(&self) -> String {
        self.errors.name.clone()
    }

    /// Returns an unused name for an additional variable.
    pub fn fresh(&mut self, preferred: &str) -> String {
        self.names.unique(&identifier(preferred))
    }

    /// Adds an error and returns its label.
    fn error(&mut self, name: &str, meaning: &str) -> String {
        let label = format!("{}_{name}", self.prefix);
        let label = self.names.unique(&label);
        self.errors.labels.push((label.clone(), comment(meaning)));
        label
    }

    /// Returns the label of the error for a violated assumption with this name.
    pub fn assumption_error(&mut self, name: &str) -> String {
        if let Some(label) = self.assumption_errors.get(name) {
            return label.clone();
        }
        let all = self.specification.assumptions.all();
        let texts: Vec<String> = all.filter(|f| f.name == name).map(text).collect();
        let label = self.error(&format!("broken_{}", part(name)), &texts.join("; "));
        self.assumption_errors
            .insert(name.to_owned(), label.clone());
        label
    }

    /// Adds the error for a missing transition and returns its label.
    pub fn no_step(&mut self) -> String {
        let meaning = "the controller has no step for these inputs, so they break an assumption";
        self.error("no_step", meaning)
    }

    /// Declares the type of a port with labels, if it is not declared yet.
    fn declare(&mut self, port: &mealy::Port) {
        let Domain::Enum { name, labels } = &port.domain else {
            return;
        };
        let key = (name.clone(), labels.clone());
        if self.known.contains_key(&key) {
            return;
        }
        let prefix = if let Some(name) = name {
            stem(name)
        } else {
            // The elements of an array share their type.
            let whole = port.name.split('[').next().unwrap_or_default();
            format!("{}_{}", self.prefix, part(whole))
        };
        let declared = Enumeration {
            name: self.names.unique(&format!("E_{prefix}")),
            description: String::new(),
            labels: labels
                .iter()
                .map(|label| {
                    let preferred = format!("{prefix}_{}", part(label));
                    let declared = self.names.unique(&preferred);
                    // A comment is only needed if the declared name differs from the label.
                    let meaning = if declared == format!("{prefix}_{label}") {
                        String::new()
                    } else {
                        comment(label)
                    };
                    (declared, meaning)
                })
                .collect(),
        };
        self.known.insert(key, self.types.len());
        self.types.push(declared);
    }

    fn ports(&mut self, ports: &'a [mealy::Port]) -> Vec<Port<'a>> {
        let named = ports.iter().map(|port| {
            let name = self.names.unique(&identifier(&port.name));
            let (kind, labels) = match &port.domain {
                Domain::Bool => (Type::Bool, Vec::new()),
                Domain::Range { low, high } => (Type::Integer(Width::of(*low, *high)), Vec::new()),
                Domain::Enum { name, labels } => {
                    let declared = &self.types[self.known[&(name.clone(), labels.clone())]];
                    let kind = Type::Enumeration(declared.name.clone());
                    (kind, declared.labels.iter().map(|l| l.0.clone()).collect())
                }
            };
            Port {
                name,
                kind,
                labels,
                of: port,
            }
        });
        named.collect()
    }

    /// Completes the block with the parts that depend on the form of the controller.
    pub fn finish(self, parts: Parts) -> Block {
        let body = self.body(&parts);
        let description = self.description();
        let Self { own, errors, .. } = self;
        let control = |name: &str, text: &str| Variable::new(name, Type::Bool, text);
        let mut inputs = vec![
            control(
                &own.enable,
                "each call in which it is TRUE makes one step; not edge-triggered",
            ),
            control(
                &own.reset,
                "return to the state before step 0; no step is made while it is TRUE",
            ),
        ];
        let mut outputs = vec![
            control(&own.stepped, "this call made a step"),
            control(
                &own.error,
                "the last step was refused and changed nothing; stays TRUE until the next step or reset",
            ),
            Variable::new(
                &own.error_id,
                Type::Enumeration(errors.name.clone()),
                "reason why the step was refused",
            ),
        ];
        let mut locals = parts.locals;
        inputs.extend(self.inputs.iter().map(Port::variable));
        for port in &self.outputs {
            if port.of.internal {
                locals.push(port.variable());
            } else {
                outputs.push(port.variable());
            }
        }
        let used = |v: &Variable| mentions(&body, &v.name);
        let mut temporaries = parts.temporaries;
        let mut constants = parts.constants;
        temporaries.retain(used);
        constants.retain(used);
        let refused = Variable::new(
            &own.refused,
            Type::Enumeration(errors.name.clone()),
            "reason why this step is refused",
        );
        temporaries.insert(0, refused);
        let mut types = self.types;
        types.push(errors);
        let sections = [
            (Section::Input, inputs),
            (Section::Output, outputs),
            (Section::Local, locals),
            (Section::Constant, constants),
            (Section::Temporary, temporaries),
        ];
        Block {
            contract: self.contract,
            name: self.block,
            description,
            types,
            sections: sections
                .into_iter()
                .filter(|(_, list)| !list.is_empty())
                .collect(),
            body,
        }
    }

    fn description(&self) -> Vec<String> {
        let own = &self.own;
        let timing = match self.timing {
            Timing::Mealy => "the outputs of a step can depend on the inputs of the same step",
            Timing::Moore => "the outputs of a step do not depend on the inputs of the same step",
        };
        let list = |side: &Side| {
            let mut seen = Vec::new();
            for formula in side.all() {
                let formula = text(formula);
                if !seen.contains(&formula) {
                    seen.push(formula);
                }
            }
            seen
        };
        let text = render(
            "structured_text/description.txt",
            Description {
                title: comment(&self.origin.title),
                timing,
                enable: &own.enable,
                error: &own.error,
                error_id: &own.error_id,
                reset: &own.reset,
                usage: self.origin.usage.iter().map(|text| comment(text)).collect(),
                assumptions: list(&self.specification.assumptions),
                guarantees: list(&self.specification.guarantees),
            },
        );
        text.lines().map(str::to_owned).collect()
    }

    fn body(&self, parts: &Parts) -> String {
        let mut reset_statements = parts.reset.clone();
        for port in &self.outputs {
            let _ = writeln!(
                reset_statements,
                "{} := {};",
                port.name,
                port.initial_value()
            );
        }
        let checks = self.domain_checks();
        let levels = if checks.is_empty() { 1 } else { 2 };
        render(
            "structured_text/call.st",
            Call {
                own: &self.own,
                reset_statements: indented(&reset_statements, 1).trim_end().to_owned(),
                checks: indented(&checks, 1).trim_end().to_owned(),
                step: indented(&parts.step, levels).trim_end().to_owned(),
            },
        )
    }

    /// Statements that refuse inputs outside their domains. In some systems an enumeration can have
    /// values other than its labels.
    fn domain_checks(&self) -> String {
        let mut out = String::new();
        for (port, label) in self.inputs.iter().zip(&self.domain_errors) {
            let Some(label) = label else {
                continue;
            };
            let condition = if port.labels.is_empty() {
                let domain = &port.of.domain;
                let (low, high) = (literal(domain.low()), literal(domain.high()));
                format!("({0} < {low}) OR ({0} > {high})", port.name)
            } else {
                let labels = port.labels.iter();
                let tests: Vec<String> =
                    labels.map(|l| format!("({} <> {l})", port.name)).collect();
                tests.join(" AND ")
            };
            let word = if out.is_empty() { "IF" } else { "ELSIF" };
            let condition = wrap_condition(&format!("{word} {condition} THEN"), "        ");
            let _ = writeln!(out, "{condition}\n    {} := {label};", self.own.refused);
        }
        if !out.is_empty() {
            out.push_str("END_IF;\n");
        }
        out
    }
}

/// Whether a name occurs in a text.
pub(super) fn mentions(text: &str, name: &str) -> bool {
    let mut words = text.split(|c: char| !c.is_ascii_alphanumeric() && c != '_');
    words.any(|w| w == name)
}

/// Formats a formula with its name and requirement.
fn text(formula: &Formula) -> String {
    let requirement = match &formula.requirement {
        Some(requirement) => format!(" ({requirement})"),
        None => String::new(),
    };
    comment(&format!("{}{requirement}: {}", formula.name, formula.text))
}

impl Port<'_> {
    /// Formats a value of the port as a literal.
    pub fn value(&self, value: i64) -> String {
        match self.kind {
            Type::Bool => if value == 0 { "FALSE" } else { "TRUE" }.to_owned(),
            Type::Enumeration(_) => self.labels[value as usize].clone(),
            _ => literal(value),
        }
    }

    /// Literal of the port's value before the first call: 0 if that is in the domain, otherwise the
    /// lowest value.
    pub fn initial_value(&self) -> String {
        self.value(self.zero())
    }

    fn zero(&self) -> i64 {
        let domain = &self.of.domain;
        if domain.contains(0) { 0 } else { domain.low() }
    }

    /// Declares the port as a variable of the block.
    pub fn variable(&self) -> Variable {
        let port = self.of;
        let mut description = match &self.kind {
            Type::Integer(_) => describe_domain(&port.domain, &port.unit),
            _ => String::new(),
        };
        if port.name != self.name {
            let separator = if description.is_empty() { "" } else { ": " };
            description = format!("{}{separator}{description}", port.name);
        }
        Variable {
            name: self.name.clone(),
            kind: self.kind.clone(),
            initial: match self.zero() {
                0 => Initial::Default,
                value => Initial::Value(literal(value)),
            },
            description: comment(&description),
        }
    }
}
