//! Renders a profile as the C header `uf_profile.h`, which `ffi/uf_value.h` includes. Like every
//! other file of a package, the header is part of the content hash and the shipped sources.

use super::{Encoding, Profile};
use crate::emit::text::{comment, string};
use crate::template::render;
use serde::Serialize;

/// File name of the header in a package.
pub const NAME: &str = "uf_profile.h";

/// The fields of `uf_profile.h`.
#[derive(Serialize)]
struct Header<'a> {
    name: String,
    state: &'static str,
    found: String,
    size: u32,
    value_offset: u32,
    integer_bits: u32,
    encoding: &'static str,
    tag_offset: u32,
    tag_bits: u32,
    tag_integer: u64,
    tag_real: u64,
    tag_string: u64,
    tag_boolean: Option<u64>,
    more_real: &'a [u64],
}

impl Profile {
    /// Renders `uf_profile.h`.
    pub fn to_header(&self) -> String {
        let layout = &self.layout;
        let tag = &layout.tag;
        let state = if self.is_verified() {
            "verified: the host read back values that were returned with this layout"
        } else {
            "UNVERIFIED: no test has shown the host reading back values with this layout"
        };
        let encoding = match layout.strings {
            Encoding::Utf8 => "LW_UF_UTF_8",
            Encoding::Latin1 => "LW_UF_LATIN_1",
            Encoding::Windows1252 => "LW_UF_WINDOWS_1252",
            Encoding::Utf16 => "LW_UF_UTF_16",
        };
        render(
            "profile/uf_profile.h",
            Header {
                name: comment(&string(&self.name)),
                state,
                found: comment(self.found.trim_end_matches('.')),
                size: layout.size,
                value_offset: layout.value,
                integer_bits: layout.integer_bits,
                encoding,
                tag_offset: tag.offset,
                tag_bits: tag.bits,
                tag_integer: tag.integer,
                tag_real: tag.real,
                tag_string: tag.string,
                tag_boolean: tag.boolean,
                more_real: &tag.more_real,
            },
        )
    }
}
