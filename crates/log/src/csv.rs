//! Comma-separated values (RFC 4180), with a header. Numbers have as many digits as it takes to
//! read the same number again.

use crate::row::{COLUMNS, Row, RowWriter};
use std::io::{self, Write};

/// Writes rows as CSV.
pub(crate) struct CsvWriter<W: Write> {
    writer: csv::Writer<W>,
    /// Text of a number.
    text: String,
}

impl<W: Write> CsvWriter<W> {
    pub(crate) fn new(file: W) -> io::Result<Self> {
        let mut builder = csv::WriterBuilder::new();
        let mut writer = builder.terminator(csv::Terminator::CRLF).from_writer(file);
        writer.write_record(COLUMNS)?;
        Ok(Self {
            writer,
            text: String::new(),
        })
    }

    fn number(&mut self, number: Option<impl std::fmt::Display>) -> io::Result<()> {
        use std::fmt::Write as _;
        self.text.clear();
        if let Some(number) = number {
            write!(self.text, "{number}").map_err(io::Error::other)?;
        }
        self.writer.write_field(&self.text)?;
        Ok(())
    }
}

impl<W: Write> RowWriter for CsvWriter<W> {
    fn row(&mut self, row: &Row<'_>) -> io::Result<()> {
        self.number(Some(row.time))?;
        self.writer.write_field(row.node.unwrap_or_default())?;
        self.writer.write_field(row.part_type.unwrap_or_default())?;
        self.number(row.part)?;
        self.writer.write_field(row.what)?;
        self.writer.write_field(row.other.unwrap_or_default())?;
        for number in [row.value, row.seconds, row.joules, row.control_seconds] {
            self.number(number)?;
        }
        self.writer.write_record(None::<&[u8]>)?;
        Ok(())
    }

    fn finish(&mut self) -> io::Result<()> {
        self.writer.flush()
    }
}
