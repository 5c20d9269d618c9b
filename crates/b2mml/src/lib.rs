//! B2MML 7.0.1: layouts, recipes, schedules and performances as documents, written and read.
//!
//! B2MML is the XML form of ISA-95 (IEC 62264). The Business To Manufacturing Markup Language
//! (B2MML) is used courtesy of MESA International.
//!
//! | document | holds | written by | read as |
//! |---|---|---|---|
//! | `EquipmentInformation` | a layout | [`write::equipment`] | [`Document::Layouts`] |
//! | `OperationsDefinition` | a recipe | [`write::definition`] | [`Document::Recipes`] |
//! | `WorkflowSpecification` | a recipe as a graph | [`write::workflow`] | [`Document::Recipes`] |
//! | `OperationsSchedule` | a controller | [`write::schedule`] | [`Document::Schedule`] |
//! | `OperationsPerformance` | a run | [`write::performance`] | [`Document::Performance`] |
//!
//! What is written is valid against the schemas, whatever the names are, and [`read()`] gives the
//! same values. What is read may come from other programs. It is validated first.
//!
//! ```
//! use linewright_b2mml::{Document, read, write};
//! use linewright_recipe::model::{Action, Layout, Resource};
//!
//! let press = Resource::new("press", &["empty"], &[])
//!     .with("empty", Action::Operation("form".to_owned()), "empty");
//! let layout = Layout { name: "Cell".to_owned(), resources: vec![press] };
//! let text = write::equipment(&layout).expect("the layout has no problems");
//! let reading = read(text.as_bytes()).expect("it is a document");
//! assert_eq!(reading.document, Document::Layouts(vec![layout]));
//! ```

mod finding;
mod linear;
mod name;
mod performance;
mod read;
mod schedule;
mod schema;
mod terms;
pub mod write;
mod xml;

pub use finding::{Finding, Findings, MAX_FINDINGS, Rule};
pub use name::{decode, encode};
pub use performance::{Performance, Record};
pub use read::{Document, MAX_BYTES, Reading, read};
pub use schedule::{Activity, NoSequence, PlanPlace, Request, Schedule};
pub use schema::NAMESPACE;
pub use write::WriteError;
