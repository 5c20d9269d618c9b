//! Linewright: from assume-guarantee contracts to a running virtual production line.
//!
//! The entry point for programs is [`Project`](engine::project::Project): files in; verdicts,
//! station libraries and runs out. This example simulates an hour of a line, with station libraries
//! built by a C compiler:
//!
//! ```
//! use linewright::engine::{project::Project, simulation::SimulationOptions};
//! use linewright::{line::Options, report};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let project = Project::open("examples/loader/line.lw")?;
//! let line = project.line("Loading").ok_or("no such line")?;
//! let options = Options { until: Some(3600.0), ..Options::default() };
//! let options = SimulationOptions { options, ..SimulationOptions::default() };
//! let folder = tempfile::tempdir()?;
//! let run = project.run(line, folder.path(), &options)?;
//! println!("{}", report::table(line, &run.traces[0], None));
//! assert_eq!(run.traces[0].violation_count, 0);
//! # Ok(())
//! # }
//! ```
//!
//! The stages below are connected as follows. Each arrow is a module, which owns the type that it
//! produces:
//!
//! ```text
//! text ─parse→ Ast ─resolve→ Library ─lower→ gr1::Specification ─encode→ symbolic
//!      ─solve→ game::Outcome ─extract→ mealy::Machine (verified) ─emit→ station::Package
//!      ─load→ line::Plant ─run→ line::Trace ─→ report
//! ```
//!
//! The stages meet at three narrow interfaces: [`gr1::Specification`], [`mealy::Machine`] and
//! [`line::Trace`]. To solve a specification of your own, start with [`game::solve`]; to read one
//! of another tool, with [`interchange::read`].

pub mod cli;

pub use linewright_algebra as algebra;
pub use linewright_automata as automata;
pub use linewright_b2mml as b2mml;
pub use linewright_core::{deadline, diagnostics, drawing, gr1, source, taxonomy};
pub use linewright_engine::{self as engine, play};
pub use linewright_interchange as interchange;
pub use linewright_language::{contract, order};
pub use linewright_line as line;
pub use linewright_log as event_log;
pub use linewright_recipe as recipe;
pub use linewright_report as report;
pub use linewright_solver::{game, mealy, symbolic};
pub use linewright_station as station;
pub use linewright_syntax as syntax;
