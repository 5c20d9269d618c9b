//! Valid names of IEC 61131-3.
//!
//! An identifier consists of ASCII letters, digits and single underscores, does not begin with a
//! digit and does not end with an underscore. Case is ignored. Keywords, the standard's functions
//! and function blocks, and words reserved by the larger development systems cannot be names.

use std::collections::BTreeSet;

/// Words reserved by the standard: keywords of all its editions and languages, elementary types,
/// standard functions and function blocks.
const STANDARD: &str = "
    ABSTRACT ACTION AND ANY ANY_BIT ANY_CHAR ANY_CHARS ANY_DATE ANY_DERIVED ANY_DURATION ANY_ELEMENTARY ANY_INT ANY_MAGNITUDE
    ANY_NUM ANY_REAL ANY_SIGNED ANY_STRING ANY_UNSIGNED ARRAY AT BOOL BY BYTE CASE CHAR CLASS CONFIGURATION CONSTANT CONTINUE
    DATE DATE_AND_TIME DINT DO DT DWORD ELSE ELSIF EN ENO END_ACTION END_CASE END_CLASS END_CONFIGURATION END_FOR END_FUNCTION
    END_FUNCTION_BLOCK END_IF END_INTERFACE END_METHOD END_NAMESPACE END_PROGRAM END_REPEAT END_RESOURCE END_STEP END_STRUCT
    END_TRANSITION END_TYPE END_VAR END_WHILE EXIT EXTENDS FALSE FINAL FOR FROM FUNCTION FUNCTION_BLOCK F_EDGE IF IMPLEMENTS
    INITIAL_STEP INT INTERFACE INTERNAL INTERVAL LDATE LDATE_AND_TIME LDT LINT LREAL LTIME LTIME_OF_DAY LTOD LWORD METHOD MOD
    NAMESPACE NON_RETAIN NOT NULL OF ON OR OVERLAP OVERRIDE PRIORITY PRIVATE PROGRAM PROTECTED PUBLIC READ_ONLY READ_WRITE REAL
    REF REF_TO REPEAT RESOURCE RETAIN RETURN R_EDGE SINGLE SINT STEP STRING STRUCT SUPER TASK THEN THIS TIME TIME_OF_DAY TO TOD
    TRANSITION TRUE TYPE UDINT UINT ULINT UNTIL USING USINT VAR VAR_ACCESS VAR_CONFIG VAR_EXTERNAL VAR_GLOBAL VAR_INPUT
    VAR_IN_OUT VAR_OUTPUT VAR_TEMP WCHAR WHILE WITH WORD WSTRING XOR
    ABS ACOS ADD ASIN ATAN ATAN2 CONCAT CONCAT_DATE CONCAT_DATE_TOD CONCAT_DT CONCAT_TOD COS DAY_OF_WEEK DELETE DIV DIVTIME EQ
    EXP EXPT FIND FROM_BIG_ENDIAN FROM_LITTLE_ENDIAN GE GT INSERT IS_VALID IS_VALID_BCD LE LEFT LEN LIMIT LN LOG LOWER_BOUND LT
    MAX MID MIN MOVE MUL MULTIME MUX NE REPLACE RIGHT ROL ROR SEL SHL SHR SIN SPLIT_DATE SPLIT_DT SPLIT_TOD SQRT SUB TAN
    TO_BIG_ENDIAN TO_LITTLE_ENDIAN TRUNC UPPER_BOUND
    CTD CTU CTUD F_TRIG RS RTC R_TRIG SEMA SR TOF TON TP";

/// Further words reserved by development systems: operators and modifiers of CODESYS and TwinCAT,
/// words of Siemens' SCL, and the instructions of IL.
const VENDORS: &str = "
    ADR ANDN AND_THEN BEGIN BIT BITADR CAL CALC CALCN DATA_BLOCK END_DATA_BLOCK END_FUNCTIONBLOCK END_ORGANIZATION_BLOCK
    END_PROPERTY END_REGION END_UNION FUNCTIONBLOCK GOTO INDEXOF INI JMP JMPC JMPCN LD LDN NIL ORGANIZATION_BLOCK ORN OR_ELSE
    PARAMS PERSISTENT POINTER PROPERTY REFERENCE REGION RET RETC RETCN S5TIME SIZEOF ST STN UNION VARIANT VAR_INST VAR_STAT
    VOID XORN XSIZEOF";

/// Whether a word is reserved and cannot be a name.
fn is_reserved(word: &str) -> bool {
    let word = word.to_ascii_uppercase();
    let listed = |list: &str| list.split_whitespace().any(|w| w == word);
    // Conversions: `INT_TO_BOOL`, `TO_INT`, `BCD_TO_UINT`, `TRUNC_DINT`.
    let converts = word.contains("_TO_") || word.starts_with("TO_") || word.starts_with("TRUNC_");
    listed(STANDARD) || listed(VENDORS) || converts
}

