//! The manifest next to a library: its machine and its checksum.

use crate::{Error, Package, disk, emit};
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};

const SCHEMA: &str = "linewright/library/1";

/// The manifest of a library.
#[derive(Debug, Clone, PartialEq, Eq, JsonSchema, Serialize, Deserialize)]
pub(crate) struct Manifest {
    schema: String,
    /// The name of the library's machine.
    machine: String,
    /// The hash of the machine and its contracts, in hexadecimal digits.
    contract_hash: String,
    /// The size of the library in bytes.
    length: u64,
    /// The SHA-256 sum of the library, in hexadecimal digits.
    sha256: String,
}

/// The JSON Schema of a manifest.
pub fn schema(generator: &mut SchemaGenerator) -> Schema {
    Manifest::json_schema(generator)
}

impl Manifest {
    /// Creates the manifest of a package's library, which has these bytes.
    pub(super) fn new(package: &Package, bytes: &[u8]) -> Self {
        Self {
            schema: SCHEMA.to_owned(),
            machine: package.name.clone(),
            contract_hash: package.contract_hash.clone(),
            length: bytes.len() as u64,
            sha256: emit::hex(&Sha256::digest(bytes)),
        }
    }

    /// Path of a library's manifest.
    pub(super) fn path(library: &Path) -> PathBuf {
        library.with_extension("json")
    }

    /// Compares a library with its manifest.
    pub(crate) fn verify(library: &Path) -> Result<(), Error> {
        let damaged = |reason: String| Error::LibraryDamaged {
            path: library.to_owned(),
            reason,
        };
        let path = Self::path(library);
        let text = disk::read(&path).map_err(|e| {
            damaged(format!(
                "its manifest {} cannot be read: {e}",
                path.display()
            ))
        })?;
        let manifest: Self = serde_json::from_slice(&text)
            .map_err(|e| damaged(format!("its manifest {} is damaged: {e}", path.display())))?;
        let bytes = disk::read(library).map_err(|e| damaged(format!("it cannot be read: {e}")))?;
        if bytes.len() as u64 != manifest.length {
            return Err(damaged(format!(
                "it has {} bytes instead of {}",
                bytes.len(),
                manifest.length
            )));
        }
        if emit::hex(&Sha256::digest(&bytes)) != manifest.sha256 {
            return Err(damaged("its SHA-256 differs from its manifest".to_owned()));
        }
        Ok(())
    }
}
