//! The unit in which an energy is shown, so that its digits show.

use linewright_line::metric::JOULES_PER_KWH;

/// A unit of energy.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EnergyUnit {
    /// Kilowatt hours.
    KilowattHours,
    /// Watt hours.
    WattHours,
    /// Joules.
    Joules,
}

impl EnergyUnit {
    /// The greatest unit of which this energy is at least a tenth; kilowatt hours for 0.
    pub fn of(joules: f64) -> Self {
        let units = [Self::KilowattHours, Self::WattHours];
        let fits = |unit: &Self| joules.abs() >= 0.1 * unit.joules() || joules == 0.0;
        units.into_iter().find(fits).unwrap_or(Self::Joules)
    }

    /// Its symbol.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::KilowattHours => "kWh",
            Self::WattHours => "Wh",
            Self::Joules => "J",
        }
    }

    /// Joules in one of it.
    pub fn joules(self) -> f64 {
        match self {
            Self::KilowattHours => JOULES_PER_KWH,
            Self::WattHours => 3600.0,
            Self::Joules => 1.0,
        }
    }
}

/// An energy in a unit that shows it: `1.250 kWh`, `34.700 Wh`, `8.100 J`.
pub fn energy(joules: f64) -> String {
    let unit = EnergyUnit::of(joules);
    format!("{:.3} {}", joules / unit.joules(), unit.symbol())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_energy_has_a_unit_that_shows_it() {
        for (joules, wanted) in [
            (0.0, "0.000 kWh"),
            (4.5e6, "1.250 kWh"),
            (3.6e5, "0.100 kWh"),
            (3.5e5, "97.222 Wh"),
            (360.0, "0.100 Wh"),
            (8.1, "8.100 J"),
            (0.002, "0.002 J"),
        ] {
            assert_eq!(energy(joules), wanted);
        }
    }
}
