//! Finds and reads source files: command-line paths, imports, and the bundled library.
//!
//! The resolver identifies files by name, so a file that is reached by several paths gets a single
//! name (`Names`). Names are normalized paths (`a/../b.lw` becomes `b.lw`). Names of library files
//! begin with `std/`.
//!
//! Files of other tools are recognized by their extension. They are read only when named
//! explicitly; in a folder, only `.lw` files are found.

use include_dir::{Dir, include_dir};
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::source::{FileId, Span};
use linewright_interchange::{self as interchange, Format, Reading};
use linewright_language::contract::set::{Owner, SettableNumber, Settings};
use linewright_language::contract::{self, Contract, Library};
use linewright_station::disk;
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

static BUNDLED: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/../../contracts");

/// Folder that is loaded if no path is given.
const DEFAULT_FOLDER: &str = "contracts";

/// The library behind `import std...`: the bundled one, or a folder that replaces it.
#[derive(Debug, Clone, Default)]
pub struct StandardLibrary {
    folder: Option<PathBuf>,
}

impl StandardLibrary {
    /// Uses the library in `folder`, or the bundled one if `folder` is `None`.
    pub fn new(folder: Option<PathBuf>) -> Self {
        Self { folder }
    }

    /// Reads a file by its library path, such as `handling/turn.lw`.
    fn read(&self, path: &str) -> Result<String, String> {
        match &self.folder {
            Some(folder) => read(&folder.join(path)),
            None => BUNDLED
                .get_file(path)
                .and_then(|f| f.contents_utf8())
                .map(str::to_owned)
                .ok_or_else(|| format!("the bundled library has no {path}")),
        }
    }

    /// Paths of all `.lw` files of the library in alphabetical order, with a finding for each
    /// folder that cannot be read.
    fn paths(&self) -> (Vec<String>, Vec<Diagnostic>) {
        let (mut paths, mut findings) = (Vec::new(), Vec::new());
        match &self.folder {
            Some(folder) => {
                let found = search(folder);
                for file in &found.files {
                    let inner = file.strip_prefix(folder).unwrap_or(file);
                    paths.push(shown(inner));
                }
                findings.extend(found.unreadable.iter().map(|(n, why)| unreadable(n, why)));
            }
            None => embedded(&BUNDLED, &mut paths),
        }
        paths.sort();
        (paths, findings)
    }

    /// Names and texts of all files of the library, with a finding for each file or folder that
    /// cannot be read.
    fn files(&self) -> (Vec<(String, String)>, Vec<Diagnostic>) {
        let (paths, mut findings) = self.paths();
        let mut files = Vec::new();
        for path in paths {
            match self.read(&path) {
                Ok(text) => files.push((format!("std/{path}"), text)),
                Err(why) => findings.push(unreadable(&path, &why)),
            }
        }
        (files, findings)
    }

    /// Reads the target of an `import`: `std.handling.turn`, or a path relative to the importing
    /// file. Returns its name and text.
    fn import(&self, path: &str, importer: &str) -> Result<(String, String), String> {
        let name = imported_name(path, importer);
        // A library file imports its neighbors from the library.
        let within = library_path(path).is_some() || importer.starts_with("std/");
        let text = match name.strip_prefix("std/").filter(|_| within) {
            Some(inner) => self.read(inner)?,
            None => read(Path::new(&name))?,
        };
        Ok((name, text))
    }

    /// Path on disk of the file with this name. A file of the bundled library has none; its name is
    /// returned unchanged.
    pub fn disk_path(&self, name: &str) -> PathBuf {
        match (&self.folder, name.strip_prefix("std/")) {
            (Some(folder), Some(inner)) => folder.join(inner),
            _ => PathBuf::from(name),
        }
    }
}

/// Maps each canonical path on disk to the name by which the file was first reached: in the working
/// directory `a`, the path `../a/b.lw` and links to the file also get the name `b.lw`.
#[derive(Debug, Default)]
struct Names(BTreeMap<PathBuf, String>);

