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
    let path = &selection.path;
    let found = find(selection, loaded);
    if !found.is_empty() {
        return Ok(found);
    }
    let Some(name) = &selection.name else {
        anyhow::bail!("{path} has no statement `realize`: write `realize RECIPE on LAYOUT`");
    };
    let known: Vec<&str> = own(loaded).flat_map(names).collect();
    anyhow::bail!(
        "{path} has no statement `realize` with a recipe or layout `{name}`: they have {}",
        known.join(", ")
    );
}

/// Like [`realizations`], but there may be none.
pub(in crate::cli) fn find<'l>(
    selection: &Selection,
    loaded: &'l LoadedFiles,
) -> Vec<&'l Realization> {
    let wanted = selection.name.as_deref();
    own(loaded)
        .filter(|r| wanted.is_none_or(|name| names(r).any(|own| own == name)))
        .collect()
}

/// The statements that the files themselves have.
fn own(loaded: &LoadedFiles) -> impl Iterator<Item = &Realization> {
    let library = &loaded.library;
    library.realizations.iter().filter(|r| {
        let file = &library.sources.file(r.span.file).name;
        loaded.roots.contains(file)
    })
}

/// The recipes of a statement, and its layout.
fn names(realization: &Realization) -> impl Iterator<Item = &str> {
    let recipes = realization.recipes.iter().map(|w| w.name.as_str());
    recipes.chain([realization.layout.as_str()])
}

/// Returns the layout of a statement, and its recipe if it asks for one product only.
pub(in crate::cli) fn models<'l>(
    loaded: &'l LoadedFiles,
    realization: &Realization,
) -> (Option<&'l Layout>, Option<&'l Recipe>) {
    let layout = loaded.library.layout_at(realization.layout_declared);
    let recipe = match recipes(loaded, realization).as_slice() {
        [recipe] if realization.is_single() => Some(*recipe),
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
