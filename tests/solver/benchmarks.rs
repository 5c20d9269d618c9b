//! The generated benchmark specifications: those that were published have the same text, and all
//! can be read and have the expected verdicts.

#[path = "../bench/families/mod.rs"]
mod families;

use crate::support;
use families::anzu::{amba, genbuf};
use families::arithmetic::{Task, ahb, cinderella, elevator, robot_arm};
use families::formula::Format as Language;
use linewright_core::source::FileId;
use linewright_interchange::{Format, read};
use linewright_solver::game::{Limits, Outcome, solve};

#[test]
fn generated_specifications_equal_the_published_ones() {
    let Some(folder) = support::specs() else {
        return;
    };
    let mut compared = 0;
    for entry in std::fs::read_dir(folder.join("anzu")).expect("a folder") {
        let path = entry.expect("an entry").path();
        let part =
            |part: Option<&std::ffi::OsStr>| part.and_then(|p| p.to_str()).map(str::to_owned);
        let (Some(stem), Some(ending)) = (part(path.file_stem()), part(path.extension())) else {
            continue;
        };
        let language = match &*ending {
            "slugsin" => Language::Slugsin,
            "spc" => Language::Spc,
            "spectra" => Language::Spectra,
            _ => continue,
        };
        let size = stem.trim_start_matches(char::is_alphabetic);
        let size: usize = size.parse().expect("a size");
        let text = if stem.starts_with("genbuf") {
            genbuf(size, language)
        } else {
            amba(size, language)
        };
        let published = std::fs::read_to_string(&path).expect("a text");
        assert!(text == published, "{} differs", path.display());
        compared += 1;
    }
    assert!(compared > 30, "only {compared} files");
}

#[test]
fn generated_specifications_have_the_expected_verdicts() {
    let realizable = [
        robot_arm(5, 8, Task::Sum, false),
        robot_arm(5, 8, Task::Obstacle, false),
        elevator(4, 1, None),
        elevator(3, 1, Some(14)),
        ahb(3, false),
        cinderella(3, 2, 4, 2),
        genbuf(3, Language::Spectra),
        amba(2, Language::Spectra),
    ];
    let unrealizable = [
        robot_arm(5, 8, Task::Sum, true),
        elevator(3, 1, Some(13)),
        ahb(3, true),
    ];
    for (texts, expected) in [(&realizable[..], true), (&unrealizable[..], false)] {
        for text in texts {
            let name = text.lines().next().unwrap_or_default();
            let reading = read(Format::Spectra, "generated", FileId(0), text);
            let specification = reading.specification;
            let specification =
                specification.unwrap_or_else(|| panic!("{name}: {:?}", reading.findings));
            let is_realizable = match solve(&specification, &Limits::default()) {
                Outcome::Realizable(_) => true,
                Outcome::Unrealizable(_) => false,
                Outcome::GaveUp(limit) => panic!("{name}: {limit}"),
            };
            assert_eq!(is_realizable, expected, "{name}");
        }
    }
}
