//! Selects the machines for `build` and `synth`.

use super::select::Selection;
use crate::contract::line::Line;
use crate::contract::machine::Machine;
use crate::diagnostics::{Diagnostic, codes};
use crate::engine::files::LoadedFiles;
use crate::engine::findings;
use crate::engine::machines::{contains, is_same, of_line};
use crate::station::file_stem;
use std::borrow::Cow;
use std::collections::BTreeSet;

/// Machines to build, with the lines that use them.
#[derive(Debug, Default)]
pub struct BuildSelection<'a> {
    /// Selected machines.
    pub machines: Vec<&'a Machine>,
    /// Lines whose machines are all selected.
    pub lines: Vec<&'a Line>,
    /// Notes on the selection.
    pub notes: Vec<Diagnostic>,
}

/// Selects the machine with the selection's name, or the machines of the line with that name.
/// Without a name, selects the machines of the file's lines, with the parameters that they have
/// there, and the file's other machines, with their default parameters.
///
/// # Errors
/// No machine matches the selection.
pub fn select_machines<'a>(
    selection: &Selection,
    loaded: &'a LoadedFiles,
) -> anyhow::Result<BuildSelection<'a>> {
    let library = &loaded.library;
    let declared = selection.find(loaded, &library.machines, |m| (&m.name, m.span));
    if selection.name.is_some() && !declared.is_empty() {
        return Ok(BuildSelection {
            machines: declared,
            ..BuildSelection::default()
        });
    }
    let lines = selection.find(loaded, &library.lines, |l| (&l.name, l.span));
    let mut picked = BuildSelection::default();
    for machine in lines.iter().flat_map(|l| of_line(l)) {
        let known = |m: &&Machine| is_same(m, machine);
        if !picked.machines.iter().any(known) {
            picked.machines.push(machine);
        }
    }
    for machine in declared {
        // An inner machine is part of the library of the outer machine.
        if picked.machines.iter().any(|m| contains(m, machine.span)) {
            continue;
        }
        let mut used = picked.machines.iter().filter(|m| m.span == machine.span);
        if used.clone().count() == 0 {
            picked.machines.push(machine);
        } else if !used.any(|m| is_same(m, machine)) {
            let note = note_on_parameters(selection, machine, &lines);
            picked.notes.push(note);
        }
    }
    picked.lines = lines;
    if picked.machines.is_empty() {
        picked.machines =
            selection.pick(loaded, "machine", &library.machines, |m| (&m.name, m.span))?;
    }
    Ok(picked)
}

/// Note that a machine is built with parameters other than its defaults.
fn note_on_parameters(selection: &Selection, machine: &Machine, lines: &[&Line]) -> Diagnostic {
    let name = &machine.name;
    let users = lines
        .iter()
        .filter(|l| of_line(l).iter().any(|m| m.span == machine.span))
        .map(|l| format!("`{}`", l.name));
    let users: Vec<String> = users.collect();
    Diagnostic::note(
        codes::LINE_SIZES,
        machine.span,
        format!(
            "`{name}` is built with the parameters that it has in {}",
            findings::list(&users)
        ),
    )
    .with_help(format!(
        "`linewright build {}::{name}` builds it with its default parameters",
        selection.path
    ))
}

/// Renames machines whose libraries would be written to the same file, such as one machine with two
/// sets of parameters: the second becomes `Printer_2`.
pub fn with_distinct_names<'a>(machines: &[&'a Machine]) -> Vec<Cow<'a, Machine>> {
    // SimTalk ignores case, as some file systems do.
    let keys = |name: &str| [file_stem(name), name.to_lowercase()];
    let mut taken: BTreeSet<String> = BTreeSet::new();
    let mut shown = Vec::new();
    for machine in machines {
        let mut name = machine.name.clone();
        let mut number = 2;
        while keys(&name).iter().any(|key| taken.contains(key)) {
            name = format!("{}_{number}", machine.name);
            number += 1;
        }
        taken.extend(keys(&name));
        shown.push(if name == machine.name {
            Cow::Borrowed(*machine)
        } else {
            Cow::Owned(Machine {
                name,
                ..(*machine).clone()
            })
        });
    }
    shown
}
