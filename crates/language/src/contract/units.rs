//! Units of length, time, angle and the like.
//!
//! The plant computes with real numbers in base units. A contract computes with whole numbers in
//! the unit of each declaration.

/// Dimension of a quantity. Values are stored in the base unit stated here.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Dimension {
    /// A bare number.
    None,
    /// A fraction of 1, written in `%`. It is allowed where a bare number is expected. A constant
    /// may be added to or compared with a bare one: `1 - 5 %` is 95 %. With a property it would be
    /// unclear whether 1 means 1 %, since a bare number in its declaration is in the declared unit.
    Share,
    /// Seconds.
    Time,
    /// Metres.
    Length,
    /// Degrees.
    Angle,
    /// Watts.
    Power,
    /// Joules.
    Energy,
    /// Kilograms.
    Mass,
    /// Metres per second.
    Speed,
}

impl Dimension {
    /// Returns the dimension of the product of two quantities; `None` if the language has no such
    /// dimension.
    pub fn times(self, other: Self) -> Option<Self> {
        use Dimension as D;
        match (self, other) {
            // A multiple of a share is a share.
            (D::Share, D::None) => Some(D::Share),
            (D::None | D::Share, d) | (d, D::None | D::Share) => Some(d),
            (D::Speed, D::Time) | (D::Time, D::Speed) => Some(D::Length),
            (D::Power, D::Time) | (D::Time, D::Power) => Some(D::Energy),
            _ => None,
        }
    }

    /// Returns the dimension of the quotient of two quantities; `None` if the language has no such
    /// dimension.
    pub fn divided_by(self, other: Self) -> Option<Self> {
        use Dimension as D;
        match (self, other) {
            (d, D::None) => Some(d),
            (a, b) if a == b => Some(D::None),
            (d, D::Share) => Some(d),
            (D::Length, D::Speed) | (D::Energy, D::Power) => Some(D::Time),
            (D::Length, D::Time) => Some(D::Speed),
            (D::Energy, D::Time) => Some(D::Power),
            _ => None,
        }
    }

    /// Describes the dimension in messages, with its units.
    pub fn describe(self) -> &'static str {
        match self {
            Self::None => "a bare number",
            Self::Share => "a share (`%`)",
            Self::Time => "a time (`s`, `min`, `h`, `d`)",
            Self::Length => "a length (`mm`, `m`)",
            Self::Angle => "an angle (`deg`)",
            Self::Power => "a power (`W`, `kW`)",
            Self::Energy => "an energy (`J`, `kWh`)",
            Self::Mass => "a mass (`g`, `kg`)",
            Self::Speed => "a speed (`m/s`, `mm/s`, `m/min`, `mm/min`)",
        }
    }
}

/// Returns the dimension of a unit, and the factor that converts it to the base unit. An unknown
/// name stands for a bare number.
pub(super) fn unit(name: &str) -> (Dimension, f64) {
    use Dimension as D;
    match name {
        "ms" => (D::Time, 0.001),
        "s" => (D::Time, 1.0),
        "min" => (D::Time, 60.0),
        "h" => (D::Time, 3600.0),
        "d" => (D::Time, 86_400.0),
        "mm" => (D::Length, 0.001),
        "cm" => (D::Length, 0.01),
        "m" => (D::Length, 1.0),
        "deg" => (D::Angle, 1.0),
        "rad" => (D::Angle, 180.0 / std::f64::consts::PI),
        "W" => (D::Power, 1.0),
        "kW" => (D::Power, 1000.0),
        "J" => (D::Energy, 1.0),
        "Wh" => (D::Energy, 3600.0),
        "kWh" => (D::Energy, 3.6e6),
        "g" => (D::Mass, 0.001),
        "kg" => (D::Mass, 1.0),
        "mm/s" => (D::Speed, 0.001),
        "m/s" => (D::Speed, 1.0),
        "mm/min" => (D::Speed, 0.001 / 60.0),
        "m/min" => (D::Speed, 1.0 / 60.0),
        "%" => (D::Share, 0.01),
        _ => (D::None, 1.0),
    }
}

/// Minimum duration other than 0, in seconds. The clock of a run is an `f64`. Even after
/// [`MAX_SECONDS`], it can still distinguish two instants that are this far apart.
pub const MIN_SECONDS: f64 = 1e-6;

/// Maximum duration, in seconds: about thirty years.
pub const MAX_SECONDS: f64 = 1e9;

/// Maximum power, in watts.
pub const MAX_WATTS: f64 = 1e12;

/// Returns whether this duration is allowed: 0, or from [`MIN_SECONDS`] to [`MAX_SECONDS`].
pub fn is_duration(seconds: f64) -> bool {
    seconds == 0.0 || (MIN_SECONDS..=MAX_SECONDS).contains(&seconds)
}

/// Returns whether an operation can use this energy, in joules: at most [`MAX_WATTS`] for
/// [`MAX_SECONDS`].
pub fn is_energy(joules: f64) -> bool {
    (0.0..=MAX_WATTS * MAX_SECONDS).contains(&joules)
}

/// Names of all units.
pub(super) const UNITS: &[&str] = &[
    "ms", "s", "min", "h", "d", "mm", "cm", "m", "deg", "rad", "W", "kW", "J", "Wh", "kWh", "g",
    "kg", "mm/s", "m/s", "mm/min", "m/min", "%",
];

/// Unit of a whole number in a contract.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Unit(&'static str);

impl Unit {
    /// Returns the unit with this name; `None` for an unknown name, and for `%`, which contracts do
    /// not use as a unit.
    pub fn named(name: &str) -> Option<Self> {
        let known = UNITS.iter().find(|u| **u == name && **u != "%")?;
        Some(Self(known))
    }

    /// Returns all units except `%`.
    pub fn all() -> impl Iterator<Item = Self> {
        UNITS.iter().filter(|u| **u != "%").map(|u| Self(u))
    }

    /// Returns the name as written in a file.
    pub fn name(self) -> &'static str {
        self.0
    }

    /// Returns the dimension of the unit.
    pub fn dimension(self) -> Dimension {
        unit(self.0).0
    }

    /// Returns the factor that converts this unit to the base unit.
    pub fn factor(self) -> f64 {
        unit(self.0).1
    }

    /// Returns how many of the units `other` make one of this unit; `None` if their number is not
    /// whole, or if the dimensions differ.
    pub fn in_terms_of(self, other: Self) -> Option<i64> {
        if self.dimension() == other.dimension() {
            whole(self.factor() / other.factor())
        } else {
            None
        }
    }

    /// Converts a quantity from base units to this unit; `None` if the result is not a whole
    /// number.
    pub fn count(self, base: f64) -> Option<i64> {
        whole(base / self.factor())
    }
}

/// Returns the whole number nearest to a quotient; `None` if the two differ by more than a rounding
/// error.
fn whole(x: f64) -> Option<i64> {
    let near = x.round();
    ((x - near).abs() <= 1e-9 * near.abs().max(1.0) && near.abs() < 9e15).then_some(near as i64)
}
