//! What a run measures, and requirements and reports speak of.
//!
//! Names, units and words of all measures stand in one table, [`MEASURES`]. The runner has the
//! values.

use super::value::Dimension;
use std::ops::Range;

/// Something that a run measures, about the whole line or about a place.
#[derive(Debug, Clone, PartialEq)]
pub struct Metric {
    /// What is measured.
    pub measure: Measure,
    /// The places (node indices) whose mean it is; empty if it is about the whole line.
    pub nodes: Range<usize>,
}

impl From<Measure> for Metric {
    /// A metric of the whole line.
    fn from(measure: Measure) -> Self {
        Self {
            measure,
            nodes: 0..0,
        }
    }
}

/// What is measured. [`Measure::info`] describes each.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Measure {
    /// End products per hour that arrive in a sink or store.
    Throughput,
    /// End products per hour of working time; per hour if the line has no calendar.
    ThroughputOnShift,
    /// Time from the start to the last end product.
    Makespan,
    /// Mean lead time: from when the product's first part leaves its source to when the product
    /// arrives in its sink or store.
    LeadTime,
    /// Median of the lead time.
    LeadTimeMedian,
    /// 95th percentile of the lead time.
    LeadTimeP95,
    /// Maximum of the lead time.
    LeadTimeMax,
    /// Mean number of parts in the line.
    Wip,
    /// Maximum number of parts in the line.
    WipMax,
    /// Energy of the whole line.
    Energy,
    /// Energy of the whole line, divided by the number of end products.
    EnergyPerProduct,
    /// Number of rejected parts.
    Rejected,
    /// Share of the parts that left the line good at the first pass.
    FirstPassYield,
    /// Share of the parts that left the line as scrap.
    Scrap,
    /// Number of end products.
    Products,
    /// Number of contract violations.
    Violations,
    /// Share of the time in which a station works.
    Busy,
    /// Share of the time in which a station waits for parts.
    Starved,
    /// Share of the time in which a station waits for room.
    Blocked,
    /// Share of the time in which a station is broken down.
    Failed,
    /// Share of the time in which a station is set up.
    Setup,
    /// Share of the time in which a station is off shift.
    Idle,
    /// Overall equipment effectiveness of a station.
    Oee,
    /// Mean number of parts in a buffer.
    Length,
    /// Maximum number of parts in a buffer.
    LengthMax,
    /// Share of the time in which a buffer is full.
    Full,
    /// Mean time of a part in a buffer.
    Wait,
    /// Maximum time of a part in a buffer.
    WaitMax,
    /// Share of a source's parts that found no room.
    Lost,
}

/// Kind of place that a measure is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PlaceKind {
    /// A station.
    Station,
    /// A buffer.
    Buffer,
    /// A source.
    Source,
}

impl PlaceKind {
    /// The word in the language.
    pub fn word(self) -> &'static str {
        match self {
            Self::Station => "station",
            Self::Buffer => "buffer",
            Self::Source => "source",
        }
    }
}

/// Unit in which a value is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum MeasureUnit {
    /// Products an hour.
    PerHour,
    /// Seconds.
    Seconds,
    /// Kilowatt hours.
    KilowattHours,
    /// A number of things.
    Number,
    /// A share from 0 to 1.
    Share,
}

impl MeasureUnit {
    /// Dimension of a bound in the language.
    pub(super) fn dimension(self) -> Dimension {
        match self {
            Self::Seconds => Dimension::Time,
            Self::KilowattHours => Dimension::Energy,
            Self::PerHour | Self::Number | Self::Share => Dimension::None,
        }
    }

    /// Base units of the dimension in one of this unit.
    pub fn in_base_units(self) -> f64 {
        match self {
            Self::KilowattHours => 3.6e6,
            Self::PerHour | Self::Seconds | Self::Number | Self::Share => 1.0,
        }
    }

    /// The greatest possible value, if there is one. The least is 0.
    pub fn greatest(self) -> Option<f64> {
        (self == Self::Share).then_some(1.0)
    }
}

/// Description of a measure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MeasureInfo {
    /// The measure.
    pub measure: Measure,
    /// Name in the language.
    pub name: &'static str,
    /// Kind of place that it is about; `None` if it is about the whole line.
    pub place: Option<PlaceKind>,
    /// Unit of its values.
    pub unit: MeasureUnit,
    /// Name with unit, for tables. The name of the place follows.
    pub label: &'static str,
    /// Subject of a sentence. The name of the place follows.
    pub subject: &'static str,
    /// Why there is no value in some runs; `None` if there always is one.
    pub absent: Option<&'static str>,
}

