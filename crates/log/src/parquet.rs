//! Apache Parquet, gzip-compressed, with dictionaries for names. The description of the line stands
//! in the metadata of the file under `linewright`.

use crate::Context;
use crate::jsonl::header;
use crate::row::{Row, RowWriter};
use parquet::basic::{Compression, GzipLevel};
use parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::parser::parse_message_type;
use std::collections::HashMap;
use std::io::{self, Write};
use std::sync::Arc;

/// Number of rows in a group: it decides on the memory.
const GROUP: usize = 1 << 16;
/// Maximum number of names that are kept.
const NAMES: usize = 1 << 12;

const SCHEMA: &str = "message log {
    required double time;
    optional binary node (UTF8);
    optional binary part_type (UTF8);
    optional int64 part;
    required binary what (UTF8);
    optional binary other (UTF8);
    optional double value;
    optional double seconds;
    optional double joules;
    optional double control_seconds;
}";

/// Writes rows as Parquet.
pub(crate) struct ParquetWriter<W: Write + Send> {
    /// `None` after the file was completed.
    writer: Option<SerializedFileWriter<W>>,
    names: Names,
    time: Vec<f64>,
    what: Vec<ByteArray>,
    node: Column<ByteArrayType>,
    part_type: Column<ByteArrayType>,
    part: Column<Int64Type>,
    other: Column<ByteArrayType>,
    value: Column<DoubleType>,
    seconds: Column<DoubleType>,
    joules: Column<DoubleType>,
    control_seconds: Column<DoubleType>,
}

/// Names that have been written, so that each is in memory once.
#[derive(Default)]
struct Names(HashMap<String, ByteArray>);

impl Names {
    fn get(&mut self, name: &str) -> ByteArray {
        if let Some(known) = self.0.get(name) {
            return known.clone();
        }
        let bytes = ByteArray::from(name);
        if self.0.len() < NAMES {
            self.0.insert(name.to_owned(), bytes.clone());
        }
        bytes
    }
}

/// A column with gaps.
struct Column<T: DataType> {
    values: Vec<T::T>,
    /// By row: 1 if it has a value, 0 if not.
    levels: Vec<i16>,
}

impl<T: DataType> Column<T> {
    fn new() -> Self {
        Self {
            values: Vec::new(),
            levels: Vec::new(),
        }
    }

    fn push(&mut self, value: Option<T::T>) {
        self.levels.push(i16::from(value.is_some()));
        self.values.extend(value);
    }

    fn write<W: Write + Send>(
        &mut self,
        group: &mut SerializedRowGroupWriter<'_, W>,
    ) -> Result<(), ParquetError> {
        write_column::<T, W>(group, &self.values, Some(&self.levels))?;
        self.values.clear();
        self.levels.clear();
        Ok(())
    }
}

fn write_column<T: DataType, W: Write + Send>(
    group: &mut SerializedRowGroupWriter<'_, W>,
    values: &[T::T],
    levels: Option<&[i16]>,
) -> Result<(), ParquetError> {
    let Some(mut column) = group.next_column()? else {
        return Err(ParquetError::General("a column is missing".to_owned()));
    };
    column.typed::<T>().write_batch(values, levels, None)?;
    column.close()
}

impl<W: Write + Send> ParquetWriter<W> {
    pub(crate) fn new(file: W, context: Context<'_>) -> io::Result<Self> {
        let schema = parse_message_type(SCHEMA).map_err(io::Error::other)?;
        let about = KeyValue::new("linewright".to_owned(), header(context).to_string());
        let properties = WriterProperties::builder()
            .set_compression(Compression::GZIP(GzipLevel::default()))
            .set_statistics_enabled(EnabledStatistics::Chunk)
            .set_offset_index_disabled(true)
            .set_key_value_metadata(Some(vec![about]))
            .build();
        let writer = SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties));
        Ok(Self {
            writer: Some(writer.map_err(io::Error::other)?),
            names: Names::default(),
            time: Vec::new(),
            what: Vec::new(),
            node: Column::new(),
            part_type: Column::new(),
            part: Column::new(),
            other: Column::new(),
            value: Column::new(),
            seconds: Column::new(),
            joules: Column::new(),
            control_seconds: Column::new(),
        })
    }

    fn write_group(&mut self) -> Result<(), ParquetError> {
        let Some(writer) = &mut self.writer else {
            return Ok(());
        };
        let mut group = writer.next_row_group()?;
        write_column::<DoubleType, W>(&mut group, &self.time, None)?;
        self.node.write(&mut group)?;
        self.part_type.write(&mut group)?;
        self.part.write(&mut group)?;
        write_column::<ByteArrayType, W>(&mut group, &self.what, None)?;
        self.other.write(&mut group)?;
        self.value.write(&mut group)?;
        self.seconds.write(&mut group)?;
        self.joules.write(&mut group)?;
        self.control_seconds.write(&mut group)?;
        self.time.clear();
        self.what.clear();
        group.close()?;
        Ok(())
    }
}

impl<W: Write + Send> RowWriter for ParquetWriter<W> {
    fn row(&mut self, row: &Row<'_>) -> io::Result<()> {
        self.time.push(row.time);
        let names = &mut self.names;
        self.what.push(names.get(row.what));
        self.node.push(row.node.map(|name| names.get(name)));
        self.part_type
            .push(row.part_type.map(|name| names.get(name)));
        self.part.push(row.part.map(|part| part as i64));
        self.other.push(row.other.map(|name| names.get(name)));
        self.value.push(row.value);
        self.seconds.push(row.seconds);
        self.joules.push(row.joules);
        self.control_seconds.push(row.control_seconds);
        if self.time.len() == GROUP {
            self.write_group().map_err(io::Error::other)?;
        }
        Ok(())
    }

    fn finish(&mut self) -> io::Result<()> {
        self.write_group().map_err(io::Error::other)?;
        if let Some(writer) = self.writer.take() {
            let mut file = writer.into_inner().map_err(io::Error::other)?;
            file.flush()?;
        }
        Ok(())
    }
}
