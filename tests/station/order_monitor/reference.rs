//! A monitor that looks everything up in the plain table.

use crate::random::Random;
use linewright::order::monitor::RefusalReason;
use linewright::order::table::{RECALL, REFUSED, TOGETHER, Table};

pub struct Reference<'a> {
    table: &'a Table,
    state: u32,
}

impl<'a> Reference<'a> {
    pub fn new(table: &'a Table) -> Self {
        Self {
            table,
            state: table.start,
        }
    }

    pub fn state(&self) -> u32 {
        self.state
    }

    pub fn reset(&mut self) {
        self.state = self.table.start;
    }

    /// The state after a call, or the reason for its refusal.
    pub fn look(&self, mask: u64) -> Result<u32, RefusalReason> {
        let table = self.table;
        if mask == 0 {
            return Ok(self.state);
        }
        if (0..64).any(|bit| mask >> bit & 1 == 1 && bit >= table.skills.len()) {
            return Err(RefusalReason::Unknown);
        }
        let column = table.calls.iter().position(|c| *c == mask);
        let column = column.ok_or(RefusalReason::Together)?;
        let place = self.state as usize * table.calls.len() + column;
        match table.next[place] {
            REFUSED => Err(match table.reasons[place] {
                RECALL => RefusalReason::Recall,
                TOGETHER => RefusalReason::Together,
                rule => RefusalReason::Rule(usize::from(rule)),
            }),
            after => Ok(after),
        }
    }

    pub fn call(&mut self, mask: u64) -> Result<(), RefusalReason> {
        self.state = self.look(mask)?;
        Ok(())
    }
}

/// A random call: mostly from the table, sometimes empty, sometimes arbitrary.
pub fn some_call(table: &Table, random: &mut Random) -> u64 {
    let skill = |random: &mut Random| 1_u64 << random.below(64.min(table.skills.len() as u64 + 1));
    match random.below(10) {
        0 => 0,
        1 => skill(random) | skill(random) | skill(random),
        2..6 => skill(random),
        _ => table.calls[random.below(table.calls.len() as u64) as usize],
    }
}
