//! The SimTalk of machines, compared with the description of their libraries: arity and argument
//! order of every call, loading first, and checks of every negative code.

use super::simtalk::{Expression, Method, Statement, methods};
use crate::{fixtures, support};
use linewright::contract::machine::Machine;
use linewright::station::profile::Profile;
use linewright::station::simtalk::LibraryForm;
use linewright::station::{Package, simtalk};
use serde_json::Value;
use std::collections::BTreeSet;

/// Results that are error codes if negative.
const CODED: [&str; 5] = [
    "instantiate",
    "simulate",
    "reset",
    "deinstantiate",
    "get_integer",
];

/// Faults in a machine's methods; empty if there are none.
fn wrong(text: &str, description: &Value) -> Vec<String> {
    let mut checker = Checker {
        exports: &description["exports"],
        properties: description["properties"].as_array().expect("properties"),
        library: String::new(),
        called: Vec::new(),
        sound: 0,
        wrong: Vec::new(),
    };
    let methods = methods(text);
    for method in &methods {
        checker.method(method);
    }
    let mut found = checker.wrong;
    let titled = |end: &str| {
        methods
            .iter()
            .find(|m| m.title.split(':').next().is_some_and(|t| t.ends_with(end)))
    };
    for end in ["_init", "_reset", "_endSim"] {
        if titled(end).is_none() {
            found.push(format!("there is no method {end}"));
        }
    }
    let all: Vec<(usize, &str)> = checker
        .called
        .iter()
        .map(|(m, e)| (*m, e.as_str()))
        .collect();
    let place = |wanted: &str| all.iter().position(|(_, e)| *e == wanted);
    let in_order = [
        ("loadLibrary", "instantiate"),
        ("instantiate", "simulate"),
        ("deinstantiate", "freeLibrary"),
        // Instances left by an unfinished run are released before new ones are made: handles could
        // be equal.
        ("loadLibrary", "deinstantiate"),
        ("deinstantiate", "instantiate"),
    ];
    for (first, second) in in_order {
        if let (before, Some(after)) = (place(first), place(second))
            && before.is_none_or(|b| b > after)
        {
            found.push(format!("`{first}` does not come before `{second}`"));
        }
    }
    let has_operations = description["operations"]
        .as_array()
        .is_some_and(|o| !o.is_empty());
    if has_operations != place("simulate").is_some() {
        found.push("`simulate` is called if and only if there are operations".to_owned());
    }
    let backs = all.iter().filter(|(_, e)| *e == "deinstantiate");
    if backs.map(|(m, _)| m).collect::<BTreeSet<_>>().len() != 2 {
        found.push("instances are not given back at the beginning and at the end".to_owned());
    }
    if has_operations {
        for end in ["_init", "_reset"] {
            let zero = titled(end).is_some_and(|m| sets(&m.body, "Station.LW_Energy", "0"));
            if !zero {
                found.push(format!("{end} leaves the energy as it is"));
            }
        }
    }
    if all.iter().filter(|(_, e)| *e == "loadLibrary").count() != 1 {
        found.push("the library is loaded more or less than once".to_owned());
    }
    found
}

struct Checker<'a> {
    exports: &'a Value,
    properties: &'a [Value],
    library: String,
    /// The calls in text order, each with its method's number.
    called: Vec<(usize, String)>,
    /// Number of active checks of a getter's result at the current position.
    sound: usize,
    wrong: Vec<String>,
}

