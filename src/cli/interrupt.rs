//! Ctrl-C: the first one is a deadline that is past, so that what is known is printed; the second
//! one ends the program.
//!
//! A command that looks at its deadline watches; during any other, Ctrl-C ends the program as it
//! always does.

use std::sync::Once;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// What a shell calls a program that SIGINT has ended.
const KILLED: i32 = 130;

static INSTALL: Once = Once::new();
static INTERRUPTED: AtomicBool = AtomicBool::new(false);
static WATCHING: AtomicUsize = AtomicUsize::new(0);

/// While it is there, the first Ctrl-C does not end the program.
#[derive(Debug)]
pub struct Watch(());

impl Watch {
    /// Begins to watch.
    pub fn new() -> Self {
        INSTALL.call_once(|| {
            // Fails where a handler exists already; then that one decides.
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

/// Whether Ctrl-C was pressed, for a command that it ends in the ordinary way: from now on it
/// counts as not pressed.
pub fn take() -> bool {
    INTERRUPTED.swap(false, Ordering::SeqCst)
}

/// Whether Ctrl-C was pressed.
pub fn interrupted() -> bool {
    INTERRUPTED.load(Ordering::SeqCst)
}

/// What is set when Ctrl-C is pressed.
pub fn flag() -> &'static AtomicBool {
    &INTERRUPTED
}
