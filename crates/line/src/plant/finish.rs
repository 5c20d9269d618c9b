//! The end of a run: closes and checks the accounts, and creates the trace.

use super::{Node, Place, Run};
use crate::bottleneck::Bottleneck;
use crate::metric::percentiles_of_lead_time;
use crate::requirement;
use crate::statistics::Activity;
use crate::trace::{
    BufferStatistics, ConveyorStatistics, End, MachineStatistics, PartCounts, ProductStatistics,
    Reject, SourceStatistics, StationStatistics, Trace, WorkInProgress, Yields,
};
use linewright_language::contract::line::NodeKind;

impl Run<'_> {
    pub(super) fn finish(mut self, end: End) -> Trace {
        self.report_deadlock(end);
        self.report_short_run();
        self.log_end(end);
        for node in 0..self.nodes.len() {
            if matches!(self.nodes[node].place, Place::Station(_)) {
                self.end_starving(node);
            }
        }
        let batches = self.close_batches(end);
        let (mut stations, mut conveyors, mut buffers) = (Vec::new(), Vec::new(), Vec::new());
        let mut sources = Vec::new();
        let now = self.now;
        let start = self.counting_start();
        let counted = now - start;
        for (index, node) in self.line.nodes.iter().enumerate() {
            let Node { place, outlet, .. } = &mut self.nodes[index];
            match (&node.kind, place) {
                (NodeKind::Station(declared), Place::Station(station)) => {
                    station.close(now, declared.idle_watts);
                    stations.push(StationStatistics {
                        node: index,
                        name: node.name.clone(),
                        machine: declared
                            .machine
                            .as_ref()
                            .map(|machine| machine.name.clone()),
                        processed: station.processed,
                        shares: station.clock.shares(station.is_visited()),
                        busy_seconds: station.clock.seconds(Activity::Busy),
                        joules: station.joules,
                        joules_by_state: station.clock.energy(
                            station.joules,
                            declared.idle_watts,
                            station.is_visited(),
                        ),
                        work_time: station.work_time(),
                        oee: station.oee(),
                        scrapped: station.scrapped,
                        waits: station.waits.causes(self.line, station.clock.total()),
                    });
                }
                (NodeKind::Conveyor { watts, .. }, Place::Conveyor(conveyor)) => {
                    let moving_seconds = conveyor.moving_seconds(now);
                    conveyor.level.advance(now);
                    conveyors.push(ConveyorStatistics {
                        node: index,
                        name: node.name.clone(),
                        machine: None,
                        carried: conveyor.carried,
                        moving_seconds,
                        joules: moving_seconds * watts,
                        standing_joules: 0.0,
                        length: conveyor.level.mean(),
                        longest: conveyor.level.max(),
                    });
                }
                (
                    NodeKind::Conveyor {
                        watts,
                        belt: Some(declared),
                        ..
                    },
                    Place::Belt(belt),
                ) => {
                    let idle_watts = declared.machine.idle_watts;
                    let (moving_seconds, joules, standing_joules) =
                        belt.moved(counted, *watts, idle_watts);
                    belt.level.advance(now);
                    conveyors.push(ConveyorStatistics {
                        node: index,
                        name: node.name.clone(),
                        machine: Some(declared.machine.name.clone()),
                        carried: belt.carried,
                        moving_seconds,
                        joules,
                        standing_joules,
                        length: belt.level.mean(),
                        longest: belt.level.max(),
                    });
                }
                (NodeKind::Source { .. }, Place::Source(source)) => {
                    let (passed, blocked, lost) = source.close(now, counted, outlet.part.is_some());
                    sources.push(SourceStatistics {
                        node: index,
                        name: node.name.clone(),
                        passed,
                        blocked,
                        lost,
                    });
                }
                (NodeKind::Buffer { .. }, Place::Buffer(buffer)) => {
                    buffer.level.advance(now);
                    buffers.push(BufferStatistics {
                        node: index,
                        name: node.name.clone(),
                        passed: buffer.passed(),
                        length: buffer.level.mean(),
                        longest: buffer.level.max(),
                        full: buffer.level.full_share(),
                        wait: buffer.waits.mean(),
                        longest_wait: buffer.waits.max,
                        wait_percentiles: buffer.wait_percentiles(),
                        expired: buffer.expired,
                    });
                }
                _ => {}
            }
        }
        let parts = self.count_parts();
        let counters = &mut self.counters;
        let over_time = std::mem::take(&mut counters.units_over_time);
        let wip_over_time = over_time.over_time(now, &counters.units);
        self.check_littles_law();
        let rate = |count: u64, seconds: f64| {
            if seconds > 0.0 {
                count as f64 * 3600.0 / seconds
            } else {
                0.0
            }
        };
        let per_hour = |seconds: f64| rate(self.counters.products, seconds);
        let by_type = self.counters.by_type.into_iter();
        let numbers = percentiles_of_lead_time(self.line);
        let by_type = by_type.map(|(part, mut lead_times)| ProductStatistics {
            part,
            products: lead_times.count(),
            throughput_per_hour: rate(lead_times.count(), counted),
            lead_time: lead_times.summary(),
            lead_time_percentiles: lead_times.percentiles(&numbers),
        });
        let on_shift_seconds = self
            .line
            .calendar
            .as_ref()
            .map(|calendar| calendar.worked_until(now) - calendar.worked_until(start));
        self.journal.count_repeated_violations();
        let mut trace = Trace {
            seed: self.seed,
            end,
            seconds: now,
            events: self.events,
            products: self.counters.products,
            stored: self.counters.stored,
            makespan: self.counters.makespan,
            warm_up: start,
            warm_up_found: self.setup.warm_up_found,
            warm_up_products: self.setup.options.warm_up_products,
            throughput_per_hour: per_hour(counted),
            throughput_on_shift: on_shift_seconds.map(per_hour),
            wip: WorkInProgress {
                mean: self.counters.units.mean(),
                max: self.counters.units.max(),
            },
            parts,
            wip_over_time: Some(wip_over_time),
            lead_time: self.counters.lead_times.summary(),
            lead_time_percentiles: self.counters.lead_times.percentiles(&numbers),
            by_type: by_type.collect(),
            // Starts from 0, because the sum of no numbers is -0.
            joules: 0.0
                + stations.iter().map(|s| s.joules).sum::<f64>()
                + conveyors.iter().map(|c| c.joules).sum::<f64>(),
            machines: machines(&stations, &conveyors),
            bottleneck: match self.deadlock {
                Some(deadlock) => Bottleneck::Deadlock(deadlock),
                None => Bottleneck::of(self.line, &stations, &sources),
            },
            sources,
            stations,
            conveyors,
            buffers,
            yields: Yields::sum(&self.counters.yields),
            yields_by_type: self.counters.yields,
            rejects: self
                .counters
                .rejects
                .iter()
                .enumerate()
                .filter(|(_, (count, _))| *count > 0)
                .map(|(part, &(count, reordered))| Reject {
                    part,
                    count,
                    reordered,
                })
                .collect(),
            violations: self.journal.violations,
            violation_count: self.journal.violation_count,
            requirements: Vec::new(),
            findings: self.journal.findings,
            batches,
        };
        requirement::check(self.line, &mut trace);
        trace
    }

    /// Checks Little's law for the line and for each buffer. It holds exactly in every interval
    /// (Stidham, 1974): the integral of the number of parts there is the sum of the times that
    /// parts spent there.
    fn check_littles_law(&mut self) {
        let (now, start) = (self.now, self.counting_start());
        self.counters.units.advance(now);
        let here = (0..self.nodes.len()).flat_map(|node| self.held(node));
        let here = here.filter(|part| self.parts[*part].entered);
        let unit_seconds = here
            .map(|part| now - self.parts[part].since.max(start))
            .sum::<f64>()
            + self.counters.unit_seconds;
        let area = self.counters.units.area();
        assert_littles_law("the line", area, unit_seconds);
        for (index, node) in self.nodes.iter_mut().enumerate() {
            if let Place::Buffer(buffer) = &mut node.place {
                let (area, waited) = buffer.littles_law(now);
                assert_littles_law(&self.line.nodes[index].name, area, waited);
            }
        }
    }

    /// The part counts, checked against the parts that are actually in the line.
    fn count_parts(&self) -> PartCounts {
        let in_progress = (0..self.nodes.len())
            .flat_map(|node| self.held(node))
            .filter(|&part| self.parts[part].entered)
            .count() as u64;
        let counts = PartCounts {
            entered: self.counters.entered,
            finished: self.counters.finished,
            rejected: self.counters.rejects.iter().map(|(count, _)| count).sum(),
            consumed: self.counters.consumed,
            in_progress,
            before: self.counters.before,
        };
        assert_eq!(
            counts.before + counts.entered,
            counts.finished + counts.rejected + counts.consumed + counts.in_progress,
            "internal error: the counts of parts disagree: {counts:?}; please report this"
        );
        counts
    }
}

