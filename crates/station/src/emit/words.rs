//! Valid C names.

use super::text::identifier;

/// Reserved words of C and C++, which cannot name a field.
const RESERVED: [&str; 66] = [
    "and",
    "asm",
    "auto",
    "bool",
    "break",
    "case",
    "catch",
    "char",
    "class",
    "const",
    "continue",
    "default",
    "delete",
    "do",
    "double",
    "else",
    "enum",
    "export",
    "extern",
    "false",
    "float",
    "for",
    "friend",
    "goto",
    "if",
    "inline",
    "int",
    "long",
    "mutable",
    "namespace",
    "new",
    "not",
    "operator",
    "or",
    "private",
    "protected",
    "public",
    "register",
    "restrict",
    "return",
    "short",
    "signed",
    "sizeof",
    "static",
    "struct",
    "switch",
    "template",
    "this",
    "throw",
    "true",
    "try",
    "typedef",
    "typeid",
    "typename",
    "union",
    "unsigned",
    "using",
    "virtual",
    "void",
    "volatile",
    "wchar_t",
    "while",
    "xor",
    "nullptr",
    "constexpr",
    "alignas",
];

/// Whether the included headers, or a compiler with extensions, can define the name.
fn is_macro(word: &str) -> bool {
    const OTHERS: [&str; 8] = [
        "NULL",
        "alignas",
        "alignof",
        "linux",
        "static_assert",
        "thread_local",
        "typeof",
        "unix",
    ];
    const LIMITS: [&str; 8] = [
        "INT",
        "UINT",
        "PTRDIFF",
        "SIG_ATOMIC",
        "SIZE",
        "WCHAR",
        "WINT",
        "LINEWRIGHT",
    ];
    let ends = |endings: &[&str]| endings.iter().any(|e| word.ends_with(e));
    OTHERS.contains(&word)
        || ends(&["_t"])
        || LIMITS.iter().any(|l| word.starts_with(l))
            && ends(&["_MAX", "_MIN", "_WIDTH", "_C", "_H"])
}

/// Whether the C standard library has a header of that name, which a generated header must not
/// hide.
pub(crate) fn is_header(name: &str) -> bool {
    const HEADERS: [&str; 24] = [
        "assert", "complex", "ctype", "errno", "fenv", "float", "inttypes", "iso646", "limits",
        "locale", "math", "setjmp", "signal", "stdarg", "stdbool", "stddef", "stdint", "stdio",
        "stdlib", "string", "tgmath", "time", "wchar", "wctype",
    ];
    HEADERS.contains(&name.to_ascii_lowercase().as_str())
}

/// Converts a name to a valid C name.
pub(crate) fn word(name: &str) -> String {
    let word = identifier(name);
    if !word.starts_with(|c: char| c.is_ascii_alphabetic()) {
        format!("v_{word}")
    } else if RESERVED.contains(&word.as_str()) || is_macro(&word) {
        format!("{word}_")
    } else {
        word
    }
}
