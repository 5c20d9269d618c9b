//! Prints a profile as a file. The same profile always gives the same text, which parses back to
//! the same profile.

use super::{Profile, SCHEMA};
use std::fmt::Write as _;

impl Profile {
    /// Formats the profile as TOML.
    pub fn to_toml(&self) -> String {
        let layout = &self.layout;
        let tag = &layout.tag;
        let mut out = String::from(
            "# A layout of Plant Simulation's UF_Value. Offsets and sizes are in bytes.\n",
        );
        let _ = writeln!(out, "schema = {}", quoted(SCHEMA));
        let _ = writeln!(out, "name = {}", quoted(&self.name));
        let _ = writeln!(out, "found = {}", quoted(&self.found));
        let _ = writeln!(out, "verified = {}", self.is_verified());
        if let (true, Some(fingerprint)) = (self.is_verified(), &self.confirmed) {
            let _ = writeln!(
                out,
                "confirmed = {} # fingerprint of the confirmed layout",
                quoted(fingerprint)
            );
        }
        let _ = writeln!(out, "\n[layout]");
        let _ = writeln!(
            out,
            "size = {} # distance from one argument to the next",
            layout.size
        );
        let _ = writeln!(out, "packing = {}", layout.packing);
        let _ = writeln!(out, "value = {} # offset", layout.value);
        let _ = writeln!(out, "integer_bits = {}", layout.integer_bits);
        let _ = writeln!(out, "strings = {}", quoted(layout.strings.name()));
        let _ = writeln!(out, "\n[tag]");
        let _ = writeln!(out, "offset = {}", tag.offset);
        let _ = writeln!(out, "bits = {}", tag.bits);
        let _ = writeln!(out, "integer = {}", tag.integer);
        let _ = writeln!(out, "real = {}", tag.real);
        let _ = writeln!(out, "string = {}", tag.string);
        if let Some(boolean) = tag.boolean {
            let _ = writeln!(out, "boolean = {boolean}");
        }
        if !tag.more_real.is_empty() {
            let more: Vec<String> = tag.more_real.iter().map(u64::to_string).collect();
            let _ = writeln!(
                out,
                "more_real = [{}] # times, lengths and the like",
                more.join(", ")
            );
        }
        out
    }
}

/// Formats a TOML basic string.
fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => out.extend(['\\', c]),
            c if c.is_control() => {
                let _ = write!(out, "\\u{:04X}", u32::from(c));
            }
            c => out.push(c),
        }
    }
    out.push('"');
    out
}
