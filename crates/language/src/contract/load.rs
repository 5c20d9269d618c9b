//! Loading: follows imports, resolves every file in its own scope, and builds the library.

use super::definitions::definitions;
use super::instantiate::{Arguments, instantiate, taxonomy_codes};
use super::recipe::Realization;
use super::scope::Scope;
use super::set::{Changes, Owner, SettableNumber, Settings, Target};
use super::table::Tables;
use super::uses::{self, PossibleUses};
use super::{Library, Loader, lines, machines, recipes, skills};
use crate::order::Skills;
use linewright_core::diagnostics::{Diagnostic, Severity, Spelling, codes};
use linewright_core::source::{FileId, SourceMap, Span};
use linewright_syntax::ast;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

struct File {
    id: FileId,
    tree: ast::File,
    /// The tree as written, if numbers in it were set from outside.
    written: Option<ast::File>,
    /// Indices of the imported files.
    imports: Vec<usize>,
    /// Positions of syntax errors.
    syntax_errors: Vec<Span>,
    /// Whether the caller requested the file; otherwise it is only imported.
    is_requested: bool,
}

impl File {
    /// The tree as written.
    fn written(&self) -> &ast::File {
        self.written.as_ref().unwrap_or(&self.tree)
    }
}

struct Reader<'l> {
    sources: SourceMap,
    files: Vec<File>,
    by_name: BTreeMap<String, usize>,
    loader: &'l Loader<'l>,
    findings: Vec<Diagnostic>,
}

/// Parses and resolves files (name and text) and all their imports. Returns the library of all
/// declarations without errors, and the findings, sorted by position.
pub fn load(files: &[(String, String)], loader: &Loader<'_>) -> (Library, Vec<Diagnostic>) {
    load_with(files, loader, Settings::default())
}

/// Like [`load`], with numbers of one line or layout set from outside.
pub fn load_with(
    files: &[(String, String)],
    loader: &Loader<'_>,
    settings: Settings<'_>,
) -> (Library, Vec<Diagnostic>) {
    let Reader {
        mut sources,
        mut files,
        mut findings,
        ..
    } = Reader::of(files, loader);
    let changes = set(&mut files, settings, &mut sources, &mut findings);
    let tables = read_tables(&files, loader, &mut sources);
    let mut library = Library::default();
    let sets: Vec<Vec<Option<Arc<Skills>>>> = files
        .iter()
        .map(|file| skill_sets(&file.tree, &sources, &mut findings))
        .collect();
    let mut wanted = Vec::new();
    for index in 0..files.len() {
        let mut scope = Scope::with(&changes.variants, &tables);
        let mut own = Vec::new();
        for file in closure(&files, index) {
            scope.add(&files[file].tree, &sets[file], &mut own);
        }
        scope.evaluate(&mut own);
        findings.append(&mut own);
        resolve(&files[index], &scope, &sources, &mut library, &mut findings);
        wanted.extend(realizations(&files[index], &scope, &mut findings));
        add_skill_sets(&files[index].tree, &sets[index], &mut library);
    }
    add_realizations(wanted, &mut library, &mut findings);
    changes.relocate(&mut findings);
    for index in 0..files.len() {
        let mut found = unused(&files, index, &sources, &findings);
        findings.append(&mut found);
    }
    // A suspicious comparison that contains an error is not reported.
    let errors: Vec<Span> = findings
        .iter()
        .filter(|f| f.severity == Severity::Error)
        .filter_map(|f| f.span)
        .collect();
    findings.retain(|f| {
        let is_suspicious = [codes::COMPARISON_DECIDED, codes::NEXT_BOTH_SIDES].contains(&f.code);
        let holds = |span: Span| errors.iter().any(|e| span.contains(*e));
        !(is_suspicious && f.span.is_some_and(holds))
    });
    library.sources = sources;
    library.tables = tables.files();
    let malformed = files.iter().filter(|f| !f.syntax_errors.is_empty());
    library.malformed_files = malformed.map(|f| f.id).collect();
    // The same finding can occur several times, because several files can import its file, or
    // several machines can use its contract. It is reported once.
    let mut seen = BTreeSet::new();
    let mut unique: Vec<Diagnostic> = findings
        .into_iter()
        .filter(|f| seen.insert((f.span, f.code, f.message.clone())))
        .collect();
    unique.sort_by_key(|f| f.span);
    (library, unique)
}

