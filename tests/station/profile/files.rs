//! Profiles as files: printed and read again unchanged; every error a finding at its place, all of
//! them at once.

use linewright::diagnostics::{codes, render};
use linewright::source::SourceMap;
use linewright::station::profile::{Encoding, Layout, Profile, Tag, read};
use proptest::prelude::*;
use std::collections::BTreeSet;
use std::fmt::Write as _;

fn parse(text: &str) -> Result<Profile, String> {
    let mut sources = SourceMap::new();
    let file = sources.add("uf.toml", text);
    read::parse(file, text).map_err(|findings| {
        for finding in &findings {
            assert_eq!(finding.code, codes::PROFILE);
            assert!(finding.help.is_some(), "{finding:?}");
            let span = finding.span.expect("a place");
            assert!(span.start <= span.end && span.end as usize <= text.len());
        }
        assert!(!findings.is_empty());
        render::short(&sources, &findings)
    })
}

fn layouts() -> impl Strategy<Value = Layout> {
    let numbers = (
        0..4_usize,
        0..4_usize,
        0..3_usize,
        0..4_usize,
        any::<bool>(),
        0..3_u32,
    );
    let tags = proptest::collection::btree_set(0..200_u64, 5..8);
    (numbers, tags).prop_map(|((packing, bits, integer, encoding, first, slack), tags)| {
        let packing: u32 = [1, 2, 4, 8][packing];
        let bits: u32 = [8, 16, 32, 64][bits];
        let width = bits / 8;
        let unit = |own: u32| packing.min(own);
        let (tag, value) = if first {
            (0, width.next_multiple_of(unit(8)))
        } else {
            (8_u32.next_multiple_of(unit(width)), 0)
        };
        let end = (tag + width).max(value + 8) + slack * packing;
        let tags: Vec<u64> = BTreeSet::into_iter(tags).collect();
        Layout {
            size: end
                .next_multiple_of(packing)
                .max(9)
                .next_multiple_of(packing),
            packing,
            value,
            integer_bits: [16, 32, 64][integer],
            strings: Encoding::ALL[encoding],
            tag: Tag {
                offset: tag,
                bits,
                integer: tags[0],
                real: tags[1],
                string: tags[2],
                boolean: Some(tags[3]).filter(|t| t % 2 == 0),
                more_real: tags[4..].to_vec(),
            },
        }
    })
}

proptest! {
    #[test]
    fn profiles_are_read_as_they_were_printed(
        layout in layouts(),
        name in "[ -~äöü€]{0,19}[!-~]",
        found in "[ -~]{0,30}[!-~]",
        confirmed in any::<bool>(),
    ) {
        let confirmed = confirmed.then(|| layout.fingerprint());
        let profile = Profile { name, found, confirmed, layout };
        let text = profile.to_toml();
        let read = parse(&text);
        prop_assert_eq!(read.as_ref(), Ok(&profile), "{}", text);
        prop_assert_eq!(read.map(|p| p.to_toml()), Ok(text));
    }
}

#[test]
fn the_assumed_profile_reads_well() {
    insta::assert_snapshot!("assumed_toml", Profile::assumed().to_toml());
    insta::assert_snapshot!("assumed_header", Profile::assumed().to_header());
}

#[test]
fn every_mistake_is_found_at_once() {
    let good = Profile::assumed().to_toml();
    assert!(parse(&good).is_ok());
    let mut report = String::new();
    let changes: &[&[(&str, &str)]] = &[
        &[("[layout]", "[layout")],
        &[("size = 16", "size = 16\nsize = 17")],
        &[(
            "schema = \"linewright/uf-profile/1\"",
            "schema = \"linewright/uf-profile/9\"",
        )],
        &[
            ("name = \"default\"", "name = \"\""),
            ("verified = false", "verified = \"no\""),
        ],
        &[
            ("size = 16", "sise = 16"),
            ("bits = 32\ninteger", "bits = 33\ninteger"),
            ("strings = \"utf-8\"", "strings = \"utf8\""),
        ],
        &[
            ("value = 8", "value = 2"),
            ("real = 2", "real = 1"),
            ("integer_bits = 32", "integer_bits = 24"),
        ],
        &[("value = 8", "value = 2"), ("real = 2", "real = 1")],
        &[
            ("size = 16", "size = 12"),
            ("string = 3", "string = 99999999999"),
        ],
        &[("verified = false", "verified = true")],
        &[(
            "verified = false",
            "verified = true\nconfirmed = \"0123456789abcdef\"",
        )],
        &[(
            "string = 3",
            "string = 3\nboolean = 3\nmore_real = [2, 7, -1]",
        )],
        &[(
            "string = 3",
            "string = 3\nboolean = 3\nmore_real = [2, 7]\nextra = 1",
        )],
        &[("[tag]", "[tags]")],
        &[("[layout]", "layout = 3\n[layouts]")],
        &[("offset = 0", "offset = 60")],
        &[("packing = 8", "packing = 4"), ("value = 8", "value = 6")],
    ];
    for change in changes {
        let mut text = good.clone();
        for (from, to) in *change {
            assert!(text.contains(from), "{from}");
            text = text.replace(from, to);
        }
        let said = parse(&text).expect_err("a finding");
        let shown: Vec<String> = change
            .iter()
            .map(|(_, to)| to.replace('\n', " | "))
            .collect();
        let _ = write!(report, "--- {}\n{said}", shown.join(", "));
    }
    insta::assert_snapshot!("mistakes", report);
}
