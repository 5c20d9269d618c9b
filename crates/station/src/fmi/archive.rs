//! Writes the archive: files in name order with a fixed time, compressed with the method that every
//! host supports.

use super::description::{build_description, description};
use super::documentation::documentation;
use super::{Unit, Version};
use crate::toolchain::Platform;
use std::collections::BTreeMap;
use std::io::{Cursor, Write as _};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

/// Returns the bytes of a unit's archive.
pub(super) fn archive(unit: &Unit, binaries: &[(Platform, Vec<u8>)]) -> Vec<u8> {
    let mut files: BTreeMap<String, (Vec<u8>, u32)> = BTreeMap::new();
    let mut text = |name: String, text: &str| files.insert(name, (text.as_bytes().to_vec(), 0o644));
    text("modelDescription.xml".to_owned(), &description(unit));
    text("documentation/index.html".to_owned(), &documentation(unit));
    for (name, content) in unit.package.files() {
        text(format!("sources/{name}"), content);
    }
    if unit.version == Version::Three {
        text(
            "sources/buildDescription.xml".to_owned(),
            &build_description(unit),
        );
    }
    for (platform, bytes) in binaries {
        let folder = unit.version.binaries(*platform);
        let name = format!(
            "binaries/{folder}/{}{}",
            unit.package.stem,
            platform.suffix()
        );
        files.insert(name, (bytes.clone(), 0o755));
    }
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, (bytes, permissions)) in files {
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Deflated)
            .last_modified_time(DateTime::default())
            .unix_permissions(permissions);
        archive
            .start_file(name, options)
            .and_then(|()| Ok(archive.write_all(&bytes)?))
            .expect("writing an archive to memory does not fail");
    }
    let written = archive
        .finish()
        .expect("writing an archive to memory does not fail");
    written.into_inner()
}
