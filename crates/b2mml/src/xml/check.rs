//! Rules of XML 1.0 (fifth edition) that `quick-xml` leaves to its users: characters, names,
//! attributes, references and the XML declaration.

use crate::finding::quoted;

/// Maximum number of attributes and namespace declarations of one element: more would make the
/// search for duplicates slow.
const MAX_ATTRIBUTES: usize = 64;

/// A broken rule: byte offset in the text that was given, and what is wrong.
pub(super) type Broken = (usize, String);

/// An attribute as it is written.
pub(super) struct RawAttribute<'t> {
    /// Byte offset of its name.
    pub at: usize,
    /// Name with its prefix.
    pub name: &'t str,
    /// Value, with references.
    pub value: &'t str,
    /// Byte offset of the value.
    pub value_at: usize,
}

/// Finds the first character that XML does not allow.
pub(super) fn characters(text: &str) -> Result<(), Broken> {
    let mut at = 0;
    while at < text.len() {
        // All printable characters of ASCII are allowed, and most texts have few others.
        let plain = text.as_bytes()[at..].iter();
        at += plain.take_while(|b| matches!(b, b' '..=b'~')).count();
        let Some(character) = text[at..].chars().next() else {
            break;
        };
        if !is_allowed(character) {
            let number = u32::from(character);
            let message = format!("the character U+{number:04X} is not allowed in XML");
            return Err((at, message));
        }
        at += character.len_utf8();
    }
    Ok(())
}

/// Production `Char`.
fn is_allowed(character: char) -> bool {
    matches!(character, '\t' | '\n' | '\r' | ' '..='\u{fffd}' | '\u{10000}'..)
}

/// Productions `NameStartChar`, without the colon, which separates a prefix.
fn begins_name(c: char) -> bool {
    c.is_ascii_alphabetic()
        || c == '_'
        || matches!(c, '\u{c0}'..='\u{d6}' | '\u{d8}'..='\u{f6}' | '\u{f8}'..='\u{2ff}'
            | '\u{370}'..='\u{37d}' | '\u{37f}'..='\u{1fff}' | '\u{200c}'..='\u{200d}'
            | '\u{2070}'..='\u{218f}' | '\u{2c00}'..='\u{2fef}' | '\u{3001}'..='\u{d7ff}'
            | '\u{f900}'..='\u{fdcf}' | '\u{fdf0}'..='\u{fffd}' | '\u{10000}'..='\u{effff}')
}

/// Production `NameChar`, without the colon.
fn continues_name(c: char) -> bool {
    begins_name(c)
        || c.is_ascii_digit()
        || matches!(c, '-' | '.' | '\u{b7}' | '\u{300}'..='\u{36f}' | '\u{203f}'..='\u{2040}')
}

/// Returns whether a text is a name without a colon.
pub(super) fn is_plain_name(text: &str) -> bool {
    let mut characters = text.chars();
    characters.next().is_some_and(begins_name) && characters.all(continues_name)
}

/// Returns whether a text is a name with at most one prefix.
pub(super) fn is_name(text: &str) -> bool {
    match text.split_once(':') {
        Some((prefix, local)) => is_plain_name(prefix) && is_plain_name(local),
        None => is_plain_name(text),
    }
}

fn is_space(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | b'\r' | b'\n')
}

/// Returns whether a text has only the white space of XML.
pub(crate) fn is_blank(text: &str) -> bool {
    text.bytes().all(is_space)
}

/// Splits the part of a tag behind its name into attributes.
pub(super) fn attributes(text: &str) -> Result<Vec<RawAttribute<'_>>, Broken> {
    let bytes = text.as_bytes();
    let mut found: Vec<RawAttribute<'_>> = Vec::new();
    let mut at = 0;
    loop {
        let spaces = bytes[at..].iter().take_while(|b| is_space(**b)).count();
        at += spaces;
        if at == bytes.len() {
            return Ok(found);
        }
        if spaces == 0 {
            return Err((at, "there is no space before an attribute".to_owned()));
        }
        let length = text[at..].find(|c: char| c == '=' || c.is_ascii_whitespace());
        let name = &text[at..at + length.unwrap_or(text.len() - at)];
        if !is_name(name) {
            return Err((at, format!("{} is not a name", quoted(name))));
        }
        let start = at;
        at += name.len();
        at += bytes[at..].iter().take_while(|b| is_space(**b)).count();
        if bytes.get(at) != Some(&b'=') {
            return Err((at, format!("attribute {} has no value", quoted(name))));
        }
        at += 1;
        at += bytes[at..].iter().take_while(|b| is_space(**b)).count();
        let quote = bytes.get(at).copied().filter(|b| matches!(b, b'"' | b'\''));
        let length = quote.and_then(|q| bytes[at + 1..].iter().position(|b| *b == q));
        let Some(length) = length else {
            let message = format!("the value of {} is not in quotes", quoted(name));
            return Err((at, message));
        };
        let value = &text[at + 1..at + 1 + length];
        if let Some(less) = value.find('<') {
            let message = "`<` is not allowed in the value of an attribute".to_owned();
            return Err((at + 1 + less, message));
        }
        if found.iter().any(|a| a.name == name) {
            return Err((start, format!("attribute {} occurs twice", quoted(name))));
        }
        if found.len() == MAX_ATTRIBUTES {
            let message = format!("an element has more than {MAX_ATTRIBUTES} attributes");
            return Err((start, message));
        }
        found.push(RawAttribute {
            at: start,
            name,
            value,
            value_at: at + 1,
        });
        at += length + 2;
    }
}

