//! Damages bytes, words and characters, lines and blocks.

use linewright::line::random::Stream;

const NUMBERS: [&str; 22] = [
    "0",
    "1",
    "-1",
    "2",
    "64",
    "255",
    "4096",
    "4097",
    "65536",
    "2147483647",
    "2147483648",
    "-2147483649",
    "4294967296",
    "9007199254740993",
    "9223372036854775807",
    "9223372036854775808",
    "-9223372036854775808",
    "18446744073709551616",
    "1e308",
    "1e-308",
    "1e309",
    "0.1",
];
const SIGNS: [&str; 43] = [
    "and",
    "or",
    "xor",
    "->",
    "<->",
    "=",
    "!=",
    "<",
    "<=",
    ">",
    ">=",
    "+",
    "-",
    "*",
    "/",
    "mod",
    "not",
    "next",
    "always",
    "eventually",
    "until",
    "since",
    "once",
    "historically",
    "previous",
    "if",
    "then",
    "else",
    "in",
    "..",
    "(",
    ")",
    "{",
    "}",
    "[",
    "]",
    ",",
    ":",
    "min(",
    "max(",
    "abs(",
    "floor(",
    "||",
];
const WORDS: [&str; 62] = [
    "true",
    "false",
    "it",
    "operation",
    "none",
    "done",
    "contract",
    "moore contract",
    "machine",
    "line",
    "skills",
    "import",
    "input",
    "output",
    "internal",
    "assume",
    "guarantee",
    "define",
    "type",
    "const",
    "property",
    "parameter",
    "signal",
    "abstract",
    "coordinator",
    "action",
    "time",
    "per step",
    "write",
    "limit",
    "step",
    "part",
    "source",
    "sink",
    "store",
    "buffer",
    "conveyor",
    "station",
    "route",
    "perform",
    "defect on",
    "when",
    "otherwise",
    "array[2] of",
    "forall i in 0..3:",
    "bool",
    "layout",
    "recipe",
    "realize",
    "resource",
    "transport",
    "at start",
    "holds",
    "nop",
    "start",
    "end",
    "leftover",
    "on",
    "in:1",
    "out:1",
    "a -> b:",
    "glue(p)(p)",
];

fn pick<'a, T: ?Sized>(stream: &mut Stream, list: &[&'a T]) -> &'a T {
    list[stream.below(list.len() as u64) as usize]
}

/// One to four changes.
pub fn damaged(stream: &mut Stream, text: &str, other: &str) -> Vec<u8> {
    let mut text = text.to_owned();
    let changes = 1 + stream.below(4).min(stream.below(4));
    for _ in 0..changes {
        text = match stream.below(20) {
            0..10 => words_damaged(stream, &text),
            10..18 => lines_damaged(stream, &text, other),
            _ => spliced(stream, &text, other),
        };
    }
    let mut bytes = text.into_bytes();
    if stream.below(8) == 0 {
        bytes_damaged(stream, &mut bytes);
    }
    bytes
}

fn bytes_damaged(stream: &mut Stream, bytes: &mut Vec<u8>) {
    for _ in 0..=stream.below(3) {
        let at = stream.below(bytes.len() as u64 + 1) as usize;
        match stream.below(5) {
            0 => bytes.insert(at, stream.below(256) as u8),
            1 if at < bytes.len() => {
                bytes.remove(at);
            }
            2 if at < bytes.len() => bytes[at] ^= 1 << stream.below(8),
            3 => bytes.truncate(at),
            _ => {
                let end = (at + stream.below(60) as usize).min(bytes.len());
                let piece = bytes[at..end].to_vec();
                bytes.splice(at..at, piece);
            }
        }
    }
}

/// Words, numbers, characters and the text between them; together the whole text.
pub fn tokens(text: &str) -> Vec<String> {
    let mut tokens: Vec<String> = Vec::new();
    let class = |c: char| match c {
        c if c.is_alphanumeric() || c == '_' => 0,
        c if c.is_whitespace() => 1,
        '<' | '>' | '=' | '-' | '!' | '.' | '&' | '|' | '/' => 2,
        _ => 3,
    };
    for c in text.chars() {
        match tokens.last_mut() {
            Some(last)
                if class(c) != 3
                    && last
                        .chars()
                        .next_back()
                        .is_some_and(|l| class(l) == class(c)) =>
            {
                last.push(c);
            }
            _ => tokens.push(c.to_string()),
        }
    }
    tokens
}

