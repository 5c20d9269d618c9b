//! `--report`: the page of a run.

use super::{Arguments, Simulated};
use crate::cli::page::{command, origin};
use crate::diagnostics::Diagnostic;
use crate::engine::output::PendingFile;
use crate::line::comparison::Comparison;
use crate::report::html::run::{Compared, Page, page};
use crate::report::{Intervals, Variant};
use std::collections::BTreeMap;
use std::io::Write as _;

/// Writes the page of a run to a file.
pub(super) fn write(
    file: PendingFile,
    arguments: &Arguments,
    base: &Simulated,
    intervals: Option<Intervals<'_>>,
    compared: Option<&(Variant, Simulated, Vec<Comparison>)>,
) -> Result<(), Box<Diagnostic>> {
    let Some(recorder) = &base.recorder else {
        return Ok(());
    };
    let set: BTreeMap<&str, &str> = super::settings_by_name(&arguments.set);
    let comparison = compared.map(|(variant, simulated, comparisons)| Compared {
        variant,
        traces: &simulated.run.traces,
        comparisons,
    });
    let text = page(&Page {
        line: &base.line,
        traces: &base.run.traces,
        intervals,
        recorder,
        comparison,
        set: &set,
        origin: origin(&command(), &base.loaded.library.sources, &base.findings),
    });
    let written = file.file().write_all(text.as_bytes());
    file.keep(written)
}