impl Names {
    /// Returns the unique name of the file that was reached as `name`.
    fn of(&mut self, name: String, standard: &StandardLibrary) -> String {
        if standard.folder.is_none() && name.starts_with("std/") {
            return name;
        }
        match std::fs::canonicalize(standard.disk_path(&name)) {
            Ok(place) => self.0.entry(place).or_insert(name).clone(),
            Err(_) => name,
        }
    }
}

/// Name of the file that an `import` refers to.
fn imported_name(path: &str, importer: &str) -> String {
    if let Some(inner) = library_path(path) {
        return format!("std/{inner}");
    }
    let folder = Path::new(importer).parent().unwrap_or(Path::new(""));
    clean(&folder.join(path))
}

/// Result of loading files.
#[derive(Debug, Default)]
pub struct LoadedFiles {
    /// Declarations of all files.
    pub library: Library,
    /// Findings of reading, parsing and resolving.
    pub findings: Vec<Diagnostic>,
    /// Names of the files that were requested; all others were imported.
    pub roots: Vec<String>,
    /// Requested paths that could not be read.
    pub unreadable: Vec<String>,
    /// Names of imported files that could not be read.
    pub missing: Vec<String>,
    /// Canonical paths of the files on disk, which results must not overwrite.
    pub places: BTreeSet<PathBuf>,
    /// Specifications of other tools. Those that could be read are also in the library, as
    /// contracts.
    pub foreign: Vec<Foreign>,
}

/// A file of another tool.
#[derive(Debug)]
pub struct Foreign {
    /// The file it was read from.
    pub file: FileId,
    /// File name without folder and extension; also the contract's name.
    pub name: String,
    /// Result of reading the file.
    pub reading: Reading,
}

impl LoadedFiles {
    /// Returns the other tool's specification in a file, if the file has one.
    pub fn foreign(&self, file: FileId) -> Option<&Foreign> {
        self.foreign.iter().find(|f| f.file == file)
    }

    /// Whether some file of another tool yielded no specification, because of an error of any kind.
    pub fn has_invalid_foreign(&self) -> bool {
        let mut foreign = self.foreign.iter();
        foreign.any(|f| f.reading.specification.is_none())
    }

    /// Reads another tool's file with its imports, and adds its specification as a contract.
    fn add_foreign(
        &mut self,
        format: Format,
        path: &str,
        text: String,
        names: &mut Names,
        standard: &StandardLibrary,
    ) {
        let stem = Path::new(path).file_stem().unwrap_or_default();
        let name = stem.to_string_lossy().into_owned();
        let text: Arc<str> = text.into();
        let file = self.library.sources.add(path, Arc::clone(&text));
        let Self {
            library, missing, ..
        } = self;
        let mut known = BTreeMap::from([(path.to_owned(), file)]);
        let reading =
            interchange::read_with(format, &name, file, &text, &mut |wanted, importer| {
                let sources = &mut library.sources;
                let folder = Path::new(&sources.file(importer).name).parent();
                let wanted = wanted.replace('\\', "/");
                let name = clean(&folder.unwrap_or(Path::new("")).join(wanted));
                let name = names.of(name, standard);
                if let Some(id) = known.get(&name) {
                    return Ok((*id, Arc::clone(&sources.file(*id).text)));
                }
                let text: Arc<str> = match read(Path::new(&name)) {
                    Ok(text) => text.into(),
                    Err(why) => {
                        missing.push(name);
                        return Err(why);
                    }
                };
                let id = sources.add(name.as_str(), Arc::clone(&text));
                known.insert(name, id);
                Ok((id, text))
            });
        self.findings.extend(reading.findings.iter().cloned());
        if let Some(specification) = &reading.specification {
            self.library.contracts.push(Contract {
                name: name.clone(),
                doc: String::new(),
                codes: Vec::new(),
                arguments: Vec::new(),
                specification: Arc::new(specification.clone()),
                span: Span {
                    end: reading.span.start,
                    ..reading.span
                },
            });
        }
        self.foreign.push(Foreign {
            file,
            name,
            reading,
        });
    }
}

/// Loads files and folders with everything they import. Without a path, loads `./contracts`, or
/// else the whole bundled library.
pub fn load(paths: &[String], standard: &StandardLibrary) -> LoadedFiles {
    load_with(paths, standard, Settings::default())
}

