//! What a run measures, and requirements and reports speak of.
//!
//! Names, units and words of all measures stand in one table, [`MEASURES`]. The runner has the
//! values.

use super::value::Dimension;
use std::ops::Range;

/// Something that a run measures, about the whole line, an end product, or a place.
#[derive(Debug, Clone, PartialEq)]
pub struct Metric {
    /// What is measured.
    pub measure: Measure,
    /// The places (node indices) whose mean it is; empty if it is not about places.
    pub nodes: Range<usize>,
    /// The end product (index of a part type) that it is about; `None` for all of them.
    pub product: Option<usize>,
    /// Which percentile it is, from 1 to 99. Without meaning for other measures.
    pub percentile: u8,
}

impl From<Measure> for Metric {
    /// A metric of the whole line. A percentile is the one in [`MEASURES`].
    fn from(measure: Measure) -> Self {
        Self {
            measure,
            nodes: 0..0,
            product: None,
            percentile: TABLE_PERCENTILE,
        }
    }
}

impl Metric {
    /// Name in the language, without what it is about: `lead_time_p90`.
    pub fn name(&self) -> String {
        let name = self.measure.info().name;
        match name.strip_suffix("95") {
            Some(stem) => format!("{stem}{}", self.percentile),
            None => name.to_owned(),
        }
    }

    /// Words of the table about the measure, with the number of the percentile.
    pub fn words(&self, of_measure: &str) -> String {
        of_measure.replace("95th", &ordinal(self.percentile))
    }
}

/// The percentile that stands in [`MEASURES`] for all of them.
const TABLE_PERCENTILE: u8 = 95;

/// `21st`, `95th`.
fn ordinal(number: u8) -> String {
    let ending = match (number / 10 % 10, number % 10) {
        (1, _) => "th",
        (_, 1) => "st",
        (_, 2) => "nd",
        (_, 3) => "rd",
        _ => "th",
    };
    format!("{number}{ending}")
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
    /// A percentile of the lead time.
    LeadTimePercentile,
    /// Maximum of the lead time.
    LeadTimeMax,
    /// Mean number of parts in the line.
    Wip,
    /// Maximum number of parts in the line.
    WipMax,
    /// Energy of the whole line, or of a station or conveyor.
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
    /// Overall equipment effectiveness of a station: the product of the three measures that follow.
    Oee,
    /// Time in work of a station, divided by its planned time.
    Availability,
    /// Planned time of the completed work of a station, divided by its time in work.
    Effectiveness,
    /// Share of a station's parts that were not rejected because of it.
    Quality,
    /// Mean number of parts in a buffer or on a conveyor.
    Length,
    /// Maximum number of parts in a buffer or on a conveyor.
    LengthMax,
    /// Share of the time in which a buffer is full.
    Full,
    /// Mean time of a part in a buffer, until it leaves or expires.
    Wait,
    /// A percentile of the time of a part in a buffer.
    WaitPercentile,
    /// Maximum time of a part in a buffer.
    WaitMax,
    /// Number of parts that expired in a buffer.
    Expired,
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
    /// A conveyor.
    Conveyor,
    /// A source.
    Source,
}

