//! Numbers for the script of a page: as bytes, compressed, in Base64.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::DeflateEncoder;
use std::io::Write as _;

/// A sequence of whole numbers as bytes: seven bits in each, the lowest first; the eighth is set if
/// more follow.
#[derive(Debug, Clone, Default)]
pub struct Bytes(Vec<u8>);

impl Bytes {
    /// Appends a number.
    pub fn push(&mut self, mut number: u64) {
        while number >= 0x80 {
            self.0.push(number as u8 | 0x80);
            number >>= 7;
        }
        self.0.push(number as u8);
    }

    /// The bytes, compressed by DEFLATE (RFC 1951) and written in Base64 (RFC 4648).
    pub fn packed(&self) -> String {
        let mut encoder = DeflateEncoder::new(Vec::new(), Compression::new(9));
        // Writing to memory cannot fail.
        let compressed = encoder
            .write_all(&self.0)
            .and_then(|()| encoder.finish())
            .unwrap_or_default();
        STANDARD.encode(compressed)
    }
}

/// The unit of time for a run of this many seconds: small enough to show every event apart, and
/// large enough for short numbers.
pub fn tick(seconds: f64) -> f64 {
    let magnitude = seconds.max(1e-3).log10().floor() as i32;
    10_f64.powi(magnitude - 7)
}