/// Like [`load`], with numbers of one line or layout set from outside of its file.
pub fn load_with(
    paths: &[String],
    standard: &StandardLibrary,
    settings: Settings<'_>,
) -> LoadedFiles {
    let mut loaded = LoadedFiles::default();
    let mut files: Vec<(String, String)> = Vec::new();
    let mut names = Names::default();
    let paths = or_default(paths, standard);
    if paths.is_empty() {
        (files, loaded.findings) = standard.files();
        for (name, _) in &files {
            names.of(name.clone(), standard);
        }
    }
    for path in &paths {
        for found in collect(path, standard) {
            match found {
                Ok((name, text)) => {
                    let name = names.of(name, standard);
                    if files.iter().all(|f| f.0 != name) {
                        files.push((name, text));
                    }
                }
                Err((name, why)) => {
                    loaded.findings.push(unreadable(&name, &why));
                    loaded.unreadable.push(name);
                }
            }
        }
    }
    loaded.roots = files.iter().map(|f| f.0.clone()).collect();
    let (foreign, own): (Vec<_>, Vec<_>) = files
        .into_iter()
        .partition(|(name, _)| Format::from_path(name).is_some());
    let (missing, names) = (RefCell::new(Vec::new()), RefCell::new(names));
    let loader = |path: &str, importer: &str| {
        let read = standard.import(path, importer);
        if read.is_err() {
            missing.borrow_mut().push(imported_name(path, importer));
        }
        let (name, text) = read?;
        Ok((names.borrow_mut().of(name, standard), text))
    };
    let (library, findings) = contract::load_with(&own, &loader, settings);
    loaded.missing = missing.into_inner();
    let mut names = names.into_inner();
    loaded.library = library;
    loaded.findings.extend(findings);
    for (name, text) in foreign {
        if let Some(format) = Format::from_path(&name) {
            loaded.add_foreign(format, &name, text, &mut names, standard);
        }
    }
    loaded.places = names.0.into_keys().collect();
    loaded
}

/// Returns the numbers of a line or layout that can be set; see [`contract::settable`].
///
/// # Errors
/// Returns the reason if the file cannot be read.
pub fn settable(
    path: &str,
    standard: &StandardLibrary,
    of: Owner,
    owner: Option<&str>,
) -> Result<Vec<SettableNumber>, String> {
    let name = clean(Path::new(path));
    let text = read(Path::new(path))?;
    let loader = |path: &str, importer: &str| standard.import(path, importer);
    Ok(contract::settable(&[(name, text)], &loader, of, owner))
}

/// Returns the given paths, or the default folder if there are none. An empty result stands for the
/// whole library.
fn or_default(paths: &[String], standard: &StandardLibrary) -> Vec<String> {
    if paths.is_empty() && standard.folder.is_none() && Path::new(DEFAULT_FOLDER).is_dir() {
        return vec![DEFAULT_FOLDER.to_owned()];
    }
    paths.to_vec()
}

/// Folders and files on disk that a command with these arguments depends on. The files are those in
/// the folders and those among the arguments, even if they do not exist. Imports are not included.
pub fn watched_paths(paths: &[String], standard: &StandardLibrary) -> (Vec<PathBuf>, Vec<PathBuf>) {
    let (mut folders, mut files) = (Vec::new(), Vec::new());
    let paths = or_default(paths, standard);
    folders.extend(standard.folder.clone().filter(|_| paths.is_empty()));
    for path in paths {
        let place = PathBuf::from(&path);
        if place.is_dir() {
            folders.push(place);
        } else {
            let inner = library_path(&path).filter(|_| !place.exists());
            files.push(inner.map_or(place, |inner| standard.disk_path(&format!("std/{inner}"))));
        }
    }
    for folder in &folders {
        files.extend(search(folder).files);
    }
    (folders, files)
}

type Resolution = Result<(String, String), (String, String)>;

/// Name and text of a file, or the finding that it cannot be read.
pub type Read = Result<(String, String), Diagnostic>;

