//! Infers the layout of `UF_Value` from a probe's dump.
//!
//! Each answer must explain all observations:
//!
//! - The value is at the offset at which every call with a number shows this number, and every call
//!   with a text shows a pointer to this text.
//! - The size of an argument is the distance from one value to the next.
//! - The width of an integer is the number of bytes that match the number, including its sign.
//! - The tag is at the offset at which the bytes differ between kinds and agree within each kind.
//!
//! Open questions are reported, with advice. Finally, the complete layout must explain every call.

use super::dump::{Dump, Record};
use super::texts::{encoding, reads};
use super::{CONFIRM_EXPORT, Kind, Value, returned_values};
use crate::profile::{Encoding, Layout, MAX_SIZE, Profile, Tag, VALUE_BYTES, read};
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::source::{FileId, Span};
use schemars::JsonSchema;
use serde::Serialize;
use std::fmt::Write as _;

/// Certainty of an answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, JsonSchema, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Confidence {
    /// No other answer explains the dump.
    Certain,
    /// Another answer also explains the dump, but is less simple or makes no difference.
    Likely,
    /// The dump does not determine the answer; this is the simplest one.
    Open,
}

/// The answer to one question.
#[derive(Debug, Clone, PartialEq, Eq, JsonSchema, Serialize)]
pub struct Fact {
    /// The question: `tag width`.
    pub what: &'static str,
    /// The answer.
    pub found: String,
    /// Certainty of the answer.
    pub sure: Confidence,
    /// Reason for the answer, and advice if it is not certain.
    pub why: String,
}

/// A layout with the evidence for it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Inference {
    /// The layout.
    pub layout: Layout,
    /// The answers to all questions.
    pub facts: Vec<Fact>,
}

/// Advice if no layout can be found.
const VENDOR: &str = "run the probe's complete SimTalk method without changes; if that does not help, compile with the vendor's header (-DUF_USE_VENDOR_HEADER)";

/// Infers the layout from a dump's calls.
pub fn infer(dump: &Dump) -> Result<Inference, Box<Diagnostic>> {
    let mut facts = Vec::new();
    let value = value_offset(dump, &mut facts)?;
    let size = distance(dump, value, &mut facts)?;
    let unit = |p: &&usize| value % **p == 0 && size % **p == 0;
    let packing = *[8, 4, 2].iter().find(unit).unwrap_or(&1);
    facts.push(Fact {
        what: "packing",
        found: packing.to_string(),
        sure: Confidence::Certain,
        why: format!("value and size are multiples of {packing}"),
    });
    let slots = slots(dump, size);
    let integer_bits = integer_bits(&slots, value, &mut facts);
    let tag = tag(&slots, value, packing, integer_bits, &mut facts)?;
    let strings = encoding(&slots, value, &mut facts);
    let layout = Layout {
        size: size as u32,
        packing: packing as u32,
        value: value as u32,
        integer_bits,
        strings,
        tag,
    };
    // Texts that the host changed are already reported, so only the other arguments must match.
    let mismatch = dump
        .calls
        .iter()
        .find_map(|r| explain(&layout, r, false).err());
    match mismatch {
        Some(finding) => Err(finding),
        None => Ok(Inference { layout, facts }),
    }
}

/// Evaluates the second round: checks whether the host read the returned values with the profile's
/// layout, and returns the confirmed profile. `None` for a dump of the first round.
pub fn confirm(dump: &Dump) -> Option<Result<Profile, Vec<Diagnostic>>> {
    let text = dump.profile.as_ref()?;
    Some(judge(dump, text))
}

fn judge(dump: &Dump, text: &str) -> Result<Profile, Vec<Diagnostic>> {
    let start = dump.calls.first().map(|c| c.place);
    let mut profile = read::parse(FileId::default(), text).map_err(|findings| {
        let first = findings.first().map_or("", |f| f.message.as_str());
        let message = format!("the profile in the dump is damaged: {first}");
        vec![Diagnostic::error(codes::DUMP, start, message).with_help(
            "build the probe again with `build --probe --profile FILE`, and run it again",
        )]
    })?;
    let wanted = returned_values(profile.layout.integer_bits);
    let seen: Vec<&Record> = dump
        .calls
        .iter()
        .filter(|r| r.name == CONFIRM_EXPORT)
        .collect();
    if seen.is_empty() || seen.iter().any(|r| r.expects != wanted) {
        return Err(vec![
            Diagnostic::error(
                codes::LAYOUT_REFUTED,
                start,
                format!("the dump contains no complete call of `{CONFIRM_EXPORT}`: the host did not pass the returned values back"),
            )
            .with_help("run the SimTalk method of the second round to its end; if the host crashes in it, the layout is wrong: delete the profile, and run `linewright doctor --probe` on the first dump again"),
        ]);
    }
    // The texts of the first round might have been changed when they were pasted into the method.
    // The texts that the library itself returned cannot have been changed.
    let misfits: Vec<Diagnostic> = dump
        .calls
        .iter()
        .filter_map(|r| explain(&profile.layout, r, r.name == CONFIRM_EXPORT).err())
        .map(|mut finding| {
            finding.code = codes::LAYOUT_REFUTED;
            *finding
        })
        .collect();
    if !misfits.is_empty() {
        return Err(misfits);
    }
    profile.confirmed = Some(profile.layout.fingerprint());
    Ok(profile)
}

