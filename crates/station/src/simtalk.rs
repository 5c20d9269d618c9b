//! The SimTalk 2 text that calls a station library from Plant Simulation, and the page that says how to import it.
//!
//! What is public of SimTalk is little: `loadLibrary`, `callLibrary`, `freeLibrary`, `@` for the part, `?` for the station, and
//! `?.Failed := true` (Spellini et al. 2021, Listing 2). The text uses no other built-in than it must, and names those that are
//! assumed. Unlike that listing it loads the library once, when the model starts, makes one instance for each station, passes
//! every argument that an export reads, and looks at every negative code.
//!
//! Names that the user has to create begin with `LW_`, so that they meet no attribute that a station or part already has.

use super::package::Package;
use super::probe::Value;
use super::profile::Profile;
use super::toolchain;
use linewright_core::gr1::Domain;
use linewright_language::contract::machine::{Machine, PropertyKind};
use std::collections::BTreeSet;
use std::fmt::Write as _;

/// The texts of one machine.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Texts {
    /// The methods.
    pub methods: String,
    /// The page on importing them, in Markdown.
    pub page: String,
}

/// How the texts' file names end, behind the library's name without its ending.
pub const ENDINGS: [&str; 2] = [".simtalk.txt", ".import.md"];

/// What the texts stand beside.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Beside<'a> {
    /// A library of this file name, and a folder with its C source.
    Library {
        /// The library.
        library: &'a str,
        /// The folder.
        source: &'a str,
    },
    /// The C source, which is yet to be compiled into a library of this file name.
    Source {
        /// The library.
        library: &'a str,
    },
}

impl<'a> Beside<'a> {
    fn library(self) -> &'a str {
        match self {
            Self::Library { library, .. } | Self::Source { library } => library,
        }
    }
}

/// A value as SimTalk writes it.
pub fn literal(value: &Value) -> String {
    match value {
        Value::Integer(i) => i.to_string(),
        Value::Real(x) | Value::Time(x) => format!("{x:?}"),
        Value::Text(t) => quoted(t),
        Value::Boolean(b) => b.to_string(),
    }
}

/// A text in quotes; a quote within it would end it, and names of contracts hold none.
fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('"', "'"))
}

/// The texts for a machine.
pub fn texts(machine: &Machine, package: &Package, profile: &Profile, beside: Beside<'_>) -> Texts {
    let names = Names::of(machine);
    let writer = Writer {
        machine,
        package,
        profile,
        library: beside.library(),
        beside,
        names,
    };
    Texts {
        methods: writer.methods(),
        page: writer.page(),
    }
}

/// The names that the user creates.
struct Names {
    /// `AssemblyCell`, as part of a name.
    machine: String,
    /// The variable that holds the library's handle.
    library: String,
    /// One attribute a property.
    attributes: Vec<String>,
}

impl Names {
    fn of(machine: &Machine) -> Self {
        let own = plain(&machine.name);
        // SimTalk does not tell `A` from `a`.
        let mut taken: BTreeSet<String> = ["lw_handle", "lw_operation", "lw_energy"]
            .map(str::to_owned)
            .into();
        let attributes = machine.properties.iter().map(|property| {
            let wish = format!("LW_{}", plain(&property.name));
            let mut name = wish.clone();
            let mut number = 2;
            while !taken.insert(name.to_lowercase()) {
                name = format!("{wish}_{number}");
                number += 1;
            }
            name
        });
        Self {
            attributes: attributes.collect(),
            library: format!("LW_{own}"),
            machine: own,
        }
    }
}

/// Letters, digits and single underscores of ASCII: `heights[2]` is `heights_2`.
fn plain(name: &str) -> String {
    let mut out = String::new();
    for c in name.chars() {
        match c {
            c if c.is_ascii_alphanumeric() => out.push(c),
            ']' => {}
            _ if !out.ends_with('_') => out.push('_'),
            _ => {}
        }
    }
    out
}

struct Writer<'a> {
    machine: &'a Machine,
    package: &'a Package,
    profile: &'a Profile,
    library: &'a str,
    beside: Beside<'a>,
    names: Names,
}

