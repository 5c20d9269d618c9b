//! Internal errors: a panic is caught where the remaining contracts, machines and lines can still
//! be checked, or at the top level.
//!
//! A panic means that an invariant of the program is violated, so the program cannot conclude
//! anything about the checked object. It becomes a finding (LW007, exit code 4) that names the
//! activity. Activities are named where they begin ([`within`], [`caught`]), in any thread. If a
//! thread panics, the names of its activities are passed to the thread that waits for it.
//!
//! A build with debug assertions panics on purpose if the environment variable `LINEWRIGHT_PANIC`
//! is a part of the activity's name. The tests use this to reach every place that catches panics.

use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::source::Span;
use std::any::Any;
use std::cell::{Cell, RefCell};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};

thread_local! {
    /// Number of enclosing `caught` calls in this thread.
    static CATCHING: Cell<usize> = const { Cell::new(0) };
    /// The last panic in this thread: its message and source location.
    static LAST: RefCell<Option<(String, String)>> = const { RefCell::new(None) };
}

/// A panic that was caught.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// Nested activities, the outermost first.
    doing: Vec<String>,
    message: String,
    /// Location in the program's sources.
    place: Option<String>,
}

impl Fault {
    /// Creates a fault that was detected without a panic.
    pub fn detected(doing: String, message: String) -> Self {
        Self {
            doing: vec![doing],
            message,
            place: None,
        }
    }

    /// Passes the fault on to the code that catches panics.
    pub fn raise(self) -> ! {
        resume_unwind(Box::new(self))
    }

    fn of(payload: Box<dyn Any + Send>) -> Self {
        let payload = match payload.downcast::<Self>() {
            Ok(fault) => return *fault,
            Err(payload) => payload,
        };
        let (message, place) = match LAST.take() {
            Some((message, place)) => (message, Some(place)),
            None => (text(&*payload), None),
        };
        Self {
            doing: Vec::new(),
            message,
            place,
        }
    }

    /// Converts the fault to a finding at `span`.
    pub fn finding(&self, span: Option<Span>) -> Diagnostic {
        let message = self.message.trim_end_matches("; please report this");
        let place = self.place.as_ref().map(|p| format!(" ({p})"));
        Diagnostic::error(
            codes::INTERNAL,
            span,
            format!(
                "internal error while {}: {message}{}",
                self.doing.join(": "),
                place.unwrap_or_default()
            ),
        )
        .with_help(format!(
            "this is a fault of linewright {}, not of the file: please report it, with the command and the files that cause it",
            env!("CARGO_PKG_VERSION")
        ))
    }
}

/// The message of a panic.
fn text(payload: &(dyn Any + Send)) -> String {
    if let Some(text) = payload.downcast_ref::<&str>() {
        (*text).to_owned()
    } else if let Some(text) = payload.downcast_ref::<String>() {
        text.clone()
    } else {
        "a panic without a message".to_owned()
    }
}

/// Runs `work` and returns a panic as a fault. `doing` returns the name of the activity:
/// `checking the machine `T` of a.lw`.
pub fn caught<R>(doing: impl FnOnce() -> String, work: impl FnOnce() -> R) -> Result<R, Fault> {
    CATCHING.set(CATCHING.get() + 1);
    // It is safe to assert unwind safety: after a panic, the work's result is replaced by a
    // finding, so inconsistent state is never read.
    let mut named = None;
    let result = catch_unwind(AssertUnwindSafe(|| {
        let doing = named.insert(doing());
        panic_on_purpose(doing);
        work()
    }));
    CATCHING.set(CATCHING.get() - 1);
    result.map_err(|payload| {
        let mut fault = Fault::of(payload);
        // The name is empty for the work of a thread, which is not an activity of its own (see
        // `worker`).
        fault
            .doing
            .splice(0..0, named.filter(|doing| !doing.is_empty()));
        fault
    })
}

/// Runs `work`; if it panics, adds the activity and passes the panic on to the catcher.
pub fn within<R>(doing: &str, work: impl FnOnce() -> R) -> R {
    caught(|| doing.to_owned(), work).unwrap_or_else(|fault| resume_unwind(Box::new(fault)))
}

/// Installs a panic hook: a panic that will be caught is reported by its catcher only, unless
/// `RUST_BACKTRACE` requests a backtrace.
pub fn install_panic_hook() {
    let default = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        let place = info.location().map(ToString::to_string);
        LAST.set(Some((text(info.payload()), place.unwrap_or_default())));
        if CATCHING.get() == 0 || std::env::var_os("RUST_BACKTRACE").is_some_and(|v| v != "0") {
            default(info);
        }
    }));
}

fn panic_on_purpose(doing: &str) {
    if cfg!(debug_assertions)
        && let Ok(wanted) = std::env::var("LINEWRIGHT_PANIC")
    {
        let is_here = !wanted.is_empty() && doing.contains(&wanted);
        assert!(!is_here, "on purpose, for a test");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_keeps_its_activities_across_threads() {
        let fault = caught(
            || "checking a thing".to_owned(),
            || {
                let thread = std::thread::spawn(|| {
                    within("solving it", || panic!("broken; please report this"));
                });
                thread.join().unwrap_or_else(|panic| resume_unwind(panic));
            },
        )
        .unwrap_err();
        assert_eq!(fault.doing, ["checking a thing", "solving it"]);
        let finding = fault.finding(None);
        assert_eq!(finding.code, codes::INTERNAL);
        assert!(
            finding
                .message
                .starts_with("internal error while checking a thing: solving it: broken"),
            "{}",
            finding.message
        );
        assert_eq!(caught(|| "adding".to_owned(), || 1 + 1), Ok(2));
    }
}
