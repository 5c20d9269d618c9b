//! Determines the string encoding of a host: the encoding that explains the texts in the dump.

use super::Value;
use super::infer::{Confidence, Fact, Slot};
use crate::profile::Encoding;

/// Infers how strings are encoded, and adds the result to `facts`. `value` is the offset within an
/// argument at which its value is stored.
pub(super) fn encoding(slots: &[Slot<'_>], value: usize, facts: &mut Vec<Fact>) -> Encoding {
    let texts: Vec<(&str, &[u8])> = slots
        .iter()
        .filter_map(|s| match s.value {
            Value::Text(t) if !t.is_empty() => {
                Some((t.as_str(), s.record.bytes_at_pointer(s.base + value)?))
            }
            _ => None,
        })
        .collect();
    let reading = |wanted: &dyn Fn(&str) -> bool| -> Vec<Encoding> {
        let all = |e: &Encoding| {
            let mut chosen = texts.iter().filter(|(t, _)| wanted(t));
            chosen.all(|(t, bytes)| reads(bytes, t, *e))
        };
        Encoding::ALL.into_iter().filter(all).collect()
    };
    let latin = |t: &str| t.chars().all(|c| u32::from(c) < 256);
    let umlauts = texts.iter().any(|(t, _)| !t.is_ascii() && latin(t));
    let beyond = texts.iter().any(|(t, _)| !latin(t));
    let (every, without_euro, plain) =
        (reading(&|_| true), reading(&latin), reading(&str::is_ascii));
    let (found, sure, why) = if let ([one], true, true) = (every.as_slice(), umlauts, beyond) {
        (
            *one,
            Confidence::Certain,
            "umlauts and the euro sign arrived in this encoding".to_owned(),
        )
    } else if let ([one], true) = (without_euro.as_slice(), umlauts) {
        (
            *one,
            Confidence::Likely,
            "umlauts arrived in this encoding; the text with a euro sign was changed or missing"
                .to_owned(),
        )
    } else if umlauts && without_euro.contains(&Encoding::Latin1) {
        (
            Encoding::Latin1,
            Confidence::Likely,
            "umlauts arrived in this encoding, or in windows-1252; the text with a euro sign was changed or missing".to_owned(),
        )
    } else {
        let found = if plain.contains(&Encoding::Utf8) {
            Encoding::Utf8
        } else {
            plain.first().copied().unwrap_or(Encoding::Utf8)
        };
        (
            found,
            Confidence::Open,
            "umlauts did not arrive unchanged; names without them work anyway. Check that the umlauts in the method were intact when the probe ran".to_owned(),
        )
    };
    facts.push(Fact {
        what: "strings",
        found: found.name().to_owned(),
        sure,
        why,
    });
    found
}

/// Whether the bytes begin with a text in an encoding, followed by its terminator.
pub(super) fn reads(bytes: &[u8], text: &str, encoding: Encoding) -> bool {
    let mut wanted = encode(text, encoding);
    wanted.extend(if encoding == Encoding::Utf16 {
        &[0, 0][..]
    } else {
        &[0]
    });
    bytes.starts_with(&wanted)
}

/// Encodes a text; characters that the encoding lacks become `?`.
fn encode(text: &str, encoding: Encoding) -> Vec<u8> {
    let single = |c: char| match (u32::from(c), encoding) {
        (point @ (0..0x80 | 0xa0..0x100), _) | (point @ 0x80..0xa0, Encoding::Latin1) => {
            point as u8
        }
        (point, Encoding::Windows1252) => {
            let place = WINDOWS.iter().position(|w| u32::from(*w) == point);
            place.map_or(b'?', |i| 0x80 + i as u8)
        }
        _ => b'?',
    };
    match encoding {
        Encoding::Utf8 => text.as_bytes().to_vec(),
        Encoding::Utf16 => text.encode_utf16().flat_map(u16::to_le_bytes).collect(),
        Encoding::Latin1 | Encoding::Windows1252 => text.chars().map(single).collect(),
    }
}

/// Characters of the bytes 0x80 to 0x9f in windows-1252; 1 for bytes that have no character.
const WINDOWS: [u16; 32] = [
    0x20ac, 1, 0x201a, 0x0192, 0x201e, 0x2026, 0x2020, 0x2021, 0x02c6, 0x2030, 0x0160, 0x2039,
    0x0152, 1, 0x017d, 1, 1, 0x2018, 0x2019, 0x201c, 0x201d, 0x2022, 0x2013, 0x2014, 0x02dc,
    0x2122, 0x0161, 0x203a, 0x0153, 1, 0x017e, 0x0178,
];
