//! Performances from `OperationsPerformance`, as they are written here: times are those of the data
//! of each segment.

use super::activity::{Elements, Parts, activity};
use super::source::Source;
use crate::finding::Rule;
use crate::performance::{Performance, Record, seconds_of};
use crate::terms::activity as words;
use crate::xml::Element;

const ELEMENTS: Elements = Elements {
    equipment: "EquipmentActual",
    material: "MaterialActual",
};

/// Reads the performance of a document.
pub(super) fn performance(source: &mut Source<'_, '_>) -> Performance {
    let name = source.id(0);
    let schedule = source
        .child(0, "OperationsScheduleID")
        .map(|s| source.name(s));
    let started = source.child(0, "StartTime");
    source.child(0, "Endtime");
    source.code(0, "OperationsType");
    source.code(0, "PerformanceState");
    let seconds = started.and_then(|s| seconds_of(&source.text(s)));
    if seconds.is_none() {
        let message = "a `StartTime` in UTC is expected, as `2026-11-30T12:00:00Z`";
        source.add(started.unwrap_or(0), Rule::Meaning, message);
    }
    let mut parts = Parts::default();
    let mut records = Vec::new();
    for response in source.children(0, "OperationsResponse") {
        source.id(response);
        source.code(response, "OperationsType");
        source.code(response, "ResponseState");
        for name in [
            "StartTime",
            "EndTime",
            "OperationsRequestID",
            "SegmentRequirementID",
            "OperationsDefinitionID",
            "OperationsSegmentID",
        ] {
            source.child(response, name);
        }
        for segment in source.children(response, "SegmentResponse") {
            records.extend(record(source, segment, &mut parts));
        }
    }
    Performance {
        name,
        schedule,
        started: seconds.unwrap_or_default(),
        parts: parts.list,
        records,
    }
}

fn record(source: &mut Source<'_, '_>, segment: Element, parts: &mut Parts) -> Option<Record> {
    source.id(segment);
    source.code(segment, "SegmentState");
    for name in ["ActualStartTime", "ActualEndTime", "SegmentRequirementID"] {
        source.child(segment, name);
    }
    let recipe = source.names(segment, "OperationsDefinitionID");
    let request = source.names(segment, "OperationsRequestID");
    if recipe.len() != 1 || request.len() > 1 {
        let message = "a segment has one recipe and at most one request";
        source.add(segment, Rule::Meaning, message);
    }
    let data = source.properties(segment, "SegmentData");
    let product = source.single(&data, words::PRODUCT).map(|p| p.text.clone());
    let mut time = |id| {
        let value = source.single(&data, id)?;
        source.quantity(value, "s")
    };
    let [begin, end] = [words::BEGIN, words::END].map(&mut time);
    let activity = activity(source, segment, &ELEMENTS, &data, parts);
    let (Some(product), Some(begin), Some(end)) = (product, begin, end) else {
        let message = "a segment needs data `Product`, `Begin` and `End`";
        source.add(segment, Rule::Meaning, message);
        return None;
    };
    if begin > end {
        source.add(segment, Rule::Meaning, "the end is before the begin");
    }
    Some(Record {
        activity: activity?,
        recipe: recipe.into_iter().next()?,
        product,
        request: request.into_iter().next(),
        begin,
        end,
    })
}
