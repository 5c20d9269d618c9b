//! Parts enter the line and leave it: finished, rejected, or as scrap.

use super::part::PartIndex;
use super::{Place, Run};
use crate::log::{EventKind, Other};
use crate::trace::End;
use linewright_language::contract::line::NodeKind;

impl Run<'_> {
    /// A part that leaves its source or a store's stock enters the line.
    pub(super) fn enter(&mut self, node: usize, part: PartIndex) {
        let now = self.now;
        let entering = &mut self.parts[part];
        entering.came_from = Some(node as u32);
        if !entering.entered {
            entering.entered = true;
            entering.entered_at = now;
            entering.since = now;
            self.counters.unit_enters(now);
            self.record(node, Some(part), EventKind::Entered);
        }
    }

    /// Removes a finished part from the line. The run ends when the requested number of end
    /// products is reached.
    pub(super) fn complete(&mut self, node: usize, part: PartIndex) {
        self.record(node, Some(part), EventKind::Finished);
        self.counters.finished += 1;
        let (worked, reworked) = (self.parts[part].worked(), self.parts[part].reworked());
        let yields = &mut self.counters.yields[self.parts[part].kind];
        yields.finished += worked;
        yields.first_pass += worked.saturating_sub(reworked);
        self.count_out(self.parts[part].kind);
        if self.line.is_product(self.parts[part].kind) {
            let stored = matches!(self.nodes[node].place, Place::Store(_));
            self.counters
                .count_product(self.now, &self.parts[part], stored);
            self.progress
                .count_product(self.events, self.journal.violation_count);
            self.count_in_batch(part);
            self.count_in_warm_up();
            if self.is_counting() && self.setup.target == Some(self.counters.products) {
                self.stop(End::Products);
            }
        }
        self.leave_line(part);
    }

    /// Removes a part that has left the line, or was joined to another.
    pub(super) fn leave_line(&mut self, part: PartIndex) {
        let start = self.counting_start();
        self.counters
            .unit_leaves(self.now, self.parts[part].since, start);
        self.parts.remove(part);
    }

    /// Removes a part from the line as scrap, and orders replacements from the source `reorder`, if
    /// any.
    pub(super) fn reject(&mut self, node: usize, part: PartIndex, reorder: Option<usize>) {
        let charged = self.charge_scrap(part);
        self.discard(node, part, charged, reorder);
    }

    /// Removes a part from the line as scrap that a failure made, or that has expired, and orders
    /// its replacement.
    pub(super) fn scrap(&mut self, node: usize, part: PartIndex) {
        self.count_scrap(part);
        let replacement = self.replacement(self.parts[part].kind);
        self.discard(node, part, Some(node), replacement);
    }

    /// Removes a part that was rejected because of the node `charged`, if any.
    fn discard(
        &mut self,
        node: usize,
        part: PartIndex,
        charged: Option<usize>,
        reorder: Option<usize>,
    ) {
        let because_of = charged.map(Other::Node);
        self.record_with(node, Some(part), EventKind::Rejected, because_of);
        let kind = self.parts[part].kind;
        self.counters.rejects[kind].0 += 1;
        self.count_out(kind);
        if let Some(source) = reorder
            && let NodeKind::Source { part: ordered, .. } = self.line.nodes[source].kind
        {
            let count = self.setup.content(kind, ordered);
            let from = Some(Other::Node(source));
            self.record_with(node, Some(part), EventKind::Reordered(count), from);
            self.leave_line(part);
            self.order(source, count);
            self.counters.rejects[kind].1 += count;
        } else {
            self.leave_line(part);
        }
    }

    /// Charges a rejected part to the station whose defect changed it last; without a defect, to
    /// the station that worked on it last. Returns the station. A part that no station has worked
    /// on is not scrap.
    fn charge_scrap(&mut self, part: PartIndex) -> Option<usize> {
        let rejected = &self.parts[part];
        let station = rejected.defect_at.or(rejected.worked_at)? as usize;
        self.count_scrap(part);
        self.station(station).scrapped += 1;
        Some(station)
    }

    /// Counts the single parts in a part as scrap: those on which a station has worked, or the part
    /// as one if none has.
    fn count_scrap(&mut self, part: PartIndex) {
        let part = &self.parts[part];
        self.counters.yields[part.kind].scrapped += part.worked().max(1);
    }

    /// The source from which a replacement is ordered for a part that was removed before it reached
    /// a sink. Of the sources from which rejecting sinks reorder, this is the first that makes
    /// the part or something in it; if there is none, the first of all.
    pub(super) fn replacement(&self, kind: usize) -> Option<usize> {
        let sources = || {
            self.line.nodes.iter().filter_map(|node| match node.kind {
                NodeKind::Sink {
                    reject: true,
                    reorder,
                } => reorder,
                _ => None,
            })
        };
        sources()
            .find(|&source| match self.line.nodes[source].kind {
                NodeKind::Source { part, .. } => self.setup.contains(kind, part),
                _ => false,
            })
            .or_else(|| sources().next())
    }
}