/// Returns the numbers of a line or layout that can be set with [`load_with`]; none if there is no
/// such line or layout.
pub fn settable(
    files: &[(String, String)],
    loader: &Loader<'_>,
    of: Owner,
    name: Option<&str>,
) -> Vec<SettableNumber> {
    let reader = Reader::of(files, loader);
    let Some((index, name)) = owner_to_set(&reader.files, of, name) else {
        return Vec::new();
    };
    target(&reader.files, index, of, name).settable(&reader.sources)
}

/// Sets numbers of a line or layout. If it does not exist, nothing is set: the caller reports it.
fn set(
    files: &mut [File],
    settings: Settings<'_>,
    sources: &mut SourceMap,
    findings: &mut Vec<Diagnostic>,
) -> Changes {
    if settings.list.is_empty() {
        return Changes::default();
    }
    let Some((index, name)) = owner_to_set(files, settings.of, settings.name) else {
        return Changes::default();
    };
    let mut target = target(files, index, settings.of, name);
    let changes = target.apply(settings.list, sources, findings);
    let items = target.items;
    let places = files[index].tree.places.clone();
    let tables = files[index].tree.tables.clone();
    let tree = ast::File {
        items,
        places,
        tables: [tables, changes.tables.clone()].concat(),
    };
    files[index].written = Some(std::mem::replace(&mut files[index].tree, tree));
    changes
}

/// Reads the tables that the files name.
fn read_tables(files: &[File], loader: &Loader<'_>, sources: &mut SourceMap) -> Tables {
    let mut tables = Tables::default();
    for file in files {
        let importer = sources.file(file.id).name.clone();
        for path in &file.tree.tables {
            tables.read(path, &importer, loader, sources);
        }
    }
    tables
}

/// Finds the line or layout with this name, first in the requested files; or else the only one of
/// the requested files. Returns the index of its file, and its name.
fn owner_to_set<'f>(
    files: &'f [File],
    of: Owner,
    name: Option<&str>,
) -> Option<(usize, &'f ast::Name)> {
    let owners = files.iter().enumerate().flat_map(|(index, file)| {
        file.tree
            .items
            .iter()
            .filter_map(move |item| match (item, of) {
                (ast::Item::Line(line), Owner::Line) => Some((index, &line.name)),
                (ast::Item::Layout(layout), Owner::Layout) => Some((index, &layout.name)),
                _ => None,
            })
    });
    let mut requested = owners.clone().filter(|(i, _)| files[*i].is_requested);
    if let Some(name) = name {
        return requested.chain(owners).find(|(_, n)| n.text == name);
    }
    requested.next().filter(|_| requested.next().is_none())
}

/// A line or layout in its file, as [`set::Target`](super::set) needs it.
fn target<'f>(files: &'f [File], index: usize, of: Owner, name: &'f ast::Name) -> Target<'f> {
    let visible = closure(files, index);
    let mut machines = BTreeMap::new();
    for item in visible.iter().flat_map(|file| &files[*file].tree.items) {
        if let ast::Item::Machine(machine) = item {
            let name = machine.header.name.text.as_str();
            machines.entry(name).or_insert(machine);
        }
    }
    Target {
        items: files[index].tree.items.clone(),
        of,
        name,
        machines,
        is_malformed: visible
            .iter()
            .any(|file| !files[*file].syntax_errors.is_empty()),
    }
}