impl Checker<'_> {
    fn method(&mut self, method: &Method) {
        let number = self.called.last().map_or(0, |(m, _)| m + 1);
        self.block(&method.body, number);
    }

    fn block(&mut self, body: &[Statement], method: usize) {
        for (i, statement) in body.iter().enumerate() {
            match statement {
                Statement::Print(values) => values.iter().for_each(|v| {
                    self.expression(v, method, true);
                }),
                Statement::Do(value) => {
                    if let Some(export) = self.expression(value, method, true)
                        && export != "freeLibrary"
                    {
                        self.wrong
                            .push(format!("the result of `{export}` is not looked at"));
                    }
                }
                Statement::Assign(target, value) => {
                    self.assign(target, value, &body[i + 1..], method);
                }
                Statement::If(condition, then, otherwise) => {
                    self.branch(condition, then, otherwise, method);
                }
            }
        }
    }

    fn assign(&mut self, target: &str, value: &Expression, rest: &[Statement], method: usize) {
        let looked_at = matches!(rest.first(), Some(Statement::If(c, _, _)) if is_negative(c, &Expression::Name(target.to_owned())));
        if let Expression::Call(name, _) = value
            && name == "loadLibrary"
        {
            target.clone_into(&mut self.library);
        }
        let Some(export) = self.expression(value, method, looked_at) else {
            return;
        };
        let coded = CODED.contains(&export.as_str()) || export == "loadLibrary";
        if coded && !looked_at {
            self.wrong
                .push(format!("the code of `{export}` is not looked at"));
        }
    }

    fn branch(
        &mut self,
        condition: &Expression,
        then: &[Statement],
        otherwise: &[Statement],
        method: usize,
    ) {
        self.expression(condition, method, true);
        let handles = then
            .iter()
            .any(|s| matches!(s, Statement::Assign(t, _) if t.ends_with(".Failed")));
        if let Expression::Operation(_, '<', _) = condition
            && !handles
            && otherwise.is_empty()
            && !matches!(
                then.first(),
                Some(Statement::If(..) | Statement::Assign(..))
            )
        {
            self.wrong
                .push("a negative code has no consequence".to_owned());
        }
        self.block(then, method);
        let sound = self.sound;
        self.sound += 1;
        self.block(otherwise, method);
        self.sound = sound;
    }

    /// Examines every call in an expression; returns the export that the expression calls.
    fn expression(&mut self, value: &Expression, method: usize, looked_at: bool) -> Option<String> {
        match value {
            Expression::Operation(a, _, b) => {
                self.expression(a, method, looked_at);
                self.expression(b, method, looked_at);
                None
            }
            Expression::Call(name, arguments) if name == "callLibrary" => {
                let [
                    Expression::Name(library),
                    Expression::Text(export),
                    passed @ ..,
                ] = arguments.as_slice()
                else {
                    self.wrong
                        .push(format!("no library and export: {arguments:?}"));
                    return None;
                };
                if *library != self.library {
                    self.wrong
                        .push(format!("`{library}` is not the library that was loaded"));
                }
                match self.exports[export].as_u64() {
                    None => self.wrong.push(format!("`{export}` is not exported")),
                    Some(arity) if arity != passed.len() as u64 => {
                        self.wrong.push(format!(
                            "`{export}` takes {arity} arguments, not {}",
                            passed.len()
                        ));
                    }
                    Some(_) => {}
                }
                if export == "simulate" {
                    self.simulate(passed);
                }
                if export == "get_real" && !looked_at && self.sound < 2 {
                    self.wrong
                        .push("a result is read before one was looked at".to_owned());
                }
                self.called.push((method, export.clone()));
                Some(export.clone())
            }
            Expression::Call(name, arguments) => {
                if name != "loadLibrary" && name != "freeLibrary" {
                    self.wrong.push(format!("`{name}` is not known of SimTalk"));
                }
                if arguments.len() != 1 {
                    self.wrong.push(format!("`{name}` takes one argument"));
                }
                if let ("loadLibrary", Some(Expression::Text(path))) =
                    (name.as_str(), arguments.first())
                    && !path.starts_with("C:\\")
                {
                    self.wrong.push(format!("the path {path} is not absolute"));
                }
                self.called.push((method, name.clone()));
                Some(name.clone())
            }
            _ => None,
        }
    }

    /// Handle and operation of the station, then every property in order, of the part or of the
    /// station.
    fn simulate(&mut self, passed: &[Expression]) {
        let mut wanted = vec!["?.LW_Handle".to_owned(), "?.LW_Operation".to_owned()];
        for property in self.properties {
            let name = property["name"].as_str().expect("a name");
            let name = name.replace('[', "_").replace(']', "").replace('.', "_");
            let holder = if property["kind"] == "part" { "@" } else { "?" };
            wanted.push(format!("{holder}.LW_{name}"));
        }
        let passed: Vec<String> = passed
            .iter()
            .map(|p| match p {
                Expression::Name(n) => n.clone(),
                other => format!("{other:?}"),
            })
            .collect();
        if passed != wanted {
            self.wrong.push(format!(
                "`simulate` is called with {passed:?}, not {wanted:?}"
            ));
        }
    }
}

/// Whether statements set a target to a number.
fn sets(body: &[Statement], target: &str, number: &str) -> bool {
    body.iter().any(|statement| match statement {
        Statement::Assign(t, Expression::Number(n)) => t == target && n == number,
        Statement::If(_, then, otherwise) => {
            sets(then, target, number) || sets(otherwise, target, number)
        }
        _ => false,
    })
}

/// Whether a condition tests that this is negative.
fn is_negative(condition: &Expression, of: &Expression) -> bool {
    matches!(condition, Expression::Operation(a, '<', zero)
        if **a == *of && **zero == Expression::Number("0".to_owned()))
}

fn beside(library: &str) -> LibraryForm<'_> {
    LibraryForm::Library {
        library,
        source: "station-0123-source",
    }
}

fn of_machine(machine: &Machine, package: &Package) -> (String, Value) {
    let texts = simtalk::texts(
        machine,
        package,
        &Profile::assumed(),
        beside("station-0123.dll"),
    );
    let description = serde_json::from_str(&package.description).expect("JSON");
    (texts.methods, description)
}

#[test]
fn methods_of_fixtures_keep_to_the_exports() {
    for (machine, controllers) in [
        fixtures::manipulator(),
        fixtures::belt(),
        fixtures::jammed(),
    ] {
        let package = Package::emit(&machine, &controllers);
        let (text, description) = of_machine(&machine, &package);
        assert_eq!(wrong(&text, &description), Vec::<String>::new(), "{text}");
    }
}

