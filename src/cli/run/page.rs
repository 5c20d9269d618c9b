//! `--report`: the page of a run.

use super::{Arguments, Simulated};
use crate::diagnostics::Diagnostic;
use crate::engine::output::PendingFile;
use crate::line::comparison::Comparison;
use crate::report::html::{Compared, Page, page};
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
        sources: &base.loaded.library.sources,
        set: &set,
        command: &command(std::env::args().skip(1)),
        version: env!("CARGO_PKG_VERSION"),
        findings: &base.findings,
    });
    let written = file.file().write_all(text.as_bytes());
    file.keep(written)
}

/// The command line, quoted for a shell where that is necessary.
fn command(arguments: impl Iterator<Item = String>) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "-_=+.,:/%@".contains(c);
    let quoted = arguments.map(|argument| {
        if !argument.is_empty() && argument.chars().all(is_plain) {
            argument
        } else {
            format!("'{}'", argument.replace('\'', r"'\''"))
        }
    });
    std::iter::once("linewright".to_owned())
        .chain(quoted)
        .collect::<Vec<_>>()
        .join(" ")
}

#[cfg(test)]
mod tests {
    use super::command;

    #[test]
    fn a_command_can_be_pasted_into_a_shell() {
        let arguments = [
            "run",
            "my line.lw",
            "--set",
            "a.takes='2 s'",
            "--parts",
            "5",
        ];
        assert_eq!(
            command(arguments.map(str::to_owned).into_iter()),
            r"linewright run 'my line.lw' --set 'a.takes='\''2 s'\''' --parts 5"
        );
    }
}
