//! The warm-up: the time from the start of a run in which nothing is counted, because the line is
//! still filling.

use super::{Event, Place, Plant, Run, WARM_UP};
use crate::mser::mser5;
use crate::trace::End;
use linewright_core::diagnostics::{Diagnostic, Severity, codes};
use linewright_language::contract::line::{NodeKind, Supply};

impl Plant {
    /// Finds the warm-up by a pilot run with the seed and the end of the options, and sets it for
    /// all runs from now on. MSER-5 is applied to the lead times of the products and to the times
    /// between them, and the later cut is taken. Returns the warm-up in seconds.
    ///
    /// # Errors
    /// Returns `LW404` if the pilot run is too short, `LW403` if this is so because of a deadlock,
    /// and `LW204` if the deadline cut it off.
    pub fn find_warm_up(&mut self) -> Result<f64, Box<Diagnostic>> {
        self.setup.options.warm_up = 0.0;
        self.setup.options.warm_up_products = 0;
        let mut run = self.begin(self.setup.options.seed, None);
        run.counters.observations = Some(Vec::new());
        let end = run.advance();
        if end == End::GaveUp
            && let Some(late) = run.journal.findings.pop()
        {
            return Err(Box::new(late));
        }
        let observations = run.counters.observations.take().unwrap_or_default();
        let lead_times: Vec<f64> = observations.iter().map(|(_, lead)| *lead).collect();
        let mut last = 0.0;
        let between = observations.iter().map(|(time, _)| {
            let seconds = time - last;
            last = *time;
            seconds
        });
        let between: Vec<f64> = between.collect();
        let (Some(a), Some(b)) = (mser5(&lead_times), mser5(&between)) else {
            run.report_deadlock(end);
            if let Some(blocked) = run.blocked() {
                return Err(Box::new(blocked.clone()));
            }
            let line = &self.setup.line;
            let message = format!(
                "no warm-up of {} was found in a run with {} products: it does not become steady in the first half of the run",
                line.name,
                observations.len()
            );
            return Err(Box::new(
                Diagnostic::error(codes::LINE_LIMIT, line.span, message).with_help(
                    "Let it run longer, or give the warm-up: `--warm-up 2h`. If parts come faster than they can be processed, the line never becomes steady.",
                ),
            ));
        };
        let warm_up = match a.max(b) {
            0 => 0.0,
            cut => observations[cut - 1].0,
        };
        self.set_found_warm_up(warm_up);
        Ok(warm_up)
    }

    /// Sets a warm-up that [`Self::find_warm_up`] has found in another plant of the line.
    pub fn set_found_warm_up(&mut self, seconds: f64) {
        self.setup.options.warm_up = seconds;
        self.setup.warm_up_found = true;
    }
}

impl Run<'_> {
    /// Ends the warm-up at this instant if it lasts until a number of products, and this was the
    /// last of them.
    pub(super) fn count_in_warm_up(&mut self) {
        let wanted = self.setup.options.warm_up_products;
        if !self.is_counting() && self.counters.products == wanted {
            self.schedule(self.now, WARM_UP, Event::WarmUp);
        }
    }

    /// Ends the warm-up: what has been counted so far is forgotten. Violations and findings are
    /// kept. Parts that are in the line stay there. Sources on order, which have had orders without
    /// end so far, get those for the wanted products, if these are of one type.
    pub(super) fn end_warm_up(&mut self) {
        let now = self.now;
        self.close_log();
        self.counting_since = Some(now);
        for node in 0..self.nodes.len() {
            self.end_wait(node);
        }
        for node in &mut self.nodes {
            match &mut node.place {
                Place::Station(station) => station.forget(now),
                Place::Conveyor(conveyor) => conveyor.forget(now),
                Place::Belt(belt) => {
                    belt.moving_seconds = 0.0;
                    belt.carried = 0;
                    belt.level.forget(now);
                }
                Place::Buffer(buffer) => buffer.forget(now),
                Place::Source(source) => source.forget(now),
                Place::Sink | Place::Store(_) => {}
            }
        }
        for node in 0..self.nodes.len() {
            self.begin_wait(node);
        }
        self.counters.forget(self.line, now, self.seed);
        self.log_counting();
        self.begin_batches();
        let (Some(target), Some(product)) = (self.setup.target, self.line.only_product()) else {
            return;
        };
        let places = self.nodes.iter_mut().map(|node| &mut node.place);
        for (node, place) in self.line.nodes.iter().zip(places) {
            if let (
                NodeKind::Source {
                    part,
                    supply: Supply::OnOrder,
                    ..
                },
                Place::Source(source),
            ) = (&node.kind, place)
            {
                let each = self.setup.content(product, *part);
                source.limit_orders(target.saturating_mul(each));
            }
        }
    }

    /// Reports that a run ended during its warm-up, so that nothing was counted.
    pub(super) fn report_short_run(&mut self) {
        if self.is_counting() {
            return;
        }
        let of = match self.setup.options.warm_up_products {
            0 => String::new(),
            wanted => format!(" of {wanted} products ({} made)", self.counters.products),
        };
        self.end_warm_up();
        let message = format!(
            "the run of {} ended at {}, before its warm-up{of} was over: nothing was counted",
            self.line.name,
            self.moment()
        );
        let help = match self.blocked() {
            Some(_) => "First repair what made the line stand still.",
            None => "Let it run longer, or shorten the warm-up.",
        };
        self.journal
            .findings
            .push(Diagnostic::warning(codes::LINE_LIMIT, self.line.span, message).with_help(help));
    }

    /// The error that the line, or a part of it, can no longer advance.
    fn blocked(&self) -> Option<&Diagnostic> {
        let mut findings = self.journal.findings.iter();
        findings.find(|f| f.code == codes::LINE_BLOCKED && f.severity == Severity::Error)
    }

    /// Whether the warm-up is over, or there is none.
    pub(super) fn is_counting(&self) -> bool {
        self.counting_since.is_some() || !self.setup.has_warm_up()
    }

    /// Time from which on was counted: the end of the warm-up, or 0.
    pub(super) fn counting_start(&self) -> f64 {
        self.counting_since.unwrap_or(0.0)
    }
}
