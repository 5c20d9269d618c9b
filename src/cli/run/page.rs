//! `--report`: a run as a page.

use super::{Arguments, Compared, Simulated};
use crate::cli::page::{command, origin};
use crate::report::Intervals;
use crate::report::html::run::{self, Page};
use std::collections::BTreeMap;

/// Returns the page of a run that was recorded.
pub(super) fn page(
    arguments: &Arguments,
    base: &Simulated,
    intervals: Option<Intervals<'_>>,
    compared: &[Compared],
) -> Option<String> {
    let recorder = base.recorder.as_ref()?;
    let set: BTreeMap<&str, &str> = super::settings_by_name(&arguments.set);
    let comparisons = compared.iter().map(|of| run::Compared {
        variant: &of.variant,
        traces: &of.simulated.run.traces,
        comparisons: &of.differences,
    });
    let comparisons: Vec<run::Compared<'_>> = comparisons.collect();
    Some(run::page(&Page {
        line: &base.line,
        traces: &base.run.traces,
        intervals,
        recorder,
        comparisons: &comparisons,
        set: &set,
        origin: origin(&command(), &base.loaded.library.sources, &base.findings),
    }))
}
