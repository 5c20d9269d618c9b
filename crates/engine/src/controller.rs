//! The controller of a won game: extracted in the form that was asked for, and verified.
//!
//! Where either form will do, a machine is tried for small games only, and given up when it grows,
//! or when its tables would take much room in a station library. What decides are bits, nodes and
//! bytes: a bound on time would make the form depend on the computer.

use super::pipeline::InternalError;
use super::statistics::Seconds;
use linewright_core::gr1::Specification;
use linewright_solver::game::{Limit, Limits, Preference, Won};
use linewright_solver::mealy::{self, Machine, functions::Functions};
use linewright_station::emit::table_bytes;
use std::time::Instant;

/// A machine is only tried for games that needed at most so many nodes.
const MACHINE_PEAK_NODES: u64 = 50_000;

/// A machine is only tried for games of at most so many pairs of bits.
const MACHINE_PAIRS: usize = 48;

/// Where functions will do, a machine is given up that needs more nodes than this at once, or more
/// pairs of a state and inputs to be verified.
const MACHINE_NODES: u64 = 500_000;

/// Where functions will do, a machine is given up whose tables would take more bytes than this.
const TABLE_BYTES: usize = 256 << 10;

/// What a controller shall be like.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct ExtractionOptions {
    /// What a machine shall be good at.
    pub preference: Preference,
    /// Whether functions are as good as a machine where that would be large.
    pub functions: bool,
}

/// What becomes of the controller.
#[derive(Debug, Clone)]
pub enum Controller {
    /// Nobody asks for it.
    NotRequested,
    /// A limit was reached first.
    Stopped(Limit),
    /// A machine, verified.
    Machine(Machine),
    /// Functions, certified.
    Functions(Box<Functions>),
}

/// Extracts a controller, and verifies it.
pub fn controller(
    specification: &Specification,
    won: &Won,
    pairs: usize,
    wish: ExtractionOptions,
    limits: &Limits,
    seconds: Option<&mut Seconds>,
) -> Result<Controller, InternalError> {
    let mut work = Work {
        specification,
        won,
        preference: wish.preference,
        seconds,
    };
    let made = if !wish.functions {
        work.machine(limits)
    } else if won.peak_nodes > MACHINE_PEAK_NODES || pairs > MACHINE_PAIRS {
        work.functions(limits)
    } else {
        let bounded = Limits {
            most_nodes: Some(MACHINE_NODES),
            ..*limits
        };
        match work.machine(&bounded) {
            Err(Limit::Memory | Limit::Size) => work.functions(limits),
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

/// A controller, or the rule that it breaks.
type Made = Result<Result<Controller, String>, Limit>;

struct Work<'a> {
    specification: &'a Specification,
    won: &'a Won,
    preference: Preference,
    seconds: Option<&'a mut Seconds>,
}

impl Work<'_> {
    fn machine(&mut self, limits: &Limits) -> Made {
        let (specification, won, preference) = (self.specification, self.won, self.preference);
        let extract = || mealy::extract::extract_preferring(preference, specification, won, limits);
        let machine = self.timed(|s| &mut s.extract, extract)?;
        let verify = || mealy::verify::verify(specification, &machine, limits);
        let verdict = self.timed(|s| &mut s.verify, verify)?;
        Ok(match verdict {
            Ok(()) => Ok(Controller::Machine(machine)),
            Err(violation) => Err(violation.clause.to_string()),
        })
    }

    fn functions(&mut self, limits: &Limits) -> Made {
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

    /// Adds what something takes to one of the phases.
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