/// Infers the offset of the value.
fn value_offset(dump: &Dump, facts: &mut Vec<Fact>) -> Result<usize, Box<Diagnostic>> {
    let mut left: Vec<usize> = (0..=(MAX_SIZE - VALUE_BYTES) as usize).collect();
    for (kind, what, min_calls) in [
        (Kind::Real, "real numbers", 2),
        (Kind::Integer, "integers", 2),
        (Kind::Text, "strings", 1),
    ] {
        let firsts = dump
            .calls
            .iter()
            .filter_map(|r| Some((r, r.expects.first()?)));
        let firsts: Vec<(&Record, &Value)> = firsts
            .filter(|(_, v)| v.kind() == kind && !is_empty(v))
            .collect();
        if firsts.len() < min_calls {
            let message = format!("the dump has too few calls with {what}");
            return Err(Box::new(open(dump.calls.first(), message)));
        }
        left.retain(|&v| firsts.iter().all(|(r, value)| holds(r, v, value)));
        if left.is_empty() {
            let message = format!(
                "no offset in the first {MAX_SIZE} bytes at `arg` holds all {what} that were passed"
            );
            return Err(Box::new(open(firsts.first().map(|(r, _)| *r), message)));
        }
    }
    let certain = left.len() == 1;
    facts.push(Fact {
        what: "value",
        found: format!("offset {}", left[0]),
        sure: if certain {
            Confidence::Certain
        } else {
            Confidence::Open
        },
        why: if certain {
            "all numbers and the addresses of all texts are there".to_owned()
        } else {
            format!(
                "all values are also at offset {}; the second round decides",
                left[1]
            )
        },
    });
    Ok(left[0])
}

/// Infers the distance in bytes from one argument to the next.
fn distance(dump: &Dump, value: usize, facts: &mut Vec<Fact>) -> Result<usize, Box<Diagnostic>> {
    let several: Vec<&Record> = dump.calls.iter().filter(|r| r.expects.len() > 1).collect();
    if several.is_empty() {
        let message = "the dump has no call with several arguments".to_owned();
        return Err(Box::new(open(dump.calls.first(), message)));
    }
    let fits = |size: &usize| {
        several.iter().all(|r| {
            let mut values = r.expects.iter().enumerate();
            values.all(|(i, v)| is_empty(v) || holds(r, i * size + value, v))
        })
    };
    let min_size = value + VALUE_BYTES as usize;
    let sizes: Vec<usize> = (min_size.max(9)..=MAX_SIZE as usize).filter(fits).collect();
    let Some(&size) = sizes.first() else {
        let message = "no distance between the arguments of a call explains the dump".to_owned();
        return Err(Box::new(open(several.first().copied(), message)));
    };
    let certain = sizes.len() == 1;
    facts.push(Fact {
        what: "size",
        found: format!("{size} bytes"),
        sure: if certain {
            Confidence::Certain
        } else {
            Confidence::Open
        },
        why: if certain {
            "distance between the arguments of a call".to_owned()
        } else {
            format!(
                "{} bytes would fit as well; the second round decides",
                sizes[1]
            )
        },
    });
    Ok(size)
}

/// An argument: its value and the bytes of its `UF_Value`.
pub(super) struct Slot<'d> {
    pub(super) value: &'d Value,
    bytes: &'d [u8],
    /// The call, and the offset of this argument in the bytes at `arg`.
    pub(super) record: &'d Record,
    pub(super) base: usize,
}

fn slots(dump: &Dump, size: usize) -> Vec<Slot<'_>> {
    let of = |record| move |(i, value)| slot(record, i * size, size, value);
    let each = |r| Record::values(r).filter_map(of(r));
    dump.calls.iter().flat_map(each).collect()
}

