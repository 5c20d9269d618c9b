//! A profile as the C header `uf_profile.h` that `ffi/uf_value.h` includes: part of a package like any other file, so that content
//! hash, sources and reproducibility follow by themselves.

use super::{Encoding, Profile};
use crate::emit::text::{comment, string};
use std::fmt::Write as _;

/// The header's name in a package.
pub const NAME: &str = "uf_profile.h";

impl Profile {
    /// The text of `uf_profile.h`.
    pub fn to_header(&self) -> String {
        let layout = &self.layout;
        let tag = &layout.tag;
        let state = if self.verified() {
            "verified: the host read back what was returned with this layout"
        } else {
            "UNVERIFIED: nobody has seen the host read back what was returned with it"
        };
        let encoding = match layout.strings {
            Encoding::Utf8 => "LW_UF_UTF_8",
            Encoding::Latin1 => "LW_UF_LATIN_1",
            Encoding::Windows1252 => "LW_UF_WINDOWS_1252",
            Encoding::Utf16 => "LW_UF_UTF_16",
        };
        let mut out = format!(
            "/* The layout of UF_Value: profile {}, {state}.\n * {}.\n * Emitted by linewright; another profile is given with `build --profile FILE`. */\n",
            comment(&string(&self.name)),
            comment(self.found.trim_end_matches('.')),
        );
        out.push_str("#ifndef LW_UF_PROFILE_H\n#define LW_UF_PROFILE_H\n\n");
        let lines = [
            ("LW_UF_SIZE", layout.size.to_string()),
            ("LW_UF_VALUE_OFFSET", layout.value.to_string()),
            ("LW_UF_INTEGER", format!("int{}_t", layout.integer_bits)),
            ("LW_UF_ENCODING", encoding.to_owned()),
            ("LW_UF_TAG_OFFSET", tag.offset.to_string()),
            ("LW_UF_TAG", format!("uint{}_t", tag.bits)),
            ("LW_UF_TAG_INTEGER", format!("{}U", tag.integer)),
            ("LW_UF_TAG_REAL", format!("{}U", tag.real)),
            ("LW_UF_TAG_STRING", format!("{}U", tag.string)),
        ];
        for (name, value) in lines {
            let _ = writeln!(out, "#define {name} {value}");
        }
        if let Some(boolean) = tag.boolean {
            let _ = writeln!(out, "#define LW_UF_TAG_BOOLEAN {boolean}U");
        }
        if !tag.more_real.is_empty() {
            let tests: Vec<String> = tag
                .more_real
                .iter()
                .map(|t| format!("(tag) == {t}U"))
                .collect();
            let _ = writeln!(out, "#define LW_UF_MORE_REAL(tag) ({})", tests.join(" || "));
        }
        out.push_str("\n#endif\n");
        out
    }
}