impl PlaceKind {
    /// The word in the language.
    pub fn word(self) -> &'static str {
        match self {
            Self::Station => "station",
            Self::Buffer => "buffer",
            Self::Conveyor => "conveyor",
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
    /// Whether it can be about the whole line.
    pub of_line: bool,
    /// Whether it can be about one end product.
    pub of_product: bool,
    /// Kinds of places that it can be about.
    pub places: &'static [PlaceKind],
    /// Unit of its values.
    pub unit: MeasureUnit,
    /// Name with unit, for tables. The name of the place follows, after `of` if it can also be
    /// about the line. In the words of percentiles, `95th` stands for the number.
    pub label: &'static str,
    /// Subject of a sentence, with the same rules.
    pub subject: &'static str,
    /// Why there is no value in some runs; `None` if there always is one.
    pub absent: Option<&'static str>,
}

/// All measures, in the order of [`Measure`].
pub const MEASURES: [MeasureInfo; 34] = {
    use Measure as M;
    use MeasureUnit::{KilowattHours, Number, PerHour, Seconds, Share};
    use PlaceKind::{Buffer, Conveyor, Source, Station};
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
            of_line: true,
            of_product: false,
            places: &[],
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
    const fn or_product(info: MeasureInfo) -> MeasureInfo {
        MeasureInfo {
            of_product: true,
            ..info
        }
    }
    const fn of_place(places: &'static [PlaceKind], info: MeasureInfo) -> MeasureInfo {
        MeasureInfo {
            of_line: false,
            places,
            ..info
        }
    }
    const fn of_work(info: MeasureInfo) -> MeasureInfo {
        MeasureInfo {
            absent: Some("it finished no part"),
            ..of_place(&[Station], info)
        }
    }
    const fn of_departures(info: MeasureInfo) -> MeasureInfo {
        MeasureInfo {
            absent: Some("no part left it"),
            ..info
        }
    }
    [
        or_product(of_line(
            M::Throughput,
            "throughput",
            PerHour,
            "throughput per hour",
            "the throughput in products an hour",
        )),
        or_product(of_line(
            M::ThroughputOnShift,
            "throughput_on_shift",
            PerHour,
            "throughput per hour on shift",
            "the throughput in products an hour on shift",
        )),
        of_products(of_line(
            M::Makespan,
            "makespan",
            Seconds,
            "makespan in s",
            "the makespan in seconds",
        )),
        or_product(of_products(of_line(
            M::LeadTime,
            "lead_time",
            Seconds,
            "mean lead time in s",
            "the mean lead time in seconds",
        ))),
        or_product(of_products(of_line(
            M::LeadTimeMedian,
            "lead_time_median",
            Seconds,
            "median lead time in s",
            "the median lead time in seconds",
        ))),
        or_product(of_products(of_line(
            M::LeadTimePercentile,
            "lead_time_p95",
            Seconds,
            "95th percentile of lead time in s",
            "the 95th percentile of the lead time in seconds",
        ))),
        or_product(of_products(of_line(
            M::LeadTimeMax,
            "lead_time_max",
            Seconds,
            "maximum lead time in s",
            "the maximum lead time in seconds",
        ))),
        of_line(M::Wip, "wip", Number, "mean WIP", "the mean WIP in parts"),
        of_line(
            M::WipMax,
            "wip_max",
            Number,
            "maximum WIP",
            "the maximum WIP in parts",
        ),
        MeasureInfo {
            places: &[Station, Conveyor],
            ..of_line(
                M::Energy,
                "energy",
                KilowattHours,
                "energy in kWh",
                "the energy in kWh",
            )
        },
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
        or_product(of_parts(of_line(
            M::FirstPassYield,
            "first_pass_yield",
            Share,
            "first-pass yield",
            "the first-pass yield",
        ))),
        or_product(of_parts(of_line(
            M::Scrap,
            "scrap",
            Share,
            "scrap",
            "the share of scrap",
        ))),
        or_product(of_line(
            M::Products,
            "products",
            Number,
            "products",
            "the number of products",
        )),
        of_line(
            M::Violations,
            "violations",
            Number,
            "violations",
            "the number of contract violations",
        ),
        of_place(
            &[Station],
            of_line(M::Busy, "busy", Share, "busy share of", "the busy share of"),
        ),
        of_place(
            &[Station],
            of_line(
                M::Starved,
                "starved",
                Share,
                "starved share of",
                "the starved share of",
            ),
        ),
        of_place(
            &[Station],
            of_line(
                M::Blocked,
                "blocked",
                Share,
                "blocked share of",
                "the blocked share of",
            ),
        ),
        of_place(
            &[Station],
            of_line(
                M::Failed,
                "failed",
                Share,
                "failed share of",
                "the failed share of",
            ),
        ),
        of_place(
            &[Station],
            of_line(
                M::Setup,
                "setup",
                Share,
                "setup share of",
                "the setup share of",
            ),
        ),
        of_place(
            &[Station],
            of_line(M::Idle, "idle", Share, "idle share of", "the idle share of"),
        ),
        of_work(of_line(M::Oee, "oee", Share, "OEE of", "the OEE of")),
        of_work(of_line(
            M::Availability,
            "availability",
            Share,
            "availability of",
            "the availability of",
        )),
        of_work(of_line(
            M::Effectiveness,
            "effectiveness",
            Share,
            "effectiveness of",
            "the effectiveness of",
        )),
        of_work(of_line(
            M::Quality,
            "quality",
            Share,
            "quality of",
            "the quality of",
        )),
        of_place(
            &[Buffer, Conveyor],
            of_line(
                M::Length,
                "length",
                Number,
                "mean length of",
                "the mean number of parts in",
            ),
        ),
        of_place(
            &[Buffer, Conveyor],
            of_line(
                M::LengthMax,
                "length_max",
                Number,
                "maximum length of",
                "the maximum number of parts in",
            ),
        ),
        of_place(
            &[Buffer],
            of_line(M::Full, "full", Share, "full share of", "the full share of"),
        ),
        of_departures(of_place(
            &[Buffer],
            of_line(
                M::Wait,
                "wait",
                Seconds,
                "mean wait in s in",
                "the mean wait in seconds in",
            ),
        )),
        of_departures(of_place(
            &[Buffer],
            of_line(
                M::WaitPercentile,
                "wait_p95",
                Seconds,
                "95th percentile of wait in s in",
                "the 95th percentile of the wait in seconds in",
            ),
        )),
        of_departures(of_place(
            &[Buffer],
            of_line(
                M::WaitMax,
                "wait_max",
                Seconds,
                "maximum wait in s in",
                "the maximum wait in seconds in",
            ),
        )),
        of_place(
            &[Buffer],
            of_line(
                M::Expired,
                "expired",
                Number,
                "expired parts in",
                "the number of expired parts in",
            ),
        ),
        of_departures(of_place(
            &[Source],
            of_line(M::Lost, "lost", Share, "lost share of", "the lost share of"),
        )),
    ]
};

impl Measure {
    /// The metric of these places (node indices).
    pub fn at(self, nodes: Range<usize>) -> Metric {
        Metric {
            nodes,
            ..self.into()
        }
    }

