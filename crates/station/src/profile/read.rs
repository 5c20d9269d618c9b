//! Parses a profile strictly: unknown and missing keys, impossible values and overlapping fields
//! give findings, all reported in one run with their positions.
//!
//! The `toml` crate returns the tree with the position of every key and value. This module reads
//! the tree itself, because a derived reader stops at the first error.

use super::{Encoding, Layout, MAX_SIZE, Profile, SCHEMA, Tag, VALUE_BYTES};
use linewright_core::diagnostics::{Diagnostic, codes, nearest};
use linewright_core::source::{FileId, Span};
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Maximum number of characters of the profile's name.
const MAX_NAME_CHARS: usize = 60;

/// Maximum number of characters of the line about the profile's origin.
const MAX_ORIGIN_CHARS: usize = 200;

/// Parses a profile.
///
/// # Errors
/// Returns findings about all mistakes in the text.
pub fn parse(file: FileId, text: &str) -> Result<Profile, Vec<Diagnostic>> {
    let mut reader = Reader {
        file,
        findings: Vec::new(),
    };
    let profile = reader.profile(text);
    match profile {
        Some(profile) if reader.findings.is_empty() => Ok(profile),
        _ => Err(reader.findings),
    }
}

struct Reader {
    file: FileId,
    findings: Vec<Diagnostic>,
}

/// A table whose keys are read one by one; keys that are never read are unknown.
struct Fields<'t, 'i> {
    table: &'t DeTable<'i>,
    place: Range<usize>,
    within: &'static str,
    known: Vec<&'static str>,
}

/// A value with its position.
type SpannedValue<T> = Spanned<T>;

impl Reader {
    fn report(&mut self, place: Range<usize>, message: String, help: impl Into<String>) {
        let span = Span::new(self.file, place.start, place.end);
        self.findings
            .push(Diagnostic::error(codes::PROFILE, span, message).with_help(help));
    }

    fn profile(&mut self, text: &str) -> Option<Profile> {
        let (document, errors) = DeTable::parse_recoverable(text);
        for error in errors {
            let place = error.span().unwrap_or(0..0);
            let end = place.end.min(text.len());
            self.report(
                place.start.min(end)..end,
                format!("this is not TOML: {}", error.message().replace('\n', " ")),
                "correct the TOML; `linewright explain LW540` shows a complete profile",
            );
        }
        if !self.findings.is_empty() {
            return None;
        }
        let mut top = Fields::of(document.get_ref(), 0..0, "");
        let schema = self.text(&mut top, "schema");
        if let Some(schema) = schema.filter(|s| s.get_ref() != SCHEMA) {
            self.report(
                schema.span(),
                format!("the schema is \"{}\", not \"{SCHEMA}\"", schema.get_ref()),
                format!("use a profile with the schema \"{SCHEMA}\"; `linewright doctor --probe` writes one"),
            );
        }
        let name = self.line(&mut top, "name", MAX_NAME_CHARS);
        let found = self.line(&mut top, "found", MAX_ORIGIN_CHARS);
        let verified = self.required(&mut top, "verified", "true or false", |v| match v {
            DeValue::Boolean(b) => Some(*b),
            _ => None,
        });
        let confirmed = if top.has("confirmed") {
            self.text(&mut top, "confirmed")
        } else {
            top.known.push("confirmed");
            None
        };
        let layout = self.fields(&mut top, "layout").map(|mut f| {
            let layout = self.layout(&mut f);
            self.unknown(&f);
            layout
        });
        let tag = self.fields(&mut top, "tag").map(|mut f| {
            let tag = self.tag(&mut f);
            self.unknown(&f);
            tag
        });
        self.unknown(&top);
        let (layout, tag) = (layout??, tag??);
        let layout = self.together(&layout, &tag);
        let fingerprint = layout.fingerprint();
        let claimed = confirmed.is_some();
        let confirmed = confirmed.filter(|c| {
            if *c.get_ref() != fingerprint {
                self.report(
                    c.span(),
                    "the layout differs from the layout that was confirmed".to_owned(),
                    "undo the change; or delete this line, set `verified = false`, and confirm the layout with the probe",
                );
            }
            *c.get_ref() == fingerprint
        });
        match verified {
            Some(v) if *v.get_ref() && !claimed => self.report(
                v.span(),
                "the profile is verified without a confirmation".to_owned(),
                "set it to false: only `doctor --probe` on the dump of the second round writes a verified profile",
            ),
            Some(v) if !*v.get_ref() && claimed => self.report(
                v.span(),
                "the profile has a confirmation but is not verified".to_owned(),
                "delete the line `confirmed`, or set this to true",
            ),
            _ => {}
        }
        Some(Profile {
            name: name?,
            found: found?,
            confirmed: confirmed.map(Spanned::into_inner),
            layout,
        })
    }

