//! A schedule as `OperationsSchedule`: an `OperationsRequest` with one `SegmentRequirement` for
//! each operation and each transfer.

use super::activity::{Parts, by_name, segments, shown, write_equipment, write_materials};
use super::{Value, WriteError, name, property};
use crate::name::encode;
use crate::schedule::{Activity, Request, Schedule};
use crate::schema::{NAMESPACE, seconds_as_duration};
use crate::terms::activity as words;
use crate::write::activity::write_type;
use crate::xml::XmlWriter;
use rustc_hash::FxHashSet;

const PARAMETER: &str = "SegmentParameter";

/// Returns a schedule as a document with the root `OperationsSchedule`. Durations of 1e9 s and more
/// are left out.
///
/// Takes time proportional to the schedule.
///
/// # Errors
/// [`WriteError::Nothing`] and [`WriteError::DuplicateRequest`].
pub fn schedule(schedule: &Schedule) -> Result<String, WriteError> {
    if schedule.requests.is_empty() {
        return Err(WriteError::Nothing);
    }
    let mut known = FxHashSet::default();
    for request in &schedule.requests {
        if !known.insert(request.id.as_str()) {
            return Err(WriteError::DuplicateRequest(request.id.clone()));
        }
    }
    let parts = by_name(&schedule.parts);
    Ok(XmlWriter::document("OperationsSchedule", NAMESPACE, |w| {
        w.text("ID", &encode(&schedule.name));
        w.text("OperationsType", "Production");
        for request in &schedule.requests {
            w.element("OperationsRequest", |w| write_request(w, request, &parts));
        }
    }))
}

fn write_request(w: &mut XmlWriter, request: &Request, parts: &Parts<'_>) {
    let activity = &request.activity;
    let (id, recipe) = (encode(&request.id), encode(&request.recipe));
    let (process, segment) = segments(activity);
    w.text("ID", &id);
    w.text("Description", &shown(activity));
    write_type(w, activity);
    w.text("OperationsDefinitionID", &recipe);
    w.text("OperationsSegmentID", &segment);
    w.element("SegmentRequirement", |w| {
        w.text("ID", &id);
        write_type(w, activity);
        w.text("ProcessSegmentID", &process);
        if let Some(duration) = request.seconds.and_then(seconds_as_duration) {
            w.text("Duration", &duration);
        }
        w.text("OperationsDefinitionID", &recipe);
        w.text("OperationsSegmentID", &segment);
        if let Activity::Transfer { label, .. } = activity {
            name(w, PARAMETER, words::LABEL, label);
        }
        if let Some(place) = request.place {
            for (id, index) in [
                (words::POSITION, place.position),
                (words::TRANSITION, place.transition),
                (words::VECTOR, place.vector),
            ] {
                property(w, PARAMETER, id, &[Value::count(&(index + 1).to_string())]);
            }
        }
        write_equipment(w, "EquipmentRequirement", activity);
        write_materials(w, "MaterialRequirement", activity, parts, None);
    });
}
