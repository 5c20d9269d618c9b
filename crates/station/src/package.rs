//! A station library before compilation: the C files and their names.

use super::profile::{Profile, header};
use super::{Error, emit};
use linewright_language::contract::machine::Machine;
use linewright_solver::mealy;
use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};

/// The files of `ffi/` that belong to every library, embedded in the program.
pub const SUPPORT: [(&str, &str); 6] = [
    ("station.h", include_str!("../../../ffi/station.h")),
    ("machine.h", include_str!("../../../ffi/machine.h")),
    ("step.c", include_str!("../../../ffi/step.c")),
    ("runtime.c", include_str!("../../../ffi/runtime.c")),
    ("uf_value.h", include_str!("../../../ffi/uf_value.h")),
    (
        "plant_simulation.c",
        include_str!("../../../ffi/plant_simulation.c"),
    ),
];

/// C source of one machine, or of the probe.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Package {
    /// Name of the machine.
    pub name: String,
    /// Name of the machine in file names: `AssemblyCell` is `assembly_cell`.
    pub stem: String,
    /// The C file to compile; it includes the other files.
    pub c_source: String,
    support: Vec<(&'static str, String)>,
    /// JSON text that the library's `lw_describe` returns.
    pub description: String,
    /// Hash of everything that determines the machine's behavior, 64 hexadecimal digits.
    pub contract_hash: String,
    /// Hash of all compiled files, 64 hexadecimal digits.
    pub hash: String,
}

impl Package {
    /// Emits a machine with the controller of each of its components, in order.
    ///
    /// # Panics
    /// Panics if a controller does not fit its component's contract.
    pub fn emit(machine: &Machine, controllers: &[mealy::Controller]) -> Self {
        Self::emit_with(machine, controllers, &Profile::assumed())
    }

    /// Like `emit`, for a layout of `UF_Value` other than the assumed one.
    ///
    /// # Panics
    /// Panics if a controller does not fit its component's contract.
    pub fn emit_with(
        machine: &Machine,
        controllers: &[mealy::Controller],
        profile: &Profile,
    ) -> Self {
        let emitted = emit::emit(machine, controllers, profile);
        Self {
            description: emitted.description,
            contract_hash: emitted.contract_hash,
            ..Self::of_files(
                &machine.name,
                &file_stem(&machine.name),
                emitted.source,
                support(profile),
            )
        }
    }

    /// Creates a package of these files; `c_source` is the file to compile.
    pub(super) fn of_files(
        name: &str,
        stem: &str,
        c_source: String,
        support: Vec<(&'static str, String)>,
    ) -> Self {
        let mut hash = Sha256::new();
        let files = support.iter().map(|(name, text)| (*name, text.as_str()));
        for (name, text) in std::iter::once(("", c_source.as_str())).chain(files) {
            // The lengths are hashed, too, because two lists of files can have the same joined
            // text.
            hash.update(format!("{name}:{}\n", text.len()));
            hash.update(text);
        }
        Self {
            name: name.to_owned(),
            stem: stem.to_owned(),
            c_source,
            support,
            description: String::new(),
            contract_hash: String::new(),
            hash: emit::hex(&hash.finalize()),
        }
    }

    /// All files of the package, by name; the first is the file to compile.
    pub fn files(&self) -> Vec<(String, &str)> {
        let own = (format!("{}.c", self.stem), self.c_source.as_str());
        let support = self
            .support
            .iter()
            .map(|(name, text)| ((*name).to_owned(), text.as_str()));
        std::iter::once(own).chain(support).collect()
    }

    /// Writes all files into a folder, and returns the path of the file to compile.
    pub fn write_source(&self, folder: &Path) -> Result<PathBuf, Error> {
        create_folder(folder)?;
        for (name, text) in self.files() {
            write(&folder.join(name), text.as_bytes())?;
        }
        Ok(folder.join(format!("{}.c", self.stem)))
    }
}

/// Files that a machine's C file includes: the files of [`SUPPORT`], and the header with the layout
/// of `UF_Value`.
pub fn support(profile: &Profile) -> Vec<(&'static str, String)> {
    let fixed = SUPPORT
        .iter()
        .map(|(name, text)| (*name, (*text).to_owned()));
    fixed.chain([(header::NAME, profile.to_header())]).collect()
}

/// Creates a folder and its parents.
pub(super) fn create_folder(folder: &Path) -> Result<(), Error> {
    std::fs::create_dir_all(folder).map_err(|cause| Error::Unwritable {
        path: folder.to_owned(),
        cause,
    })
}

/// Writes a file under a temporary name and renames it, so that a killed run leaves no partial
/// file.
pub(super) fn write(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    let unwritable = |cause| Error::Unwritable {
        path: path.to_owned(),
        cause,
    };
    let folder = path.parent().unwrap_or(Path::new("."));
    let mut file = tempfile::Builder::new()
        .prefix(".new-")
        .tempfile_in(folder)
        .map_err(unwritable)?;
    std::io::Write::write_all(&mut file, bytes).map_err(unwritable)?;
    make_readable(file.as_file()).map_err(unwritable)?;
    file.persist(path).map_err(|e| unwritable(e.error))?;
    Ok(())
}

/// Gives a result ordinary permissions, because temporary files are readable only by their owner.
#[cfg(unix)]
fn make_readable(file: &std::fs::File) -> std::io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    file.set_permissions(std::fs::Permissions::from_mode(0o644))
}