/// Transliterates a German letter to ASCII.
fn umlaut(c: char) -> Option<&'static str> {
    Some(match c {
        'ä' => "ae",
        'ö' => "oe",
        'ü' => "ue",
        'Ä' => "Ae",
        'Ö' => "Oe",
        'Ü' => "Ue",
        'ß' => "ss",
        _ => return None,
    })
}

/// Converts a name to the inner part of an identifier: ASCII letters, digits and single
/// underscores. The result is never empty but can begin with a digit.
pub(crate) fn part(name: &str) -> String {
    let mut out = String::new();
    for c in name.chars() {
        let written: &str = match c {
            c if let Some(letters) = umlaut(c) => letters,
            c if c.is_ascii_alphanumeric() => {
                out.push(c);
                continue;
            }
            ']' | ')' => "",
            _ if out.is_empty() || out.ends_with('_') => "",
            _ => "_",
        };
        out.push_str(written);
    }
    let out = out.trim_end_matches('_');
    if out.is_empty() {
        "v".to_owned()
    } else {
        out.to_owned()
    }
}

/// Converts a name to the beginning of an identifier. The result does not begin with a digit.
pub(crate) fn stem(name: &str) -> String {
    let word = part(name);
    if word.starts_with(|c: char| c.is_ascii_digit()) {
        format!("v_{word}")
    } else {
        word
    }
}

/// Converts a name to an identifier that is not a reserved word.
pub(crate) fn identifier(name: &str) -> String {
    let word = stem(name);
    if is_reserved(&word) {
        format!("v_{word}")
    } else {
        word
    }
}

/// Assigns identifiers that are unique, ignoring case.
#[derive(Debug, Default)]
pub(crate) struct Names(BTreeSet<String>);

impl Names {
    /// Returns the preferred identifier, or that identifier with the first free number appended.
    pub fn unique(&mut self, preferred: &str) -> String {
        let mut name = preferred.to_owned();
        let mut number = 2;
        while !self.0.insert(name.to_ascii_uppercase()) {
            name = format!("{preferred}_{number}");
            number += 1;
        }
        name
    }
}

/// Makes text safe for a comment: the result neither ends the comment nor opens another. It
/// contains no braces (some systems read them as directives), no characters that XML forbids, and
/// no characters that change the reading direction.
pub(crate) fn comment(text: &str) -> String {
    let hidden = |c: char| {
        let turns = matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{61c}');
        turns || c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}')
    };
    let visible = |c: char| match c {
        '\n' | '\t' => ' ',
        '{' => '[',
        '}' => ']',
        c if hidden(c) => '?',
        c => c,
    };
    let text: String = text.chars().map(visible).collect();
    // `(*)` contains both marks, overlapping. The second replacement also breaks the mark that the
    // first one leaves.
    text.replace("*)", "* )").replace("(*", "( *")
}

/// Formats a character string literal of at most `max_chars` characters, in ASCII, because a
/// `STRING` holds bytes in the system's own encoding.
pub(crate) fn string(text: &str, max_chars: usize) -> String {
    let mut ascii = String::new();
    for c in text.chars() {
        match umlaut(c) {
            Some(letters) => ascii.push_str(letters),
            None if matches!(c, ' '..='~') => ascii.push(c),
            None => ascii.push('?'),
        }
    }
    ascii.truncate(max_chars);
    format!("'{}'", ascii.replace('$', "$$").replace('\'', "$'"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_become_identifiers() {
        for (name, wanted) in [
            ("angle", "angle"),
            ("a.b[3]", "a_b_3"),
            ("h[2][3]", "h_2_3"),
            ("__x__y_", "x_y"),
            ("Förderband", "Foerderband"),
            ("Ω", "v"),
            ("", "v"),
            ("3d", "v_3d"),
            ("step", "v_step"),
            ("End_If", "v_End_If"),
            ("int_to_bool", "v_int_to_bool"),
            ("Move", "v_Move"),
        ] {
            assert_eq!(identifier(name), wanted, "{name}");
        }
    }

    #[test]
    fn case_does_not_distinguish_names() {
        let mut names = Names::default();
        let given = ["a", "A", "a_2", "A"].map(|n| names.unique(n));
        assert_eq!(given, ["a", "A_2", "a_2_2", "A_3"]);
    }

    #[test]
    fn strings_are_plain_ascii() {
        assert_eq!(string("it's $5: größer", 80), "'it$'s $$5: groesser'");
        assert_eq!(string("\u{202e}a\tb", 2), "'?a'");
    }

    #[test]
    fn no_comment_ends_early() {
        for text in ["a *) b", "(*)", "*)(*", "((*))", "**)", "x {pragma} y"] {
            let inner = comment(text);
            let bad = ["*)", "(*", "{", "}"];
            assert!(!bad.iter().any(|b| inner.contains(b)), "{inner}");
        }
    }
}