/// Ends the program if the two sides of Little's law differ by more than their rounding errors.
fn assert_littles_law(of: &str, area: f64, part_seconds: f64) {
    assert!(
        (area - part_seconds).abs() <= 1e-6 * area.max(1.0),
        "internal error: Little's law is broken in {of}: {area} and {part_seconds} part seconds; please report this"
    );
}

/// Sums up the statistics of stations and contracted belts by machine.
fn machines(
    stations: &[StationStatistics],
    conveyors: &[ConveyorStatistics],
) -> Vec<MachineStatistics> {
    let of_stations = stations
        .iter()
        .filter_map(|s| s.machine.as_ref().map(|m| (m, s.busy_seconds, s.joules)));
    let of_belts = conveyors
        .iter()
        .filter_map(|c| c.machine.as_ref().map(|m| (m, c.moving_seconds, c.joules)));
    let mut machines: Vec<MachineStatistics> = Vec::new();
    for (name, busy_seconds, joules) in of_stations.chain(of_belts) {
        match machines.iter_mut().find(|m| m.name == *name) {
            Some(machine) => {
                machine.busy_seconds += busy_seconds;
                machine.joules += joules;
            }
            None => machines.push(MachineStatistics {
                name: name.clone(),
                busy_seconds,
                joules,
            }),
        }
    }
    machines
}
