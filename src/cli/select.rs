//! `FILE::NAME`: selects declarations of a file.

use super::exit::ExitCode;
use super::options::GlobalOptions;
use super::outline;
use crate::contract::Contract;
use crate::contract::set::{Owner, SettableNumber, Setting, Settings};
use crate::diagnostics::{codes, has_errors};
use crate::engine::files::{self, LoadedFiles};
use crate::source::{SourceMap, Span};
use std::collections::BTreeSet;

/// A path, and optionally the name of a declaration in it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Selection {
    /// File or folder.
    pub path: String,
    /// Name after the last `::`.
    pub name: Option<String>,
}

impl std::str::FromStr for Selection {
    type Err = std::convert::Infallible;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Ok(match text.rsplit_once("::") {
            Some((path, name)) if !path.is_empty() && !name.is_empty() && !name.contains('/') => {
                Self {
                    path: path.to_owned(),
                    name: Some(name.to_owned()),
                }
            }
            _ => Self {
                path: text.to_owned(),
                name: None,
            },
        })
    }
}

impl Selection {
    /// The only contract among those that were picked.
    ///
    /// # Errors
    /// There are several. The message begins with `why` only one is possible, and names them.
    pub fn only<'c>(&self, picked: &[&'c Contract], why: &str) -> anyhow::Result<&'c Contract> {
        if let [contract] = picked {
            return Ok(contract);
        }
        let names: Vec<&str> = picked.iter().map(|c| c.name.as_str()).collect();
        let (path, names) = (&self.path, names.join(", "));
        anyhow::bail!("{why}: write `{path}::NAME`, where NAME is one of {names}")
    }

    /// Loads the files; if they have errors, prints all findings and returns the command's exit
    /// code.
    pub fn load(
        &self,
        command: &str,
        options: &GlobalOptions,
    ) -> anyhow::Result<Result<LoadedFiles, ExitCode>> {
        Self::if_valid(self.read(options), command, options)
    }

    /// Like [`Selection::load`], with numbers of the selected line set from outside of its file.
    pub fn load_with(
        &self,
        settings: &[Setting],
        command: &str,
        options: &GlobalOptions,
    ) -> anyhow::Result<Result<LoadedFiles, ExitCode>> {
        Self::if_valid(self.read_with(settings, options), command, options)
    }

    /// Like [`Selection::load`], with numbers of a layout set from outside of its file.
    pub fn load_layout(
        &self,
        layout: &str,
        settings: &[Setting],
        command: &str,
        options: &GlobalOptions,
    ) -> anyhow::Result<Result<LoadedFiles, ExitCode>> {
        let settings = Settings {
            of: Owner::Layout,
            name: Some(layout),
            list: settings,
        };
        Self::if_valid(self.read_set(settings, options), command, options)
    }

    /// Like [`Selection::load`], for a command that needs only the declaration with that name, or
    /// the statements `realize` with it and what they name: findings in other declarations are
    /// dropped, unless a file cannot be read or parsed.
    pub fn load_alone(
        &self,
        command: &str,
        options: &GlobalOptions,
    ) -> anyhow::Result<Result<LoadedFiles, ExitCode>> {
        let mut loaded = self.read(options);
        if let Some(name) = &self.name {
            let sources = &loaded.library.sources;
            let needed = needed(sources, name);
            let foreign: Vec<_> = loaded.foreign.iter().map(|f| f.file).collect();
            loaded.findings.retain(|f| {
                let elsewhere = f.span.is_some_and(|span| {
                    !foreign.contains(&span.file)
                        && outline::declarations(sources, span.file)
                            .iter()
                            .any(|d| d.holds(span) && !needed.contains(&d.name))
                });
                !elsewhere || f.code.id < codes::NAME_UNKNOWN.id
            });
        }
        Self::if_valid(loaded, command, options)
    }

    /// The numbers of a line that can be set; none if they cannot be read any more.
    pub fn settable(&self, line: &str, options: &GlobalOptions) -> Vec<SettableNumber> {
        let standard = files::StandardLibrary::new(options.library.clone());
        files::settable(&self.path, &standard, Owner::Line, Some(line)).unwrap_or_default()
    }

    fn read(&self, options: &GlobalOptions) -> LoadedFiles {
        self.read_with(&[], options)
    }

    fn read_with(&self, settings: &[Setting], options: &GlobalOptions) -> LoadedFiles {
        let settings = Settings {
            of: Owner::Line,
            name: self.name.as_deref(),
            list: settings,
        };
        self.read_set(settings, options)
    }

    fn read_set(&self, settings: Settings<'_>, options: &GlobalOptions) -> LoadedFiles {
        let standard = files::StandardLibrary::new(options.library.clone());
        files::load_with(std::slice::from_ref(&self.path), &standard, settings)
    }

    fn if_valid(
        loaded: LoadedFiles,
        command: &str,
        options: &GlobalOptions,
    ) -> anyhow::Result<Result<LoadedFiles, ExitCode>> {
        if has_errors(&loaded.findings) {
            let sources = &loaded.library.sources;
            options
                .console()
                .failed(command, sources, &loaded.findings)?;
            return Ok(Err(options
                .exit_code(&loaded.findings)
                .and(ExitCode::of_loading(&loaded))));
        }
        Ok(Ok(loaded))
    }

    /// Returns the selected items of `all`: the item with the selected name or, if no name was
    /// given, all items that the file itself declares. The result can be empty.
    pub fn find<'a, T>(
        &self,
        loaded: &LoadedFiles,
        all: &'a [T],
        describe: impl Fn(&T) -> (&str, Span),
    ) -> Vec<&'a T> {
        let own = |item: &T| {
            let file = loaded.library.sources.file(describe(item).1.file);
            loaded.roots.contains(&file.name)
        };
        match &self.name {
            Some(name) => {
                let named = || all.iter().filter(|i| describe(i).0 == name);
                // A name declared in the file itself takes precedence over an imported one.
                match named().find(|i| own(i)) {
                    Some(item) => vec![item],
                    None => named().take(1).collect(),
                }
            }
            None => all.iter().filter(|i| own(i)).collect(),
        }
    }

    /// Like [`Selection::find`], but an empty selection is an error that lists the candidates.
    pub fn pick<'a, T>(
        &self,
        loaded: &LoadedFiles,
        kind: &str,
        all: &'a [T],
        describe: impl Fn(&T) -> (&str, Span),
    ) -> anyhow::Result<Vec<&'a T>> {
        let picked = self.find(loaded, all, &describe);
        if picked.is_empty() {
            let path = &self.path;
            let names: Vec<&str> = all.iter().map(|i| describe(i).0).collect();
            let instead = match names.as_slice() {
                [] => "give a file that declares one".to_owned(),
                [only] => format!("write `{path}::{only}`"),
                names => format!(
                    "write `{path}::NAME`, where NAME is one of {}",
                    names.join(", ")
                ),
            };
            match &self.name {
                Some(name) => anyhow::bail!("{path} has no {kind} `{name}`: {instead}"),
                None => anyhow::bail!("{path} declares no {kind} itself: {instead}"),
            }
        }
        Ok(picked)
    }
}

/// The names of the declarations that a selected name needs: itself, and the statements `realize`
/// with it as recipe or layout, with their recipes and layouts.
fn needed(sources: &SourceMap, name: &str) -> BTreeSet<String> {
    let mut needed = BTreeSet::from([name.to_owned()]);
    for (file, _) in sources.files() {
        for declaration in outline::declarations(sources, file) {
            let mut words = declaration.name.split([' ', ',']);
            if declaration.kind == outline::Kind::Realize && words.clone().any(|w| w == name) {
                needed.extend(words.by_ref().map(str::to_owned));
                needed.insert(declaration.name.clone());
            }
        }
    }
    needed
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_name_follows_the_last_colons() {
        let parse = |text: &str| {
            let Ok(selection) = text.parse::<Selection>();
            (selection.path, selection.name)
        };
        let name = |n: &str| Some(n.to_owned());
        assert_eq!(parse("a.lw"), ("a.lw".to_owned(), None));
        assert_eq!(parse("a.lw::Turn"), ("a.lw".to_owned(), name("Turn")));
        assert_eq!(parse("x::y/a.lw"), ("x::y/a.lw".to_owned(), None));
        assert_eq!(parse("a.lw::"), ("a.lw::".to_owned(), None));
    }
}
