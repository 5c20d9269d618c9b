//! Findings for the causes that the crate `recipe` names.

use super::words::{call, quoted};
use linewright_core::diagnostics::{Code, Diagnostic, codes, nearest};
use linewright_core::source::Span;
use linewright_language::contract::recipe::{CallPlaces, Layout, Realization, Recipe};
use linewright_recipe::model::{Action, OperationCall, Step};
use linewright_recipe::realize::Obstacle;

/// What a finding is about.
#[derive(Debug, Clone, Copy)]
pub(super) struct Subject<'m> {
    pub layout: &'m Layout,
    pub recipe: &'m Recipe,
    pub realization: &'m Realization,
}

impl<'m> Subject<'m> {
    pub fn step(&self, transition: usize, step: usize) -> &'m Step {
        &self.recipe.model.transitions[transition].steps[step]
    }

    /// Places of the calls of a step.
    pub fn places(&self, transition: usize, step: usize) -> &'m [CallPlaces] {
        &self.recipe.transitions[transition].steps[step]
    }

    /// An error of the recipe that concerns this layout only.
    pub fn error(&self, code: Code, span: Span, message: String, help: String) -> Diagnostic {
        let finding = Diagnostic::error(code, span, message).with_help(help);
        let title = super::words::title(self.realization);
        finding.with_label(self.realization.span, format!("to make {title}"))
    }

    fn resource(&self, at: usize) -> &'m str {
        &self.layout.model.resources[at].name
    }

    fn resources(&self, all: &[usize]) -> String {
        quoted(all.iter().map(|at| self.resource(*at)))
    }

    /// Operations that resources perform, each with the first resource.
    fn performed(&self) -> Vec<(&'m str, &'m str)> {
        let mut found: Vec<(&str, &str)> = Vec::new();
        for resource in &self.layout.model.resources {
            for transition in &resource.transitions {
                if let Action::Operation(name) = &transition.action
                    && !found.iter().any(|(known, _)| known == name)
                {
                    found.push((name, &resource.name));
                }
            }
        }
        found
    }

    /// Returns the finding for a cause.
    pub fn finding(&self, obstacle: &Obstacle) -> Diagnostic {
        match obstacle {
            Obstacle::NoPerformer {
                transition,
                step,
                operation,
            } => self.no_performer(*transition, *step, operation),
            Obstacle::NoSource {
                transition,
                step,
                part,
            } => self.no_source(*transition, *step, part),
            Obstacle::NoRoom {
                transition,
                step,
                operation,
                parts,
            } => self.no_room(*transition, *step, *operation, *parts),
            Obstacle::TooFewPerformers {
                transition,
                step,
                performers,
            } => self.too_few(*transition, *step, performers),
            Obstacle::NoWay {
                transition,
                step,
                part,
                from,
                to,
            } => self.no_way(*transition, *step, part, (from, to)),
        }
    }

    fn no_performer(&self, transition: usize, step: usize, operation: &str) -> Diagnostic {
        let layout = &self.layout.model.name;
        let calls = self.step(transition, step).operations.iter();
        let mut places = calls.zip(self.places(transition, step));
        let place = places.find(|(c, _)| c.name == operation);
        let performed = self.performed();
        let help = match nearest(operation, performed.iter().map(|(name, _)| *name)) {
            Some(near) => {
                let by = performed.iter().find(|(name, _)| *name == near);
                let by = by.map_or("", |(_, by)| *by);
                format!("did you mean `{near}`, which `{by}` performs?")
            }
            None => {
                format!("write a transition in a resource of `{layout}`: `s0 -> s1: {operation}`")
            }
        };
        self.error(
            codes::RECIPE_OPERATION,
            place.map_or(self.recipe.span, |(_, p)| p.name),
            format!("no resource of `{layout}` performs `{operation}`"),
            help,
        )
    }

    fn no_source(&self, transition: usize, step: usize, part: &str) -> Diagnostic {
        let (called, place) = self.input(transition, step, part);
        let model = &self.recipe.model;
        let mut calls = (model.transitions.iter())
            .flat_map(|t| &t.steps)
            .flat_map(|s| &s.operations);
        let made = calls.any(|c| c.outputs.iter().any(|o| o == part));
        let kind = model.part(part).map_or(part, |at| &model.parts[at].kind);
        let message = if made {
            format!("nothing makes `{part}` before `{}` needs it", called.name)
        } else {
            format!("nothing makes `{part}`, which `{}` needs", called.name)
        };
        let help = if made {
            "make it before, or name a part that is there".to_owned()
        } else {
            format!(
                "write an operation that brings it, such as `load()({part})`, or let a resource hold one: `at start r1 s0 holds {kind}`"
            )
        };
        self.error(codes::RECIPE_PART, place, message, help)
    }

    fn no_room(
        &self,
        transition: usize,
        step: usize,
        operation: usize,
        parts: usize,
    ) -> Diagnostic {
        let called = &self.step(transition, step).operations[operation];
        let performers = self.performers(&called.name);
        let most = (performers.iter())
            .max_by_key(|at| self.layout.model.resources[**at].capacity)
            .copied()
            .unwrap_or(0);
        let room = self.layout.model.resources[most].capacity;
        let verb = if called.inputs.len() == parts {
            "needs"
        } else {
            "makes"
        };
        self.error(
            codes::RECIPE_ROOM,
            self.places(transition, step)[operation].span,
            format!(
                "`{}` {verb} {parts} parts, but `{}` has room for {room}",
                called.name,
                self.resource(most)
            ),
            format!("give it room: `holds {parts}`"),
        )
        .with_label(self.layout.resources[most].name, "performs it")
    }

    fn too_few(&self, transition: usize, step: usize, performers: &[usize]) -> Diagnostic {
        let names = (self.step(transition, step).operations.iter()).map(|c| c.name.as_str());
        let places = self.places(transition, step);
        let span = match places {
            [first, .., last] => first.span.to(last.span),
            _ => places.first().map_or(self.recipe.span, |p| p.span),
        };
        let has = if performers.len() == 1 {
            "performs"
        } else {
            "perform"
        };
        self.error(
            codes::RECIPE_PARALLEL,
            span,
            format!(
                "{} need different resources at the same time, but only {} {has} them",
                quoted(names),
                self.resources(performers)
            ),
            format!(
                "write `;` instead of `||`, or add a resource: `resource {0}_2 = {0}`",
                performers.first().map_or("", |at| self.resource(*at))
            ),
        )
    }

    fn no_way(
        &self,
        transition: usize,
        step: Option<usize>,
        part: &str,
        (from, to): (&[usize], &[usize]),
    ) -> Diagnostic {
        let (place, purpose) = if let Some(step) = step {
            let (called, place) = self.input(transition, step, part);
            (place, format!("`{}`", called.name))
        } else {
            let places = &self.recipe.transitions[transition];
            let place = places.guard.unwrap_or(places.span);
            (place, "the test".to_owned())
        };
        let (message, help) = match (from, to) {
            ([one], [other]) if one == other => (
                format!(
                    "while `{}` holds `{part}`, it never comes to a state in which it performs {purpose}",
                    self.resource(*one)
                ),
                "write a transition that leads to such a state".to_owned(),
            ),
            _ => (
                format!(
                    "`{part}` cannot get from {} to {}, where {purpose} needs it",
                    self.resources(from),
                    self.resources(to)
                ),
                "add a route or a transfer; `linewright recipe repair` lists those that would be enough"
                    .to_owned(),
            ),
        };
        self.error(codes::RECIPE_WAY, place, message, help)
    }

    /// Returns the first operation of a step that needs a part, and the place of the part.
    fn input(&self, transition: usize, step: usize, part: &str) -> (&'m OperationCall, Span) {
        let calls = self.step(transition, step).operations.iter();
        for (called, places) in calls.zip(self.places(transition, step)) {
            if let Some(at) = called.inputs.iter().position(|i| i == part) {
                return (called, places.inputs[at]);
            }
        }
        let called = &self.step(transition, step).operations[0];
        (called, self.places(transition, step)[0].span)
    }

    /// Indices of the resources that perform an operation.
    fn performers(&self, operation: &str) -> Vec<usize> {
        let performs = |action: &Action| matches!(action, Action::Operation(n) if n == operation);
        let resources = self.layout.model.resources.iter().enumerate();
        resources
            .filter(|(_, r)| r.transitions.iter().any(|t| performs(&t.action)))
            .map(|(at, _)| at)
            .collect()
    }

    /// The finding without a known cause: it points to the first step that can never be performed.
    /// `furthest_steps` is empty if it is not known how far the recipe gets.
    pub fn unrealizable(&self, furthest_steps: &[Option<usize>]) -> Diagnostic {
        let model = &self.recipe.model;
        let title = format!(
            "`{}` cannot be made on `{}`",
            model.name, self.layout.model.name
        );
        let help = "`linewright recipe repair` lists the smallest changes that make it possible"
            .to_owned();
        let stuck = furthest_steps
            .iter()
            .enumerate()
            .find_map(|(number, reached)| {
                let reached = (*reached)?;
                let step = model.transitions[number].steps.get(reached)?;
                Some((number, reached, step))
            });
        match stuck {
            Some((number, reached, step)) => {
                let calls: Vec<String> = step.operations.iter().map(call).collect();
                let places = self.places(number, reached);
                let span = match places {
                    [first, .., last] => first.span.to(last.span),
                    _ => places.first().map_or(self.recipe.span, |p| p.span),
                };
                self.error(
                    codes::RECIPE_UNREALIZABLE,
                    span,
                    format!("{title}: `{}` can never be performed here", calls.join(" || ")),
                    help,
                )
            }
            None if furthest_steps.is_empty() => self.error(
                codes::RECIPE_UNREALIZABLE,
                self.recipe.span,
                format!("{title}: a symbolic search proves it, without showing which step is missing"),
                help,
            ),
            None => self.error(
                codes::RECIPE_UNREALIZABLE,
                self.recipe.span,
                format!("{title}: each step can be performed, but not whatever the outcomes of the tests"),
                help,
            ),
        }
    }
}
