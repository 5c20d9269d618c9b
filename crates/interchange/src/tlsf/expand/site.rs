//! Expansion sites of formulas: calls, and iterations of big operators.

use super::super::report::Report;
use linewright_core::diagnostics::Diagnostic;
use std::ops::Range;

/// A call, or an iteration of a big operator.
#[derive(Debug, Clone)]
pub(in super::super) struct Site {
    pub range: Range<usize>,
    pub outer: u32,
    /// The binding of the iteration, such as `i = 1`; empty for a call.
    pub with: String,
}

/// Adds labels to a finding for at most 4 enclosing sites, innermost first.
pub(in super::super) fn located(
    mut finding: Diagnostic,
    site: u32,
    sites: &[Site],
    report: &Report,
) -> Diagnostic {
    let mut at = site;
    let mut shown = 0;
    while at != 0 && shown < 4 {
        let Some(found) = sites.get(at as usize) else {
            break;
        };
        let text = if found.with.is_empty() {
            "in this call".to_owned()
        } else {
            format!("for {}", found.with)
        };
        // Report each location once, because recursive calls all have the same one.
        let label = (report.span(&found.range), text);
        if finding.span != Some(label.0) && !finding.labels.contains(&label) {
            finding.labels.push(label);
            shown += 1;
        }
        at = found.outer;
    }
    finding
}

/// The bindings of the big operators around a formula, such as `i = 1, j = 2`.
pub(in super::super) fn bindings(site: u32, sites: &[Site]) -> String {
    let mut found = Vec::new();
    let mut at = site;
    while at != 0
        && found.len() < 4
        && let Some(site) = sites.get(at as usize)
    {
        if !site.with.is_empty() {
            found.push(site.with.as_str());
        }
        at = site.outer;
    }
    found.reverse();
    found.join(", ")
}
