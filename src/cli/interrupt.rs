//! Ctrl-C: the first one acts like a deadline, so that the results so far are printed; the second
//! one ends the program.
//!
//! A command that checks its deadline creates a [`Watch`]. In all other commands, the first Ctrl-C
//! ends the program.

use std::sync::Once;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Exit code of a shell for a program ended by SIGINT.
const KILLED: i32 = 130;

static INSTALL: Once = Once::new();
static INTERRUPTED: AtomicBool = AtomicBool::new(false);
static WATCHING: AtomicUsize = AtomicUsize::new(0);

/// While a value of this type exists, the first Ctrl-C does not end the program.
#[derive(Debug)]
pub struct Watch(());

impl Watch {
    /// Starts watching.
    pub fn new() -> Self {
        INSTALL.call_once(|| {
            // Fails if a handler already exists; that one is then used.
            let _ = ctrlc::set_handler(|| {
                let watched = WATCHING.load(Ordering::SeqCst) > 0;
                if INTERRUPTED.swap(true, Ordering::SeqCst) || !watched {
                    std::process::exit(KILLED);
                }
            });
        });
        WATCHING.fetch_add(1, Ordering::SeqCst);
        Self(())
    }
}

impl Default for Watch {
    fn default() -> Self {
        Self::new()
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        WATCHING.fetch_sub(1, Ordering::SeqCst);
    }
}

/// Returns whether Ctrl-C was pressed, and resets the state. Used by a command that Ctrl-C ends
/// normally, without an error.
pub fn take() -> bool {
    INTERRUPTED.swap(false, Ordering::SeqCst)
}

/// Whether Ctrl-C was pressed.
pub fn interrupted() -> bool {
    INTERRUPTED.load(Ordering::SeqCst)
}

/// The flag set by Ctrl-C.
pub fn flag() -> &'static AtomicBool {
    &INTERRUPTED
}
