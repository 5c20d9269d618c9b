//! Results of the previous run, for a program that checks repeatedly.
//!
//! A result is reused if the whole job is the same, including all source positions, so that its
//! findings still point to the right place. For contracts that have moved within their file, there
//! is the [cache](crate::cache). Unlike the cache, the memory also holds the results of jobs that
//! reached a limit.

use super::{CheckedContract, Job};

/// Jobs of the last run with their results.
#[derive(Debug, Default)]
pub struct Memory {
    known: Vec<(Job, CheckedContract)>,
}

impl Memory {
    /// Returns the remembered result of a job.
    pub(super) fn find(&self, job: &Job) -> Option<CheckedContract> {
        let same = |known: &&(Job, CheckedContract)| known.0 == *job;
        self.known.iter().find(same).map(|known| known.1.clone())
    }

    /// Remembers a run and forgets the previous one.
    pub(super) fn store(&mut self, jobs: &[Job], results: &[CheckedContract]) {
        self.known = jobs.iter().cloned().zip(results.iter().cloned()).collect();
    }
}