    /// The metric of an end product (index of the part type).
    pub fn of(self, product: usize) -> Metric {
        Metric {
            product: Some(product),
            ..self.into()
        }
    }

    /// Description of the measure.
    pub fn info(self) -> &'static MeasureInfo {
        &MEASURES[self as usize]
    }

    /// Whether it is a percentile, so that a metric says which.
    pub fn is_percentile(self) -> bool {
        matches!(self, Self::LeadTimePercentile | Self::WaitPercentile)
    }

    /// The measure with this name in the language, and which percentile it is.
    pub fn named(name: &str) -> Option<(Self, u8)> {
        let named = |name: &str| {
            let found = MEASURES.iter().find(|info| info.name == name);
            found.map(|info| info.measure)
        };
        let digits = name.trim_start_matches(|c: char| !c.is_ascii_digit());
        let stem = &name[..name.len() - digits.len()];
        if digits.is_empty() || digits.starts_with('0') {
            return named(name).map(|measure| (measure, TABLE_PERCENTILE));
        }
        let percentile = digits.parse().ok().filter(|p| (1..=99).contains(p))?;
        Some((named(&format!("{stem}{TABLE_PERCENTILE}"))?, percentile))
    }
}

impl MeasureInfo {
    /// How the language writes it: `energy`, `energy(station)`, `energy(conveyor)`.
    pub fn forms(&self) -> Vec<String> {
        let alone = self.of_line.then(|| self.name.to_owned());
        let product = self.of_product.then_some("product");
        let about = product
            .into_iter()
            .chain(self.places.iter().map(|place| place.word()));
        let about = about.map(|word| format!("{}({word})", self.name));
        alone.into_iter().chain(about).collect()
    }

    /// What it can be about: `station or conveyor`.
    pub fn about(&self) -> String {
        let words: Vec<&str> = self.places.iter().map(|place| place.word()).collect();
        words.join(" or ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_has_the_order_of_the_measures() {
        for (index, info) in MEASURES.iter().enumerate() {
            assert_eq!(info.measure as usize, index, "{}", info.name);
            assert_eq!(Measure::named(info.name), Some((info.measure, 95)));
            assert_eq!(Metric::from(info.measure).name(), info.name);
        }
    }

    #[test]
    fn a_percentile_has_its_number_in_its_name() {
        let (measure, percentile) = Measure::named("wait_p52").unwrap();
        assert_eq!((measure, percentile), (Measure::WaitPercentile, 52));
        let metric = Metric {
            percentile,
            ..measure.at(0..1)
        };
        assert_eq!(metric.name(), "wait_p52");
        let label = metric.words(measure.info().label);
        assert_eq!(label, "52nd percentile of wait in s in");
        for wrong in [
            "wait_p0",
            "wait_p05",
            "wait_p100",
            "wait_p",
            "wip95",
            "wait_95",
        ] {
            assert_eq!(Measure::named(wrong), None, "{wrong}");
        }
    }
}
