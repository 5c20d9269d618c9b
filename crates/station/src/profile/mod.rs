//! A *profile*: the assumed layout of `UF_Value`, the C structure in which Plant Simulation passes
//! arguments to a library.
//!
//! The vendor's header is not public, so the layout is a build setting. A profile is a small TOML
//! file ([`read`]) that becomes a C header of a package ([`header`]); the probe (`station::probe`)
//! determines the layout. A profile is *verified* only if the program in which it was found has
//! read back values that a library returned with exactly this layout: [`Profile::confirmed`] then
//! holds the layout's fingerprint, so a layout that is edited later does not count as verified.

pub mod header;
mod print;
pub mod read;

use schemars::JsonSchema;
use serde::Serialize;
use sha2::{Digest, Sha256};

/// Schema of a profile file.
pub const SCHEMA: &str = "linewright/uf-profile/1";

/// The JSON Schema of a profile file, for the value that its TOML represents.
pub const FILE_SCHEMA: &str = include_str!("uf-profile.schema.json");

/// Number of bytes of the union's value: a real number or a pointer.
pub const VALUE_BYTES: u32 = 8;

/// Maximum size of a `UF_Value` in bytes. The probe reads at most this number of bytes per
/// argument.
pub const MAX_SIZE: u32 = 64;

/// An assumed layout with its name and origin.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Profile {
    /// Short name, shown by `station_describe`.
    pub name: String,
    /// Origin of the layout, in one line.
    pub found: String,
    /// Fingerprint of the layout that was confirmed; `None` if none was.
    pub confirmed: Option<String>,
    /// The layout.
    pub layout: Layout,
}

/// Offsets and contents of the fields of a `UF_Value`. Little-endian, with 64-bit pointers.
#[derive(Debug, Clone, PartialEq, Eq, JsonSchema, Serialize)]
pub struct Layout {
    /// Distance in bytes from one argument to the next.
    pub size: u32,
    /// The `#pragma pack` that explains the offsets: 1, 2, 4 or 8.
    pub packing: u32,
    /// Offset of the value in bytes.
    pub value: u32,
    /// Width of an integer in bits: 16, 32 or 64.
    pub integer_bits: u32,
    /// Encoding of the text that a string value points to.
    pub strings: Encoding,
    /// The tag.
    pub tag: Tag,
}

/// A profile in the output of `station_describe` and `doctor`.
#[derive(Debug, JsonSchema, Serialize)]
pub struct ProfileEntry {
    /// The name of the profile.
    name: String,
    /// Whether the layout was confirmed in the program that it is for.
    verified: bool,
    /// The origin of the profile.
    found: String,
    /// The layout; null if the vendor's header defines it.
    layout: Option<Layout>,
}

/// The field that contains the kind of a value.
#[derive(Debug, Clone, PartialEq, Eq, JsonSchema, Serialize)]
pub struct Tag {
    /// Offset in bytes.
    pub offset: u32,
    /// Width in bits: 8, 16, 32 or 64.
    pub bits: u32,
    /// Tag of an integer.
    pub integer: u64,
    /// Tag of a real number.
    pub real: u64,
    /// Tag of a string.
    pub string: u64,
    /// Tag of a Boolean value, if it is not passed as an integer.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub boolean: Option<u64>,
    /// Tags of further kinds of real numbers, such as times and lengths.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub more_real: Vec<u64>,
}

/// Encoding of a zero-terminated text.
#[derive(Debug, Clone, Copy, PartialEq, Eq, JsonSchema, Serialize)]
pub enum Encoding {
    /// UTF-8.
    #[serde(rename = "utf-8")]
    Utf8,
    /// ISO 8859-1.
    #[serde(rename = "latin-1")]
    Latin1,
    /// Windows-1252: a variant with letters and signs where ISO 8859-1 has control characters.
    #[serde(rename = "windows-1252")]
    Windows1252,
    /// UTF-16, little-endian: Windows' wide characters.
    #[serde(rename = "utf-16")]
    Utf16,
}

impl Encoding {
    /// All encodings.
    pub const ALL: [Self; 4] = [Self::Utf8, Self::Latin1, Self::Windows1252, Self::Utf16];

    /// Name of the encoding in a profile.
    pub fn name(self) -> &'static str {
        match self {
            Self::Utf8 => "utf-8",
            Self::Latin1 => "latin-1",
            Self::Windows1252 => "windows-1252",
            Self::Utf16 => "utf-16",
        }
    }
}

impl Layout {
    /// The assumed layout: `struct { int type; union { int integer; double real; const char
    /// *string; } value; }`.
    pub fn assumed() -> Self {
        Self {
            size: 16,
            packing: 8,
            value: 8,
            integer_bits: 32,
            strings: Encoding::Utf8,
            tag: Tag {
                offset: 0,
                bits: 32,
                integer: 1,
                real: 2,
                string: 3,
                boolean: None,
                more_real: Vec::new(),
            },
        }
    }

    /// Returns 16 hexadecimal digits that identify the complete layout.
    pub fn fingerprint(&self) -> String {
        let text = serde_json::to_string(self)
            .expect("a layout could not be written as JSON; please report this");
        super::emit::hex(&Sha256::digest(text))[..16].to_owned()
    }
}

impl Profile {
    /// The built-in profile.
    pub fn assumed() -> Self {
        Self {
            name: "default".to_owned(),
            found: "assumed; never tested in the real product".to_owned(),
            confirmed: None,
            layout: Layout::assumed(),
        }
    }

    /// Whether the program in which the layout was found has read back values that were returned
    /// with exactly this layout.
    pub fn is_verified(&self) -> bool {
        self.confirmed.as_deref() == Some(self.layout.fingerprint().as_str())
    }

    /// Returns name and state of the profile: `profile "default" (unverified)`.
    pub fn label(&self) -> String {
        let state = if self.is_verified() {
            "verified"
        } else {
            "unverified"
        };
        format!("profile \"{}\" ({state})", self.name)
    }

    /// Returns the profile as in the output of `station_describe`.
    pub fn describe(&self) -> ProfileEntry {
        ProfileEntry {
            name: self.name.clone(),
            verified: self.is_verified(),
            found: self.found.clone(),
            layout: Some(self.layout.clone()),
        }
    }

    /// Returns the entry for a library that is compiled with the vendor's header, whose layout is
    /// unknown to this program.
    pub fn describe_vendor_header() -> ProfileEntry {
        ProfileEntry {
            name: "vendor header".to_owned(),
            verified: true,
            found: "compiled with the vendor's cwinfunc.h".to_owned(),
            layout: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_edited_layout_is_not_verified() {
        let mut profile = Profile::assumed();
        assert!(!profile.is_verified());
        profile.confirmed = Some(profile.layout.fingerprint());
        assert!(profile.is_verified());
        assert!(profile.label().ends_with("(verified)"));
        profile.layout.tag.string = 4;
        assert!(!profile.is_verified());
        assert!(profile.label().ends_with("(unverified)"));
    }
}
