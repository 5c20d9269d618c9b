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
            let rule = match (&error.rule, error.code) {
                (Some(rule), ErrorCode::Assumption) => {
                    format!("the assumption \"{rule}\" was broken")
                }
                (Some(rule), ErrorCode::Guarantee) => {
                    format!("the guarantee \"{rule}\" was broken")
                }
                (Some(rule), _) => format!("\"{rule}\" was broken"),
                (None, ErrorCode::Assumption) => {
                    "its assumptions contradict each other: no inputs satisfy them".to_owned()
                }
                (None, ErrorCode::Limit) => "the operation did not end".to_owned(),
                (None, ErrorCode::Domain) => "a value is outside its domain".to_owned(),
                (None, _) => "the controller refused a call".to_owned(),
            };
            let work = part.map_or(String::new(), |(number, kind)| {
                // A value is outside its domain when the part is joined, or when the work ends.
                let when = if error.code == ErrorCode::Domain {
                    "at work on"
                } else {
                    "when it began work on"
                };
                format!(", {when} {} {number}", self.type_name(kind))
            });
            let message = format!(
                "{}: {rule} at {}{work}: {}",
                self.name(node),
                self.moment(),
                error.message
            );
            self.journal
                .violation_kinds
                .insert(kind, (self.journal.findings.len(), 1));
            self.journal.findings.push(
                Diagnostic::error(code, self.line.nodes[node].span, message).with_help(
                    if error.code == ErrorCode::Order {
                        "Request the station's operations in an order that the rule allows, or correct the calls of the skills: `linewright order complete` lists the allowed calls."
                    } else {
                        "Compare the rule with the part's properties and the machine's bindings."
                    },
                ),
            );
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
}

fn times(count: u64) -> String {
    format!(" (the first of {count} times)")
}
