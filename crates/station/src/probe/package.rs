//! The probe as a package: `ffi/probe.c` with the list of its calls, and the SimTalk that makes them.

use super::{Call, SEEN, Value, calls, returned};
use crate::emit::text::string;
use crate::package::Package;
use crate::profile::{Profile, header};
use crate::simtalk::literal;
use std::fmt::Write as _;

/// The probe's name as a file's.
pub const STEM: &str = "linewright_probe";

/// The probe; with a profile that of the second round, which also returns values with it.
pub fn package(profile: Option<&Profile>) -> Package {
    let mut own = String::from(
        "/* The probe of Plant Simulation's UF_Value, emitted by linewright. `probe.c` says what it does. */\n",
    );
    own.push_str("#define LW_PROBE_CALLS(CALL)");
    for call in all(profile) {
        let words = call
            .arguments
            .iter()
            .fold(String::new(), |s, v| s + " " + &v.word());
        let _ = write!(
            own,
            " \\\n    CALL({}, {}U, {})",
            call.name,
            call.arguments.len(),
            string(&words)
        );
    }
    own.push('\n');
    let mut support = vec![(
        "probe.c",
        include_str!("../../../../ffi/probe.c").to_owned(),
    )];
    if let Some(profile) = profile {
        let lines: Vec<String> = profile
            .to_toml()
            .lines()
            .map(|line| format!("    {}", string(&format!("profile {line}\n"))))
            .collect();
        let _ = writeln!(
            own,
            "\n/* The profile, line by line. */\n#define LW_PROBE_PROFILE \\\n{}",
            lines.join(" \\\n")
        );
        let names = ["LW_CONFIRM_INTEGER", "LW_CONFIRM_REAL", "LW_CONFIRM_STRING"];
        for (name, value) in names.iter().zip(returned(profile.layout.integer_bits)) {
            let value = match value {
                Value::Text(t) => string(&t),
                Value::Real(x) | Value::Time(x) => format!("{x:?}"),
                Value::Integer(i) => i.to_string(),
                Value::Boolean(b) => i32::from(b).to_string(),
            };
            let _ = writeln!(own, "#define {name} {value}");
        }
        support.push((
            "uf_value.h",
            include_str!("../../../../ffi/uf_value.h").to_owned(),
        ));
        support.push((header::NAME, profile.to_header()));
    }
    own.push_str("\n#include \"probe.c\"\n");
    Package::of_files("probe", STEM, own, support)
}

/// All calls of a round.
fn all(profile: Option<&Profile>) -> Vec<Call> {
    let mut all = calls();
    if let Some(profile) = profile {
        all.push(Call {
            name: SEEN.to_owned(),
            arguments: returned(profile.layout.integer_bits).into(),
            optional: false,
        });
    }
    all
}

/// The SimTalk 2 text of a method that makes the calls. `library` is the library's file name.
pub fn simtalk(profile: Option<&Profile>, library: &str) -> String {
    let mut out = String::from(
        "-- A SimTalk 2 method that runs Linewright's probe once. Nothing of the model is changed.\n\
         --\n\
         -- 1. Copy the library to a folder of this computer that you may write to, and put its absolute path into the next line\n\
         --    of code. Save your model first: a host that lays its values out in an unforeseen way could end in a call.\n\
         -- 2. Paste all of this into a new method, and run it.\n\
         -- 3. Beside the library there is now a file that ends in .dump.txt (or `linewright_probe.dump.txt` in %TEMP%). It holds some\n\
         --    hundred bytes of this program's memory, around the values that are passed below. Give it to\n\
         --        linewright doctor --probe FILE --out profile.toml\n\n",
    );
    let _ = writeln!(
        out,
        "var probe := loadLibrary(\"C:\\linewright\\{library}\")"
    );
    out.push_str("if probe < 0\n    print \"The probe could not be loaded. Is the path absolute, and this program one of 64 bits?\"\nelse\n");
    for call in calls() {
        let before = if call.optional { "    -- " } else { "    " };
        if call.name == "lw_probe_boolean_1" {
            out.push_str("    -- Where the lines below are accepted, take their first dashes away: they are not needed, but say more.\n");
        }
        if matches!(call.arguments.first(), Some(Value::Time(_))) {
            let _ = writeln!(
                out,
                "{before}var duration: time := {}",
                literal(&call.arguments[0])
            );
            let _ = writeln!(
                out,
                "{before}callLibrary(probe, \"{}\", duration)",
                call.name
            );
            continue;
        }
        let _ = writeln!(out, "{before}{}", line(&call));
    }
    if profile.is_some() {
        out.push_str(
            "    -- The second round: what the library returns is passed back to it.\n\
             \x20   var whole := callLibrary(probe, \"lw_confirm_integer\")\n\
             \x20   var number := callLibrary(probe, \"lw_confirm_real\")\n\
             \x20   var text := callLibrary(probe, \"lw_confirm_string\")\n",
        );
        let _ = writeln!(
            out,
            "    callLibrary(probe, \"{SEEN}\", whole, number, text)"
        );
    }
    out.push_str("    freeLibrary(probe)\nend\n");
    out
}

/// One call as a statement.
fn line(call: &Call) -> String {
    let arguments = call
        .arguments
        .iter()
        .fold(String::new(), |s, v| s + ", " + &literal(v));
    format!("callLibrary(probe, \"{}\"{arguments})", call.name)
}
