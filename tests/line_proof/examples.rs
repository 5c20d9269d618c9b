//! The lines of `examples`.

use linewright::cli::files::{self, StandardLibrary};
use linewright::contract::line::Line;
use linewright::diagnostics::has_errors;
use linewright::game::Limits;
use linewright::line::abstraction::{Abstraction, decide, findings};
use std::path::Path;

pub fn load(path: &str) -> Line {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    let loaded = files::load(&[file.display().to_string()], &StandardLibrary::default());
    assert!(!has_errors(&loaded.findings), "{path}: {:?}", loaded.findings);
    let mut lines = loaded.library.lines;
    assert_eq!(lines.len(), 1, "{path}");
    lines.remove(0)
}

#[test]
fn what_is_true_of_them() {
    for path in ["examples/loader/line.lw", "examples/ice-lab/milled.lw", "examples/ice-lab/line.lw"] {
        let line = load(path);
        let start = std::time::Instant::now();
        let abstraction = Abstraction::of(&line).unwrap();
        let formulas: usize = abstraction.system.parts.iter().map(|p| p.guarantees.all().count()).sum();
        let assumed: usize = abstraction.system.parts.iter().map(|p| p.assumptions.all().count()).sum();
        println!("{path}: {} variables, {} parts, {formulas} guarantees, {assumed} assumptions, {} goals", abstraction.system.variables.len(), abstraction.system.parts.len(), abstraction.claim.goal.all().count());
        let verdict = decide(&abstraction, &Limits::default()).unwrap();
        println!("  {:.2} s, holds: {}", start.elapsed().as_secs_f64(), verdict.holds());
        for open in &verdict.open {
            println!("  open: {}", abstraction.goal(open.what).name);
        }
        for finding in findings(&line, &abstraction, &verdict) {
            println!("{} {}\n{:?}\n{:?}", finding.code.id, finding.message, finding.notes, finding.help);
        }
    }
}