impl<'l> Reader<'l> {
    /// Reads files with all their imports.
    fn of(files: &[(String, String)], loader: &'l Loader<'l>) -> Self {
        let mut reader = Self {
            sources: SourceMap::new(),
            files: Vec::new(),
            by_name: BTreeMap::new(),
            loader,
            findings: Vec::new(),
        };
        for (name, text) in files {
            reader.read(name, text, &mut Vec::new());
        }
        reader
    }

    /// Reads a file and its imports, unless the file has already been read, and returns its index.
    /// `path` is the chain of imports that leads to this file.
    fn read(&mut self, name: &str, text: &str, path: &mut Vec<usize>) -> usize {
        if let Some(index) = self.by_name.get(name) {
            return *index;
        }
        let id = self.sources.add(name, text);
        let (tree, mut found) = linewright_syntax::parse(id, text);
        let errors = found.iter().filter(|f| f.severity == Severity::Error);
        let whole = Span::new(id, 0, text.len());
        let syntax_errors = errors.map(|f| f.span.unwrap_or(whole)).collect();
        self.findings.append(&mut found);
        let index = self.files.len();
        self.by_name.insert(name.to_owned(), index);
        let wanted: Vec<ast::Import> = tree
            .items
            .iter()
            .filter_map(|i| match i {
                ast::Item::Import(i) => Some(i.clone()),
                _ => None,
            })
            .collect();
        self.files.push(File {
            id,
            tree,
            written: None,
            imports: Vec::new(),
            syntax_errors,
            is_requested: path.is_empty(),
        });
        path.push(index);
        for import in wanted {
            if let Some(target) = self.import(name, &import, path) {
                self.files[index].imports.push(target);
            }
        }
        path.pop();
        index
    }

    fn import(&mut self, from: &str, import: &ast::Import, path: &mut Vec<usize>) -> Option<usize> {
        let wanted = if import.dotted {
            if import.path.starts_with("std.") {
                import.path.clone()
            } else {
                self.findings.push(
                    Diagnostic::error(
                        codes::IMPORT_MISSING,
                        import.span,
                        format!("`{}` is not in the bundled library", import.path),
                    )
                    .with_help(
                        "write the name of a bundled file with `std.`, or the path of another file in quotes",
                    ),
                );
                return None;
            }
        } else {
            import.path.clone()
        };
        match (self.loader)(&wanted, from) {
            Ok((name, text)) => {
                if let Some(position) = path
                    .iter()
                    .position(|i| self.sources.file(self.files[*i].id).name == name)
                {
                    let cycle: Vec<String> = path[position..]
                        .iter()
                        .map(|i| self.sources.file(self.files[*i].id).name.clone())
                        .chain([name])
                        .collect();
                    self.findings.push(
                        Diagnostic::error(
                            codes::IMPORT_CIRCULAR,
                            import.span,
                            format!("these files import each other: {}", cycle.join(" -> ")),
                        )
                        .with_help("move the shared declarations to a third file"),
                    );
                    return None;
                }
                Some(self.read(&name, &text, path))
            }
            Err(why) => {
                self.findings.push(
                    Diagnostic::error(
                        codes::IMPORT_MISSING,
                        import.span,
                        format!("cannot import `{}`: {why}", import.path),
                    )
                    .with_help(if import.dotted {
                        "`std.handling.turn` means `handling/turn.lw` in the bundled library; `linewright din coverage` lists its contracts"
                    } else {
                        "write the path relative to the importing file"
                    }),
                );
                None
            }
        }
    }
}

