//! Which format a file has, by its name.

use std::path::Path;

/// Format of a log.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Format {
    /// Comma-separated values (RFC 4180).
    Csv,
    /// JSON lines of the schema `linewright/log/1`.
    Jsonl,
    /// Apache Parquet.
    Parquet,
    /// Trace Event Format of Chrome and Perfetto.
    Perfetto,
    /// Object-centric event log: OCEL 2.0 in JSON.
    Ocel,
    /// Event log by cases: XES (IEEE 1849).
    Xes,
}

/// Ends of file names, with their formats.
pub const EXTENSIONS: [(&str, Format); 8] = [
    (".csv", Format::Csv),
    (".jsonl", Format::Jsonl),
    (".parquet", Format::Parquet),
    (".perfetto.json", Format::Perfetto),
    (".trace.json", Format::Perfetto),
    (".ocel.json", Format::Ocel),
    (".jsonocel", Format::Ocel),
    (".xes", Format::Xes),
];

impl Format {
    /// The format of a file with this name; `None` if its extension is none of [`EXTENSIONS`].
    pub fn of(path: &Path) -> Option<Self> {
        let name = path.file_name()?.to_str()?.to_lowercase();
        let mut known = EXTENSIONS.iter();
        known
            .find(|(extension, _)| name.len() > extension.len() && name.ends_with(extension))
            .map(|(_, format)| *format)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_extension_gives_the_format() {
        for (name, wanted) in [
            ("run.csv", Some(Format::Csv)),
            ("a.b/RUN.CSV", Some(Format::Csv)),
            ("run.trace.json", Some(Format::Perfetto)),
            ("run.ocel.json", Some(Format::Ocel)),
            ("run.json", None),
            (".csv", None),
            ("csv", None),
            ("", None),
        ] {
            assert_eq!(Format::of(Path::new(name)), wanted, "{name}");
        }
    }
}
