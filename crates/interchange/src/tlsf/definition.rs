//! Parses parameters, definitions and enumerations.

use super::ast::{Definition, Enumeration, File, Label};
use super::parser::Parser;
use crate::names::quoted;

impl Parser<'_, '_> {
    pub(super) fn definition(&mut self, parameter: bool, file: &mut File) -> Option<()> {
        if !parameter && self.take("enum") {
            let enumeration = self.enumeration()?;
            file.enumerations.push(enumeration);
            return Some(());
        }
        let (name, place) = self.name("a name to define")?;
        let mut arguments = Vec::new();
        if self.take("(") && !self.take(")") {
            loop {
                arguments.push(self.name("the name of an argument")?.0);
                if !self.take(",") {
                    self.expect(")")?;
                    break;
                }
            }
        }
        self.expect("=")?;
        let mut cases = vec![self.expression()?];
        while !matches!(self.peek(), None | Some(";" | "}")) {
            cases.push(self.expression()?);
        }
        file.definitions.push(Definition {
            name,
            place,
            arguments,
            cases,
            parameter,
        });
        Some(())
    }

    /// Parses `enum name = A: 01,10  B: 1*`, after the keyword.
    pub(super) fn enumeration(&mut self) -> Option<Enumeration> {
        let (name, place) = self.name("the name of the enumeration")?;
        self.expect("=")?;
        let mut labels: Vec<Label> = Vec::new();
        let mut width = 0;
        while !matches!(self.peek(), None | Some(";" | "}")) {
            let (label, at) = self.name("a value of the enumeration")?;
            self.expect(":")?;
            let mut codes = Vec::new();
            loop {
                let code = self.code()?;
                if width == 0 {
                    width = code.len();
                } else if code.len() != width {
                    self.report.syntax(
                        at.clone(),
                        format!(
                            "`{}` has a code of {} bits, but earlier codes have {width}",
                            quoted(&label),
                            code.len()
                        ),
                        "all values of an enumeration need codes of the same length",
                    );
                    return None;
                }
                codes.push(code);
                if !self.take(",") {
                    break;
                }
            }
            labels.push(Label {
                name: label,
                place: at,
                codes,
            });
        }
        if labels.is_empty() {
            return self.missing("a value of the enumeration");
        }
        Some(Enumeration {
            name,
            place,
            width,
            labels,
        })
    }

    /// Parses a code of `0`, `1` and `*`, without blanks.
    pub(super) fn code(&mut self) -> Option<Vec<Option<bool>>> {
        let mut bits = Vec::new();
        let mut end = None;
        while let Some(token) = self.tokens.get(self.at) {
            let text = self.word(&token.range);
            if end.is_some_and(|e| e != token.range.start)
                || !text.bytes().all(|b| b"01*".contains(&b))
            {
                break;
            }
            bits.extend(text.bytes().map(|b| match b {
                b'0' => Some(false),
                b'1' => Some(true),
                _ => None,
            }));
            end = Some(token.range.end);
            self.at += 1;
        }
        if bits.is_empty() {
            return self.missing("a code of the bits 0, 1 and `*`");
        }
        // A limit that no practical enumeration exceeds.
        if bits.len() > 16 {
            self.at -= 1;
            return self.missing("a code of at most 16 bits");
        }
        Some(bits)
    }
}
