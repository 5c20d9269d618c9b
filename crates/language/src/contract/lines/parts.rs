//! Resolution of part types: their properties and bills of materials.

use super::{Builder, Part};
use crate::contract::elaborate::{Elaborator, nearest};
use crate::contract::line::{InitialValue, PartProperty, PartType};
use crate::contract::machines::{
    PropertyType, declare_property, element_names, property_type, property_values,
};
use linewright_core::diagnostics::codes;
use linewright_syntax::ast::{self, ExprKind, LineItem};

impl<'a> Builder<'a, '_> {
    pub(super) fn declare_parts(&mut self, decl: &'a ast::Line) {
        // All types are resolved before the initial values, because a product can copy values of
        // parts that are declared later.
        for item in &decl.items {
            let LineItem::Part {
                name,
                bill,
                properties,
            } = item
            else {
                continue;
            };
            let mut types: Vec<(String, usize, PropertyType)> = Vec::new();
            let mut first = 0;
            for p in properties {
                if let Some((_, _, _)) = types.iter().find(|(n, ..)| *n == p.name.text) {
                    self.e.findings.error_with(
                        codes::NAME_DUPLICATE,
                        p.name.span,
                        format!("`{}` is declared twice", p.name.text),
                        "give one of the two another name",
                    );
                    continue;
                }
                if let Some(ty) = property_type(&mut self.e, &p.domain) {
                    let n = ty.length.unwrap_or(1);
                    types.push((p.name.text.clone(), first, ty));
                    first += n;
                }
            }
            let mut resolved = Vec::new();
            for counted in bill {
                if counted.count == 0 || counted.count > 10_000 {
                    self.e.findings.error_with(
                        codes::ARGUMENT,
                        counted.name.span,
                        "the count in a bill of materials must be from 1 to 10000",
                        "write the number of parts of this type in one product: `from 2 Brick`",
                    );
                }
                if let Some(part) = self.find_part(&counted.name) {
                    resolved.push((part, counted.count as u32));
                }
            }
            self.parts.push(Part {
                model: PartType {
                    name: name.text.clone(),
                    properties: Vec::new(),
                    bill: resolved,
                    span: name.span,
                },
                types,
            });
        }
        let mut index = 0;
        for item in &decl.items {
            let LineItem::Part { properties, .. } = item else {
                continue;
            };
            for p in properties {
                let Some((_, _, ty)) = self.parts[index]
                    .types
                    .iter()
                    .find(|(n, ..)| *n == p.name.text)
                    .cloned()
                else {
                    continue;
                };
                let initial = self.initial(index, &ty, p.values.first());
                for (i, name) in element_names(&p.name.text, &ty).into_iter().enumerate() {
                    let initial = initial
                        .as_ref()
                        .and_then(|v| v.get(i).copied())
                        .unwrap_or(InitialValue::Number(0.0));
                    self.parts[index].model.properties.push(PartProperty {
                        name,
                        unit: ty.unit.clone(),
                        domain: ty.domain.clone(),
                        initial,
                    });
                }
            }
            index += 1;
        }
    }

    /// Resolves the initial value of a property: `= 0`, `= [0, 1]`, or `= Printed.heights`.
    pub(super) fn initial(
        &mut self,
        part: usize,
        ty: &PropertyType,
        value: Option<&'a ast::Expr>,
    ) -> Option<Vec<InitialValue>> {
        if let Some(ast::Expr {
            kind: ExprKind::Path(names),
            span,
        }) = value
            && let [component, property] = names.as_slice()
            && let Some(from) = self.part_index.get(&component.text).copied()
        {
            if !self.parts[part].model.bill.iter().any(|(p, _)| *p == from) {
                self.e.findings.error_with(
                    codes::PROPERTY,
                    *span,
                    format!(
                        "`{}` is not in the bill of materials of `{}`",
                        component.text, self.parts[part].model.name
                    ),
                    format!(
                        "use a part type of the bill, or add `{}` after `from`",
                        component.text
                    ),
                );
                return None;
            }
            let found = self.parts[from]
                .types
                .iter()
                .find(|(n, ..)| *n == property.text)
                .cloned();
            let Some((_, first, found)) = found else {
                let known = self.parts[from].types.iter().map(|(n, ..)| n.as_str());
                let help = match nearest(&property.text, known) {
                    Some(near) => format!("did you mean `{near}`?"),
                    None => format!("declare it in `part {}`", component.text),
                };
                self.e.findings.error_with(
                    codes::PROPERTY,
                    property.span,
                    format!("`{}` has no property `{}`", component.text, property.text),
                    help,
                );
                return None;
            };
            if found.unit != ty.unit || found.length != ty.length || found.domain != ty.domain {
                self.e.findings.error_with(
                    codes::TYPE_MISMATCH,
                    *span,
                    "the two properties have different types",
                    "declare both with the same unit, range or labels",
                );
                return None;
            }
            return Some(
                (0..ty.length.unwrap_or(1))
                    .map(|i| InitialValue::Component(from, first + i))
                    .collect(),
            );
        }
        let mut component = None;
        if let Some(value) = value {
            value.for_each_path(&mut |names| {
                if let [from, property] = names
                    && self.part_index.contains_key(&from.text)
                {
                    component.get_or_insert(format!("{}.{}", from.text, property.text));
                }
            });
            if let Some(component) = component {
                self.e.findings.error_with(
                    codes::PROPERTY,
                    value.span,
                    "a joined part can only copy a value of a component",
                    format!(
                        "write `= {component}`, and compute with the value in a machine, with `write` or `time`"
                    ),
                );
                return None;
            }
        }
        let numbers = property_values(&mut self.e, ty, value)?;
        Some(numbers.into_iter().map(InitialValue::Number).collect())
    }

    /// Returns an elaborator whose variables are the properties of a part type, in order.
    pub(super) fn part_scope(&self, part: usize) -> Elaborator<'a> {
        let mut e = Elaborator::new(self.e.names.without_variables());
        e.dialect.real = true;
        for (name, _, ty) in &self.parts[part].types {
            declare_property(&mut e, name, ty);
        }
        e
    }
}
