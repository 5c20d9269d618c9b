//! B2MML documents as text of the language.
//!
//! ```text
//! documents ─b2mml::read→ layouts, recipes ─contract::recipe_tree→ ast::File ─syntax::format→ text
//! ```

use crate::files::describe;
use crate::internal::Fault;
use linewright_b2mml::{self as b2mml, Document, Finding, Findings, NoSequence, Rule, Schedule};
use linewright_core::diagnostics::{Diagnostic, codes, has_errors};
use linewright_core::source::{FileId, SourceMap, Span};
use linewright_language::contract::recipe_tree::{
    RecipeTree, Unwritable, tree, unwritable_in_layout, unwritable_in_recipe,
};
use linewright_recipe::model::{Layout, Recipe};
use linewright_station::disk;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// What several documents say together.
#[derive(Debug, Default)]
pub struct Imported {
    /// The documents.
    pub sources: SourceMap,
    /// What is wrong with them, and what was left out.
    pub findings: Vec<Diagnostic>,
    /// Their layouts and recipes as text, with a statement `realize` for each recipe if there is
    /// one layout. `None` if a finding is an error.
    pub text: Option<String>,
    /// Canonical paths of the documents, which results must not overwrite.
    pub places: BTreeSet<PathBuf>,
}

/// Reads documents from disk and converts them. A document that is given twice counts once.
pub fn import(paths: &[String]) -> Imported {
    let mut files = Vec::new();
    let mut findings = Vec::new();
    let mut places = BTreeSet::new();
    for path in paths {
        match disk::read(Path::new(path)) {
            Ok(bytes) => {
                let place = std::fs::canonicalize(path);
                if place.map_or(true, |place| places.insert(place)) {
                    files.push((path.clone(), bytes));
                }
            }
            Err(error) => {
                let message = format!("{path} cannot be read: {}", describe(&error));
                let finding = Diagnostic::error(codes::FILE_UNREADABLE, None, message);
                findings.push(finding.with_help("give the paths of B2MML documents"));
            }
        }
    }
    let mut imported = convert(&files);
    if !findings.is_empty() {
        imported.text = None;
    }
    findings.append(&mut imported.findings);
    Imported {
        findings,
        places,
        ..imported
    }
}

/// Converts documents, given as names and contents.
pub fn convert(files: &[(String, Vec<u8>)]) -> Imported {
    let mut importer = Importer::default();
    let mut schedules = Vec::new();
    for (name, bytes) in files {
        let text = String::from_utf8_lossy(bytes);
        let text = text.trim_start_matches('\u{feff}');
        let file = importer.sources.add(name.as_str(), text);
        match b2mml::read(bytes) {
            Ok(reading) => {
                importer.add_notes(file, &reading.notes);
                match reading.document {
                    Document::Layouts(layouts) => importer.add_layouts(file, layouts),
                    Document::Recipes(recipes) => importer.add_recipes(file, recipes),
                    Document::Schedule(schedule) => schedules.push((file, schedule)),
                    Document::Performance(performance) => {
                        let message = format!(
                            "this OperationsPerformance says what the run {} did; it has no layout and no recipe",
                            quoted(&performance.name)
                        );
                        let help = "give the OperationsDefinition that was carried out";
                        importer.refuse(file, message, help);
                    }
                }
            }
            Err(findings) => importer.add_findings(file, &findings),
        }
    }
    for (file, schedule) in schedules {
        importer.add_schedule(file, schedule);
    }
    importer.finish(files)
}

#[derive(Default)]
struct Importer {
    sources: SourceMap,
    findings: Vec<Diagnostic>,
    layouts: Vec<Layout>,
    recipes: Vec<Recipe>,
}

impl Importer {
    fn add_findings(&mut self, file: FileId, findings: &Findings) {
        for finding in &findings.list {
            let message = format!("{}: {}", finding.rule.name(), finding.message);
            let found = Diagnostic::error(codes::DOCUMENT, self.place(file, finding), message);
            self.findings.push(found.with_help(help(finding.rule)));
        }
        if findings.omitted > 0 {
            let message = format!("there are {} more findings", findings.omitted);
            self.refuse(
                file,
                message,
                "repair those that are listed, then try again",
            );
        }
    }

    /// Adds a note for each kind of elements that were left out, at the first of them.
    fn add_notes(&mut self, file: FileId, notes: &Findings) {
        let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
        for note in &notes.list {
            *counts.entry(&note.message).or_default() += 1;
        }
        for note in &notes.list {
            let Some(count) = counts.remove(note.message.as_str()) else {
                continue;
            };
            let message = match count {
                1 => note.message.clone(),
                count => format!("{}, here and in {} other places", note.message, count - 1),
            };
            self.note(self.place(file, note), message);
        }
    }

    fn note(&mut self, place: Span, message: String) {
        let note = Diagnostic::note(codes::DOCUMENT_LEFT_OUT, place, message);
        let help =
            "layouts and recipes have nothing like it; look whether it matters for the order";
        self.findings.push(note.with_help(help));
    }

    fn refuse(&mut self, file: FileId, message: String, help: &str) {
        let finding = Diagnostic::error(codes::DOCUMENT, self.root(file), message);
        self.findings.push(finding.with_help(help));
    }