/// Returns the findings for unused declarations of a file.
fn unused(
    files: &[File],
    index: usize,
    sources: &SourceMap,
    findings: &[Diagnostic],
) -> Vec<Diagnostic> {
    let file = &files[index];
    let quoted = |code| {
        let of_code = findings.iter().filter(move |f| f.code == code);
        let spans = of_code.filter_map(|f| f.span);
        spans.map(|span| (sources.text(span), span))
    };
    let unknown = quoted(codes::NAME_UNKNOWN);
    let errors = findings.iter().filter(|f| f.severity == Severity::Error);
    let mut doubt = PossibleUses {
        syntax: file.syntax_errors.clone(),
        unknown: unknown
            .map(|(name, span)| (Spelling::of(name), span))
            .collect(),
        duplicates: quoted(codes::NAME_DUPLICATE).collect(),
        errors: errors.filter_map(|f| f.span).collect(),
    };
    let end = sources.file(file.id).text.len();
    let starts: Vec<usize> = file.written().items.iter().map(start).collect();
    let everything = files.iter().flat_map(|f| &f.written().items);
    let machines: Vec<&ast::Machine> = everything
        .clone()
        .filter_map(|i| match i {
            ast::Item::Machine(m) => Some(m),
            _ => None,
        })
        .collect();
    let contracts: Vec<&ast::Contract> = everything
        .filter_map(|i| match i {
            ast::Item::Contract(c) => Some(c),
            _ => None,
        })
        .collect();
    let mut found = Vec::new();
    for (i, item) in file.written().items.iter().enumerate() {
        // The extent of an item reaches to the next item, because an error between two items can
        // belong to the first of them.
        let next = starts.get(i + 1).copied().unwrap_or(end);
        let extent = Span::new(file.id, starts[i].min(next), next);
        found.extend(match item {
            ast::Item::Contract(c) => uses::contract(c, extent, sources, &doubt),
            ast::Item::Machine(m) => uses::machine(m, &contracts, &machines, extent, &doubt),
            _ => Vec::new(),
        });
    }
    let importers: Vec<usize> = (0..files.len())
        .filter(|other| *other != index && closure(files, *other).contains(&index))
        .collect();
    // A syntax error in an importing file can hide a use, too.
    let hidden = importers
        .iter()
        .any(|i| !files[*i].syntax_errors.is_empty());
    if file.is_requested && !hidden {
        let trees: Vec<&ast::File> = importers.iter().map(|i| files[*i].written()).collect();
        let whole = Span::new(file.id, 0, end);
        for (_, span) in &mut doubt.unknown {
            // An undeclared name in an importing file can be a misspelled use of any declaration in
            // this file.
            let importer = importers.iter().any(|i| files[*i].id == span.file);
            *span = if importer { whole } else { *span };
        }
        found.extend(uses::file(file.written(), &trees, whole, &doubt));
    }
    found
}

/// Returns the offset of an import, or of the name of any other item.
fn start(item: &ast::Item) -> usize {
    let span = match item {
        ast::Item::Import(i) => i.span,
        ast::Item::Type(t) => t.name.span,
        ast::Item::Const(c) => c.name.span,
        ast::Item::Define(d) => d.name.span,
        ast::Item::Contract(c) => c.header.name.span,
        ast::Item::Machine(m) => m.header.name.span,
        ast::Item::Line(l) => l.name.span,
        ast::Item::Skills(s) => s.name.span,
        ast::Item::Layout(l) => l.name.span,
        ast::Item::Recipe(r) => r.name.span,
        ast::Item::Realize(r) => r.recipes.first().map_or(r.layout.span, |r| r.name.span),
    };
    span.start as usize
}

/// Returns a file and all files that it imports directly or indirectly. Imported files come before
/// the files that import them.
fn closure(files: &[File], index: usize) -> Vec<usize> {
    fn visit(files: &[File], index: usize, order: &mut Vec<usize>) {
        if order.contains(&index) {
            return;
        }
        for import in &files[index].imports {
            visit(files, *import, order);
        }
        if !order.contains(&index) {
            order.push(index);
        }
    }
    let mut order = Vec::new();
    visit(files, index, &mut order);
    order
}