fn words_damaged(stream: &mut Stream, text: &str) -> String {
    let mut tokens = tokens(text);
    let is_blank = |t: &String| t.chars().all(char::is_whitespace);
    let is_number = |t: &String| t.starts_with(|c: char| c.is_ascii_digit());
    let is_name = |t: &String| t.starts_with(|c: char| c.is_alphabetic() || c == '_');
    let of = |tokens: &[String], wanted: &dyn Fn(&String) -> bool| -> Vec<usize> {
        (0..tokens.len()).filter(|i| wanted(&tokens[*i])).collect()
    };
    let solid = of(&tokens, &|t| !is_blank(t));
    let numbers = of(&tokens, &is_number);
    let names = of(&tokens, &is_name);
    let signs = of(&tokens, &|t| !is_blank(t) && !is_number(t) && !is_name(t));
    let mut one = |list: &[usize]| -> Option<usize> {
        (!list.is_empty()).then(|| list[stream.below(list.len() as u64) as usize])
    };
    let Some(at) = one(&solid) else {
        return text.to_owned();
    };
    let beside = one(&solid).unwrap_or(at);
    let (number, name, another, sign) = (one(&numbers), one(&names), one(&names), one(&signs));
    match stream.below(14) {
        0 => {
            tokens.remove(at);
        }
        1 => tokens.insert(at, tokens[at].clone() + " "),
        2 => tokens.swap(at, beside),
        3..6 => {
            if let Some(number) = number {
                pick(stream, &NUMBERS).clone_into(&mut tokens[number]);
            }
        }
        6 | 7 => {
            // A similar number meets bounds that an extreme one skips.
            if let Some(number) = number
                && let Ok(value) = tokens[number].parse::<i64>()
            {
                let by = [1, -1, value, 7][stream.below(4) as usize];
                tokens[number] = value.wrapping_add(by).to_string();
            }
        }
        8 | 9 => {
            if let (Some(name), Some(another)) = (name, another) {
                let another = tokens[another].clone();
                tokens[name] = another;
            }
        }
        10 => {
            if let Some(name) = name {
                pick(stream, &WORDS).clone_into(&mut tokens[name]);
            }
        }
        11 | 12 => {
            if let Some(sign) = sign {
                tokens[sign] = format!(" {} ", pick(stream, &SIGNS));
            }
        }
        _ => tokens.insert(at, format!(" {} ", pick(stream, &SIGNS))),
    }
    tokens.concat()
}

/// The lines of a block that begins with this line and ends with its brace.
fn block(lines: &[&str], from: usize) -> usize {
    let mut depth = 0i64;
    for (at, line) in lines.iter().enumerate().skip(from) {
        depth += line.matches('{').count() as i64 - line.matches('}').count() as i64;
        if depth <= 0 {
            return at + 1;
        }
    }
    lines.len()
}

fn lines_damaged(stream: &mut Stream, text: &str, other: &str) -> String {
    let mut lines: Vec<&str> = text.lines().collect();
    let others: Vec<&str> = other.lines().collect();
    if lines.is_empty() {
        return text.to_owned();
    }
    let mut below = |n: usize| stream.below(n.max(1) as u64) as usize;
    let (at, to) = (below(lines.len()), below(lines.len()));
    let from = below(others.len());
    match below(9) {
        0 | 1 => {
            lines.remove(at);
        }
        2 => lines.insert(to, lines[at]),
        3 => lines.swap(at, to),
        4 => {
            let end = block(&lines, at);
            lines.drain(at..end);
        }
        5 => {
            let piece = lines[at..block(&lines, at)].to_vec();
            lines.splice(to..to, piece);
        }
        6 if !others.is_empty() => lines.insert(at, others[from]),
        7 if !others.is_empty() => {
            let piece = others[from..block(&others, from)].to_vec();
            lines.splice(at..at, piece);
        }
        _ if !others.is_empty() => {
            let piece = others[from..block(&others, from)].to_vec();
            let end = block(&lines, at);
            lines.splice(at..end, piece);
        }
        _ => {}
    }
    lines.join("\n") + "\n"
}

fn spliced(stream: &mut Stream, text: &str, other: &str) -> String {
    let (lines, others): (Vec<&str>, Vec<&str>) = (text.lines().collect(), other.lines().collect());
    let mut below = |n: usize| stream.below(n as u64 + 1) as usize;
    if below(1) == 0 {
        return format!("{text}\n{other}");
    }
    let (head, tail) = (below(lines.len()), below(others.len()));
    [&lines[..head], &others[tail..]].concat().join("\n") + "\n"
}
