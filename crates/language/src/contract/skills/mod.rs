//! Resolution of a set of skills to [`order::Skills`](Skills): components, their situations, the
//! effect of each skill.
//!
//! A set is independent of the file around it, so it is resolved once and shared by every machine
//! that calls its skills. Orders may mention components that are declared after them.

mod regex;
mod rules;

use super::scope::double;
use crate::order::{Component, Level, MOST_SKILLS, Skill, Skills};
use linewright_core::diagnostics::{Code, Diagnostic, codes, has_errors, nearest};
use linewright_core::source::{SourceMap, Span};
use linewright_syntax::ast::{self, SkillItem};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Maximum number of names listed in one message.
const MOST_LISTED: usize = 12;
/// Maximum number of names compared with an unknown one.
const MOST_COMPARED: usize = 4 * MOST_SKILLS;

struct Resolver<'a> {
    set: &'a ast::SkillSet,
    sources: &'a SourceMap,
    components: Vec<Component>,
    skills: Vec<Skill>,
    component_index: BTreeMap<&'a str, usize>,
    skill_index: BTreeMap<&'a str, usize>,
    findings: Vec<Diagnostic>,
    /// Whether something is missing that was reported elsewhere.
    tainted: bool,
}

/// Resolves a set of skills. `None` if there is an error; the findings give it.
pub(super) fn skills(
    set: &ast::SkillSet,
    sources: &SourceMap,
    findings: &mut Vec<Diagnostic>,
) -> Option<Arc<Skills>> {
    let mut resolver = Resolver {
        set,
        sources,
        components: Vec::new(),
        skills: Vec::new(),
        component_index: BTreeMap::new(),
        skill_index: BTreeMap::new(),
        findings: Vec::new(),
        tainted: set.broken,
    };
    for item in &set.items {
        if let SkillItem::Component(component) = item {
            resolver.component(component);
        }
    }
    resolver.count();
    let rules = resolver.rules();
    let sound = !resolver.tainted && !has_errors(&resolver.findings);
    findings.append(&mut resolver.findings);
    sound.then(|| {
        Arc::new(Skills {
            name: set.name.text.clone(),
            doc: set.doc.clone(),
            components: resolver.components,
            skills: resolver.skills,
            rules,
            span: set.name.span,
        })
    })
}

impl<'a> Resolver<'a> {
    fn error(
        &mut self,
        code: Code,
        span: Span,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        self.findings
            .push(Diagnostic::error(code, span, message).with_help(help));
    }

    fn component(&mut self, decl: &'a ast::SkillComponent) {
        let index = self.components.len();
        match self.component_index.get(decl.name.text.as_str()) {
            Some(first) => {
                let first = self.components[*first].span;
                self.findings.push(double(&decl.name, first));
            }
            None => {
                self.component_index.insert(&decl.name.text, index);
            }
        }
        let mut labels: BTreeMap<&str, Span> = BTreeMap::new();
        for label in &decl.situations {
            if let Some(first) = labels.insert(&label.text, label.span) {
                self.findings.push(double(label, first));
            }
        }
        if decl.initial.is_none() {
            self.no_initial(decl);
        }
        let initial = decl
            .initial
            .as_ref()
            .and_then(|i| self.situation_of(decl, i));
        self.components.push(Component {
            name: decl.name.text.clone(),
            doc: decl.doc.clone(),
            situations: decl.situations.iter().map(|s| s.text.clone()).collect(),
            initial: initial.unwrap_or(0),
            span: decl.name.span,
        });
        for skill in &decl.skills {
            self.skill(decl, index, skill);
        }
    }

    fn no_initial(&mut self, decl: &ast::SkillComponent) {
        if let (Some(first), Some(last)) = (decl.situations.first(), decl.situations.last()) {
            self.error(
                codes::SKILL,
                first.span.to(last.span),
                format!(
                    "it is not said which of these `{}` is in at the start",
                    decl.name.text
                ),
                format!("write it behind them: `{{...}} = {}`", first.text),
            );
        }
    }