fn slot<'d>(record: &'d Record, base: usize, size: usize, value: &'d Value) -> Option<Slot<'d>> {
    let bytes = record.arg.get(base..base + size)?;
    Some(Slot {
        value,
        bytes,
        record,
        base,
    })
}

impl Record {
    fn values(&self) -> impl Iterator<Item = (usize, &Value)> {
        self.expects.iter().enumerate()
    }
}

/// Infers the width of an integer in bits.
fn integer_bits(slots: &[Slot<'_>], value: usize, facts: &mut Vec<Fact>) -> u32 {
    let seen: Vec<(i64, &[u8])> = slots
        .iter()
        .filter_map(|s| match s.value {
            Value::Integer(i) => Some((*i, &s.bytes[value..value + 8])),
            _ => None,
        })
        .collect();
    let fits = |bits: &u32| {
        let bytes = (bits / 8) as usize;
        let same = |(i, b): &(i64, &[u8])| i.to_le_bytes()[..bytes] == b[..bytes];
        seen.iter().all(same)
    };
    let bits = [64, 32, 16].into_iter().find(fits).unwrap_or(16);
    let negative = seen.iter().any(|(i, _)| *i < 0);
    let large = seen.iter().any(|(i, _)| i16::try_from(*i).is_err());
    let certain = negative && large;
    facts.push(Fact {
        what: "integers",
        found: format!("{bits} bits"),
        sure: if certain {
            Confidence::Certain
        } else {
            Confidence::Likely
        },
        why: if certain {
            "all integers match in this width, including their signs".to_owned()
        } else {
            "no negative or no large integer was passed; run the probe again with all its integers"
                .to_owned()
        },
    });
    bits
}

/// Infers the tag: its offset, its width, and the number of each kind.
fn tag(
    slots: &[Slot<'_>],
    value: usize,
    packing: usize,
    integer_bits: u32,
    facts: &mut Vec<Fact>,
) -> Result<Tag, Box<Diagnostic>> {
    let size = slots.first().map_or(0, |s| s.bytes.len());
    let in_value = |o: usize| o >= value && o < value + VALUE_BYTES as usize;
    let clear = |o: usize, n: usize| o + n <= size && !(o..o + n).any(in_value);
    // At the tag's offset, the bytes differ between kinds and agree within each kind.
    let mut places = Vec::new();
    for width in [1, 2, 4, 8] {
        let distinct = |&o: &usize| {
            let kinds = [Kind::Integer, Kind::Real, Kind::Text];
            let of = kinds.map(|k| agreed(slots, k, o, width));
            clear(o, width)
                && of.iter().all(Option::is_some)
                && of[0] != of[1]
                && of[0] != of[2]
                && of[1] != of[2]
        };
        places = (0..size).filter(distinct).collect();
        if let Some(first) = places.first_mut() {
            // A field begins at a multiple of its size, so bytes before it that are always 0 belong
            // to it.
            let start = *first / packing.min(4) * packing.min(4);
            let zero = |o: usize| slots.iter().all(|s| s.bytes[o] == 0);
            if clear(start, *first - start) && (start..*first).all(zero) {
                let needed = *first + width - start;
                *first = start;
                return Ok(wide(
                    slots,
                    start,
                    needed,
                    &places[1..],
                    value,
                    packing,
                    integer_bits,
                    facts,
                ));
            }
            let start = *first;
            return Ok(wide(
                slots,
                start,
                width,
                &places[1..],
                value,
                packing,
                integer_bits,
                facts,
            ));
        }
    }
    drop(places);
    let message =
        "no bytes outside the value distinguish integers, real numbers and strings".to_owned();
    Err(Box::new(open(slots.first().map(|s| s.record), message)))
}

/// Returns the number that all values of a kind have at an offset; `None` if they differ.
fn agreed(slots: &[Slot<'_>], kind: Kind, offset: usize, width: usize) -> Option<u64> {
    let mut numbers = slots
        .iter()
        .filter(|s| s.value.kind() == kind)
        .map(|s| number(s.bytes, offset, width));
    let first = numbers.next()??;
    numbers.all(|n| n == Some(first)).then_some(first)
}

fn number(bytes: &[u8], offset: usize, width: usize) -> Option<u64> {
    let mut wide = [0; 8];
    wide[..width].copy_from_slice(bytes.get(offset..offset + width)?);
    Some(u64::from_le_bytes(wide))
}

/// Infers the width of the tag that begins at `start` and has at least `needed` bytes, and the
/// tag's number for each kind. `others` are further possible offsets.
#[expect(
    clippy::too_many_arguments,
    reason = "all evidence for one question is passed"
)]
fn wide(
    slots: &[Slot<'_>],
    start: usize,
    needed: usize,
    others: &[usize],
    value: usize,
    packing: usize,
    integer_bits: u32,
    facts: &mut Vec<Fact>,
) -> Tag {
    let size = slots.first().map_or(0, |s| s.bytes.len());
    let end = value + VALUE_BYTES as usize;
    let zero = |o: usize| slots.iter().all(|s| s.bytes[o] == 0);
    let possible = |w: &usize| {
        *w >= needed
            && start.is_multiple_of(packing.min(*w))
            && start + w <= size
            && (start + w <= value || start >= end)
            && (start + needed..start + w).all(zero)
    };
    let mut widths: Vec<usize> = [1, 2, 4, 8].into_iter().filter(possible).collect();
    // The tag is followed by the value, or by the end of the argument, as closely as the packing
    // allows.
    let closes = |w: &usize| {
        let next = (start + w).next_multiple_of(packing);
        next == if start < value { value } else { size }
    };
    if widths.iter().any(closes) {
        widths.retain(closes);
    }
    // Whether the host leaves unused bytes unchanged. If it does, it must have written the bytes
    // that are always 0, so they belong to the tag.
    let widest = widths.last().copied().unwrap_or(needed);
    let idle = |s: &Slot<'_>| {
        let outside = (0..size).any(|o| {
            (o < start || o >= start + widest) && (o < value || o >= end) && s.bytes[o] != 0
        });
        let used = match s.value {
            Value::Integer(_) => value + integer_bits as usize / 8,
            Value::Boolean(_) => value + 4,
            _ => end,
        };
        // The probe reads `ret` before it returns a value, so the bytes of the value there are
        // unused.
        let answer = s.record.ret.get(value..end);
        let set = |bytes: &[u8]| bytes.iter().any(|b| *b != 0);
        outside || set(&s.bytes[used..end]) || answer.is_some_and(set)
    };
    let unclean = slots.iter().any(idle);
    let width = if widths.len() > 1 && !unclean && widths.contains(&4) {
        4
    } else {
        widest
    };
    facts.push(Fact {
        what: "tag",
        found: format!("offset {start}"),
        sure: if others.is_empty() {
            Confidence::Certain
        } else {
            Confidence::Likely
        },
        why: match others.first() {
            None => "the bytes there differ between kinds and agree within each kind".to_owned(),
            Some(other) => format!("kinds also differ at offset {other}; the second round decides"),
        },
    });
    let words: Vec<String> = widths.iter().map(|w| (8 * w).to_string()).collect();
    facts.push(Fact {
        what: "tag width",
        found: format!("{} bits", 8 * width),
        sure: if widths.len() > 1 {
            Confidence::Likely
        } else {
            Confidence::Certain
        },
        why: if widths.len() <= 1 {
            "no other width explains the bytes".to_owned()
        } else if unclean {
            format!(
                "the widest of {}: its further bytes are always 0, although the host does not clear unused bytes",
                words.join(", ")
            )
        } else {
            format!(
                "{} are possible and make no difference: the further bytes are always 0",
                words.join(", ")
            )
        },
    });
    let of = |kind| {
        let mut own = slots.iter().filter(|s| s.value.kind() == kind);
        let there = own.all(|s| is_empty(s.value) || holds(s.record, s.base + value, s.value));
        agreed(slots, kind, start, width).filter(|_| there)
    };
    let base = [Kind::Integer, Kind::Real, Kind::Text].map(|k| of(k).unwrap_or_default());
    let known = |tag: u64| base.contains(&tag);
    let boolean = of(Kind::Boolean).filter(|t| !known(*t));
    let time = of(Kind::Time).filter(|t| !known(*t) && boolean != Some(*t));
    let mut shown = format!("integer {}, real {}, string {}", base[0], base[1], base[2]);
    if let Some(tag) = boolean {
        let _ = write!(shown, ", boolean {tag}");
    }
    if let Some(tag) = time {
        let _ = write!(shown, ", time {tag}");
    }
    let unknown: Vec<&str> = [
        ("Boolean values", Kind::Boolean, boolean),
        ("times", Kind::Time, time),
    ]
    .into_iter()
    .filter(|(_, kind, tag)| tag.is_none() && slots.iter().any(|s| s.value.kind() == *kind))
    .map(|(words, ..)| words)
    .collect();
    let mut why = "all values of the same kind have the same tag".to_owned();
    if !unknown.is_empty() {
        let _ = write!(
            why,
            ", but {} have no tag of their own",
            unknown.join(" and ")
        );
    } else if boolean.is_none() && time.is_none() {
        why.push_str("; no Boolean values or times were passed");
    }
    facts.push(Fact {
        what: "tags",
        found: shown,
        sure: Confidence::Certain,
        why,
    });
    Tag {
        offset: start as u32,
        bits: 8 * width as u32,
        integer: base[0],
        real: base[1],
        string: base[2],
        boolean,
        more_real: time.into_iter().collect(),
    }
}

/// Error for a question that the dump leaves open.
fn open(record: Option<&Record>, message: String) -> Diagnostic {
    let place = record.map(|r| r.place);
    Diagnostic::error(codes::LAYOUT_UNDETERMINED, place, message).with_help(VENDOR)
}

/// Whether a value is an empty text, which cannot be recognized.
fn is_empty(value: &Value) -> bool {
    matches!(value, Value::Text(t) if t.is_empty())
}

/// Whether a value can be at an offset of `arg`, for any integer width and encoding.
fn holds(record: &Record, offset: usize, value: &Value) -> bool {
    let Some(bytes) = record.arg.get(offset..offset + VALUE_BYTES as usize) else {
        return false;
    };
    match value {
        Value::Real(x) | Value::Time(x) => bytes == x.to_le_bytes(),
        Value::Integer(i) => bytes[..2] == i.to_le_bytes()[..2],
        Value::Boolean(b) => (bytes[0] != 0) == *b,
        Value::Text(t) if !t.is_ascii() => record.bytes_at_pointer(offset).is_some(),
        Value::Text(t) => record
            .bytes_at_pointer(offset)
            .is_some_and(|bytes| Encoding::ALL.into_iter().any(|e| reads(bytes, t, e))),
    }
}

/// Checks that a layout explains the bytes of a call. Texts that are not ASCII are checked only if
/// `texts` is true.
fn explain(layout: &Layout, record: &Record, texts: bool) -> Result<(), Box<Diagnostic>> {
    let size = layout.size as usize;
    for (i, value) in record.values() {
        let why = match slot(record, i * size, size, value) {
            None => Some("is beyond the bytes that the probe could read".to_owned()),
            Some(slot) => misread(layout, &slot, texts),
        };
        if let Some(why) = why {
            let message = format!("argument {} of `{}` {why}", i + 1, record.name);
            let place: Span = record.place;
            return Err(Box::new(
                Diagnostic::error(codes::LAYOUT_UNDETERMINED, place, message).with_help(VENDOR),
            ));
        }
    }
    Ok(())
}

/// Describes how an argument differs from the value that was passed; `None` if it does not.
fn misread(layout: &Layout, slot: &Slot<'_>, texts: bool) -> Option<String> {
    let tag = number(
        slot.bytes,
        layout.tag.offset as usize,
        layout.tag.bits as usize / 8,
    )?;
    let at = layout.value as usize;
    let bytes = &slot.bytes[at..at + VALUE_BYTES as usize];
    let tags = &layout.tag;
    let tag_fits = match slot.value.kind() {
        Kind::Integer => tag == tags.integer,
        Kind::Real => tag == tags.real,
        Kind::Text => tag == tags.string,
        // A kind without a tag in the layout is not checked.
        Kind::Boolean if tags.boolean.is_none() => return None,
        Kind::Time if tag != tags.real && !tags.more_real.contains(&tag) => return None,
        Kind::Boolean => tags.boolean == Some(tag),
        Kind::Time => true,
    };
    if !tag_fits {
        return Some(format!(
            "has the tag {tag}, which is not the tag of its kind"
        ));
    }
    let value_fits = match slot.value {
        Value::Integer(i) => {
            let width = layout.integer_bits as usize / 8;
            bytes[..width] == i.to_le_bytes()[..width]
        }
        Value::Boolean(b) => (bytes[0] != 0) == *b,
        Value::Real(x) | Value::Time(x) => bytes == x.to_le_bytes(),
        Value::Text(t) if t.is_empty() => {
            bytes == [0; 8]
                || slot
                    .record
                    .bytes_at_pointer(slot.base + at)
                    .is_none_or(|b| reads(b, t, layout.strings))
        }
        Value::Text(t) if !texts && !t.is_ascii() => true,
        Value::Text(t) => slot
            .record
            .bytes_at_pointer(slot.base + at)
            .is_some_and(|b| reads(b, t, layout.strings)),
    };
    (!value_fits).then(|| "is not the value that was passed".to_owned())
}
