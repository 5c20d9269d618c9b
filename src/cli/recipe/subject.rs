//! Selects the statements `realize` on which a command works.

use super::stations;
use crate::cli::exit::ExitCode;
use crate::cli::options::GlobalOptions;
use crate::cli::select::Selection;
use crate::contract::recipe::{Layout, Realization, Recipe};
use crate::contract::set::Setting;
use crate::engine::files::LoadedFiles;

/// Loads the files; if they have errors, prints all findings and returns the command's exit code.
/// With settings, the layout of the selected statements is loaded again with these numbers.
pub(super) fn load(
    selection: &Selection,
    settings: &[Setting],
    command: &str,
    options: &GlobalOptions,
) -> anyhow::Result<Result<LoadedFiles, ExitCode>> {
    let loaded = match selection.load(command, options)? {
        Ok(loaded) => loaded,
        Err(code) => return Ok(Err(code)),
    };
    if settings.is_empty() {
        return Ok(Ok(loaded));
    }
    let mut layouts: Vec<String> = (realizations(selection, &loaded)?.iter())
        .map(|r| r.layout.clone())
        .collect();
    layouts.sort_unstable();
    layouts.dedup();
    let [layout] = layouts.as_slice() else {
        anyhow::bail!(
            "--set changes one layout, but these are selected: {}",
            layouts.join(", ")
        );
    };
    selection.load_layout(layout, settings, command, options)
}

/// Loads the files like [`load`]. In the layouts of the selected statements, each operation of a
/// machine gets the time and power of the machine.
pub(super) fn load_timed(
    selection: &Selection,
    settings: &[Setting],
    command: &str,
    options: &GlobalOptions,
) -> anyhow::Result<Result<LoadedFiles, ExitCode>> {
    let mut loaded = match load(selection, settings, command, options)? {
        Ok(loaded) => loaded,
        Err(code) => return Ok(Err(code)),
    };
    let mut layouts: Vec<&Layout> = Vec::new();
    for realization in realizations(selection, &loaded)? {
        let layout = loaded.library.layout_at(realization.layout_declared);
        layouts.extend(layout.filter(|l| !layouts.iter().any(|known| known.span == l.span)));
    }
    let timed = stations::timed(&loaded, &layouts, command, options)?;
    let timed = match timed {
        Ok((timed, _)) => timed,
        Err(code) => return Ok(Err(code)),
    };
    for layout in timed {
        let all = &mut loaded.library.layouts;
        if let Some(old) = all.iter_mut().find(|l| l.span == layout.span) {
            *old = layout;
        }
    }
    Ok(Ok(loaded))
}

/// Returns the statements `realize` with the selected recipe or layout; without a name, all that
/// the file itself has.
pub(super) fn realizations<'l>(
    selection: &Selection,
    loaded: &'l LoadedFiles,
) -> anyhow::Result<Vec<&'l Realization>> {
    let library = &loaded.library;
    let path = &selection.path;
    let is_own = |r: &&Realization| {
        let file = &library.sources.file(r.span.file).name;
        loaded.roots.contains(file)
    };
    let own: Vec<&Realization> = library.realizations.iter().filter(is_own).collect();
    let Some(name) = &selection.name else {
        anyhow::ensure!(
            !own.is_empty(),
            "{path} has no statement `realize`: write `realize RECIPE on LAYOUT`"
        );
        return Ok(own);
    };
    let has_name = |r: &&&Realization| {
        r.layout == *name || r.recipes.iter().any(|wanted| wanted.name == *name)
    };
    let named: Vec<&Realization> = own.iter().filter(has_name).copied().collect();
    if named.is_empty() {
        let known: Vec<String> = (own.iter())
            .flat_map(|r| {
                r.recipes
                    .iter()
                    .map(|w| w.name.clone())
                    .chain([r.layout.clone()])
            })
            .collect();
        anyhow::bail!(
            "{path} has no statement `realize` with a recipe or layout `{name}`: they have {}",
            known.join(", ")
        );
    }
    Ok(named)
}

/// Returns the layout of a statement, and its recipe if it asks for one product only.
pub(super) fn models<'l>(
    loaded: &'l LoadedFiles,
    realization: &Realization,
) -> (Option<&'l Layout>, Option<&'l Recipe>) {
    let layout = loaded.library.layout_at(realization.layout_declared);
    let recipe = match recipes(loaded, realization).as_slice() {
        [recipe] if realization.recipes[0].count == 1 => Some(*recipe),
        _ => None,
    };
    (layout, recipe)
}

/// Returns the recipes of a statement, in its order. A statement that was decided has them all.
pub(super) fn recipes<'l>(loaded: &'l LoadedFiles, realization: &Realization) -> Vec<&'l Recipe> {
    let wanted = realization.recipes.iter();
    wanted
        .filter_map(|wanted| loaded.library.recipe_at(wanted.declared))
        .collect()
}