    /// Reads the table `[layout]`.
    fn layout(&mut self, fields: &mut Fields<'_, '_>) -> Option<PlacedLayout> {
        let size = self.number(fields, "size", 9..=i64::from(MAX_SIZE));
        let packing = self.one_of(fields, "packing", &[1, 2, 4, 8]);
        let value = self.number(fields, "value", 0..=i64::from(MAX_SIZE - VALUE_BYTES));
        let integer_bits = self.one_of(fields, "integer_bits", &[16, 32, 64]);
        let strings = self.required(fields, "strings", "an encoding", |v| {
            v.as_str().map(str::to_owned)
        });
        let strings = strings.and_then(|given| {
            let known = Encoding::ALL
                .into_iter()
                .find(|e| e.name() == given.get_ref());
            if known.is_none() {
                let words = Encoding::ALL.map(Encoding::name);
                let help = match nearest(given.get_ref(), words.into_iter()) {
                    Some(word) => format!("did you mean \"{word}\"?"),
                    None => format!("choose one of {}", words.join(", ")),
                };
                self.report(
                    given.span(),
                    format!("\"{}\" is not a string encoding", given.get_ref()),
                    help,
                );
            }
            known
        });
        Some(PlacedLayout {
            size: size?,
            packing: packing?,
            value: value?,
            integer_bits: integer_bits?,
            strings: strings?,
        })
    }

    /// Reads the table `[tag]`.
    fn tag(&mut self, fields: &mut Fields<'_, '_>) -> Option<PlacedTag> {
        let offset = self.number(fields, "offset", 0..=i64::from(MAX_SIZE - 1));
        let bits = self.one_of(fields, "bits", &[8, 16, 32, 64]);
        let any = 0..=i64::MAX;
        let (mut tags, mut complete) = (Vec::new(), true);
        for key in ["integer", "real", "string", "boolean"] {
            if key == "boolean" && !fields.has(key) {
                fields.known.push(key);
                continue;
            }
            match self.number(fields, key, any.clone()) {
                Some(number) => tags.push((key, number)),
                None => complete = false,
            }
        }
        if fields.has("more_real") {
            for tag in self.numbers(fields, "more_real") {
                tags.push(("more_real", tag));
            }
        } else {
            fields.known.push("more_real");
        }
        self.distinct(bits.as_ref().map(|b| *b.get_ref()), &tags);
        complete.then_some(PlacedTag {
            offset: offset?,
            bits: bits?,
            tags,
        })
    }