/// Reads the given files, and every `.lw` file below the given folders. Each file is returned once.
pub fn read_all(paths: &[String]) -> Vec<Read> {
    let mut files: Vec<Read> = Vec::new();
    for path in paths {
        let place = Path::new(path);
        for file in within(place) {
            let file = file.map_err(|(name, why)| unreadable(&name, &why));
            let known = |f: &Read| matches!((f, &file), (Ok(a), Ok(b)) if a.0 == b.0);
            if !files.iter().any(known) {
                files.push(file);
            }
        }
    }
    files
}

/// Reads the files of one path: a file, every `.lw` file below a folder, or a library file.
fn collect(path: &str, standard: &StandardLibrary) -> Vec<Resolution> {
    let place = Path::new(path);
    if !place.exists()
        && let Some(inner) = library_path(path)
    {
        let name = format!("std/{inner}");
        return vec![match standard.read(&inner) {
            Ok(text) => Ok((name, text)),
            Err(why) => Err((name, why)),
        }];
    }
    within(place)
}

/// Reads a file, or every `.lw` file below a folder; the result is never empty.
fn within(place: &Path) -> Vec<Resolution> {
    if !place.is_dir() {
        return vec![read_named(place)];
    }
    let found = search(place);
    let mut all: Vec<Resolution> = found.files.iter().map(|f| read_named(f)).collect();
    all.extend(found.unreadable.into_iter().map(Err));
    if all.is_empty() {
        all.push(Err((shown(place), "it contains no .lw file".to_owned())));
    }
    all
}

/// Returns whether a file is taken for a B2MML document: its name ends with `.xml`.
pub fn is_document(path: &Path) -> bool {
    let extension = path.extension();
    extension.is_some_and(|e| e.eq_ignore_ascii_case("xml"))
}

fn read_named(path: &Path) -> Resolution {
    let name = clean(path);
    if is_document(path) && path.is_file() {
        let why = "B2MML is not read here, but `linewright import` converts it to a .lw file";
        return Err((name, why.to_owned()));
    }
    match read(path) {
        Ok(text) => Ok((name, text)),
        Err(why) => Err((name, why)),
    }
}

/// Converts `std.handling.turn` to a path in the library: `handling/turn.lw`.
fn library_path(name: &str) -> Option<String> {
    let inner = name.strip_prefix("std.")?;
    let plain = inner.split('.').all(|part| {
        !part.is_empty()
            && part
                .chars()
                .all(|c| c.is_alphanumeric() || "_-".contains(c))
    });
    let ending = inner.rsplit('.').next() == Some("lw");
    (plain && !ending).then(|| format!("{}.lw", inner.replace('.', "/")))
}

/// Contents of a folder tree.
#[derive(Debug, Default)]
struct Search {
    /// All `.lw` files in alphabetical order.
    files: Vec<PathBuf>,
    /// Folders that cannot be read, in alphabetical order, with the reason.
    unreadable: Vec<(String, String)>,
}

/// Searches a folder tree for `.lw` files. Skips folders whose name begins with a dot, and symbolic
/// links to folders, which can form cycles.
fn search(folder: &Path) -> Search {
    let mut found = Search::default();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        if let Err(error) = found.look_into(&folder, &mut folders) {
            found.unreadable.push((shown(&folder), describe(&error)));
        }
    }
    found.files.sort();
    found.unreadable.sort();
    found
}

impl Search {
    fn look_into(&mut self, folder: &Path, folders: &mut Vec<PathBuf>) -> std::io::Result<()> {
        for entry in std::fs::read_dir(folder)? {
            let entry = entry?;
            let (path, kind) = (entry.path(), entry.file_type()?);
            // Anything with this extension is included, even folders; reading reports those.
            if path.extension().is_some_and(|e| e == "lw") {
                self.files.push(path);
            } else if kind.is_dir() && !entry.file_name().to_string_lossy().starts_with('.') {
                folders.push(path);
            }
        }
        Ok(())
    }
}

fn embedded(folder: &Dir<'_>, paths: &mut Vec<String>) {
    for file in folder.files() {
        if file.path().extension().is_some_and(|e| e == "lw") {
            paths.push(shown(file.path()));
        }
    }
    for inner in folder.dirs() {
        embedded(inner, paths);
    }
}

