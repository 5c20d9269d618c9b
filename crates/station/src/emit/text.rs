//! Pieces of C text: comments, strings, names, wrapped lines.

/// Maximum line length in characters, if the text can be broken.
const WIDTH: usize = 110;

/// Makes text safe for a C comment: the result neither ends the comment nor opens another, and
/// contains no characters that change the reading direction or control a terminal.
pub fn comment(text: &str) -> String {
    let visible = |c: char| {
        let bidirectional = matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{61c}');
        match c {
            '\n' | '\t' => ' ',
            c if c.is_control() || bidirectional => '?',
            c => c,
        }
    };
    let text: String = text.chars().map(visible).collect();
    // `/*/` and `*/*` contain both marks, overlapping. The second replacement also breaks the mark
    // that the first one leaves.
    let text = text.replace("*/", "* /").replace("/*", "/ *");
    text.strip_suffix('*')
        .map_or(text.clone(), |rest| format!("{rest}* "))
        .replace("??", "? ?")
}

/// Formats a text as a C string literal.
pub fn string(text: &str) -> String {
    let mut out = String::from("\"");
    for &byte in text.as_bytes() {
        match byte {
            b'"' => out.push_str("\\\""),
            b'\\' => out.push_str("\\\\"),
            // A `?` could begin a trigraph.
            b'?' => out.push_str("\\?"),
            b'\n' => out.push_str("\\n"),
            0x20..=0x7e => out.push(byte as char),
            _ => {
                out.push('\\');
                for shift in [6, 3, 0] {
                    out.push((b'0' + (byte >> shift & 7)) as char);
                }
            }
        }
    }
    out.push('"');
    out
}

/// Formats a long text as string literals, one per line, which the compiler joins.
pub fn long_string(text: &str, indent: &str) -> String {
    let mut pieces = vec![String::new()];
    for c in text.chars() {
        if pieces.last().is_some_and(|p| p.len() >= WIDTH - 20) && c == ' ' {
            pieces.push(String::new());
        }
        if let Some(last) = pieces.last_mut() {
            last.push(c);
        }
    }
    let literals: Vec<String> = pieces.iter().map(|p| string(p)).collect();
    literals.join(&format!("\n{indent}"))
}

/// Replaces the characters of a name that are not allowed in a C identifier: `heights[2]` becomes
/// `heights_2`. The result can begin with a digit.
pub fn identifier(name: &str) -> String {
    let mut out = String::new();
    for c in name.chars() {
        match c {
            c if c.is_ascii_alphanumeric() => out.push(c),
            ']' | ')' => {}
            _ => out.push('_'),
        }
    }
    out
}

/// Breaks a long C expression at its spaces; continuation lines start with `indent`.
pub fn wrap(text: &str, indent: &str) -> String {
    let mut out = String::new();
    let mut column = indent.len();
    for (i, word) in text.split(' ').enumerate() {
        if i > 0 && column + 1 + word.len() > WIDTH {
            out.push('\n');
            out.push_str(indent);
            column = indent.len();
        } else if i > 0 {
            out.push(' ');
            column += 1;
        }
        out.push_str(word);
        column += word.len();
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_comment_ends_early() {
        for text in ["a */ b", "*/*", "/*/", "x*", "**/", "/**/", "*/*/*/"] {
            let comment = format!("/* {}*/", comment(text));
            let inner = &comment[2..comment.len() - 2];
            assert!(!inner.contains("*/") && !inner.contains("/*"), "{comment}");
            assert_eq!(comment.find("*/"), Some(comment.len() - 2), "{comment}");
        }
    }

    #[test]
    fn strings_are_plain_ascii() {
        assert_eq!(string("a\"b\\c?"), r#""a\"b\\c\?""#);
        assert_eq!(string("°1"), "\"\\302\\2601\"");
    }
}