    /// Checks that the tags fit their field and are distinct.
    fn distinct(&mut self, bits: Option<i64>, tags: &[(&'static str, SpannedValue<i64>)]) {
        for (i, (name, number)) in tags.iter().enumerate() {
            if let Some(bits) = bits.filter(|b| *b < 64 && *number.get_ref() >> b != 0) {
                self.report(
                    number.span(),
                    format!(
                        "{} does not fit into the {bits} bits of a tag",
                        number.get_ref()
                    ),
                    "increase `bits`, or correct the number",
                );
            }
            let mut before = tags[..i].iter();
            if let Some((other, _)) = before.find(|(_, n)| n.get_ref() == number.get_ref()) {
                self.report(
                    number.span(),
                    format!(
                        "`{other}` and `{name}` have the same tag {}",
                        number.get_ref()
                    ),
                    "give each kind of value a different tag",
                );
            }
        }
    }

    /// Checks that layout and tag are compatible, and combines them.
    fn together(&mut self, layout: &PlacedLayout, tag: &PlacedTag) -> Layout {
        let bytes = *tag.bits.get_ref() / 8;
        let (size, value, offset) = (
            *layout.size.get_ref(),
            *layout.value.get_ref(),
            *tag.offset.get_ref(),
        );
        let width = i64::from(VALUE_BYTES);
        if value + width > size {
            self.report(
                layout.value.span(),
                format!(
                    "the value occupies bytes {value} to {}, but `size` is {size}",
                    value + width - 1
                ),
                format!(
                    "set `size` to at least {}, or decrease the value's offset",
                    value + width
                ),
            );
        }
        if offset + bytes > size {
            self.report(
                tag.offset.span(),
                format!(
                    "the tag occupies bytes {offset} to {}, but `size` is {size}",
                    offset + bytes - 1
                ),
                format!(
                    "set `size` to at least {}, or decrease the tag's offset",
                    offset + bytes
                ),
            );
        }
        if offset < value + width && value < offset + bytes {
            self.report(
                tag.offset.span(),
                format!(
                    "the tag in bytes {offset} to {} overlaps the value in bytes {value} to {}",
                    offset + bytes - 1,
                    value + width - 1
                ),
                "move the tag before or after the value, which always has 8 bytes, or make the tag narrower",
            );
        }
        let packing = *layout.packing.get_ref();
        for (what, place, of, own) in [
            ("the value's offset is", layout.value.span(), value, width),
            ("the tag's offset is", tag.offset.span(), offset, bytes),
            ("the size is", layout.size.span(), size, width),
        ] {
            let unit = packing.min(own);
            if of % unit != 0 {
                self.report(
                    place,
                    format!("{what} {of}, but `packing = {packing}` requires a multiple of {unit}"),
                    "decrease the packing, or correct the number",
                );
            }
        }
        let all = |wanted: &str| -> Vec<u64> {
            let named = tag.tags.iter().filter(|(name, _)| *name == wanted);
            named.map(|(_, number)| *number.get_ref() as u64).collect()
        };
        let one = |wanted: &str| all(wanted).first().copied();
        Layout {
            size: size as u32,
            packing: packing as u32,
            value: value as u32,
            integer_bits: *layout.integer_bits.get_ref() as u32,
            strings: layout.strings,
            tag: Tag {
                offset: offset as u32,
                bits: *tag.bits.get_ref() as u32,
                integer: one("integer").unwrap_or_default(),
                real: one("real").unwrap_or_default(),
                string: one("string").unwrap_or_default(),
                boolean: one("boolean"),
                more_real: all("more_real"),
            },
        }
    }

    /// Reads a required value, converted by `read`; `wanted` describes it in messages.
    fn required<T>(
        &mut self,
        fields: &mut Fields<'_, '_>,
        key: &'static str,
        wanted: &str,
        read: impl FnOnce(&DeValue<'_>) -> Option<T>,
    ) -> Option<SpannedValue<T>> {
        let Some(value) = fields.take(key) else {
            let within = fields.within;
            let place = fields.place.clone();
            self.report(
                place,
                format!("`{key}` is missing{within}"),
                format!(
                    "add `{key} = ...`, {wanted}; `linewright explain LW540` shows a complete profile"
                ),
            );
            return None;
        };
        let read = read(value.get_ref());
        if read.is_none() {
            self.report(
                value.span(),
                format!("`{key}` is not {wanted}"),
                format!("write {wanted}"),
            );
        }
        read.map(|v| Spanned::new(value.span(), v))
    }

    fn text(
        &mut self,
        fields: &mut Fields<'_, '_>,
        key: &'static str,
    ) -> Option<SpannedValue<String>> {
        self.required(fields, key, "a text in quotes", |v| {
            v.as_str().map(str::to_owned)
        })
    }

    /// Reads a single line of text that is neither empty nor too long.
    fn line(
        &mut self,
        fields: &mut Fields<'_, '_>,
        key: &'static str,
        max_chars: usize,
    ) -> Option<String> {
        let text = self.text(fields, key)?;
        let value = text.get_ref();
        if value.trim().is_empty()
            || value.chars().count() > max_chars
            || value.chars().any(char::is_control)
        {
            self.report(
                text.span(),
                format!("`{key}` is not one line of 1 to {max_chars} characters"),
                "write one short line",
            );
            return None;
        }
        // Messages show the name next to "(verified)" or "(unverified)", so the name must not
        // contain such a word.
        if key == "name" && value.to_lowercase().contains("verified") {
            self.report(
                text.span(),
                format!("the name \"{value}\" contains the word \"verified\""),
                "choose another name; the key `verified` states whether the layout is verified",
            );
        }
        Some(text.into_inner())
    }

    fn number(
        &mut self,
        fields: &mut Fields<'_, '_>,
        key: &'static str,
        within: std::ops::RangeInclusive<i64>,
    ) -> Option<SpannedValue<i64>> {
        let wanted = if *within.end() == i64::MAX {
            format!("an integer from {}", within.start())
        } else {
            format!("an integer from {} to {}", within.start(), within.end())
        };
        self.required(fields, key, &wanted, |v| {
            whole(v).filter(|n| within.contains(n))
        })
    }

    fn one_of(
        &mut self,
        fields: &mut Fields<'_, '_>,
        key: &'static str,
        all: &[i64],
    ) -> Option<SpannedValue<i64>> {
        let words: Vec<String> = all.iter().map(i64::to_string).collect();
        let wanted = format!("one of {}", words.join(", "));
        self.required(fields, key, &wanted, |v| {
            whole(v).filter(|n| all.contains(n))
        })
    }

    /// Reads a list of tags.
    fn numbers(
        &mut self,
        fields: &mut Fields<'_, '_>,
        key: &'static str,
    ) -> Vec<SpannedValue<i64>> {
        let wanted = "a list of integers from 0";
        let read = self.required(fields, key, wanted, |v| {
            let all = v.as_array()?.iter().map(|item| {
                let number = whole(item.get_ref()).filter(|n| *n >= 0)?;
                Some(Spanned::new(item.span(), number))
            });
            all.collect::<Option<Vec<_>>>()
        });
        read.map(Spanned::into_inner).unwrap_or_default()
    }

    fn fields<'t, 'i>(
        &mut self,
        top: &mut Fields<'t, 'i>,
        key: &'static str,
    ) -> Option<Fields<'t, 'i>> {
        let Some(value) = top.take(key) else {
            self.report(
                0..0,
                format!("the table `[{key}]` is missing"),
                "add the table; `linewright explain LW540` shows a complete profile",
            );
            return None;
        };
        let Some(table) = value.get_ref().as_table() else {
            self.report(
                value.span(),
                format!("`{key}` is not a table"),
                format!("write a line `[{key}]`, followed by its keys"),
            );
            return None;
        };
        let within = if key == "tag" {
            " in `[tag]`"
        } else {
            " in `[layout]`"
        };
        Some(Fields::of(table, value.span(), within))
    }

    fn unknown(&mut self, fields: &Fields<'_, '_>) {
        for (key, _) in fields.table {
            let name = key.get_ref().as_ref();
            if fields.known.contains(&name) {
                continue;
            }
            let help = match nearest(name, fields.known.iter().copied()) {
                Some(word) => format!("did you mean `{word}`?"),
                None => format!("the possible keys are `{}`", fields.known.join("`, `")),
            };
            self.report(
                key.span(),
                format!("there is no key `{name}`{}", fields.within),
                help,
            );
        }
    }
}

struct PlacedLayout {
    size: SpannedValue<i64>,
    packing: SpannedValue<i64>,
    value: SpannedValue<i64>,
    integer_bits: SpannedValue<i64>,
    strings: Encoding,
}

struct PlacedTag {
    offset: SpannedValue<i64>,
    bits: SpannedValue<i64>,
    tags: Vec<(&'static str, SpannedValue<i64>)>,
}

impl<'t, 'i> Fields<'t, 'i> {
    fn of(table: &'t DeTable<'i>, place: Range<usize>, within: &'static str) -> Self {
        Self {
            table,
            place,
            within,
            known: Vec::new(),
        }
    }

    fn has(&self, key: &str) -> bool {
        self.table.get(key).is_some()
    }

    fn take(&mut self, key: &'static str) -> Option<&'t Spanned<DeValue<'i>>> {
        self.known.push(key);
        self.table.get(key)
    }
}

/// Reads an integer that fits 64 bits.
fn whole(value: &DeValue<'_>) -> Option<i64> {
    let number = value.as_integer()?;
    i64::from_str_radix(number.as_str(), number.radix()).ok()
}
