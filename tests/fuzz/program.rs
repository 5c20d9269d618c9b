//! Properties that hold for every text read as a program of calls. Shared by the fuzz target and
//! the ordinary tests.

use linewright::cli::order::program::{Program, read};
use linewright::contract::load;
use linewright::order::Skills;
use linewright::source::SourceMap;
use std::fmt::Write as _;
use std::sync::{Arc, OnceLock};

const UNIT: &str = "skills Unit {
    component x: {left, right} = left {
        Left -> left
        Right -> right
    }
    component z { Up, Down, G }
}
";

fn skills() -> &'static Skills {
    static SKILLS: OnceLock<Arc<Skills>> = OnceLock::new();
    SKILLS.get_or_init(|| {
        let files = [("unit.lw".to_owned(), UNIT.to_owned())];
        let (library, findings) = load(&files, &|_, _| Err(String::new()));
        assert!(findings.is_empty(), "{findings:#?}");
        Arc::clone(&library.skills[0])
    })
}

fn of(name: &str, text: &str) -> Program {
    let mut sources = SourceMap::default();
    let file = sources.add(name, text.to_owned());
    read(&sources, file, skills())
}

/// Reads a text as a program and as a table: every finding and every call lies within it, and calls
/// that were read can be read again from either form. Returns the number of calls without findings.
pub fn program(text: &str) -> usize {
    let mut calls = 0;
    for name in ["fuzz.txt", "fuzz.csv"] {
        let program = of(name, text);
        let labels = program.findings.iter().flat_map(|f| &f.labels);
        let spans = program.findings.iter().filter_map(|f| f.span);
        for span in spans
            .chain(labels.map(|l| l.0))
            .chain(program.spans.iter().copied())
        {
            let place = span.start as usize..span.end as usize;
            assert!(text.get(place).is_some(), "{name}: {span:?}");
        }
        assert!(program.findings.iter().all(|f| f.help.is_some()));
        assert_eq!(program.calls.len(), program.spans.len());
        if !program.findings.is_empty() {
            continue;
        }
        let (mut lines, mut table) = (String::new(), "step;skill\n".to_owned());
        for (step, call) in program.calls.iter().enumerate() {
            let _ = writeln!(lines, "{}", call.text(skills()));
            for skill in call.skills() {
                let _ = writeln!(table, "{};{}", step + 1, skills().skills[skill].name);
            }
        }
        for (name, text) in [("again.txt", &lines), ("again.csv", &table)] {
            let again = of(name, text);
            assert!(again.findings.is_empty(), "{text}\n{:#?}", again.findings);
            assert_eq!(again.calls, program.calls, "{text}");
        }
        calls += program.calls.len();
    }
    calls
}
