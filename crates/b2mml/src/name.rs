//! Names as identifiers of B2MML.
//!
//! An identifier is a `normalizedString`: it has no tabs and no line ends, and some readers
//! collapse its spaces. Names of layouts and recipes may contain anything. So whatever would be
//! lost or could not be seen is written as `_xHHHH_` with the hexadecimal number of the character,
//! which is the convention of ISO/IEC 9075-14 (SQL/XML) for names. The result tells every two names
//! apart, and can be decoded without any table.

use std::fmt::Write as _;

/// Identifier of the empty name.
const EMPTY: &str = "_x_";

/// Returns the identifier of a name. Takes time proportional to its length.
pub fn encode(name: &str) -> String {
    if name.is_empty() {
        return EMPTY.to_owned();
    }
    let mut encoded = String::with_capacity(name.len());
    let mut after_space = true;
    for (at, character) in name.char_indices() {
        let rest = &name[at + character.len_utf8()..];
        let plain = match character {
            ' ' => !after_space && !rest.is_empty(),
            '_' => !looks_encoded(rest) && name != EMPTY,
            _ => is_visible(character),
        };
        if plain {
            encoded.push(character);
        } else {
            let written = write!(encoded, "_x{:04X}_", u32::from(character));
            written.expect("a string takes all");
        }
        after_space = character == ' ';
    }
    encoded
}

/// Returns the name of an identifier. What is not encoded stays as it is.
pub fn decode(identifier: &str) -> String {
    if identifier == EMPTY {
        return String::new();
    }
    let mut name = String::with_capacity(identifier.len());
    let mut rest = identifier;
    while let Some(at) = rest.find("_x") {
        name.push_str(&rest[..at]);
        rest = &rest[at..];
        if let Some((character, length)) = encoded_character(rest) {
            name.push(character);
            rest = &rest[length..];
        } else {
            name.push('_');
            rest = &rest[1..];
        }
    }
    name.push_str(rest);
    name
}

/// Returns whether an underscore before this text could begin an encoded character.
fn looks_encoded(rest: &str) -> bool {
    let bytes = rest.as_bytes();
    bytes.len() > 4 && bytes[0] == b'x' && bytes[1..5].iter().all(u8::is_ascii_hexdigit)
}

/// Returns the character that a text begins with in its encoded form, and the length of that.
fn encoded_character(text: &str) -> Option<(char, usize)> {
    let digits = text.strip_prefix("_x")?;
    let length = digits.bytes().take(7).position(|b| b == b'_')?;
    if length < 4
        || !digits.as_bytes()[..length]
            .iter()
            .all(u8::is_ascii_hexdigit)
    {
        return None;
    }
    let number = u32::from_str_radix(&digits[..length], 16).ok()?;
    Some((char::from_u32(number)?, length + 3))
}

/// Returns whether a character other than a space can be seen, and is not combined with another.
fn is_visible(character: char) -> bool {
    character.is_ascii_graphic()
        || character.is_alphanumeric()
        || matches!(u32::from(character),
            0xa1..=0xac | 0xae..=0xff // Latin signs
            | 0x2010..=0x2027 | 0x2030..=0x205e // dashes, quotation marks, other punctuation
            | 0x20a0..=0x20bf // currencies
            | 0x2100..=0x2bff // letterlike symbols, arrows, mathematics, shapes
            | 0x3001..=0x3020 // East Asian punctuation
            | 0x1f300..=0x1f64f | 0x1f680..=0x1f6c5) // pictures
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn plain_names_stay_as_they_are() {
        for name in [
            "R1",
            "r1",
            "Größe 3",
            "a \"b\" 'c'",
            "<x>&amp;",
            "50 %",
            "a_xyz",
            "→",
            "load()(f)#1",
        ] {
            assert_eq!(encode(name), name);
        }
    }

    #[test]
    fn odd_names_can_be_told_apart() {
        for (name, encoded) in [
            ("", "_x_"),
            ("_x_", "_x005F_x_x005F_"),
            (" ", "_x0020_"),
            ("a ", "a_x0020_"),
            ("a  b", "a _x0020_b"),
            ("\u{200b}", "_x200B_"),
            ("\u{a0}", "_x00A0_"),
            ("a\tb\r\nc", "a_x0009_b_x000D__x000A_c"),
            ("\u{0}", "_x0000_"),
            ("\u{10ffff}", "_x10FFFF_"),
            ("_x0041_", "_x005F_x0041_"),
            ("_x0041\u{1}", "_x005F_x0041_x0001_"),
            ("e\u{301}", "e_x0301_"),
        ] {
            assert_eq!(encode(name), encoded);
            assert_eq!(decode(encoded), name);
        }
        assert_eq!(decode("_xD800_ _x123_ _x0041"), "_xD800_ _x123_ _x0041");
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2_000))]

        #[test]
        fn names_survive(name in "([_x0-9A-F \t\u{0}-\u{3}é€]|\\PC){0,12}") {
            let encoded = encode(&name);
            prop_assert_eq!(decode(&encoded), name);
            let words: Vec<&str> = encoded.split_whitespace().collect();
            prop_assert_eq!(words.join(" "), encoded.clone());
            prop_assert!(!encoded.is_empty());
            prop_assert!(encoded.chars().all(|c| c == ' ' || is_visible(c)));
        }
    }
}
