//! Records of a run: violations and findings.

use super::Run;
use super::part::PartIndex;
use crate::trace::{MAX_VIOLATIONS, Violation};
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_station::{CallError, ErrorCode};
use std::collections::BTreeMap;

/// Records of one run.
#[derive(Debug, Default)]
pub(super) struct Journal {
    /// The first violations, up to [`MAX_VIOLATIONS`].
    pub violations: Vec<Violation>,
    /// Total number of violations.
    pub violation_count: u64,
    /// By node, rule and code: the index of the finding for the first violation, and the number of
    /// violations.
    violation_kinds: BTreeMap<(usize, Option<String>, i32), (usize, u64)>,
    /// Findings of the run.
    pub findings: Vec<Diagnostic>,
    /// Pairs of a node and a part type for which a part had no way onward.
    pub unroutable: Vec<(usize, usize)>,
}

impl Journal {
    /// Appends the number of violations to the finding of each rule that was violated repeatedly.
    pub(super) fn count_repeated_violations(&mut self) {
        for &(finding, count) in self.violation_kinds.values() {
            if count > 1 {
                self.findings[finding].message += &times(count);
            }
        }
    }
}

impl Run<'_> {
    /// Records that a controller returned an error.
    pub(super) fn violate(&mut self, node: usize, part: Option<PartIndex>, error: CallError) {
        self.journal.violation_count += 1;
        self.progress.violations_at_instant += 1;
        let part = part.map(|part| (self.parts[part].number, self.parts[part].kind));
        let kind = (node, error.rule.clone(), error.code as i32);
        if let Some((_, count)) = self.journal.violation_kinds.get_mut(&kind) {
            *count += 1;
        } else {
            let code = match error.code {
                ErrorCode::Assumption
                | ErrorCode::Guarantee
                | ErrorCode::Limit
                | ErrorCode::Order
                | ErrorCode::Domain => codes::LINE_VIOLATION,
                _ => codes::LIBRARY_CALL,
            };
            let message = format!(
                "{} {} at {}: {}",
                self.name(node),
                self.consequence(part, error.code),
                self.moment(),
                error.message
            );
            let help = self.help(node, &error);
            self.journal
                .violation_kinds
                .insert(kind, (self.journal.findings.len(), 1));
            let span = self.line.nodes[node].span;
            self.journal
                .findings
                .push(Diagnostic::error(code, span, message).with_help(help));
        }
        let violation = Violation {
            time: self.now,
            node,
            part,
            code: error.code,
            rule: error.rule,
            message: error.message,
        };
        if let Some(observer) = &mut self.recorder.observer {
            observer.record_violation(&violation);
        }
        if self.journal.violations.len() < MAX_VIOLATIONS {
            self.journal.violations.push(violation);
        }
    }

    /// What a node does because its controller returned an error: `refused Plate 1`.
    fn consequence(&self, part: Option<(u64, usize)>, code: ErrorCode) -> String {
        let Some((number, kind)) = part else {
            return "refused a step".to_owned();
        };
        let part = format!("{} {number}", self.type_name(kind));
        match code {
            ErrorCode::Assumption | ErrorCode::Order | ErrorCode::Domain => {
                format!("refused {part}")
            }
            _ => format!("took {part} out of the line"),
        }
    }

    /// What to do about an error of a controller.
    fn help(&self, node: usize, error: &CallError) -> String {
        if error.code == ErrorCode::Order {
            return "Request the station's operations in an order that the rule allows, or correct the calls of the skills: `linewright order complete` lists the allowed calls.".to_owned();
        }
        let component = error.rule.as_deref().and_then(|rule| rule.split_once(": "));
        match (component, self.line.nodes[node].machine()) {
            (Some((component, _)), Some(machine)) => format!(
                "`{component}` is a component of the machine {}. Compare the rule with the properties of the part, and with the inputs that the machine gives to `{component}`.",
                machine.name
            ),
            _ => "Compare the rule with the properties of the part, and with the inputs that the machine gives to its components.".to_owned(),
        }
    }
}

fn times(count: u64) -> String {
    format!(" (the first of {count} times)")
}
