//! Parses the section INFO.

use super::ast::{File, Semantics};
use super::lexer::Word;
use super::parser::Parser;
use crate::names::quoted;
use std::ops::Range;

impl Parser<'_, '_> {
    pub(super) fn info(&mut self, file: &mut File) {
        loop {
            let place = self.here();
            match self.peek() {
                None => {
                    let _: Option<()> = self.missing("`}`");
                    return;
                }
                Some("}") => {
                    self.at += 1;
                    return;
                }
                Some(word @ ("TITLE" | "DESCRIPTION")) => {
                    self.at += 1;
                    let text = self.expect(":").and_then(|_| {
                        let token = self.tokens.get(self.at)?;
                        (token.word == Word::Text).then(|| self.word(&token.range))
                    });
                    if let Some(text) = text {
                        self.at += 1;
                        if word == "TITLE" {
                            file.title = Some(text.trim_matches('"').to_owned());
                        }
                    } else {
                        let _: Option<()> = self.missing_with(
                            "a text in quotation marks",
                            "write it like this: `TITLE: \"an arbiter\"`",
                        );
                        self.at += usize::from(self.peek().is_some_and(|w| w != "}"));
                    }
                }
                Some("SEMANTICS") => {
                    self.at += 1;
                    self.expect(":");
                    let words = self.words_of_info();
                    let texts: Vec<&str> = words.iter().map(|r| self.word(r)).collect();
                    let strict = texts.iter().filter(|w| **w == "Strict").count();
                    let base: Vec<&str> =
                        texts.iter().copied().filter(|w| *w != "Strict").collect();
                    file.semantics = match base.as_slice() {
                        ["Mealy"] if strict <= 1 => Some(false),
                        ["Moore"] if strict <= 1 => Some(true),
                        _ => None,
                    }
                    .map(|moore| Semantics {
                        moore,
                        strict: strict == 1,
                    });
                    if file.semantics.is_none() {
                        let range = words.first().map_or(place.clone(), |first| {
                            first.start..words.last().map_or(first.end, |l| l.end)
                        });
                        if texts.contains(&"Finite") {
                            self.report.error(
                                linewright_core::diagnostics::codes::NOT_GR1,
                                range.clone(),
                                "this file has a semantics of finite runs (LTLf), but a controller runs for ever",
                                "if its formulas mean the same on infinite runs, write `Mealy` or `Moore`, with or without `,Strict`",
                            );
                            file.finite = true;
                        } else {
                            self.report.syntax(
                                range,
                                "this is not a semantics of the format",
                                "write `Mealy` or `Moore`, optionally followed by `,Strict`",
                            );
                        }
                        // A default, so that the error is not reported again.
                        file.semantics = Some(Semantics {
                            moore: false,
                            strict: false,
                        });
                    }
                }
                Some("TARGET") => {
                    self.at += 1;
                    self.expect(":");
                    if let Some(word @ ("Mealy" | "Moore")) = self.peek() {
                        self.at += 1;
                        file.target = Some(word == "Moore");
                    } else {
                        let _: Option<()> = self.missing_with(
                            "Mealy or Moore",
                            "write `TARGET: Mealy` or `TARGET: Moore`",
                        );
                        file.target = Some(false);
                        self.at += usize::from(self.peek().is_some_and(|w| w != "}"));
                    }
                }
                Some("TAGS") => {
                    self.at += 1;
                    self.expect(":");
                    self.words_of_info();
                }
                Some(word) => {
                    self.report.syntax(
                        place,
                        format!("`{}` is not an entry of INFO", quoted(word)),
                        "INFO has TITLE, DESCRIPTION, SEMANTICS, TARGET and TAGS, each followed by `:`",
                    );
                    self.at += 1;
                    while self.peek().is_some_and(|w| {
                        !matches!(
                            w,
                            "}" | "TITLE" | "DESCRIPTION" | "SEMANTICS" | "TARGET" | "TAGS"
                        )
                    }) {
                        self.at += 1;
                    }
                }
            }
        }
    }

    /// Parses words separated by commas.
    pub(super) fn words_of_info(&mut self) -> Vec<Range<usize>> {
        let mut found = Vec::new();
        while let Some(token) = self.tokens.get(self.at) {
            let text = self.word(&token.range);
            let entry = matches!(
                text,
                "TITLE" | "DESCRIPTION" | "SEMANTICS" | "TARGET" | "TAGS"
            );
            if text == "}" || entry {
                break;
            }
            if text != "," {
                found.push(token.range.clone());
            }
            self.at += 1;
        }
        found
    }
}