#[cfg(not(unix))]
fn make_readable(_: &std::fs::File) -> std::io::Result<()> {
    Ok(())
}

/// Whether Windows reserves a file name without its extension for a device: `con`, `com1`.
pub fn is_windows_device(stem: &str) -> bool {
    let stem = stem.to_ascii_lowercase();
    let numbered = ["com", "lpt"].iter().any(|device| {
        let number = stem.strip_prefix(device).unwrap_or_default();
        number.len() == 1 && number.as_bytes()[0].is_ascii_digit()
    });
    numbered || ["con", "prn", "aux", "nul"].contains(&stem.as_str())
}

/// Converts a machine's name to a file name: `AssemblyCell` and `assembly cell` become
/// `assembly_cell`. All characters except ASCII letters and digits become `_`.
pub fn file_stem(name: &str) -> String {
    let mut stem = String::new();
    let mut after_lower = false;
    for c in name.chars() {
        if c.is_ascii_uppercase() && after_lower {
            stem.push('_');
        }
        after_lower = c.is_ascii_lowercase() || c.is_ascii_digit();
        stem.push(if c.is_ascii_alphanumeric() {
            c.to_ascii_lowercase()
        } else {
            '_'
        });
    }
    // The stem must also be a C identifier, because FMI uses it as the model identifier.
    if !stem.starts_with(|c: char| c.is_ascii_alphabetic()) {
        stem.insert_str(0, "m_");
    }
    // The stem must differ from the names of the files that come with a package.
    let mut names = SUPPORT
        .iter()
        .map(|(n, _)| *n)
        .chain(["fmi.c", "fmi2.c", "fmi3.c"]);
    if names.any(|n| n == format!("{stem}.c")) || is_windows_device(&stem) {
        stem.push('_');
    }
    stem
}

#[cfg(test)]
mod tests {
    use super::file_stem;

    #[test]
    fn file_names_are_plain() {
        assert_eq!(file_stem("AssemblyCell"), "assembly_cell");
        assert_eq!(file_stem("QC"), "qc");
        assert_eq!(file_stem("Belt3"), "belt3");
        assert_eq!(file_stem("Fräse/1"), "fr_se_1");
        assert_eq!(file_stem("runtime"), "runtime_");
        assert_eq!(file_stem("fmi2"), "fmi2_");
        assert_eq!(file_stem("Con"), "con_");
        assert_eq!(file_stem("LPT1"), "lpt1_");
        assert_eq!(file_stem("Com10"), "com10");
        assert_eq!(file_stem("2nd"), "m_2nd");
    }
}
