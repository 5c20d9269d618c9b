//! Runs work with a deadline on its own thread, and abandons the thread if the work is late.
//!
//! The stages check the deadline between operations of the BDD kernel; a single operation cannot be
//! interrupted and can take minutes. So the caller continues shortly after the deadline with what
//! the work has reported by then. The thread keeps running until the program ends, which is soon.

use super::internal;
use linewright_core::deadline::{Deadline, StopReason};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::{Duration, Instant};

/// Time after the deadline in which the work can still notice the deadline by itself. Its own
/// answer says more than the values reported before.
const GRACE: Duration = Duration::from_millis(300);

/// Interval between checks of the deadline; an interrupt can bring the deadline forward.
const POLL_INTERVAL: Duration = Duration::from_millis(5);

/// The same while the process may take less than [`LITTLE_BYTES`] more: memory can grow by a
/// gigabyte in a second.
const POLL_INTERVAL_NEAR_MEMORY_LIMIT: Duration = Duration::from_millis(1);

/// See [`POLL_INTERVAL_NEAR_MEMORY_LIMIT`].
const LITTLE_BYTES: u64 = 32 << 20;

/// Interval between two calls of `waiting`.
const CALL_INTERVAL: Duration = Duration::from_millis(50);

/// Stack size in bytes. Formulas can be nested arbitrarily deep, and are processed recursively.
pub const STACK_BYTES: usize = 256 << 20;

/// Outcome of the work.
#[derive(Debug)]
pub enum Completion<P, R> {
    /// Completed with a result.
    Done(R),
    /// Abandoned, with the last value that the work reported.
    Abandoned(StopReason, Option<P>),
}

/// Runs `work` on its own thread. `work` passes intermediate values to its argument; the last one
/// is returned if the work is abandoned. While it runs, `waiting` is called several times a second
/// with the last value.
pub fn run<P, R>(
    deadline: Deadline,
    work: impl FnOnce(&dyn Fn(P)) -> R + Send + 'static,
    mut waiting: impl FnMut(Option<&P>),
) -> Completion<P, R>
where
    P: Send + 'static,
    R: Send + 'static,
{
    let (sender, receiver) = mpsc::channel();
    let last = deadline.extended(GRACE);
    let builder = std::thread::Builder::new().stack_size(STACK_BYTES);
    let thread = builder.spawn(move || {
        let report = |partly: P| {
            let _ = sender.send(Err(partly));
        };
        // A panic is passed on to the waiting thread, with its location.
        let result = internal::within("", || work(&report));
        let _ = sender.send(Ok(result));
    });
    let thread = thread.unwrap_or_else(|e| panic!("cannot start a thread: {e}"));
    let mut reported = None;
    let mut called = Instant::now();
    loop {
        let interval = if last.memory_left() < LITTLE_BYTES {
            POLL_INTERVAL_NEAR_MEMORY_LIMIT
        } else {
            POLL_INTERVAL
        };
        let left = last.remaining().unwrap_or(interval);
        match receiver.recv_timeout(left.min(interval)) {
            Ok(Ok(result)) => return Completion::Done(result),
            Ok(Err(partly)) => reported = Some(partly),
            Err(RecvTimeoutError::Timeout) => {
                if called.elapsed() >= CALL_INTERVAL {
                    waiting(reported.as_ref());
                    called = Instant::now();
                }
                last.sample_memory();
                if let Err(late) = last.check() {
                    return Completion::Abandoned(late, reported);
                }
            }
            Err(RecvTimeoutError::Disconnected) => match thread.join() {
                Err(panic) => std::panic::resume_unwind(panic),
                Ok(()) => unreachable!("the work ended without a result; please report this"),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_that_ends_gives_its_result() {
        let work = |report: &dyn Fn(u8)| {
            report(1);
            2
        };
        let ended = run(Deadline::NONE, work, |_| ());
        assert!(matches!(ended, Completion::Done(2)));
    }

    #[test]
    fn work_that_does_not_end_is_abandoned() {
        let begin = Instant::now();
        let deadline = Deadline::after(begin, Duration::from_millis(50));
        let work = |report: &dyn Fn(u8)| {
            report(1);
            report(2);
            std::thread::sleep(Duration::from_mins(1));
        };
        let mut last = None;
        let ended = run(deadline, work, |reported| last = reported.copied());
        assert_eq!(last, Some(2));
        assert!(matches!(
            ended,
            Completion::Abandoned(StopReason::Time, Some(2))
        ));
        assert!(begin.elapsed() < Duration::from_secs(10));
    }

    #[test]
    fn a_panic_is_passed_on() {
        let work = || run(Deadline::NONE, |_: &dyn Fn(u8)| panic!("broken"), |_| ());
        let caught = internal::caught(|| "waiting".to_owned(), work);
        let finding = caught.unwrap_err().finding(None);
        assert!(
            finding.message.contains("waiting: broken"),
            "{}",
            finding.message
        );
    }
}
