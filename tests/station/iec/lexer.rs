//! Splits Structured Text into tokens.
//!
//! From IEC 61131-3: identifiers ignore case, underscores are single and not at the end, comments
//! are `(* *)`, `/* */` and `//`, directives are in braces, numbers may contain single underscores
//! and a base.

/// A word or sign.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Token {
    /// A keyword or identifier, in capital letters.
    Word(String),
    /// An integer without its sign.
    Number(i128),
    /// A character string, without its quotes.
    Text(String),
    /// Anything else.
    Sign(&'static str),
    /// The end of the text.
    End,
}

/// A token and its first line.
#[derive(Debug, Clone)]
pub struct Placed {
    pub token: Token,
    pub line: usize,
}

/// The longer signs come first.
const SIGNS: [&str; 23] = [
    ":=", "=>", "<>", "<=", ">=", "..", "**", "=", "<", ">", "+", "-", "*", "/", "(", ")", "[",
    "]", ",", ";", ":", "#", "&",
];

/// The tokens of a text, the end included.
pub fn tokens(text: &str) -> Result<Vec<Placed>, String> {
    let mut found = Vec::new();
    let mut rest = text;
    let mut line = 1;
    while let Some(first) = rest.chars().next() {
        let length = if first.is_whitespace() {
            first.len_utf8()
        } else if let Some(length) = skipped(rest).map_err(|e| format!("line {line}: {e}"))? {
            length
        } else if first.is_ascii_alphabetic() || first == '_' {
            let word = leading(rest, |c| c.is_ascii_alphanumeric() || c == '_');
            if word.contains("__") || word.ends_with('_') {
                return Err(format!("line {line}: `{word}` is no identifier"));
            }
            let token = Token::Word(word.to_ascii_uppercase());
            found.push(Placed { token, line });
            word.len()
        } else if first.is_ascii_digit() {
            let (value, length) = number(rest).map_err(|e| format!("line {line}: {e}"))?;
            let token = Token::Number(value);
            found.push(Placed { token, line });
            length
        } else if first == '\'' {
            let (text, length) = string(rest).map_err(|e| format!("line {line}: {e}"))?;
            let token = Token::Text(text);
            found.push(Placed { token, line });
            length
        } else {
            let sign = SIGNS.into_iter().find(|s| rest.starts_with(s));
            let sign = sign.ok_or_else(|| format!("line {line}: `{first}` means nothing"))?;
            let token = Token::Sign(sign);
            found.push(Placed { token, line });
            sign.len()
        };
        line += rest[..length].matches('\n').count();
        rest = &rest[length..];
    }
    let token = Token::End;
    found.push(Placed { token, line });
    Ok(found)
}

fn leading(text: &str, belongs: impl Fn(char) -> bool) -> &str {
    let end = text.find(|c| !belongs(c)).unwrap_or(text.len());
    &text[..end]
}

/// The length of a comment or directive that the text begins with.
fn skipped(text: &str) -> Result<Option<usize>, String> {
    if text.starts_with("//") {
        return Ok(Some(text.find('\n').unwrap_or(text.len())));
    }
    for (open, close) in [("(*", "*)"), ("/*", "*/")] {
        if text.starts_with(open) {
            let end = text[2..].find(close).ok_or("a comment has no end")?;
            // Whether comments nest depends on the system, so nested ones are rejected.
            if text[2..2 + end].contains(open) {
                return Err("a comment is nested in a comment".to_owned());
            }
            return Ok(Some(end + 4));
        }
    }
    if text.starts_with('{') {
        let end = text.find('}').ok_or("a directive has no end")?;
        return Ok(Some(end + 1));
    }
    Ok(None)
}

/// A character string and its length including quotes: `'it$'s'`. It contains printable ASCII
/// characters, so that a character is a byte in every system; of the escapes with `$` only the two
/// for the characters themselves are supported here.
fn string(text: &str) -> Result<(String, usize), String> {
    let mut found = String::new();
    let mut rest = text[1..].char_indices();
    while let Some((at, c)) = rest.next() {
        match c {
            '\'' => return Ok((found, at + 2)),
            '$' => match rest.next() {
                Some((_, mark @ ('$' | '\''))) => found.push(mark),
                other => return Err(format!("`$` before {other:?} in a string")),
            },
            ' '..='~' => found.push(c),
            _ => return Err(format!("{c:?} in a string")),
        }
    }
    Err("a string has no end".to_owned())
}

/// A number and its length: `17`, `1_000`, `16#FF`, `2#1010`.
fn number(text: &str) -> Result<(i128, usize), String> {
    let digits = leading(text, |c| c.is_ascii_digit() || c == '_');
    let based = &text[digits.len()..];
    let base = match (digits, based.starts_with('#')) {
        ("2", true) => 2,
        ("8", true) => 8,
        ("16", true) => 16,
        _ => 10,
    };
    let (written, length) = if base == 10 {
        (digits, digits.len())
    } else {
        let written = leading(&based[1..], |c| c.is_ascii_hexdigit() || c == '_');
        (written, digits.len() + 1 + written.len())
    };
    let wrong = || format!("`{written}` is no number");
    let alone = !written.contains("__") && !written.ends_with('_') && !written.starts_with('_');
    let after = text[length..].chars().next();
    if !alone || after.is_some_and(|c| c.is_ascii_alphanumeric() || c == '_') {
        return Err(wrong());
    }
    let value = i128::from_str_radix(&written.replace('_', ""), base).map_err(|_| wrong())?;
    Ok((value, length))
}
