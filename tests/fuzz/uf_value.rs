//! Properties that hold for every text as a profile of `UF_Value`, or as the dump of a probe.
//! Shared by the fuzz targets and the ordinary tests.

use linewright::diagnostics::{Diagnostic, has_errors};
use linewright::source::FileId;
use linewright::station::probe::{dump as dumps, infer};
use linewright::station::profile::{Profile, read};

/// Every finding lies within the text and has a help text.
fn sound(findings: &[Diagnostic], text: &str) {
    for finding in findings {
        assert!(finding.help.is_some(), "{finding:?}");
        let inside = finding
            .span
            .is_none_or(|s| text.get(s.start as usize..s.end as usize).is_some());
        assert!(inside, "{finding:?}");
    }
}

/// A printed profile is read as that profile, and its header looks like C.
fn readable(profile: &Profile) {
    let again = read::parse(FileId(0), &profile.to_toml());
    assert_eq!(again.as_ref(), Ok(profile), "{}", profile.to_toml());
    assert!(profile.to_header().contains("#define LW_UF_SIZE "));
}

/// Whether a text is a profile.
pub fn profile(text: &str) -> bool {
    match read::parse(FileId(0), text) {
        Ok(profile) => {
            readable(&profile);
            true
        }
        Err(findings) => {
            assert!(has_errors(&findings));
            sound(&findings, text);
            false
        }
    }
}

/// Outcome for a dump: whether a layout was found, and whether it was confirmed.
pub fn dump(text: &str) -> (bool, bool) {
    let sound = |findings: &[Diagnostic]| sound(findings, text);
    let (dump, findings) = dumps::parse(FileId(0), text);
    sound(&findings);
    if has_errors(&findings) {
        return (false, false);
    }
    let inferred = match infer::infer(&dump) {
        Ok(inference) => {
            readable(&Profile {
                layout: inference.layout,
                ..Profile::assumed()
            });
            true
        }
        Err(finding) => {
            sound(&[*finding]);
            false
        }
    };
    let confirmed = match infer::confirm(&dump) {
        None => false,
        Some(Ok(profile)) => {
            readable(&profile);
            true
        }
        Some(Err(findings)) => {
            assert!(!findings.is_empty());
            sound(&findings);
            false
        }
    };
    (inferred, confirmed)
}
