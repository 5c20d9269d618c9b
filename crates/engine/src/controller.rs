//! Extracts the controller of a won game in the requested form (a machine or functions), and
//! verifies it.
//!
//! If either form is acceptable, a machine is tried only for small games. It is abandoned when it
//! grows too large, or when its tables would take too much space in a station library. The limits
//! count bits, nodes and bytes instead of seconds: with a time limit, the form would depend on the
//! speed of the computer.

use super::pipeline::InternalError;
use super::statistics::Seconds;
use linewright_core::gr1::Specification;
use linewright_solver::game::{Budget, Limit, Limits, Preference, WonGame};
use linewright_solver::mealy::{self, Machine, functions::Functions};
use linewright_station::emit::table_bytes;
use std::time::Instant;

/// Maximum peak node count of games for which a machine is tried.
const MACHINE_PEAK_NODES: u64 = 47_500;

/// Maximum number of bit pairs of games for which a machine is tried.
const MACHINE_PAIRS: usize = 48;

/// If functions are acceptable: maximum size of a machine's tables in bytes.
const TABLE_BYTES: usize = 256 << 10;

/// Requested properties of a controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct ExtractionOptions {
    /// What a machine is optimized for.
    pub preference: Preference,
    /// Whether functions are acceptable instead of a large machine.
    pub functions: bool,
    /// Whether the machine is only drawn. Then a large one, of which nobody would see anything, is
    /// given up with [`Limit::Size`].
    pub drawn: bool,
}

/// Outcome of the extraction.
#[derive(Debug, Clone)]
pub enum Controller {
    /// No controller was requested.
    NotRequested,
    /// A limit was reached before the controller was verified.
    Stopped(Limit),
    /// A verified machine.
    Machine(Machine),
    /// Certified functions.
    Functions(Box<Functions>),
}

/// Extracts and verifies a controller.
///
/// # Errors
/// The verifier rejects the controller, which is a fault of this program.
pub fn controller(
    specification: &Specification,
    won: &WonGame,
    pairs: usize,
    options: ExtractionOptions,
    limits: &Limits,
    seconds: Option<&mut Seconds>,
) -> Result<Controller, InternalError> {
    let mut work = Work {
        specification,
        won,
        preference: options.preference,
        seconds,
    };
    let made = if options.drawn && !options.functions {
        let bounded = limits.with_budget_after(won.work(), Budget::LISTING);
        match work.machine(&bounded) {
            Err(Limit::Memory | Limit::Nodes(_) | Limit::Work(_)) => Err(Limit::Size),
            done => done,
        }
    } else if !options.functions {
        work.machine(limits)
    } else if won.peak_nodes > MACHINE_PEAK_NODES || pairs > MACHINE_PAIRS {
        work.functions(limits)
    } else {
        // The node limit also holds for the pairs of a state and inputs that have to be verified.
        let bounded = limits.with_budget_after(won.work(), Budget::LISTING);
        match work.machine(&bounded) {
            Err(Limit::Memory | Limit::Size | Limit::Work(_)) => work.functions(limits),
            Ok(Ok(Controller::Machine(machine))) if table_bytes(&machine) > TABLE_BYTES => {
                work.functions(limits)
            }
            done => done,
        }
    };
    match made {
        Ok(Ok(controller)) => Ok(controller),
        Ok(Err(rule)) => Err(InternalError::new(specification, rule)),
        Err(limit) => Ok(Controller::Stopped(limit)),
    }
}

/// A verified controller, or the rule that the extracted controller violates. The outer error is
/// the limit that stopped the extraction.
type Extracted = Result<Result<Controller, String>, Limit>;

struct Work<'a> {
    specification: &'a Specification,
    won: &'a WonGame,
    preference: Preference,
    seconds: Option<&'a mut Seconds>,
}

impl Work<'_> {
    fn machine(&mut self, limits: &Limits) -> Extracted {
        let (specification, won, preference) = (self.specification, self.won, self.preference);
        let extract =
            || mealy::extract::extract_with_preference(preference, specification, won, limits);
        let machine = self.timed(|s| &mut s.extract, extract)?;
        let verify = || mealy::verify::verify(specification, &machine, limits);
        let verdict = self.timed(|s| &mut s.verify, verify)?;
        Ok(match verdict {
            Ok(()) => Ok(Controller::Machine(machine)),
            Err(violation) => Err(violation.clause.to_string()),
        })
    }

    fn functions(&mut self, limits: &Limits) -> Extracted {
        let (specification, won) = (self.specification, self.won);
        let extract = || Functions::extract(specification, won, limits);
        let functions = self.timed(|s| &mut s.extract, extract)?;
        let certify = || mealy::certify::certify(specification, &functions, limits);
        let verdict = self.timed(|s| &mut s.verify, certify)?;
        Ok(match verdict {
            Ok(()) => Ok(Controller::Functions(Box::new(functions))),
            Err(fault) => Err(fault.clause.to_string()),
        })
    }

    /// Runs `something` and adds the time it takes to one of the phases.
    fn timed<T>(
        &mut self,
        phase: fn(&mut Seconds) -> &mut Option<f64>,
        something: impl FnOnce() -> T,
    ) -> T {
        let clock = Instant::now();
        let result = something();
        if let Some(seconds) = &mut self.seconds {
            *phase(seconds).get_or_insert(0.0) += clock.elapsed().as_secs_f64();
        }
        result
    }
}
