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

/// Whether a header of the standard library (C99, section 7 and "Future library directions"), or a
/// compiler with extensions, can define the name as a macro without arguments.
fn is_macro(word: &str) -> bool {
    const STANDARD: [&str; 29] = [
        "BUFSIZ",
        "CHAR_BIT",
        "CLOCKS_PER_SEC",
        "DECIMAL_DIG",
        "HUGE_VAL",
        "HUGE_VALF",
        "HUGE_VALL",
        "I",
        "INFINITY",
        "L_tmpnam",
        "MATH_ERREXCEPT",
        "MATH_ERRNO",
        "NAN",
        "NDEBUG",
        "SEEK_CUR",
        "SEEK_END",
        "SEEK_SET",
        "complex",
        "errno",
        "false",
        "imaginary",
        "math_errhandling",
        "noreturn",
        "stderr",
        "stdin",
        "stdout",
        "true",
        "_Complex_I",
        "_Imaginary_I",
    ];
    // Prefixes that the standard reserves if a capital letter, or after `E` a digit, follows.
    const PREFIXES: [&str; 10] = [
        "E", "FE_", "FP_", "LC_", "SIG", "SIG_", "DBL_", "FLT_", "LDBL_", "MB_",
    ];
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
    let follows = |prefix: &&str| {
        let next = word
            .strip_prefix(*prefix)
            .and_then(|rest| rest.chars().next());
        next.is_some_and(|c| c.is_ascii_uppercase() || *prefix == "E" && c.is_ascii_digit())
    };
    OTHERS.contains(&word)
        || STANDARD.contains(&word)
        || PREFIXES.iter().any(follows)
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
