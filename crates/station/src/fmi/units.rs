//! Units of measurement in FMI: a factor and exponents of the base units.

/// Definition of a unit: the exponents of the base units, as attributes, and a factor.
pub(super) struct Definition {
    pub exponents: &'static [(&'static str, &'static str)],
    pub factor: f64,
}

/// Returns the FMI definition of a unit of measurement; `None` if the unit is unknown. The model
/// description then contains only its name.
pub(super) fn definition(unit: &str) -> Option<Definition> {
    const TIME: &[(&str, &str)] = &[("s", "1")];
    const LENGTH: &[(&str, &str)] = &[("m", "1")];
    const ANGLE: &[(&str, &str)] = &[("rad", "1")];
    const MASS: &[(&str, &str)] = &[("kg", "1")];
    const SPEED: &[(&str, &str)] = &[("m", "1"), ("s", "-1")];
    const POWER: &[(&str, &str)] = &[("kg", "1"), ("m", "2"), ("s", "-3")];
    const ENERGY: &[(&str, &str)] = &[("kg", "1"), ("m", "2"), ("s", "-2")];
    let (exponents, factor) = match unit {
        "ms" => (TIME, 0.001),
        "s" => (TIME, 1.0),
        "min" => (TIME, 60.0),
        "h" => (TIME, 3600.0),
        "d" => (TIME, 86_400.0),
        "mm" => (LENGTH, 0.001),
        "cm" => (LENGTH, 0.01),
        "m" => (LENGTH, 1.0),
        "deg" => (ANGLE, std::f64::consts::PI / 180.0),
        "rad" => (ANGLE, 1.0),
        "W" => (POWER, 1.0),
        "kW" => (POWER, 1000.0),
        "J" => (ENERGY, 1.0),
        "Wh" => (ENERGY, 3600.0),
        "kWh" => (ENERGY, 3.6e6),
        "g" => (MASS, 0.001),
        "kg" => (MASS, 1.0),
        "mm/s" => (SPEED, 0.001),
        "m/s" => (SPEED, 1.0),
        "mm/min" => (SPEED, 0.001 / 60.0),
        "m/min" => (SPEED, 1.0 / 60.0),
        "%" => (&[][..], 0.01),
        _ => return None,
    };
    Some(Definition { exponents, factor })
}