/// Resolves the contracts, machines, lines, layouts and recipes of a file, and adds them to the
/// library.
fn resolve(
    file: &File,
    scope: &Scope<'_>,
    sources: &SourceMap,
    library: &mut Library,
    findings: &mut Vec<Diagnostic>,
) {
    let none = Arguments::new();
    for item in &file.tree.items {
        match item {
            ast::Item::Contract(c) => {
                taxonomy_codes(&c.header.codes, findings);
                match instantiate(scope, sources, c, &none, None, findings) {
                    Some(contract) => {
                        let used = definitions(scope, sources, c);
                        library.definitions.insert(contract.span, used);
                        library.contracts.push(contract);
                    }
                    None => library.refused_contracts.push(refused(&c.header)),
                }
            }
            ast::Item::Machine(m) => {
                taxonomy_codes(&m.header.codes, findings);
                match machines::machine(scope, sources, m, &none, None, findings) {
                    Some(machine) => library.machines.push(machine),
                    None => library.refused_machines.push(refused(&m.header)),
                }
            }
            ast::Item::Line(l) => match lines::line(scope, sources, l, findings) {
                Some(line) => library.lines.push(line),
                None => library
                    .refused_lines
                    .push((l.name.text.clone(), l.name.span)),
            },
            ast::Item::Layout(l) => match recipes::layout(scope, l, findings) {
                Some(layout) => library.layouts.push(layout),
                None => library
                    .refused_layouts
                    .push((l.name.text.clone(), l.name.span)),
            },
            ast::Item::Recipe(r) => match recipes::recipe(r, findings) {
                Some(recipe) => library.recipes.push(recipe),
                None => library
                    .refused_recipes
                    .push((r.name.text.clone(), r.name.span)),
            },
            _ => {}
        }
    }
}

/// Resolves the statements `realize` of a file, whose names have to be in scope.
fn realizations(
    file: &File,
    scope: &Scope<'_>,
    findings: &mut Vec<Diagnostic>,
) -> Vec<Realization> {
    let declared = file.tree.items.iter().filter_map(|item| match item {
        ast::Item::Realize(decl) => recipes::realize(scope, decl, findings),
        _ => None,
    });
    declared.collect()
}

/// Adds what is to be made to the library, and reports what does not fit. All files must be
/// resolved.
fn add_realizations(
    wanted: Vec<Realization>,
    library: &mut Library,
    findings: &mut Vec<Diagnostic>,
) {
    for realization in wanted {
        let Some(layout) = library.layout_at(realization.layout_declared) else {
            continue;
        };
        let mut found = Vec::new();
        let mut is_complete = true;
        for wanted in &realization.recipes {
            match library.recipe_at(wanted.declared) {
                Some(recipe) => recipes::report_misfits(recipe, layout, &mut found),
                None => is_complete = false,
            }
        }
        let fits = is_complete && found.is_empty();
        findings.append(&mut found);
        library.realizations.extend(fits.then_some(realization));
    }
}

/// Resolves a file's skill sets, in order; `None` for a set with errors.
fn skill_sets(
    tree: &ast::File,
    sources: &SourceMap,
    findings: &mut Vec<Diagnostic>,
) -> Vec<Option<Arc<Skills>>> {
    let declared = tree.items.iter().filter_map(|item| match item {
        ast::Item::Skills(set) => Some(skills::skills(set, sources, findings)),
        _ => None,
    });
    declared.collect()
}

/// Adds a file's skill sets to the library.
fn add_skill_sets(tree: &ast::File, sets: &[Option<Arc<Skills>>], library: &mut Library) {
    let declared = tree.items.iter().filter_map(|item| match item {
        ast::Item::Skills(set) => Some(&set.name),
        _ => None,
    });
    for (name, set) in declared.zip(sets) {
        match set {
            Some(set) => library.skills.push(Arc::clone(set)),
            None => library.refused_skills.push((name.text.clone(), name.span)),
        }
    }
}

fn refused(header: &ast::Header) -> (String, Span) {
    (header.name.text.clone(), header.name.span)
}
