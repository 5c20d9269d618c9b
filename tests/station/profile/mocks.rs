//! Layouts of `UF_Value` that Plant Simulation might have, as laid out by a C compiler.

use crate::support;
use linewright::station::profile::{Encoding, Layout};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A mock of the product: the options for compiling `cwinfunc.h`.
pub struct Mock {
    pub name: &'static str,
    packing: u32,
    tag: &'static str,
    integer: &'static str,
    tags: [u64; 3],
    encoding: Encoding,
    boolean: Option<u64>,
    time: Option<u64>,
    more: &'static [&'static str],
}

/// All of them: packing 1, 4 and 8, integers of 16, 32 and 64 bits, tags of 8 to 64, values before
/// tags, every encoding.
pub fn mocks() -> Vec<Mock> {
    let plain = || Mock {
        name: "assumed",
        packing: 8,
        tag: "int32_t",
        integer: "int32_t",
        tags: [1, 2, 3],
        encoding: Encoding::Utf8,
        boolean: None,
        time: None,
        more: &[],
    };
    vec![
        plain(),
        Mock {
            name: "packed_1",
            packing: 1,
            tag: "uint8_t",
            tags: [10, 20, 30],
            encoding: Encoding::Latin1,
            time: Some(21),
            ..plain()
        },
        Mock {
            name: "packed_4",
            packing: 4,
            tag: "uint32_t",
            integer: "int64_t",
            tags: [5, 3, 8],
            encoding: Encoding::Windows1252,
            boolean: Some(1),
            ..plain()
        },
        Mock {
            name: "narrow",
            tag: "uint16_t",
            integer: "int16_t",
            tags: [256, 512, 768],
            ..plain()
        },
        Mock {
            name: "value_first",
            tags: [0, 1, 2],
            encoding: Encoding::Utf16,
            more: &["MOCK_VALUE_FIRST"],
            ..plain()
        },
        Mock {
            name: "wide",
            tag: "uint64_t",
            integer: "int64_t",
            tags: [7, 8, 9],
            encoding: Encoding::Utf16,
            boolean: Some(6),
            time: Some(5),
            ..plain()
        },
        Mock {
            name: "value_first_packed_1",
            packing: 1,
            tag: "uint8_t",
            integer: "int16_t",
            tags: [200, 100, 50],
            encoding: Encoding::Windows1252,
            more: &["MOCK_VALUE_FIRST"],
            ..plain()
        },
        Mock {
            name: "owned",
            packing: 4,
            tag: "uint32_t",
            tags: [0, 4, 2],
            encoding: Encoding::Latin1,
            boolean: Some(9),
            more: &["MOCK_OWNER"],
            ..plain()
        },
        Mock {
            name: "cleared",
            more: &["MOCK_CLEAN"],
            ..plain()
        },
    ]
}

impl Mock {
    /// The options that give a C compiler this layout.
    pub fn options(&self) -> Vec<String> {
        let place = Encoding::ALL.iter().position(|e| *e == self.encoding);
        let tags = self.tags.map(|t| t.to_string()).join(",");
        let mut options = vec![
            format!("-DMOCK_PACKING={}", self.packing),
            format!("-DMOCK_TAG={}", self.tag),
            format!("-DMOCK_INTEGER={}", self.integer),
            format!("-DMOCK_TAGS={tags}"),
            format!("-DMOCK_ENCODING={}", place.map_or(0, |p| p + 1)),
        ];
        options.extend(self.boolean.map(|t| format!("-DMOCK_BOOLEAN={t}")));
        options.extend(self.time.map(|t| format!("-DMOCK_TIME={t}")));
        options.extend(self.more.iter().map(|m| format!("-D{m}")));
        options
    }

    /// Its layout: sizes and offsets are those printed by the compiled mock.
    pub fn layout(&self, printed: &str) -> Layout {
        let number = |what: &str| {
            let line = printed.lines().find_map(|l| l.strip_prefix(what));
            let digits = line.unwrap_or_else(|| panic!("no `{what}` in {printed}"));
            digits.trim().parse::<u32>().expect("a number")
        };
        let mut layout = Layout::assumed();
        layout.size = number("size ");
        layout.value = number("value ");
        layout.integer_bits = number("integer_bits ");
        layout.packing = self.packing;
        layout.strings = self.encoding;
        layout.tag.offset = number("tag ");
        layout.tag.bits = number("tag_bits ");
        [layout.tag.integer, layout.tag.real, layout.tag.string] = self.tags;
        layout.tag.boolean = self.boolean;
        layout.tag.more_real = self.time.into_iter().collect();
        layout
    }

    /// Compiles a host with this layout.
    pub fn host(&self, source: &str, folder: &Path, more: &[&str]) -> PathBuf {
        let program = folder.join(format!("{}-{}", source.trim_end_matches(".c"), self.name));
        let output = Command::new("cc")
            .args(["-std=gnu11", "-Wall", "-Wextra", "-Werror", "-g"])
            .args(["-Wno-unused-function", "-Wno-missing-field-initializers"])
            .args(self.options())
            .args(more)
            .arg("-I")
            .arg(folder)
            .arg("-I")
            .arg(here())
            .arg(here().join(source))
            .arg("-o")
            .arg(&program)
            .arg("-ldl")
            .output()
            .expect("a C compiler");
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{}: {said}", self.name);
        program
    }
}

/// The folder of the mock's C files.
pub fn here() -> PathBuf {
    support::root().join("tests/station/profile")
}

/// Runs a host on a library; returns its output, and whether its last line says that it passed.
pub fn run(host: &Path, library: &Path, environment: &[(&str, &Path)]) -> (bool, String) {
    let Output { stdout, stderr, .. } = Command::new(host)
        .arg(library)
        .envs(environment.iter().copied())
        .env("ASAN_OPTIONS", "detect_leaks=0")
        .env("UBSAN_OPTIONS", "halt_on_error=1")
        .output()
        .expect("the host starts");
    let mut text = String::from_utf8_lossy(&stdout).into_owned();
    let passed = text.lines().last() == Some("HOST PASSED");
    text.push_str(&String::from_utf8_lossy(&stderr));
    (passed, text)
}