impl Writer<'_> {
    fn methods(&self) -> String {
        let mut out = self.opening();
        out.push_str(&self.init());
        if !self.machine.operations.is_empty() {
            out.push_str(&self.entrance());
        }
        out.push_str(&self.reset());
        out.push_str(&self.end());
        out
    }

    /// A call of the library, for the station that `of` names.
    fn call(&self, export: &str, arguments: &[String]) -> String {
        let arguments = arguments.iter().fold(String::new(), |s, a| s + ", " + a);
        format!(
            "callLibrary({}, \"{export}\"{arguments})",
            self.names.library
        )
    }

    /// What is done when a call has failed: say why, and stop the station.
    fn failed(&self, station: &str, handle: &str, indent: &str) -> String {
        let error = self.call("last_error", &[handle.to_owned()]);
        format!(
            "{indent}print \"{}: \", {error}\n{indent}{station}.Failed := true\n",
            self.names.machine
        )
    }

    fn opening(&self) -> String {
        let name = &self.names.machine;
        let mut out = format!(
            "-- {name}: SimTalk 2 methods for the station library {}\n\
             -- UF_Value: {}\n\
             --\n",
            self.library,
            self.profile.shown()
        );
        if !self.profile.verified() {
            out.push_str(
                "-- A library whose layout of UF_Value is not the program's can end the program. Save your model before the first run,\n\
                 -- and find the layout with the probe: `linewright build --probe --target windows`.\n--\n",
            );
        }
        let _ = write!(
            out,
            "-- Each part below is a method of its own, in the frame that holds the stations. The page {} says how to\n\
             -- import them, and what has to be created first.\n\
             --\n\
             -- Known from published models: loadLibrary, callLibrary, freeLibrary, @ (the part), ? (the station), Failed.\n\
             -- Assumed, and not tried in the product: `var NAME: TYPE`, `end`, `print A, B`, the station's attribute ProcTime, and that\n\
             -- a variable of the frame and user-defined attributes are read and written by their names.\n\n",
            page_name(self.library)
        );
        out
    }

    fn init(&self) -> String {
        let (name, library) = (&self.names.machine, &self.names.library);
        let mut out = banner(&format!("{library}_init: call it in the model's init"));
        let _ = writeln!(
            out,
            "{library} := loadLibrary(\"C:\\linewright\\{}\") -- the absolute path",
            self.library
        );
        let _ = writeln!(out, "if {library} < 0");
        let _ = writeln!(
            out,
            "    print \"{name}: the library was not loaded. Is the path absolute, and Plant Simulation one of 64 bits?\""
        );
        out.push_str("    Station.LW_Handle := 0\n    Station.Failed := true\nelse\n");
        out.push_str(
            "    -- First, once for each station of this kind, with its name for Station: what a run that did not come to its endSim has left.\n\
             \x20   if 0 < Station.LW_Handle\n",
        );
        let _ = writeln!(
            out,
            "        if {} < 0",
            self.call("deinstantiate", &["Station.LW_Handle".to_owned()])
        );
        out.push_str(
            "            Station.LW_Handle := 0 -- the program was closed in between\n        end\n    end\n\
             \x20   -- Then, from here to the end of its `if`, once for each station, likewise.\n",
        );
        let _ = writeln!(
            out,
            "    Station.LW_Handle := {}",
            self.call("instantiate", &[])
        );
        out.push_str("    if Station.LW_Handle < 0\n");
        out.push_str(&self.failed("Station", "0", "        "));
        match self.no_energy("    ") {
            None => out.push_str("    end\n"),
            Some(none) => {
                let _ = write!(out, "    else\n    {none}    end\n");
            }
        }
        out.push_str("end\n\n");
        out
    }

    /// Sets a station's sum of energy back, where it has one.
    fn no_energy(&self, indent: &str) -> Option<String> {
        let has = !self.machine.operations.is_empty();
        has.then(|| format!("{indent}Station.LW_Energy := 0\n"))
    }

    fn entrance(&self) -> String {
        let (library, machine) = (&self.names.library, self.machine);
        let mut out = banner(&format!(
            "{library}_entrance: the entrance control of each station"
        ));
        out.push_str("-- LW_Operation says what is done:");
        for (index, operation) in machine.operations.iter().enumerate() {
            let _ = write!(
                out,
                "{} {index} {}",
                if index == 0 { "" } else { "," },
                operation.name
            );
        }
        out.push('\n');
        for (property, name) in machine.properties.iter().zip(&self.names.attributes) {
            let unit = if property.unit.is_empty() {
                String::new()
            } else {
                format!(" in {}", property.unit)
            };
            let _ = writeln!(
                out,
                "-- {}.{name}: {}{unit}",
                holder(property.kind),
                property.name
            );
        }
        let handle = "?.LW_Handle".to_owned();
        let mut arguments = vec![handle.clone(), "?.LW_Operation".to_owned()];
        let properties = machine.properties.iter().zip(&self.names.attributes);
        arguments.extend(properties.map(|(p, name)| format!("{}.{name}", holder(p.kind))));
        let _ = writeln!(
            out,
            "var duration: real := {}",
            self.call("simulate", &arguments)
        );
        out.push_str("if duration < 0\n");
        out.push_str(&self.failed("?", &handle, "    "));
        out.push_str("else\n");
        let get = |result: String| self.call("get_real", &[handle.clone(), quoted(&result)]);
        let _ = writeln!(out, "    var taken: real := {}", get("time".to_owned()));
        out.push_str("    if taken < 0\n");
        out.push_str(&self.failed("?", &handle, "        "));
        out.push_str("    else\n        -- There are results: what is read now may be below 0, and is no code.\n");
        for (index, _) in &machine.writes {
            let property = &machine.properties[*index];
            let _ = writeln!(
                out,
                "        {}.{} := {}",
                holder(property.kind),
                self.names.attributes[*index],
                get(format!("property.{}", property.name))
            );
        }
        let _ = writeln!(
            out,
            "        ?.LW_Energy := ?.LW_Energy + {} -- in J",
            get("energy".to_owned())
        );
        out.push_str("        ?.ProcTime := duration -- in s\n    end\nend\n\n");
        out
    }

    fn reset(&self) -> String {
        let library = &self.names.library;
        let mut out = banner(&format!(
            "{library}_reset: brings a station back to its beginning while the model runs"
        ));
        out.push_str(
            "-- All of this once for each station of this kind, with its name for Station.\n",
        );
        out.push_str("if 0 < Station.LW_Handle\n");
        let _ = writeln!(
            out,
            "    if {} < 0",
            self.call("reset", &["Station.LW_Handle".to_owned()])
        );
        out.push_str(&self.failed("Station", "Station.LW_Handle", "        "));
        out.push_str("    end\n");
        out.push_str(&self.no_energy("    ").unwrap_or_default());
        out.push_str("end\n\n");
        out
    }

    fn end(&self) -> String {
        let library = &self.names.library;
        let mut out = banner(&format!("{library}_endSim: call it in the model's endSim"));
        let _ = writeln!(
            out,
            "if {library} < 0\n    print \"{}: there is no library to free\"\nelse",
            self.names.machine
        );
        out.push_str("    -- From here to the end of its `if`, once for each station of this kind, with its name for Station.\n    if 0 < Station.LW_Handle\n");
        let _ = writeln!(
            out,
            "        if {} < 0",
            self.call("deinstantiate", &["Station.LW_Handle".to_owned()])
        );
        out.push_str(&self.failed("Station", "Station.LW_Handle", "            "));
        out.push_str("        end\n        Station.LW_Handle := 0\n    end\n");
        let _ = writeln!(
            out,
            "    -- Once, behind the last station.\n    freeLibrary({library})\n    {library} := -1\nend"
        );
        out
    }

    fn page(&self) -> String {
        let (machine, names) = (self.machine, &self.names);
        let name = &names.machine;
        let library = &names.library;
        let methods = methods_name(self.library);
        let mut out = format!("# {name} in Plant Simulation\n\n");
        let source = format!("{}.c", self.package.stem);
        match self.beside {
            Beside::Library {
                library,
                source: folder,
            } => {
                let _ = write!(
                    out,
                    "The library `{library}` holds the machine *{name}*; `{methods}` holds the SimTalk 2 methods that call it. Its C source is \
                     `{folder}/{source}`.\n\n"
                );
            }
            Beside::Source { library } => {
                let _ = write!(
                    out,
                    "`{source}` is the C source of the machine *{name}*; `{methods}` holds the SimTalk 2 methods that call its library. Compile it to \
                     `{library}` first, with either of these:\n\n"
                );
                for command in toolchain::by_hand(&source, library) {
                    let _ = writeln!(out, "    {command}");
                }
                out.push('\n');
            }
        }
        let _ = write!(
            out,
            "## What is known, and what is not\n\n\
             The layout of `UF_Value`, in which Plant Simulation passes values, is not public. This library was built with {}.\n",
            self.profile.shown()
        );
        if self.profile.verified() {
            out.push_str("In the program that the layout was found in, values that a library returned with it were read back unchanged.\n\n");
        } else {
            out.push_str(
                "*Unverified* means that nobody has seen Plant Simulation read back what a library returned with this layout. Where the layout is \
                 wrong, a call gives nonsense, or ends the program. So find it first:\n\n\
                 1. `linewright build --probe --target windows --out probe` makes the probe and a method that calls it. Run that in Plant Simulation.\n\
                 2. `linewright doctor --probe DUMP --out plant-simulation.toml` reads the layout from the dump that the probe left beside itself.\n\
                 3. `linewright build --probe --profile plant-simulation.toml --target windows --out probe` makes the second round, in which \
                 values are returned as well; `doctor --probe` then writes a verified profile.\n\
                 4. `linewright build ... --profile FILE --target windows` builds this library anew with it.\n\n\
                 Whoever has Siemens' `cwinfunc.h` can compile the C source against it instead (`-DUF_USE_VENDOR_HEADER`).\n\n",
            );
        }
        out.push_str(
            "Neither the methods nor this page have been tried in the product. The methods name what they assume of SimTalk; a name that your \
             version spells differently is changed there. Which thread calls a library does not matter: all calls may come at once.\n\n",
        );
        out.push_str("## Step by step\n\n");
        let _ = write!(
            out,
            "1. Save your model.\n\
             2. Copy `{}` to a folder of the computer with Plant Simulation (64 bits), such as `C:\\linewright`. It needs no other file{}.\n\
             3. In the frame with the stations, create a variable `{library}` of type integer with the value -1.\n\
             4. Give each station of this kind these user-defined attributes:\n\n\
             | attribute | type | value |\n|---|---|---|\n\
             | `LW_Handle` | {} | 0; the methods set it |\n",
            self.library,
            match self.beside {
                Beside::Library { .. } =>
                    ". Keep its name: it changes with its content, so that a new library is never mistaken for an old one",
                Beside::Source { .. } => "",
            },
            if self.profile.layout.integer_bits == 16 {
                "real"
            } else {
                "integer"
            }
        );
        if !machine.operations.is_empty() {
            let operations: Vec<String> = machine
                .operations
                .iter()
                .enumerate()
                .map(|(i, o)| format!("{i} {}", o.name))
                .collect();
            let _ = writeln!(
                out,
                "| `LW_Operation` | integer | the operation: {} |",
                operations.join(", ")
            );
            out.push_str("| `LW_Energy` | real | 0; adds up the joules of a run |\n");
        }
        out.push_str(&self.attributes(PropertyKind::Parameter));
        let of_parts = self.attributes(PropertyKind::Part);
        let mut step = 5;
        if !of_parts.is_empty() {
            let _ = write!(
                out,
                "\n{step}. Give the parts that come to the station these user-defined attributes:\n\n| attribute | type | value |\n|---|---|---|\n{of_parts}"
            );
            step += 1;
        }
        let mut wanted = vec![format!("`{library}_init`")];
        if !machine.operations.is_empty() {
            wanted.push(format!("`{library}_entrance`"));
        }
        wanted.extend(["reset", "endSim"].map(|m| format!("`{library}_{m}`")));
        let _ = write!(
            out,
            "\n{step}. Create the methods {} in the frame, each with its part of `{methods}`. Put the path of step 2 into `{library}_init`, and \
             the names of your stations in the place of `Station`.\n",
            wanted.join(", ")
        );
        step += 1;
        let _ = writeln!(
            out,
            "{step}. Call `{library}_init` in the model's `init`, and `{library}_endSim` in its `endSim`. Several models or frames may load the same library."
        );
        if machine.operations.is_empty() {
            out.push_str("\nThis machine has no operations: there is nothing for an entrance control to call. It is stepped through the plain C interface (`station.h`).\n");
        } else {
            step += 1;
            let _ = writeln!(
                out,
                "{step}. Choose `{library}_entrance` as the entrance control of the stations."
            );
            step += 1;
            let _ = writeln!(
                out,
                "{step}. Start the model with one part. The console shows errors; the processing time of the station has to be that of the operation."
            );
        }
        out.push_str(&self.trouble());
        out
    }

    /// The rows of a kind's attributes.
    fn attributes(&self, kind: PropertyKind) -> String {
        let properties = self.machine.properties.iter().zip(&self.names.attributes);
        properties
            .filter(|(p, _)| p.kind == kind)
            .fold(String::new(), |s, (p, name)| {
                let unit = if p.unit.is_empty() {
                    String::new()
                } else {
                    format!(", in {}", p.unit)
                };
                let domain = p
                    .domain
                    .as_ref()
                    .map_or(String::new(), |d| format!(", {}", numbers(d)));
                s + &format!(
                    "| `{name}` | real | `{}`{unit}{domain}; {} where nothing else is known |\n",
                    p.name, p.default
                )
            })
    }

    fn trouble(&self) -> String {
        let library = &self.names.library;
        format!(
            "\n## When something is wrong\n\n\
             | what you see | what it is |\n|---|---|\n\
             | `{library}` is below 0 after `loadLibrary` | the path is not absolute or misspelt, the file is blocked (its properties, *Unblock*), or Plant Simulation has 32 bits |\n\
             | the program ends in the first call | the layout of `UF_Value` is another one: run the probe |\n\
             | -1: the handle was never given by this library | `{library}_init` did not run, or `{library}_endSim` did before; each station needs an instance of its own |\n\
             | -2: ... must be ... | an attribute is missing or of another type; times and lengths count as real numbers only where the profile says so (`more_real`) |\n\
             | -3: ... outside its domain | a value of the part that the machine does not have |\n\
             | -4: there is no operation | `LW_Operation` is none of those above |\n\
             | -5: the plant broke the assumption | the text names the rule: the station was asked for what it may not be asked in its state |\n\
             | -7: did not end within | a signal that the operation waits for never came; the instance has been reset |\n\
             | -8: there is no free place | 1024 instances live at a time: a station that is deleted before `{library}_endSim` or `{library}_init` has run leaves its own behind until Plant Simulation is closed |\n\
             | the processing time takes effect one part late | your version sets times before the entrance control runs: choose the control that runs before the entrance |\n\
             | a station stays failed | nothing sets `Failed` back: set it to false when the cause is mended, or reset the model |\n\
             | every text is unreadable | the profile's encoding of strings is another one |\n\n\
             `last_error` gives the whole text of the last error; `station_describe` the machine as JSON. Contract hash: `{}`.\n",
            self.package.contract_hash
        )
    }
}

/// The values of a property, as the numbers that pass.
fn numbers(domain: &Domain) -> String {
    match domain {
        Domain::Bool => "0 false, 1 true".to_owned(),
        Domain::Range { .. } => domain.describe(),
        Domain::Enum { labels, .. } => {
            let numbered = labels.iter().enumerate();
            let words: Vec<String> = numbered.map(|(i, l)| format!("{i} {l}")).collect();
            words.join(", ")
        }
    }
}

/// Who has a property.
fn holder(kind: PropertyKind) -> &'static str {
    match kind {
        PropertyKind::Part => "@",
        PropertyKind::Parameter => "?",
    }
}

fn banner(title: &str) -> String {
    format!("-- ==== {title}\n\n")
}

/// The library's name without its ending.
pub fn stem(library: &str) -> &str {
    library.rsplit_once('.').map_or(library, |(stem, _)| stem)
}

/// The file of the methods for a library's file name.
pub fn methods_name(library: &str) -> String {
    format!("{}{}", stem(library), ENDINGS[0])
}

/// The file of the page for a library's file name.
pub fn page_name(library: &str) -> String {
    format!("{}{}", stem(library), ENDINGS[1])
}
