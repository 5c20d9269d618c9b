//! The warm-up: the time from the start of a run in which nothing is counted, because the line is
//! still filling.

use super::{Place, Run};
use crate::statistics::LeadTimes;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_language::contract::line::{NodeKind, Supply};

impl Run<'_> {
    /// Ends the warm-up: what has been counted so far is forgotten. Violations and findings are
    /// kept. Parts that are in the line stay there, and sources on order get new orders for the
    /// products made so far.
    pub(super) fn end_warm_up(&mut self) {
        let now = self.now;
        self.counting_since = Some(now);
        for place in &mut self.places {
            match place {
                Place::Station(station) => station.forget(now),
                Place::Conveyor(conveyor) => conveyor.forget(now),
                Place::Belt(belt) => {
                    belt.moving_seconds = 0.0;
                    belt.carried = 0;
                }
                Place::Buffer(buffer) => buffer.forget(now),
                Place::Source(_) | Place::Sink | Place::Store(_) => {}
            }
        }
        let counters = &mut self.counters;
        let products = std::mem::take(&mut counters.products);
        counters.stored = 0;
        counters.makespan = 0.0;
        counters.lead_times = LeadTimes::new(self.seed);
        counters.entered = 0;
        counters.finished = 0;
        counters.consumed = 0;
        counters.before = counters.units.level();
        counters.units.forget(now);
        counters.unit_seconds = 0.0;
        for reject in &mut counters.rejects {
            *reject = (0, 0);
        }
        if self.setup.target.is_none() || products == 0 {
            return;
        }
        for (index, node) in self.line.nodes.iter().enumerate() {
            if let NodeKind::Source {
                part,
                supply: Supply::OnOrder,
                ..
            } = node.kind
            {
                let each = self.setup.content(self.line.product, part);
                self.order(index, products.saturating_mul(each));
            }
        }
    }

    /// Reports that a run ended during its warm-up, so that nothing was counted.
    pub(super) fn report_short_run(&mut self) {
        if self.setup.options.warm_up <= 0.0 || self.counting_since.is_some() {
            return;
        }
        self.end_warm_up();
        let message = format!(
            "the run of {} ended at {}, before its warm-up was over: nothing was counted",
            self.line.name,
            self.moment()
        );
        self.journal.findings.push(
            Diagnostic::warning(codes::LINE_LIMIT, self.line.span, message)
                .with_help("Let it run longer, or shorten the warm-up."),
        );
    }

    /// Seconds in which was counted: from the end of the warm-up, or from the start.
    pub(super) fn counted_seconds(&self) -> f64 {
        self.now - self.counting_since.unwrap_or(0.0)
    }
}
