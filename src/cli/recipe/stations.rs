//! Controllers of the machines that do the work of resources.

use crate::cli::exit::ExitCode;
use crate::cli::options::GlobalOptions;
use crate::contract::recipe::Layout;
use crate::diagnostics::has_errors;
use crate::engine::files::LoadedFiles;
use crate::engine::recipes::stations;
use crate::engine::synthesis::Synthesis;

/// Layouts with the times of their machines, and the controllers of these machines.
type Timed<'l> = (Vec<Layout>, Synthesis<'l>);

/// Synthesizes the controllers of the machines of some layouts, and gives the operations of these
/// machines their times and powers. If a machine has none, prints why and returns the command's
/// exit code.
pub(super) fn timed<'l>(
    loaded: &'l LoadedFiles,
    layouts: &[&Layout],
    command: &str,
    options: &GlobalOptions,
) -> anyhow::Result<Result<Timed<'l>, ExitCode>> {
    let (console, settings) = (options.console(), options.settings());
    let library = &loaded.library;
    let machines = stations::machines_of(library, layouts);
    let synthesis = Synthesis::new(machines, &settings, |count| {
        console.progress(count, "synthesizing")
    });
    let mut findings = synthesis.findings();
    for machine in synthesis.controlled() {
        findings.extend(synthesis.judge(&machine, &settings));
    }
    let mut timed = Vec::new();
    if synthesis.is_complete() && !has_errors(&findings) {
        for layout in layouts {
            match stations::timed_layout(library, layout, &synthesis) {
                Ok(layout) => timed.push(layout),
                Err(found) => findings.extend(found),
            }
        }
    }
    if timed.len() < layouts.len() {
        console.failed(command, &library.sources, &findings)?;
        return Ok(Err(options.exit_code(&findings)));
    }
    Ok(Ok((timed, synthesis)))
}
