//! The probe as a package: `ffi/probe.c` with the list of its calls, and the SimTalk method that
//! makes the calls.

use super::{CONFIRM_EXPORT, Call, Value, calls, returned_values};
use crate::emit::text::string;
use crate::package::Package;
use crate::profile::{Profile, header};
use crate::simtalk::literal;
use crate::template::render;
use serde::Serialize;

/// File name of the probe, without extension.
pub const STEM: &str = "linewright_probe";

/// The fields of `probe.c`.
#[derive(Serialize)]
struct Source {
    calls: Vec<CallOfSource>,
    confirmed: Option<Confirmed>,
}

/// A call and the dump words of its arguments.
#[derive(Serialize)]
struct CallOfSource {
    name: String,
    count: usize,
    arguments: String,
}

/// The second round: the profile, and the values returned with it.
#[derive(Serialize)]
struct Confirmed {
    profile: Vec<String>,
    integer: String,
    real: String,
    string: String,
}

/// The fields of `method.txt`.
#[derive(Serialize)]
struct Method<'a> {
    library: &'a str,
    needed: Vec<CallOfMethod>,
    optional: Vec<CallOfMethod>,
    second_round: bool,
    seen: &'static str,
}

/// A call in SimTalk.
#[derive(Serialize)]
struct CallOfMethod {
    name: String,
    /// Arguments, each preceded by a comma.
    arguments: String,
    /// The argument if it is a time, because a time needs a variable in SimTalk; otherwise `None`.
    duration: Option<String>,
}

/// Creates the probe's package. With a profile, it is the probe of the second round, which also
/// returns values in the profile's layout.
pub fn package(profile: Option<&Profile>) -> Package {
    let calls = all(profile).into_iter().map(|call| {
        let words = call
            .arguments
            .iter()
            .fold(String::new(), |s, v| s + " " + &v.dump_word());
        CallOfSource {
            count: call.arguments.len(),
            arguments: string(&words),
            name: call.name,
        }
    });
    let own = render(
        "probe/probe.c",
        Source {
            calls: calls.collect(),
            confirmed: profile.map(confirmed),
        },
    );
    let mut support = vec![(
        "probe.c",
        include_str!("../../../../ffi/probe.c").to_owned(),
    )];
    if let Some(profile) = profile {
        support.push((
            "uf_value.h",
            include_str!("../../../../ffi/uf_value.h").to_owned(),
        ));
        support.push((header::NAME, profile.to_header()));
    }
    Package::of_files("probe", STEM, own, support)
}

fn confirmed(profile: &Profile) -> Confirmed {
    let toml = profile.to_toml();
    let lines = toml
        .lines()
        .map(|line| string(&format!("profile {line}\n")));
    let [integer, real, text] =
        returned_values(profile.layout.integer_bits).map(|value| match value {
            Value::Text(t) => string(&t),
            Value::Real(x) | Value::Time(x) => format!("{x:?}"),
            Value::Integer(i) => i.to_string(),
            Value::Boolean(b) => i32::from(b).to_string(),
        });
    Confirmed {
        profile: lines.collect(),
        integer,
        real,
        string: text,
    }
}

/// All calls of a round.
fn all(profile: Option<&Profile>) -> Vec<Call> {
    let mut all = calls();
    if let Some(profile) = profile {
        all.push(Call {
            name: CONFIRM_EXPORT.to_owned(),
            arguments: returned_values(profile.layout.integer_bits).into(),
            optional: false,
        });
    }
    all
}

/// Renders the SimTalk 2 method that makes the calls. `library` is the library's file name.
pub fn simtalk(profile: Option<&Profile>, library: &str) -> String {
    let (optional, needed): (Vec<Call>, Vec<Call>) = calls().into_iter().partition(|c| c.optional);
    let written = |calls: Vec<Call>| {
        let calls = calls.into_iter().map(|call| CallOfMethod {
            arguments: call
                .arguments
                .iter()
                .fold(String::new(), |s, v| s + ", " + &literal(v)),
            duration: match call.arguments.first() {
                Some(time @ Value::Time(_)) => Some(literal(time)),
                _ => None,
            },
            name: call.name,
        });
        calls.collect()
    };
    render(
        "probe/method.txt",
        Method {
            library,
            needed: written(needed),
            optional: written(optional),
            second_round: profile.is_some(),
            seen: CONFIRM_EXPORT,
        },
    )
}
