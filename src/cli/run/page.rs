//! `--report`: a run as a page.

use super::{Arguments, Simulated};
use crate::cli::page::{command, origin};
use crate::line::comparison::Comparison;
use crate::report::html::run::{self, Compared, Page};
use crate::report::{Intervals, Variant};
use std::collections::BTreeMap;

/// Returns the page of a run that was recorded.
pub(super) fn page(
    arguments: &Arguments,
    base: &Simulated,
    intervals: Option<Intervals<'_>>,
    compared: Option<&(Variant, Simulated, Vec<Comparison>)>,
) -> Option<String> {
    let recorder = base.recorder.as_ref()?;
    let set: BTreeMap<&str, &str> = super::settings_by_name(&arguments.set);
    let comparison = compared.map(|(variant, simulated, comparisons)| Compared {
        variant,
        traces: &simulated.run.traces,
        comparisons,
    });
    Some(run::page(&Page {
        line: &base.line,
        traces: &base.run.traces,
        intervals,
        recorder,
        comparison,
        set: &set,
        origin: origin(&command(), &base.loaded.library.sources, &base.findings),
    }))
}