    fn refuse_all(&mut self, file: FileId, unwritable: Vec<Unwritable>) {
        for Unwritable { message, help } in unwritable {
            self.refuse(file, message, &help);
        }
    }

    fn add_layouts(&mut self, file: FileId, layouts: Vec<Layout>) {
        for layout in layouts {
            self.refuse_all(file, unwritable_in_layout(&layout));
            if !self.layouts.contains(&layout) {
                self.layouts.push(layout);
            }
        }
    }

    fn add_recipes(&mut self, file: FileId, recipes: Vec<Recipe>) {
        for recipe in recipes {
            self.refuse_all(file, unwritable_in_recipe(&recipe));
            if !self.recipes.contains(&recipe) {
                self.recipes.push(recipe);
            }
        }
    }

    /// Adds the recipes that a schedule carries out, except those that are defined by a document.
    fn add_schedule(&mut self, file: FileId, mut schedule: Schedule) {
        let defined: BTreeSet<&str> = self.recipes.iter().map(|r| r.name.as_str()).collect();
        let all = schedule.requests.len();
        schedule
            .requests
            .retain(|r| !defined.contains(r.recipe.as_str()));
        if schedule.requests.len() < all {
            let message = "the order of this schedule is left out, since its recipe is defined";
            self.note(self.root(file), message.to_owned());
        }
        match schedule.recipes() {
            Ok(recipes) if recipes.is_empty() && schedule.requests.len() == all => {
                let message = "this OperationsSchedule has no operations";
                let help = "give the OperationsDefinition of its recipe";
                self.refuse(file, message.to_owned(), help);
            }
            Ok(recipes) => self.add_recipes(file, recipes),
            Err(reason) => {
                let help = match &reason {
                    NoSequence::Choices(_) => "give that document, too, or in place of this one",
                    NoSequence::Types(_) => "give each part one MaterialDefinitionID",
                };
                self.refuse(file, reason.to_string(), help);
            }
        }
    }

    fn finish(mut self, files: &[(String, Vec<u8>)]) -> Imported {
        let mut text = None;
        if !has_errors(&self.findings) {
            let tree = tree(&self.layouts, &self.recipes);
            match tree.text(&comments(files, &tree)) {
                Ok(written) => text = Some(written),
                Err(error) => {
                    let doing = "writing imported layouts and recipes".to_owned();
                    let fault = Fault::detected(doing, error.to_string());
                    self.findings.push(fault.finding(None));
                }
            }
        }
        Imported {
            sources: self.sources,
            findings: self.findings,
            text,
            places: BTreeSet::new(),
        }
    }

    /// The place of a finding: a tag without its attributes, or else a character.
    fn place(&self, file: FileId, finding: &Finding) -> Span {
        let rest = self.sources.file(file).text.get(finding.offset..);
        tag(file, finding.offset, rest.unwrap_or_default())
    }

    /// The place of the root of a document.
    fn root(&self, file: FileId) -> Span {
        let text = &self.sources.file(file).text;
        let is_name = |at: &usize| text[at + 1..].starts_with(|c: char| c.is_alphabetic());
        let mut tags = text.match_indices('<').map(|(at, _)| at);
        let at = tags.find(is_name).unwrap_or(0);
        tag(file, at, &text[at..])
    }
}

fn tag(file: FileId, at: usize, rest: &str) -> Span {
    let length = match rest.strip_prefix('<') {
        Some(inner) => {
            let is_end = |c: char| c.is_whitespace() || matches!(c, '>' | '/' | '<');
            1 + inner.find(is_end).unwrap_or(inner.len())
        }
        None => rest.chars().next().map_or(0, char::len_utf8),
    };
    Span::new(file, at, at + length)
}

/// What to do about a broken rule.
fn help(rule: Rule) -> &'static str {
    match rule {
        Rule::Encoding => "save the document as UTF-8",
        Rule::Syntax => "correct it in an editor for XML",
        Rule::DocumentType => "remove the declaration `<!DOCTYPE ...>`, and write entities as text",
        Rule::Version => "export the document as B2MML 7.0",
        Rule::Root => "give a document with one of these roots",
        Rule::Structure | Rule::Attribute | Rule::Value => {
            "correct it as the schemas of B2MML 7.0.1 say"
        }
        Rule::Size => "divide it into several documents",
        Rule::Meaning | Rule::Reference | Rule::LeftOut => {
            "docs/reference/b2mml.md lists what is read, and how"
        }
    }
}

fn quoted(name: &str) -> String {
    format!("`{}`", b2mml::encode(name))
}

/// The comments of a text: which documents it was imported from, and what was renamed.
fn comments(files: &[(String, Vec<u8>)], tree: &RecipeTree) -> Vec<String> {
    let names = files.iter().map(|(path, _)| {
        let name = Path::new(path).file_name().unwrap_or_default();
        b2mml::encode(&name.to_string_lossy())
    });
    let names: Vec<String> = names.collect();
    let mut comments = vec![format!("Imported from {}, in B2MML.", names.join(", "))];
    for (name, word) in &tree.renamed {
        comments.push(format!("renamed: {} is {word} here", b2mml::encode(name)));
    }
    comments
}
