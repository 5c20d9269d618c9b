//! The schema: content models as a table, and the validation of a document against it.
//!
//! `types.txt` has all types of B2MML 7.0.1 that the documents of this crate can contain. Every
//! content model of these is a sequence, in which each element has a name of its own. So validation
//! goes through the children once, and what is missing, repeated or out of order can be named.
//!
//! XML Schema 1.0 is applied as libxml2 does, with these exceptions, where valid documents are
//! refused: `xsi:type`; decimals of more than 18 digits; years other than 0001 to 9999; durations
//! with numbers of more than 9 digits before the point; URIs with characters that RFC 3986 does not
//! allow; sections `CDATA` and references between elements.

mod table;
mod validate;
mod value;

pub(crate) use table::Schema;
pub(crate) use validate::validate;
pub(crate) use value::{duration_seconds, has_calendar_units, replaced, seconds_as_duration};

/// Namespace of B2MML 7.
pub const NAMESPACE: &str = "http://www.mesa.org/xml/B2MML";
