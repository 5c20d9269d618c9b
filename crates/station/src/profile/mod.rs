//! The assumed layout of `UF_Value`, what Plant Simulation passes to a library: a *profile*.
//!
//! The vendor's header is not public, so a layout is a setting of a build and never a fact. A
//! profile is a small TOML file ([`read`]), becomes a C header of a package ([`header`]), and is
//! found by the probe (`station::probe`). It is *verified* only when the program it was found in
//! has read back what a library returned with this very layout: [`Profile::confirmed`] then holds
//! the fingerprint of the layout, so that a layout that was edited afterwards is not taken for a
//! verified one.

pub mod header;
mod print;
pub mod read;

use schemars::JsonSchema;
use serde::Serialize;
use sha2::{Digest, Sha256};

/// The schema of a profile's file.
pub const SCHEMA: &str = "linewright/uf-profile/1";

/// The JSON Schema of a profile's file, as the value that its TOML has.
pub const FILE_SCHEMA: &str = include_str!("uf-profile.schema.json");

/// How many bytes a value of the union takes: a real number or a pointer.
pub const VALUE_BYTES: u32 = 8;

/// No `UF_Value` is larger: the probe looks no further.
pub const LARGEST_SIZE: u32 = 64;

/// The assumed layout, its name, and how it is known.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Profile {
    /// A short name, shown by `station_describe`.
    pub name: String,
    /// Where it comes from, one line.
    pub found: String,
    /// The fingerprint of the layout that was confirmed; `None` for one that was not.
    pub confirmed: Option<String>,
    /// The layout.
    pub layout: Layout,
}

/// Where the fields of a `UF_Value` lie, and what they hold. Little-endian, with pointers of 64
/// bits.
#[derive(Debug, Clone, PartialEq, Eq, JsonSchema, Serialize)]
pub struct Layout {
    /// Bytes from one argument to the next.
    pub size: u32,
    /// The `#pragma pack` that explains the offsets: 1, 2, 4 or 8.
    pub packing: u32,
    /// Where the value begins.
    pub value: u32,
    /// Width of an integer: 16, 32 or 64.
    pub integer_bits: u32,
    /// How the text is written to which a string's value points.
    pub strings: Encoding,
    /// The tag.
    pub tag: Tag,
}

/// What `station_describe` and `doctor` say of a profile.
#[derive(Debug, JsonSchema, Serialize)]
pub struct ProfileEntry {
    /// The name of the profile.
    name: String,
    /// Whether the layout was confirmed in the program that it is for.
    verified: bool,
    /// Where it comes from.
    found: String,
    /// The layout; null where the vendor's header decides it.
    layout: Option<Layout>,
}

/// The field that says what a value is.
#[derive(Debug, Clone, PartialEq, Eq, JsonSchema, Serialize)]
pub struct Tag {
    /// Where it begins.
    pub offset: u32,
    /// Its width: 8, 16, 32 or 64.
    pub bits: u32,
    /// An integer.
    pub integer: u64,
    /// A real number.
    pub real: u64,
    /// A string.
    pub string: u64,
    /// A truth value, where it is not passed as an integer.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub boolean: Option<u64>,
    /// Further kinds of real numbers: times, lengths and the like.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub more_real: Vec<u64>,
}

/// How a text is written. All end with a zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq, JsonSchema, Serialize)]
pub enum Encoding {
    /// UTF-8.
    #[serde(rename = "utf-8")]
    Utf8,
    /// ISO 8859-1.
    #[serde(rename = "latin-1")]
    Latin1,
    /// Windows' variant of it, with letters and signs where ISO 8859-1 has control characters.
    #[serde(rename = "windows-1252")]
    Windows1252,
    /// UTF-16, little-endian: Windows' wide characters.
    #[serde(rename = "utf-16")]
    Utf16,
}

impl Encoding {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Utf8, Self::Latin1, Self::Windows1252, Self::Utf16];

    /// As a profile names it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Utf8 => "utf-8",
            Self::Latin1 => "latin-1",
            Self::Windows1252 => "windows-1252",
            Self::Utf16 => "utf-16",
        }
    }
}

impl Layout {
    /// The assumption: `struct { int type; union { int integer; double real; const char *string; }
    /// value; }`.
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

    /// 16 hexadecimal digits of everything that the layout says.
    pub fn fingerprint(&self) -> String {
        let text = serde_json::to_string(self).expect("a layout is plain data; please report this");
        super::emit::hex(&Sha256::digest(text))[..16].to_owned()
    }
}

impl Profile {
    /// The built-in one.
    pub fn assumed() -> Self {
        Self {
            name: "default".to_owned(),
            found: "assumed; never tried in the real product".to_owned(),
            confirmed: None,
            layout: Layout::assumed(),
        }
    }

    /// Whether the program that it was found in has read back what was returned with this very
    /// layout.
    pub fn verified(&self) -> bool {
        self.confirmed.as_deref() == Some(self.layout.fingerprint().as_str())
    }

    /// `profile "default" (unverified)`
    pub fn shown(&self) -> String {
        let state = if self.verified() {
            "verified"
        } else {
            "unverified"
        };
        format!("profile \"{}\" ({state})", self.name)
    }

    /// What `station_describe` says of it.
    pub fn describe(&self) -> ProfileEntry {
        ProfileEntry {
            name: self.name.clone(),
            verified: self.verified(),
            found: self.found.clone(),
            layout: Some(self.layout.clone()),
        }
    }

    /// The same for a library that is compiled with the vendor's own header: its layout is not
    /// known here.
    pub fn describe_vendors() -> ProfileEntry {
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
        assert!(!profile.verified());
        profile.confirmed = Some(profile.layout.fingerprint());
        assert!(profile.verified());
        assert!(profile.shown().ends_with("(verified)"));
        profile.layout.tag.string = 4;
        assert!(!profile.verified());
        assert!(profile.shown().ends_with("(unverified)"));
    }
}
