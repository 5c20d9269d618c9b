//! The C file of a unit: the machine's own text, what the adapters must know beside it, and the adapter.

use super::Version;
use super::variables::{Kind, kind};
use crate::emit::expression::{literal, real_literal};
use crate::emit::text::{comment, string};
use linewright_core::gr1::Domain;
use linewright_language::contract::machine::Machine;
use std::fmt::Write;

/// The whole file.
pub(super) fn source(
    machine: &Machine,
    unit: &str,
    tables: &str,
    token: &str,
    version: Version,
) -> String {
    let (number, prefix) = match version {
        Version::Two => ("2.0", "FMI2_FUNCTION_PREFIX"),
        Version::Three => ("3.0", "FMI3_FUNCTION_PREFIX"),
    };
    format!(
        "/* The machine {}, emitted by linewright from its contracts as a co-simulation unit of FMI {number}.\n *\n * \
         Compile this file alone, with the others of this folder beside it:\n *\n *     \
         cc -std=c99 -O2 -fPIC -shared -fvisibility=hidden -ffp-contract=off -pthread THIS.c -o THIS.so -lm\n *\n * \
         Linked into a program, {prefix} begins the names of its functions. */\n\
         #define LW_PRIVATE\n{unit}\
         /* ---- FMI {} */\n\n\
         #include \"fmi.h\"\n\n\
         /* modelDescription.xml describes the unit. */\nstatic const char lw_description[] = \"\";\n\n\
         #define LW_FMI_TOKEN {}\n{}\
         #include \"runtime.c\"\n#include \"{}\"\n",
        comment(&machine.name),
        "-".repeat(98),
        string(token),
        tables,
        version.adapter(),
    )
}

/// What the adapters must know beside the machine's own tables.
pub(super) fn tables(machine: &Machine, first_operation: usize) -> String {
    let mut out = format!(
        "#define LW_FMI_FIRST_OPERATION {first_operation}\n#define LW_FMI_IDLE_WATTS {}\n#define LW_FMI_STEP_TEXT {}\n\n",
        real_literal(machine.idle_watts),
        string(&machine.step_seconds.to_string())
    );
    let plant = machine.plant.iter().map(|p| &p.domain);
    let outputs = machine.components.iter().flat_map(|c| {
        let ids = c.specification.outputs();
        ids.map(|id| &c.specification.variable(id).domain)
    });
    let _ = writeln!(
        out,
        "/* The type of every wire, and what it shows before the first step. */\nstatic const lw_fmi_wire lw_fmi_wire_table[] = {{"
    );
    let mut empty = true;
    for (wire, domain) in plant.chain(outputs).enumerate() {
        empty = false;
        let _ = writeln!(
            out,
            "    {{ {}, {} }}, /* {} */",
            type_name(domain),
            literal(before(domain)),
            comment(&machine.wire_name(wire))
        );
    }
    if empty {
        out.push_str("    { 0, 0 }\n");
    }
    out.push_str("};\n\n/* What properties and parameters are where the host says nothing. */\nstatic const double lw_fmi_defaults[] = {\n");
    for property in &machine.properties {
        let _ = writeln!(
            out,
            "    {}, /* {} */",
            real_literal(property.default),
            comment(&property.name)
        );
    }
    if machine.properties.is_empty() {
        out.push_str("    0.0\n");
    }
    out.push_str("};\n\n");
    out
}

/// The value nearest to 0.
fn before(domain: &Domain) -> i64 {
    0.clamp(domain.low(), domain.high())
}

fn type_name(domain: &Domain) -> &'static str {
    match kind(domain) {
        Kind::Real => "LW_FMI_REAL",
        Kind::Integer => "LW_FMI_INTEGER",
        Kind::Long => "LW_FMI_LONG",
        Kind::Boolean => "LW_FMI_BOOLEAN",
        Kind::Enumeration(_) => "LW_FMI_ENUMERATION",
    }
}
