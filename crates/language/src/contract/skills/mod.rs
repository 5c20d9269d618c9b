//! Resolution of a skill set to [`order::Skills`](Skills): components, their situations, the
//! effects of skills, and orders.
//!
//! A skill set does not depend on the rest of its file, so it is resolved once and shared by every
//! machine that calls its skills. Orders can mention components that are declared after them.

mod regex;
mod rules;

use super::scope::duplicate_name;
use crate::order::{Component, Level, MAX_SKILLS, Skill, Skills};
use linewright_core::diagnostics::{Code, Diagnostic, codes, has_errors, nearest};
use linewright_core::source::{SourceMap, Span};
use linewright_syntax::ast::{self, SkillItem};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Maximum number of names listed in one message.
const MAX_LISTED: usize = 12;
/// Maximum number of names that are compared with an unknown name.
const MAX_COMPARED: usize = 4 * MAX_SKILLS;

struct Resolver<'a> {
    set: &'a ast::SkillSet,
    sources: &'a SourceMap,
    components: Vec<Component>,
    skills: Vec<Skill>,
    component_index: BTreeMap<&'a str, usize>,
    skill_index: BTreeMap<&'a str, usize>,
    findings: Vec<Diagnostic>,
    /// Whether the set depends on text with an error that was reported elsewhere.
    tainted: bool,
}

/// Resolves a skill set. Returns `None` if there is an error, which is added to the findings.
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
    resolver.check_count();
    let rules = resolver.rules();
    let is_usable = !resolver.tainted && !has_errors(&resolver.findings);
    findings.append(&mut resolver.findings);
    is_usable.then(|| {
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
                self.findings.push(duplicate_name(&decl.name, first));
            }
            None => {
                self.component_index.insert(&decl.name.text, index);
            }
        }
        let mut labels: BTreeMap<&str, Span> = BTreeMap::new();
        for label in &decl.situations {
            if let Some(first) = labels.insert(&label.text, label.span) {
                self.findings.push(duplicate_name(label, first));
            }
        }
        if decl.initial.is_none() {
            self.report_missing_initial(decl);
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

    fn report_missing_initial(&mut self, decl: &ast::SkillComponent) {
        if let (Some(first), Some(last)) = (decl.situations.first(), decl.situations.last()) {
            self.error(
                codes::SKILL,
                first.span.to(last.span),
                format!("the initial situation of `{}` is missing", decl.name.text),
                format!("write it after the situations: `{{...}} = {}`", first.text),
            );
        }
    }

    fn skill(&mut self, decl: &'a ast::SkillComponent, component: usize, skill: &'a ast::Skill) {
        if let Some(first) = self.skill_index.get(skill.name.text.as_str()) {
            let first = self.skills[*first].span;
            self.findings.push(duplicate_name(&skill.name, first));
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
                    format!("declare situations, `component {of}: {{{0}, ...}} = {0}`, or write only `{name}`", effect.text),
                );
                None
            }
            (None, Some(first)) => {
                // The text that could not be parsed might contain the situation.
                if !decl.broken {
                    let known = decl.situations.iter().map(|s| s.text.as_str());
                    let near = nearest(name, known).unwrap_or(&first.text);
                    self.error(
                        codes::SKILL,
                        skill.name.span,
                        format!("the situation to which `{name}` leads `{of}` is missing"),
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

    /// Reports a set without skills, or with more than [`MAX_SKILLS`].
    fn check_count(&mut self) {
        let name = &self.set.name;
        if self.skills.is_empty() && !self.tainted {
            self.error(
                codes::DOMAIN_EMPTY,
                name.span,
                format!("`{}` has no skill", name.text),
                "add a component with its skills: `component gripper: {open, closed} = open { Grip -> closed ... }`",
            );
        }
        if let Some(skill) = self.skills.get(MAX_SKILLS) {
            let (span, count) = (skill.span, self.skills.len());
            self.error(
                codes::DOMAIN_EMPTY,
                span,
                format!("`{}` has {count} skills, but a set can have at most {MAX_SKILLS}", name.text),
                "split it into two sets, each with the components to which its orders refer; a machine can call the skills of several sets",
            );
        }
    }

    /// Returns the skill with this name. Reports an unknown name, unless it might be declared in
    /// text that could not be parsed.
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

/// Returns the level with this keyword. The level has to be one of `known`; if there is no keyword,
/// it is [`Level::Valid`]. Reports an unknown keyword.
pub(super) fn level(
    word: Option<&ast::Name>,
    known: &[Level],
    findings: &mut Vec<Diagnostic>,
) -> Option<Level> {
    let Some(word) = word else {
        return Some(Level::Valid);
    };
    let found = known.iter().find(|level| level.keyword() == word.text);
    if found.is_none() {
        let known = known.iter().map(|level| level.keyword());
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

/// Returns a help text for an unknown name: the most similar known name or, if none is similar, all
/// known names after the words `they_are`.
pub(super) fn near_or_all<'n>(
    name: &str,
    known: impl Iterator<Item = &'n str> + Clone,
    they_are: &str,
) -> String {
    match nearest(name, known.clone().take(MAX_COMPARED)) {
        Some(near) => format!("did you mean `{near}`?"),
        None => format!("{they_are} {}", listed(known)),
    }
}

/// Joins names with commas, at most the first [`MAX_LISTED`].
pub(super) fn listed<'n>(names: impl Iterator<Item = &'n str> + Clone) -> String {
    let count = names.clone().count();
    let shown: Vec<String> = names.take(MAX_LISTED).map(|n| format!("`{n}`")).collect();
    match count.saturating_sub(shown.len()) {
        0 => shown.join(", "),
        more => format!("{} and {more} more", shown.join(", ")),
    }
}
