//! Parses counters: `counter NAME(0..9) { NAME = 0; inc: p; reset: q; overflow: keep; }`.

use super::words::Word;
use super::{Parsed, Parser};
use crate::spectra::syntax::{Counter, Overflow};

impl Parser<'_> {
    pub fn counter(&mut self) -> Parsed<Counter> {
        self.next();
        let name = self.name("the counter's name")?;
        let help = "write `counter NAME(0..9) { NAME = 0; inc: p; reset: q; overflow: keep; }`";
        self.expect("(", help)?;
        let (low, high) = self.range()?;
        self.expect(")", help)?;
        self.expect("{", help)?;
        let mut counter = Counter {
            name,
            low,
            high,
            initial: Vec::new(),
            reset: Vec::new(),
            up: Vec::new(),
            down: Vec::new(),
            overflow: None,
            underflow: None,
        };
        while !self.take("}") {
            if self.token().0 == Word::End {
                return self.unexpected("`}`", "close the braces");
            }
            let section = if self.is_ahead(1, ":") {
                self.word()
            } else {
                ""
            };
            if section.is_empty() {
                if matches!(self.word(), "ini" | "initially") {
                    self.next();
                }
                counter.initial.push(self.formula()?);
            } else {
                let start = self.start();
                if !matches!(section, "reset" | "inc" | "dec" | "overflow" | "underflow") {
                    return self.unexpected(
                        "a section of a counter",
                        "sections are `reset:`, `inc:`, `dec:`, `overflow:` and `underflow:`",
                    );
                }
                self.next();
                self.next();
                match section {
                    "reset" => counter.reset.push(self.formula()?),
                    "inc" => counter.up.push(self.formula()?),
                    "dec" => counter.down.push(self.formula()?),
                    _ => {
                        let method = match self.word() {
                            "keep" => Overflow::Keep,
                            "false" => Overflow::Refuse,
                            "modulo" => Overflow::Modulo,
                            _ => {
                                return self.unexpected("`keep`, `false` or `modulo`", "`keep` stays at the end of the range, `modulo` continues at the other end, `false` forbids leaving the range");
                            }
                        };
                        self.next();
                        let method = Some((method, self.since(start)));
                        if section == "overflow" {
                            counter.overflow = method;
                        } else {
                            counter.underflow = method;
                        }
                    }
                }
            }
            self.end()?;
        }
        Ok(counter)
    }
}