/// Reads the text of a regular file, or explains why it cannot be read.
pub fn read(path: &Path) -> Result<String, String> {
    let bytes = disk::read(path).map_err(|e| describe(&e))?;
    if let Some(offset) = bytes.iter().position(|byte| *byte == 0) {
        return Err(format!("it is not a text file: byte {offset} is zero"));
    }
    String::from_utf8(bytes).map_err(|_| "it is not a UTF-8 text file".to_owned())
}

/// Checks that a path leads to a regular file.
///
/// # Errors
/// Describes why it is not a regular file, or why this cannot be determined.
pub fn is_regular(path: &Path) -> Result<(), String> {
    disk::is_regular(path).map_err(|e| describe(&e))
}

pub(crate) fn describe(error: &std::io::Error) -> String {
    match error.kind() {
        std::io::ErrorKind::NotFound => "there is no such file".to_owned(),
        std::io::ErrorKind::PermissionDenied => "permission denied".to_owned(),
        std::io::ErrorKind::IsADirectory => "it is a folder".to_owned(),
        _ => error.to_string(),
    }
}

fn unreadable(name: &str, why: &str) -> Diagnostic {
    Diagnostic::error(
        codes::FILE_UNREADABLE,
        None,
        format!("{name} cannot be read: {why}"),
    )
    .with_help("give the path of a .lw file (`check` and `synth` also read .spc, .slugsin, .structuredslugs, .spectra and .tlsf files), or of a folder that contains .lw files")
}

/// Normalizes a path: removes `.`, and `..` where possible; uses slashes only. `..` after a
/// symbolic link is kept, since the parent of the link's target is not the preceding component.
fn clean(path: &Path) -> String {
    use std::path::Component;
    let mut parts = PathBuf::new();
    for component in path.components() {
        match component {
            Component::CurDir => {}
            Component::ParentDir
                if matches!(parts.components().next_back(), Some(Component::Normal(_)))
                    && !parts.is_symlink() =>
            {
                parts.pop();
            }
            other => parts.push(other),
        }
    }
    shown(&parts)
}

/// A path as shown in findings, with slashes.
pub fn shown(path: &Path) -> String {
    path.to_string_lossy()
        .replace(std::path::MAIN_SEPARATOR, "/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_cleaned() {
        for (path, wanted) in [
            ("./a.lw", "a.lw"),
            ("x/../a.lw", "a.lw"),
            ("../a.lw", "../a.lw"),
            ("../../x/./a.lw", "../../x/a.lw"),
            ("/x/../a.lw", "/a.lw"),
        ] {
            assert_eq!(clean(Path::new(path)), wanted);
        }
    }

    #[test]
    fn library_names_are_distinguished_from_paths() {
        assert_eq!(
            library_path("std.handling.turn").as_deref(),
            Some("handling/turn.lw")
        );
        for path in [
            "std",
            "std.",
            "std..turn",
            "std.turn.lw",
            "turn.lw",
            "std.a/../b",
        ] {
            assert_eq!(library_path(path), None, "{path}");
        }
    }

    #[test]
    fn imports_are_relative_to_the_importing_file() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir(at("sub")).unwrap();
        std::fs::write(at("a.lw"), "text of a").unwrap();
        let importer = shown(&at("sub/b.lw"));
        let standard = StandardLibrary::default();
        let (name, text) = standard.import("../a.lw", &importer).unwrap();
        assert_eq!((name, text.as_str()), (shown(&at("a.lw")), "text of a"));
        assert_eq!(
            standard.import("c.lw", &importer).unwrap_err(),
            "there is no such file"
        );
    }

    #[test]
    fn a_folder_replaces_the_library() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("handling")).unwrap();
        std::fs::write(folder.path().join("handling/turn.lw"), "own").unwrap();
        let standard = StandardLibrary::new(Some(folder.path().to_owned()));
        let imported = standard.import("std.handling.turn", "x.lw").unwrap();
        assert_eq!(
            imported,
            ("std/handling/turn.lw".to_owned(), "own".to_owned())
        );
        assert_eq!(
            standard.import("turn.lw", "std/handling/pick.lw").unwrap(),
            imported
        );
        assert_eq!(standard.paths().0, ["handling/turn.lw"]);
    }
}
