//! The numbers in the expressions of a machine: values of its properties and signals, inputs of its
//! components, and what it writes.

use super::places::element;
use super::slots::{MachineUse, Slots, has_number};
use linewright_syntax::ast::{Argument, Expr, MachineItem};

impl Slots<'_> {
    /// The expressions of a machine that contain a number, and whose statement has no name in an
    /// earlier tier.
    pub(super) fn wiring(&mut self, used: &MachineUse<'_>, items: &mut [MachineItem]) {
        let owner = used.owner;
        for item in &mut *items {
            let (MachineItem::Property(declared)
            | MachineItem::Signal(declared)
            | MachineItem::Abstract(declared)) = item
            else {
                continue;
            };
            let name = format!("{owner}.{}", declared.name.text);
            let several = declared.values.len() > 1;
            for (index, value) in declared.values.iter_mut().enumerate() {
                let name = if several {
                    format!("{name}.{}", index + 1)
                } else {
                    name.clone()
                };
                self.number_in(name, value);
            }
        }
        self.end_tier();
        for item in &mut *items {
            let (MachineItem::Component(component) | MachineItem::Refines(component)) = item else {
                continue;
            };
            let of = format!("{owner}.{}", component.name.text);
            for Argument { name, value } in &mut component.arguments {
                self.number_in(format!("{of}.{}", name.text), value);
            }
            if let Some(when) = &mut component.when {
                self.number_in(format!("{of}.when"), when);
            }
            for binding in &mut component.bindings {
                let index = binding.index.map(|index| format!("[{index}]"));
                let member = binding.member.as_ref();
                let member = member.map(|member| format!(".{}", member.text));
                let input = [Some(binding.name.text.clone()), index, member];
                let input = input.into_iter().flatten().collect::<String>();
                self.number_in(format!("{of}.{input}"), &mut binding.value);
            }
        }
        self.end_tier();
        for item in items {
            match item {
                MachineItem::Operation { name, sequence, .. } => {
                    for call in sequence {
                        for argument in &mut call.arguments {
                            let (operation, action) = (&name.text, &call.name.text);
                            let argument_name = &argument.name.text;
                            let name = format!("{owner}.{operation}.{action}.{argument_name}");
                            self.number_in(name, &mut argument.value);
                        }
                    }
                }
                MachineItem::Done(value) => self.number_in(format!("{owner}.done"), value),
                MachineItem::Write { name, index, value } => {
                    let written = element(&name.text, index.as_ref());
                    self.number_in(format!("{owner}.write.{written}"), value);
                }
                _ => {}
            }
        }
        self.end_tier();
    }

    /// An expression, if it contains a number.
    fn number_in(&mut self, name: String, value: &mut Expr) {
        if has_number(value) {
            self.expression([name], value);
        }
    }
}