/// All measures, in the order of [`Measure`].
pub const MEASURES: [MeasureInfo; 29] = {
    use Measure as M;
    use MeasureUnit::{KilowattHours, Number, PerHour, Seconds, Share};
    use PlaceKind::{Buffer, Source, Station};
    const fn of_line(
        measure: Measure,
        name: &'static str,
        unit: MeasureUnit,
        label: &'static str,
        subject: &'static str,
    ) -> MeasureInfo {
        MeasureInfo {
            measure,
            name,
            place: None,
            unit,
            label,
            subject,
            absent: None,
        }
    }
    const fn of_products(info: MeasureInfo) -> MeasureInfo {
        MeasureInfo {
            absent: Some("no product was finished"),
            ..info
        }
    }
    const fn of_parts(info: MeasureInfo) -> MeasureInfo {
        MeasureInfo {
            absent: Some("no part left the line"),
            ..info
        }
    }
    const fn of_place(place: PlaceKind, info: MeasureInfo) -> MeasureInfo {
        MeasureInfo {
            place: Some(place),
            ..info
        }
    }
    const fn of_departures(info: MeasureInfo) -> MeasureInfo {
        MeasureInfo {
            absent: Some("no part left it"),
            ..info
        }
    }
    [
        of_line(
            M::Throughput,
            "throughput",
            PerHour,
            "throughput per hour",
            "the throughput in products an hour",
        ),
        of_line(
            M::ThroughputOnShift,
            "throughput_on_shift",
            PerHour,
            "throughput per hour on shift",
            "the throughput in products an hour on shift",
        ),
        of_products(of_line(
            M::Makespan,
            "makespan",
            Seconds,
            "makespan in s",
            "the makespan in seconds",
        )),
        of_products(of_line(
            M::LeadTime,
            "lead_time",
            Seconds,
            "mean lead time in s",
            "the mean lead time in seconds",
        )),
        of_products(of_line(
            M::LeadTimeMedian,
            "lead_time_median",
            Seconds,
            "median lead time in s",
            "the median lead time in seconds",
        )),
        of_products(of_line(
            M::LeadTimeP95,
            "lead_time_p95",
            Seconds,
            "95th percentile of lead time in s",
            "the 95th percentile of the lead time in seconds",
        )),
        of_products(of_line(
            M::LeadTimeMax,
            "lead_time_max",
            Seconds,
            "maximum lead time in s",
            "the maximum lead time in seconds",
        )),
        of_line(M::Wip, "wip", Number, "mean WIP", "the mean WIP in parts"),
        of_line(
            M::WipMax,
            "wip_max",
            Number,
            "maximum WIP",
            "the maximum WIP in parts",
        ),
        of_line(
            M::Energy,
            "energy",
            KilowattHours,
            "energy in kWh",
            "the energy in kWh",
        ),
        of_products(of_line(
            M::EnergyPerProduct,
            "energy_per_product",
            KilowattHours,
            "energy per product in kWh",
            "the energy per product in kWh",
        )),
        of_line(
            M::Rejected,
            "rejected",
            Number,
            "rejected parts",
            "the number of rejected parts",
        ),
        of_parts(of_line(
            M::FirstPassYield,
            "first_pass_yield",
            Share,
            "first-pass yield",
            "the first-pass yield",
        )),
        of_parts(of_line(
            M::Scrap,
            "scrap",
            Share,
            "scrap",
            "the share of scrap",
        )),
        of_line(
            M::Products,
            "products",
            Number,
            "products",
            "the number of products",
        ),
        of_line(
            M::Violations,
            "violations",
            Number,
            "violations",
            "the number of contract violations",
        ),
        of_place(
            Station,
            of_line(M::Busy, "busy", Share, "busy share of", "the busy share of"),
        ),
        of_place(
            Station,
            of_line(
                M::Starved,
                "starved",
                Share,
                "starved share of",
                "the starved share of",
            ),
        ),
        of_place(
            Station,
            of_line(
                M::Blocked,
                "blocked",
                Share,
                "blocked share of",
                "the blocked share of",
            ),
        ),
        of_place(
            Station,
            of_line(
                M::Failed,
                "failed",
                Share,
                "failed share of",
                "the failed share of",
            ),
        ),
        of_place(
            Station,
            of_line(
                M::Setup,
                "setup",
                Share,
                "setup share of",
                "the setup share of",
            ),
        ),
        of_place(
            Station,
            of_line(M::Idle, "idle", Share, "idle share of", "the idle share of"),
        ),
        MeasureInfo {
            absent: Some("it finished no part"),
            ..of_place(
                Station,
                of_line(M::Oee, "oee", Share, "OEE of", "the OEE of"),
            )
        },
        of_place(
            Buffer,
            of_line(
                M::Length,
                "length",
                Number,
                "mean length of",
                "the mean number of parts in",
            ),
        ),
        of_place(
            Buffer,
            of_line(
                M::LengthMax,
                "length_max",
                Number,
                "maximum length of",
                "the maximum number of parts in",
            ),
        ),
        of_place(
            Buffer,
            of_line(M::Full, "full", Share, "full share of", "the full share of"),
        ),
        of_departures(of_place(
            Buffer,
            of_line(
                M::Wait,
                "wait",
                Seconds,
                "mean wait in s in",
                "the mean wait in seconds in",
            ),
        )),
        of_departures(of_place(
            Buffer,
            of_line(
                M::WaitMax,
                "wait_max",
                Seconds,
                "maximum wait in s in",
                "the maximum wait in seconds in",
            ),
        )),
        of_departures(of_place(
            Source,
            of_line(M::Lost, "lost", Share, "lost share of", "the lost share of"),
        )),
    ]
};

impl Measure {
    /// The metric of these places (node indices).
    pub fn at(self, nodes: Range<usize>) -> Metric {
        Metric {
            measure: self,
            nodes,
        }
    }

    /// Description of the measure.
    pub fn info(self) -> &'static MeasureInfo {
        &MEASURES[self as usize]
    }

    /// The measure with this name in the language.
    pub fn named(name: &str) -> Option<Self> {
        let found = MEASURES.iter().find(|info| info.name == name);
        found.map(|info| info.measure)
    }
}

impl MeasureInfo {
    /// How the language writes it: `busy(station)`.
    pub fn syntax(&self) -> String {
        match self.place {
            Some(place) => format!("{}({})", self.name, place.word()),
            None => self.name.to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_has_the_order_of_the_measures() {
        for (index, info) in MEASURES.iter().enumerate() {
            assert_eq!(info.measure as usize, index, "{}", info.name);
            assert_eq!(Measure::named(info.name), Some(info.measure));
        }
    }
}