    fn skill(&mut self, decl: &'a ast::SkillComponent, component: usize, skill: &'a ast::Skill) {
        if let Some(first) = self.skill_index.get(skill.name.text.as_str()) {
            let first = self.skills[*first].span;
            self.findings.push(double(&skill.name, first));
        } else {
            let index = self.skills.len();
            self.skill_index.insert(&skill.name.text, index);
        }
        let (name, of) = (&skill.name.text, &decl.name.text);
        let effect = match (&skill.effect, decl.situations.first()) {
            (Some(effect), Some(_)) => self.situation_of(decl, effect),
            (None, None) => None,
            (Some(effect), None) => {
                self.error(
                    codes::SKILL,
                    effect.span,
                    format!("`{name}` leads to a situation, but `{of}` has none"),
                    format!("declare them, `component {of}: {{{0}, ...}} = {0}`, or write `{name}` alone", effect.text),
                );
                None
            }
            (None, Some(first)) => {
                // A part that could not be parsed may have been its situation.
                if !decl.broken {
                    let known = decl.situations.iter().map(|s| s.text.as_str());
                    let near = nearest(name, known).unwrap_or(&first.text);
                    self.error(
                        codes::SKILL,
                        skill.name.span,
                        format!("it is not said where `{name}` leads `{of}`"),
                        format!("write `{name} -> {near}`: each skill of `{of}` leads to one of its situations"),
                    );
                }
                None
            }
        };
        self.skills.push(Skill {
            name: name.clone(),
            doc: skill.doc.clone(),
            component,
            effect,
            span: skill.name.span,
        });
    }

    fn situation_of(&mut self, decl: &ast::SkillComponent, name: &ast::Name) -> Option<usize> {
        let known = || decl.situations.iter().map(|s| s.text.as_str());
        let found = known().position(|label| label == name.text);
        if found.is_none() {
            self.error(
                codes::NAME_UNKNOWN,
                name.span,
                format!("`{}` has no situation `{}`", decl.name.text, name.text),
                near_or_all(&name.text, known(), "its situations are"),
            );
        }
        found
    }

    /// Checks that a set has skills, and not too many.
    fn count(&mut self) {
        let name = &self.set.name;
        if self.skills.is_empty() && !self.tainted {
            self.error(
                codes::DOMAIN_EMPTY,
                name.span,
                format!("`{}` has no skill", name.text),
                "add a component with its skills: `component gripper: {open, closed} = open { Grip -> closed ... }`",
            );
        }
        if let Some(skill) = self.skills.get(MOST_SKILLS) {
            let (span, count) = (skill.span, self.skills.len());
            self.error(
                codes::DOMAIN_EMPTY,
                span,
                format!("`{}` has {count} skills, and a set has at most {MOST_SKILLS}", name.text),
                "make two sets of it, each with the components that its orders refer to; a machine may call the skills of several",
            );
        }
    }

    /// Returns the skill with a name. A part that could not be parsed may have declared it.
    fn find(&mut self, name: &ast::Name) -> Option<usize> {
        let found = self.skill_index.get(name.text.as_str()).copied();
        if found.is_none() {
            self.tainted = true;
            if !self.set.broken {
                let help = near_or_all(
                    &name.text,
                    self.skills.iter().map(|s| s.name.as_str()),
                    "the skills are",
                );
                self.error(
                    codes::NAME_UNKNOWN,
                    name.span,
                    format!("`{}` has no skill `{}`", self.set.name.text, name.text),
                    help,
                );
            }
        }
        found
    }
}

/// Returns the level that a word names, among these.
pub(super) fn level(
    word: Option<&ast::Name>,
    known: &[Level],
    findings: &mut Vec<Diagnostic>,
) -> Option<Level> {
    let Some(word) = word else {
        return Some(Level::Valid);
    };
    let found = known.iter().find(|level| level.word() == word.text);
    if found.is_none() {
        let known = known.iter().map(|level| level.word());
        findings.push(
            Diagnostic::error(
                codes::NAME_UNKNOWN,
                word.span,
                format!("there is no level `{}`", word.text),
            )
            .with_help(near_or_all(&word.text, known, "the levels are")),
        );
    }
    found.copied()
}

/// Suggests a meaning of an unknown name: the nearest one, or all known names.
pub(super) fn near_or_all<'n>(
    name: &str,
    known: impl Iterator<Item = &'n str> + Clone,
    they_are: &str,
) -> String {
    match nearest(name, known.clone().take(MOST_COMPARED)) {
        Some(near) => format!("did you mean `{near}`?"),
        None => format!("{they_are} {}", listed(known)),
    }
}

/// Joins names with commas, at most the first [`MOST_LISTED`].
pub(super) fn listed<'n>(names: impl Iterator<Item = &'n str> + Clone) -> String {
    let count = names.clone().count();
    let shown: Vec<String> = names.take(MOST_LISTED).map(|n| format!("`{n}`")).collect();
    match count.saturating_sub(shown.len()) {
        0 => shown.join(", "),
        more => format!("{} and {more} more", shown.join(", ")),
    }
}