/// Faults that a weaker check would miss.
#[test]
fn wrong_methods_are_noticed() {
    let (machine, controllers) = fixtures::manipulator();
    let package = Package::emit(&machine, &controllers);
    let (text, description) = of_machine(&machine, &package);
    let changes = [
        ("?.LW_Operation, @.LW_angle", "@.LW_angle, ?.LW_Operation"),
        (", @.LW_steps)", ")"),
        ("\"instantiate\")", "\"instantiate\", 1)"),
        ("\"get_real\"", "\"get_reals\""),
        ("if duration < 0", "if duration < 1"),
        ("if taken < 0", "if taken < 1"),
        ("loadLibrary(\"C:\\linewright\\", "loadLibrary(\".\\"),
        ("LW_Manipulator := loadLibrary", "LW_Other := loadLibrary"),
        ("_endSim:", "_end:"),
        ("LW_Energy := 0", "LW_Energy := 1"),
        (
            "if 0 < Station.LW_Handle\n        if callLibrary(LW_Manipulator, \"deinst",
            "if 0 < Station.LW_Handle\n        if callLibrary(LW_Manipulator, \"inst",
        ),
        (
            "Station.LW_Handle := callLibrary",
            "Station.LW_Handl := callLibrary",
        ),
    ];
    for (from, to) in changes {
        let changed = text.replace(from, to);
        assert_ne!(changed, text, "{from}");
        assert!(
            !wrong(&changed, &description).is_empty(),
            "{to} is not noticed"
        );
    }
}

#[test]
fn a_machines_texts_read_well() {
    let (machine, controllers) = fixtures::manipulator();
    let package = Package::emit(&machine, &controllers);
    let texts = simtalk::texts(
        &machine,
        &package,
        &Profile::assumed(),
        beside("manipulator-0123456789abcdef.dll"),
    );
    insta::assert_snapshot!("methods", texts.methods);
    let page = |text: &str| text.replace(&package.contract_hash, "[hash]");
    insta::assert_snapshot!("page", page(&texts.page));
    let library = "manipulator.dll";
    let source = simtalk::texts(
        &machine,
        &package,
        &Profile::assumed(),
        LibraryForm::Source { library },
    );
    let beginning: Vec<&str> = source.page.lines().take(8).collect();
    insta::assert_snapshot!("page_of_source", beginning.join("\n"));
}

/// Every machine of the laboratory, through the program.
#[test]
fn the_laboratorys_machines_come_with_their_texts() {
    let sandbox = support::sandbox();
    for file in ["cell", "camera", "printer", "milling", "belt"] {
        let file = format!("examples/ice-lab/{file}.lw");
        let out = format!("out/{file}");
        let output = support::linewright(
            sandbox.path(),
            &["build", &file, "--target", "source", "--out", &out],
        );
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{said}");
        let printed = String::from_utf8(output.stdout).expect("paths");
        let read = |ending: &str| {
            let path = printed
                .lines()
                .find(|l| l.ends_with(ending))
                .expect("a file");
            std::fs::read_to_string(sandbox.path().join(path)).expect("a text")
        };
        let source = printed.lines().next().expect("the C file");
        let source = std::fs::read_to_string(sandbox.path().join(source)).expect("C");
        let description = description_of(&source);
        assert_eq!(
            wrong(&read(".simtalk.txt"), &description),
            Vec::<String>::new(),
            "{file}"
        );
        let page = read(".import.md");
        assert!(page.contains("(unverified)"), "{page}");
        let properties = description["properties"].as_array().expect("properties");
        for property in properties {
            let name = property["name"].as_str().expect("a name");
            assert!(page.contains(&format!("`{name}`")), "{file}: {name}");
        }
        let names: BTreeSet<_> = page
            .lines()
            .filter(|l| l.starts_with("| `LW_"))
            .map(str::to_lowercase)
            .collect();
        assert!(
            names.len() >= properties.len(),
            "{file}: every property has an attribute of its own"
        );
    }
}

/// The JSON that a C file holds in the literals of `lw_description`.
fn description_of(source: &str) -> Value {
    let text = source
        .split_once("lw_description[] =")
        .expect("a description")
        .1;
    let text = text.split_once("\";\n").expect("its end").0;
    let mut out = Vec::new();
    for line in text.lines().filter(|l| l.trim_start().starts_with('"')) {
        let line = line.trim().trim_start_matches('"');
        let mut characters = line.strip_suffix('"').unwrap_or(line).bytes();
        while let Some(byte) = characters.next() {
            if byte != b'\\' {
                out.push(byte);
                continue;
            }
            match characters.next() {
                Some(first @ b'0'..=b'7') => {
                    let digits = [
                        first,
                        characters.next().unwrap_or(b'0'),
                        characters.next().unwrap_or(b'0'),
                    ];
                    out.push(
                        digits
                            .iter()
                            .fold(0, |n: u8, d| n.wrapping_mul(8) + (d - b'0')),
                    );
                }
                Some(b'n') => out.push(b'\n'),
                Some(other) => out.push(other),
                None => {}
            }
        }
    }
    serde_json::from_slice(&out).expect("JSON")
}
