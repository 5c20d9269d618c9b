//! What a request asks for and a record tells: type, process segment, equipment and materials.

use super::{name, one_piece};
use crate::name::encode;
use crate::schedule::Activity;
use crate::terms::activity as words;
use crate::xml::XmlWriter;
use linewright_recipe::model::Part;
use rustc_hash::FxHashMap;

/// Parts by their names.
pub(super) type Parts<'a> = FxHashMap<&'a str, &'a Part>;

/// Returns parts by their names.
pub(super) fn by_name(parts: &[Part]) -> Parts<'_> {
    parts.iter().map(|p| (p.name.as_str(), p)).collect()
}

/// Writes `OperationsType`.
pub(super) fn write_type(w: &mut XmlWriter, activity: &Activity) {
    let other = match activity {
        Activity::Operation { .. } => return w.text("OperationsType", "Production"),
        Activity::Internal { .. } => words::INTERNAL,
        Activity::Transfer { .. } => words::ROUTING,
    };
    w.text_with("OperationsType", &[("OtherValue", other)], "Other");
}

/// Returns the process segment and the segment of the recipe.
pub(super) fn segments(activity: &Activity) -> (String, String) {
    match activity {
        Activity::Operation { call, segment, .. } => (encode(&call.name), encode(segment)),
        Activity::Internal { name, .. } => {
            let name = encode(name);
            (name.clone(), format!("internal:{name}"))
        }
        Activity::Transfer { label, .. } => (
            words::TRANSFER.to_owned(),
            format!("transfer:{}", encode(label)),
        ),
    }
}

/// Returns an activity as people read it.
pub(super) fn shown(activity: &Activity) -> String {
    match activity {
        Activity::Operation { resource, call, .. } => {
            let at = resource.as_ref().map(|r| format!(" at {}", encode(r)));
            format!("{}{}", super::shown(call), at.unwrap_or_default())
        }
        Activity::Internal { resource, name } => {
            format!("{} of {}", encode(name), encode(resource))
        }
        Activity::Transfer { from, to, part, .. } => {
            let part = part
                .as_ref()
                .map_or_else(|| "part".to_owned(), |p| encode(p));
            format!("{part} from {} to {}", encode(from), encode(to))
        }
    }
}

/// Writes the equipment: elements called `element`.
pub(super) fn write_equipment(w: &mut XmlWriter, element: &str, activity: &Activity) {
    let mut write = |resource: &str, usage: Option<&str>| {
        w.element(element, |w| {
            let id = encode(resource);
            w.text("ID", &id);
            w.text("EquipmentID", &id);
            if let Some(usage) = usage {
                w.text("EquipmentUse", usage);
            }
        });
    };
    match activity {
        Activity::Operation { resource, .. } => {
            if let Some(resource) = resource {
                write(resource, None);
            }
        }
        Activity::Internal { resource, .. } => write(resource, None),
        Activity::Transfer { from, to, .. } => {
            write(from, Some(words::OUT));
            write(to, Some(words::IN));
        }
    }
}

/// Writes the materials: elements called `element`, of a product if it is known.
pub(super) fn write_materials(
    w: &mut XmlWriter,
    element: &str,
    activity: &Activity,
    parts: &Parts<'_>,
    product: Option<&str>,
) {
    let property = format!("{element}Property");
    let mut write = |number: usize, usage: &str, part: &str| {
        let kind = parts.get(part).map_or(part, |p| &p.kind);
        w.element(element, |w| {
            w.text("ID", &format!("{usage}-{}", number + 1));
            w.text("MaterialDefinitionID", &encode(kind));
            if let Some(product) = product {
                w.text("MaterialLotID", &encode(product));
            }
            if usage == words::TRANSFERRED {
                w.text_with("MaterialUse", &[("OtherValue", usage)], "Other");
            } else {
                w.text("MaterialUse", usage);
            }
            one_piece(w);
            name(w, &property, words::PART, part);
        });
    };
    match activity {
        Activity::Operation { call, .. } => {
            for (usage, parts) in [("Consumed", &call.inputs), ("Produced", &call.outputs)] {
                for (number, part) in parts.iter().enumerate() {
                    write(number, usage, part);
                }
            }
        }
        Activity::Internal { .. } => {}
        Activity::Transfer { part, .. } => {
            if let Some(part) = part {
                write(0, words::TRANSFERRED, part);
            }
        }
    }
}
