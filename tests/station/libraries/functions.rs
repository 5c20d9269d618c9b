//! Controllers as functions, with everything that the laboratory's machines lack: domains that do
//! not begin at 0, constants, copies of many inputs, several goals, and outputs before the inputs
//! are known.

use crate::controlled::controlled;
use crate::differential::differential;
use linewright::engine::controller::ExtractionOptions;
use linewright::station::ErrorCode;

const STEPS: usize = 60_000;

#[test]
fn odd_functions_agree_with_the_interpreter() {
    // As in `check` and `build`; tables of these would be too large.
    let wish = ExtractionOptions {
        functions: true,
        ..ExtractionOptions::default()
    };
    let (machine, controllers) = controlled("tests/station/libraries/odd.lw", "Oddity", wish);
    let forms: Vec<bool> = controllers
        .iter()
        .map(|c| c.functions().is_some())
        .collect();
    assert_eq!(forms, [false, true, true]);
    let folder = tempfile::tempdir().expect("a folder");
    let counts = differential(&machine, &controllers, STEPS, 11, folder.path());
    let faults = counts.of(ErrorCode::Internal) + counts.of(ErrorCode::Guarantee);
    assert_eq!(faults, 0, "{counts:?}");
    assert!(counts.ok > STEPS / 3, "{counts:?}");
    for rule in ["odd: mended", "odd: gentle"] {
        assert!(
            counts.rules.get(rule).is_some_and(|n| *n > 100),
            "{counts:?}"
        );
    }
}