/// Returns the value of an attribute: with references replaced, and white space as spaces.
pub(super) fn attribute_value(raw: &str) -> Result<String, Broken> {
    let mut value = String::with_capacity(raw.len());
    let mut at = 0;
    while let Some(character) = raw[at..].chars().next() {
        match character {
            '&' => {
                let end = raw[at..]
                    .find(';')
                    .ok_or_else(|| (at, "a reference does not end with `;`".to_owned()))?;
                let name = &raw[at + 1..at + end];
                value.push(reference(name).map_err(|message| (at, message))?);
                at += end + 1;
                continue;
            }
            '\r' if raw[at + 1..].starts_with('\n') => {}
            '\t' | '\r' | '\n' => value.push(' '),
            other => value.push(other),
        }
        at += character.len_utf8();
    }
    Ok(value)
}

/// Returns the character that a reference `&name;` stands for.
pub(super) fn reference(name: &str) -> Result<char, String> {
    let predefined = match name {
        "amp" => Some('&'),
        "lt" => Some('<'),
        "gt" => Some('>'),
        "apos" => Some('\''),
        "quot" => Some('"'),
        _ => None,
    };
    if let Some(character) = predefined {
        return Ok(character);
    }
    let Some(number) = name.strip_prefix('#') else {
        return Err(format!("entity {} is not declared", quoted(name)));
    };
    let parsed = match number.strip_prefix('x') {
        Some(digits) if digits.bytes().all(|b| b.is_ascii_hexdigit()) => {
            u32::from_str_radix(digits, 16).ok()
        }
        None if number.bytes().all(|b| b.is_ascii_digit()) => number.parse().ok(),
        _ => None,
    };
    let character = parsed.and_then(char::from_u32).filter(|c| is_allowed(*c));
    character.ok_or_else(|| format!("{} is not a character of XML", quoted(&format!("&{name};"))))
}

/// Checks the XML declaration: its text between `<?xml` and `?>`.
pub(super) fn declaration(text: &str) -> Result<(), Broken> {
    let attributes = attributes(text)?;
    let mut expected = ["version", "encoding", "standalone"].iter();
    if attributes.first().is_none_or(|a| a.name != "version") {
        return Err((0, "the XML declaration has no version".to_owned()));
    }
    for attribute in &attributes {
        if !expected.any(|name| *name == attribute.name) {
            let message = format!("{} is not expected here", quoted(attribute.name));
            return Err((attribute.at, message));
        }
        let value = attribute.value;
        let (right, what) = match attribute.name {
            "version" => (value == "1.0", "XML 1.0 is read"),
            "encoding" => {
                let known = ["utf-8", "us-ascii", "ascii"];
                let known = known.iter().any(|k| value.eq_ignore_ascii_case(k));
                (known, "UTF-8 is read")
            }
            _ => (matches!(value, "yes" | "no"), "`yes` or `no` is expected"),
        };
        if !right {
            return Err((attribute.value_at, format!("{what}, not {}", quoted(value))));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn attributes_are_split() {
        let found = attributes(" a = \"1>\" b:c='\"' ").expect("they are right");
        let pairs: Vec<_> = found.iter().map(|a| (a.at, a.name, a.value)).collect();
        assert_eq!(pairs, [(1, "a", "1>"), (10, "b:c", "\"")]);
        for (wrong, at) in [
            ("a='1'", 0),
            (" a='1'b='2'", 6),
            (" a", 2),
            (" a=1", 3),
            (" a='1", 3),
            (" 1='1'", 1),
            (" a:b:c=''", 1),
            (" a='<'", 4),
            (" a='' a=''", 6),
            (" /", 1),
        ] {
            let broken = attributes(wrong).err().map(|(at, _)| at);
            assert_eq!(broken, Some(at), "{wrong}");
        }
    }

    #[test]
    fn references_are_replaced() {
        let value = attribute_value("a\r\nb\tc&#9;&#xE4;&lt;&amp;amp;").expect("it is right");
        assert_eq!(value, "a b c\tä<&amp;");
        for wrong in [
            "&", "&x;", "&#0;", "&#xD800;", "&#x;", "&#;", "&#X41;", "&#+1;", "&;",
        ] {
            assert!(attribute_value(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn declarations_are_checked() {
        for right in [
            " version='1.0'",
            " version=\"1.0\" encoding=\"utf-8\"",
            " version='1.0' encoding='UTF-8' standalone='yes' ",
            " version='1.0' standalone='no'",
        ] {
            assert_eq!(declaration(right), Ok(()), "{right}");
        }
        for wrong in [
            "",
            " encoding='UTF-8'",
            " version='1.1'",
            " version='1.0' encoding='latin1'",
            " version='1.0' standalone='yes' encoding='UTF-8'",
            " version='1.0' version='1.0'",
            " version='1.0' standalone='maybe'",
            " version='1.0' x=''",
        ] {
            assert!(declaration(wrong).is_err(), "{wrong}");
        }
    }
}
