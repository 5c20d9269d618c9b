//! The probe, a library that is called with known values and dumps the raw bytes that it receives;
//! and the analysis of the dump.
//!
//! ```text
//! calls() ─package→ Package, simtalk::text   (run in Plant Simulation)   dump::parse→ Dump ─infer→ Inference ─confirm→ Profile
//! ```
//!
//! The calls determine the layout. Real numbers with distinctive bytes show the offset of the
//! value; several real numbers in one call show the distance between arguments. Integers of both
//! signs and all sizes show the width of an integer: the bytes after that width do not belong to
//! the number. The tag is at the offset at which the bytes differ between kinds and agree within
//! each kind. Texts with umlauts and a euro sign show the string encoding.

pub mod dump;
pub mod infer;
pub mod package;
mod texts;

/// A value passed to the probe.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// An integer.
    Integer(i64),
    /// A real number with few digits, represented exactly.
    Real(f64),
    /// A text.
    Text(String),
    /// A truth value.
    Boolean(bool),
    /// A time in seconds.
    Time(f64),
}

/// A kind of value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// An integer.
    Integer,
    /// A real number.
    Real,
    /// A text.
    Text,
    /// A truth value.
    Boolean,
    /// A time.
    Time,
}

impl Value {
    /// Kind of the value.
    pub fn kind(&self) -> Kind {
        match self {
            Self::Integer(_) => Kind::Integer,
            Self::Real(_) => Kind::Real,
            Self::Text(_) => Kind::Text,
            Self::Boolean(_) => Kind::Boolean,
            Self::Time(_) => Kind::Time,
        }
    }

    /// Formats the value as in a dump: `integer:-2`, `text:4c77`.
    pub fn dump_word(&self) -> String {
        match self {
            Self::Integer(i) => format!("integer:{i}"),
            Self::Real(x) => format!("real:{x:?}"),
            Self::Text(t) => format!("text:{}", super::emit::hex(t.as_bytes())),
            Self::Boolean(b) => format!("boolean:{b}"),
            Self::Time(x) => format!("time:{x:?}"),
        }
    }
}

/// One call of the probe.
#[derive(Debug, Clone, PartialEq)]
pub struct Call {
    /// Name of the export.
    pub name: String,
    /// Arguments of the call.
    pub arguments: Vec<Value>,
    /// Whether the layout can be inferred without this call.
    pub optional: bool,
}

/// Returns the calls of the first round.
pub fn calls() -> Vec<Call> {
    let text = |t: &str| Value::Text(t.to_owned());
    let integers = [1, -2, 258, -30_000, 16_909_060, -1_985_229_329];
    let reals = [1.0, -2.5, 3.140_625, -1_048_577.031_25];
    let texts = ["Linewright", "Prüfstück ÄÖÜ", "", "12 €"];
    let mut calls = vec![call("lw_probe_none", Vec::new())];
    calls.extend(numbered("lw_probe_integer", integers.map(Value::Integer)));
    calls.extend(numbered("lw_probe_real", reals.map(Value::Real)));
    calls.extend(numbered("lw_probe_string", texts.map(text)));
    calls.push(call(
        "lw_probe_reals",
        [1.5, -2.25, 4.125, -8.0625].map(Value::Real).into(),
    ));
    calls.push(call(
        "lw_probe_integers",
        [3, -77, 20_000, -1_234_567_890].map(Value::Integer).into(),
    ));
    calls.push(call(
        "lw_probe_mixed",
        vec![
            Value::Integer(1025),
            Value::Real(0.156_25),
            text("Station"),
            Value::Integer(-3),
            Value::Real(-6.5),
            text("Teil 7"),
        ],
    ));
    let optional = numbered("lw_probe_boolean", [true, false].map(Value::Boolean))
        .into_iter()
        .chain(numbered("lw_probe_time", [Value::Time(90.5)]))
        .map(|c| Call {
            optional: true,
            ..c
        });
    calls.extend(optional);
    calls
}

/// Returns the values that the library returns in the second round: an integer that fits the
/// layout's width, a real number, a text.
pub fn returned_values(integer_bits: u32) -> [Value; 3] {
    let integer = if integer_bits == 16 {
        -12_345
    } else {
        -1_234_567_891
    };
    [
        Value::Integer(integer),
        Value::Real(2_718.281_25),
        Value::Text("Rückgabe geprüft".to_owned()),
    ]
}

/// Name of the export that receives the returned values in the second round.
pub const CONFIRM_EXPORT: &str = "lw_confirm_seen";

fn call(name: &str, arguments: Vec<Value>) -> Call {
    Call {
        name: name.to_owned(),
        arguments,
        optional: false,
    }
}

fn numbered(name: &str, values: impl IntoIterator<Item = Value>) -> Vec<Call> {
    let each = |(i, value)| call(&format!("{name}_{}", i + 1), vec![value]);
    values.into_iter().enumerate().map(each).collect()
}
