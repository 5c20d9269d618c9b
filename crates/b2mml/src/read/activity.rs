//! What a request asks for and a record tells.

use super::source::{Property, Source};
use crate::finding::{Rule, quoted};
use crate::schedule::Activity;
use crate::terms::activity as words;
use crate::xml::Element;
use linewright_recipe::model::{OperationCall, Part};
use rustc_hash::FxHashMap;

/// Parts in the order of their first mention.
#[derive(Default)]
pub(super) struct Parts {
    /// The parts.
    pub list: Vec<Part>,
    numbers: FxHashMap<String, usize>,
}

impl Parts {
    /// Adds a part. Another type than before is a finding at the element.
    fn add(&mut self, source: &mut Source<'_, '_>, element: Element, part: Part) {
        match self.numbers.get(&part.name) {
            None => {
                self.numbers.insert(part.name.clone(), self.list.len());
                self.list.push(part);
            }
            Some(number) if self.list[*number].kind != part.kind => {
                let (name, kind) = (quoted(&part.name), quoted(&self.list[*number].kind));
                let message = format!("part {name} had the type {kind} before");
                source.add(element, Rule::Reference, message);
            }
            Some(_) => {}
        }
    }
}

/// How a part is used.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Usage {
    Consumed,
    Produced,
    Transferred,
}

/// Reads materials: elements called `element` of a segment. Returns each piece with its use.
///
/// A material is a part. Its name is the property `Part`, or else its identifier; its type is its
/// definition, or else its class, or else its name.
pub(super) fn materials(
    source: &mut Source<'_, '_>,
    segment: Element,
    element: &str,
    parts: &mut Parts,
) -> Vec<(Usage, String)> {
    let mut found = Vec::new();
    for material in source.children(segment, element) {
        let id = source.id(material);
        let properties = source.properties(material, &format!("{element}Property"));
        let name = source
            .single(&properties, words::PART)
            .map(|p| p.text.clone());
        let name = name.unwrap_or(id);
        let mut kinds = source.names(material, "MaterialDefinitionID");
        if kinds.is_empty() {
            kinds = source.names(material, "MaterialClassID");
        }
        if kinds.len() > 1 {
            let message = format!("part {} has several types", quoted(&name));
            source.add(material, Rule::Meaning, message);
        }
        let kind = kinds.into_iter().next().unwrap_or_else(|| name.clone());
        source.child(material, "MaterialLotID");
        let usage = source.code(material, "MaterialUse");
        let usage = match usage
            .as_ref()
            .map(|(text, other)| (text.as_str(), other.as_deref()))
        {
            Some(("Consumed" | "Consumable" | "Material Consumed", _)) => Usage::Consumed,
            Some((
                "Produced"
                | "Material Produced"
                | "By-product Produced"
                | "Co-product Produced"
                | "Yield Produced",
                _,
            )) => Usage::Produced,
            Some(("Other", Some(words::TRANSFERRED))) => Usage::Transferred,
            Some((other, _)) => {
                let message = format!("the material use {} is not known", quoted(other));
                source.add(material, Rule::Meaning, message);
                continue;
            }
            None => {
                let message = format!("it is not said how {} is used", quoted(&name));
                source.add(material, Rule::Meaning, message);
                continue;
            }
        };
        let pieces = source.pieces(material);
        parts.add(source, material, Part::new(&name, &kind));
        found.extend(std::iter::repeat_n((usage, name), pieces));
    }
    found
}

/// Returns the call of an operation with materials. A part that is only transferred is a finding.
pub(super) fn call(
    source: &mut Source<'_, '_>,
    segment: Element,
    name: String,
    materials: Vec<(Usage, String)>,
) -> OperationCall {
    let mut call = OperationCall {
        name,
        ..OperationCall::default()
    };
    for (usage, part) in materials {
        match usage {
            Usage::Consumed => call.inputs.push(part),
            Usage::Produced => call.outputs.push(part),
            Usage::Transferred => {
                let message = format!("an operation cannot transfer {}", quoted(&part));
                source.add(segment, Rule::Meaning, message);
            }
        }
    }
    call
}

/// Names of the elements of a segment.
pub(super) struct Elements {
    /// Equipment.
    pub equipment: &'static str,
    /// Materials.
    pub material: &'static str,
}

/// Reads what a segment is about. `properties` are its parameters or data.
pub(super) fn activity(
    source: &mut Source<'_, '_>,
    segment: Element,
    elements: &Elements,
    properties: &[Property],
    parts: &mut Parts,
) -> Option<Activity> {
    let kind = source
        .code(segment, "OperationsType")
        .and_then(|(_, other)| other);
    let process = source.names(segment, "ProcessSegmentID");
    let of_recipe = source.names(segment, "OperationsSegmentID");
    let process = process.into_iter().next().unwrap_or_default();
    let of_recipe = of_recipe.into_iter().next().unwrap_or_default();
    let equipment = equipment(source, segment, elements.equipment);
    let materials = materials(source, segment, elements.material, parts);
    match kind.as_deref() {
        Some(words::ROUTING) => {
            let label = source
                .single(properties, words::LABEL)
                .map(|v| v.text.clone());
            let label = label.unwrap_or(of_recipe);
            transfer(source, segment, label, &equipment, &materials)
        }
        Some(words::INTERNAL) => match equipment.as_slice() {
            [(resource, _)] if materials.is_empty() => Some(Activity::Internal {
                resource: resource.clone(),
                name: process,
            }),
            _ => {
                let message = "an internal operation has one resource and no materials";
                source.add(segment, Rule::Meaning, message);
                None
            }
        },
        _ if equipment.len() < 2 => Some(Activity::Operation {
            resource: equipment.into_iter().next().map(|(resource, _)| resource),
            call: call(source, segment, process, materials),
            segment: of_recipe,
        }),
        _ => {
            let message = "an operation has one resource; only `Routing` has two";
            source.add(segment, Rule::Meaning, message);
            None
        }
    }
}

/// Reads the equipment of a segment: names and uses.
fn equipment(
    source: &mut Source<'_, '_>,
    segment: Element,
    element: &str,
) -> Vec<(String, String)> {
    let mut found = Vec::new();
    for equipment in source.children(segment, element) {
        let id = source.id(equipment);
        let names = source.names(equipment, "EquipmentID");
        if names.len() > 1 {
            let message = "several resources are given for one use";
            source.add(equipment, Rule::Meaning, message);
        }
        let usage = source.child(equipment, "EquipmentUse");
        let usage = usage.map(|u| source.text(u)).unwrap_or_default();
        found.push((names.into_iter().next().unwrap_or(id), usage));
    }
    found
}

/// Reads a transfer: the resource with the use `out` gives the part; otherwise it is the first.
fn transfer(
    source: &mut Source<'_, '_>,
    segment: Element,
    label: String,
    equipment: &[(String, String)],
    materials: &[(Usage, String)],
) -> Option<Activity> {
    let [first, second] = equipment else {
        let message = "a routing names two resources";
        source.add(segment, Rule::Meaning, message);
        return None;
    };
    let is_reversed = first.1 == words::IN && second.1 != words::IN;
    let same_use = !first.1.is_empty() && first.1 == second.1;
    if same_use || materials.len() > 1 {
        let message = "a routing moves one part out of a resource into another";
        source.add(segment, Rule::Meaning, message);
        return None;
    }
    let (from, to) = if is_reversed {
        (second, first)
    } else {
        (first, second)
    };
    Some(Activity::Transfer {
        from: from.0.clone(),
        to: to.0.clone(),
        label,
        part: materials.first().map(|(_, part)| part.clone()),
    })
}
