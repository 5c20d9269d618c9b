//! Schedules from `OperationsSchedule`.
//!
//! Each `SegmentRequirement` and each of its children is a request, in the order of the document.

use super::activity::{Elements, Parts, activity};
use super::source::{Property, Source};
use crate::finding::{Rule, quoted};
use crate::schedule::{PlanPlace, Request, Schedule};
use crate::schema::{duration_seconds, has_calendar_units};
use crate::terms::activity as words;
use crate::xml::Element;
use rustc_hash::FxHashSet;

const ELEMENTS: Elements = Elements {
    equipment: "EquipmentRequirement",
    material: "MaterialRequirement",
};

/// A segment within another.
const CHILD: &str = "SegmentRequirementChild";

/// Reads the schedule of a document.
pub(super) fn schedule(source: &mut Source<'_, '_>) -> Schedule {
    let mut reader = ScheduleReader::default();
    let name = source.id(0);
    source.code(0, "OperationsType");
    for request in source.children(0, "OperationsRequest") {
        source.id(request);
        source.code(request, "OperationsType");
        source.child(request, "OperationsDefinitionID");
        source.child(request, "OperationsSegmentID");
        for segment in source.children(request, "SegmentRequirement") {
            reader.segment(source, segment);
        }
    }
    Schedule {
        name,
        parts: reader.parts.list,
        requests: reader.requests,
    }
}

#[derive(Default)]
struct ScheduleReader {
    parts: Parts,
    requests: Vec<Request>,
    known: FxHashSet<String>,
}

impl ScheduleReader {
    /// Reads a segment, unless it has children, which are read in its place. The depth is that of
    /// the document.
    fn segment(&mut self, source: &mut Source<'_, '_>, segment: Element) {
        let id = source.id(segment);
        // The halves of a transfer are no requests of their own.
        let kind = source
            .code(segment, "OperationsType")
            .and_then(|(_, other)| other);
        let has_children = source.has(segment, CHILD);
        if has_children && kind.as_deref() != Some(words::ROUTING) {
            source.child(segment, "ProcessSegmentID");
            source.child(segment, "OperationsDefinitionID");
            source.child(segment, "OperationsSegmentID");
            for child in source.children(segment, CHILD) {
                self.segment(source, child);
            }
            return;
        }
        let recipe = source.child(segment, "OperationsDefinitionID");
        let recipe = recipe.map(|r| source.name(r)).unwrap_or_default();
        let properties = source.properties(segment, "SegmentParameter");
        let place = place(source, segment, &properties);
        let seconds = source.child(segment, "Duration").and_then(|duration| {
            let text = source.text(duration);
            let seconds = duration_seconds(&text).filter(|s| *s >= 0.0);
            if seconds.is_none() || has_calendar_units(&text) {
                let message = "a duration in days, hours, minutes and seconds is expected";
                source.add(duration, Rule::Meaning, message);
            }
            seconds
        });
        let activity = activity(source, segment, &ELEMENTS, &properties, &mut self.parts);
        if !self.known.insert(id.clone()) {
            let message = format!("two requests have the identifier {}", quoted(&id));
            source.add(segment, Rule::Reference, message);
        }
        self.requests.extend(activity.map(|activity| Request {
            id,
            recipe,
            activity,
            seconds,
            place,
        }));
    }
}

/// Reads the place of a request in a controller.
fn place(
    source: &mut Source<'_, '_>,
    segment: Element,
    properties: &[Property],
) -> Option<PlanPlace> {
    let ids = [words::POSITION, words::TRANSITION, words::VECTOR];
    let present = ids
        .iter()
        .filter(|id| properties.iter().any(|p| p.id == **id));
    match present.count() {
        0 => return None,
        3 => {}
        _ => {
            let message = "a place has a position, a transition and a vector";
            source.add(segment, Rule::Meaning, message);
        }
    }
    let mut index = |id| -> Option<usize> {
        let value = source.single(properties, id)?;
        let number: usize = source.number(value, "a number from 1")?;
        let index = number.checked_sub(1);
        if index.is_none() {
            source.add(value.element, Rule::Meaning, "a number from 1 is expected");
        }
        index
    };
    let [position, transition, vector] = ids.map(&mut index);
    Some(PlanPlace {
        position: position?,
        transition: transition?,
        vector: vector?,
    })
}
