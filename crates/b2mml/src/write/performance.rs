//! A performance as `OperationsPerformance`: an `OperationsResponse` with one `SegmentResponse` for
//! each record.

use super::activity::{
    Parts, by_name, segments, shown, write_equipment, write_materials, write_type,
};
use super::{Value, WriteError, name, property};
use crate::name::encode;
use crate::performance::{Performance, Record, date_time};
use crate::schedule::Activity;
use crate::schema::NAMESPACE;
use crate::terms::activity as words;
use crate::xml::XmlWriter;

const DATA: &str = "SegmentData";

/// Returns a performance as a document with the root `OperationsPerformance`. Its dates have
/// milliseconds; data of each segment has the exact seconds after the start.
///
/// Takes time proportional to the performance.
///
/// # Errors
/// [`WriteError::Nothing`] and [`WriteError::Time`].
pub fn performance(performance: &Performance) -> Result<String, WriteError> {
    if performance.records.is_empty() {
        return Err(WriteError::Nothing);
    }
    let mut dates = Vec::new();
    let mut last = 0.0_f64;
    for (number, record) in performance.records.iter().enumerate() {
        let date = |seconds| date_time(performance.started, seconds);
        let both = date(record.begin).zip(date(record.end));
        let both = both.filter(|_| record.begin <= record.end);
        dates.push(both.ok_or(WriteError::Time(number))?);
        last = last.max(record.end);
    }
    let started = date_time(performance.started, 0.0).ok_or(WriteError::Time(0))?;
    let ended = date_time(performance.started, last).ok_or(WriteError::Time(0))?;
    let parts = by_name(&performance.parts);
    Ok(XmlWriter::document(
        "OperationsPerformance",
        NAMESPACE,
        |w| {
            w.text("ID", &encode(&performance.name));
            w.text("StartTime", &started);
            // The schema spells this element so.
            w.text("Endtime", &ended);
            w.text("OperationsType", "Production");
            if let Some(schedule) = &performance.schedule {
                w.text("OperationsScheduleID", &encode(schedule));
            }
            w.text("PerformanceState", "Completed");
            for (number, (record, dates)) in performance.records.iter().zip(&dates).enumerate() {
                w.element("OperationsResponse", |w| {
                    write_response(w, number, record, dates, &parts);
                });
            }
        },
    ))
}

fn write_response(
    w: &mut XmlWriter,
    number: usize,
    record: &Record,
    (begin, end): &(String, String),
    parts: &Parts<'_>,
) {
    let activity = &record.activity;
    let (id, recipe) = (format!("{}", number + 1), encode(&record.recipe));
    let (process, segment) = segments(activity);
    let request = record.request.as_ref().map(|r| encode(r));
    w.text("ID", &id);
    w.text("Description", &shown(activity));
    w.text("StartTime", begin);
    w.text("EndTime", end);
    write_type(w, activity);
    if let Some(request) = &request {
        w.text("OperationsRequestID", request);
        w.text("SegmentRequirementID", request);
    }
    w.text("OperationsDefinitionID", &recipe);
    w.text("OperationsSegmentID", &segment);
    w.text("ResponseState", "Completed");
    w.element("SegmentResponse", |w| {
        w.text("ID", &id);
        w.text("ActualStartTime", begin);
        w.text("ActualEndTime", end);
        write_type(w, activity);
        w.text("ProcessSegmentID", &process);
        if let Some(request) = &request {
            w.text("OperationsRequestID", request);
            w.text("SegmentRequirementID", request);
        }
        w.text("OperationsDefinitionID", &recipe);
        w.text("OperationsSegmentID", &segment);
        w.text("SegmentState", "Completed");
        name(w, DATA, words::PRODUCT, &record.product);
        for (id, seconds) in [(words::BEGIN, record.begin), (words::END, record.end)] {
            property(w, DATA, id, &[Value::number(&seconds.to_string(), "s")]);
        }
        if let Activity::Transfer { label, .. } = activity {
            name(w, DATA, words::LABEL, label);
        }
        write_equipment(w, "EquipmentActual", activity);
        let product = Some(record.product.as_str());
        write_materials(w, "MaterialActual", activity, parts, product);
    });
}
