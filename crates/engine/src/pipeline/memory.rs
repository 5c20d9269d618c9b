//! What was found out in the run before, for a program that checks again and again.
//!
//! A result is taken over when the whole job is the same, with all its places in the files, so that
//! its findings still point where they should. Jobs that have moved are left to the
//! [cache](crate::cache). Unlike there, also what was given up is remembered.

use super::{CheckedContract, Job};

/// The jobs of the last run, with their results.
#[derive(Debug, Default)]
pub struct Memory {
    known: Vec<(Job, CheckedContract)>,
}

impl Memory {
    /// The result of a job.
    pub(super) fn find(&self, job: &Job) -> Option<CheckedContract> {
        let same = |known: &&(Job, CheckedContract)| known.0 == *job;
        self.known.iter().find(same).map(|known| known.1.clone())
    }

    /// Remembers a run, and forgets the one before.
    pub(super) fn keep(&mut self, jobs: &[Job], results: &[CheckedContract]) {
        self.known = jobs.iter().cloned().zip(results.iter().cloned()).collect();
    }
}
