//! `run --what-if NAME=VALUE`: what differs in a variant of the line.

use crate::contract::line::Line;
use crate::contract::set::{SettableNumber, Setting};
use crate::engine::speed;
use crate::report::Variant;
use std::collections::BTreeMap;

/// Number of pairs of runs if `--replications` does not say it.
pub const DEFAULT_PAIRS: u64 = 10;

/// Why options are refused.
#[derive(Debug)]
pub enum Refused {
    /// They make no sense, for this reason.
    Usage(String),
    /// Both change the speed of a station.
    Repeated(Box<(Setting, Setting)>),
}

impl From<String> for Refused {
    fn from(message: String) -> Self {
        Self::Usage(message)
    }
}

/// What differs in a variant of a line.
#[derive(Debug, Default)]
pub struct Changes {
    /// Numbers of the variant: those of `--set` that stay, and those of `--what-if`.
    pub set: Vec<Setting>,
    /// The variant in words.
    pub variant: Variant,
    /// By node: how many times as fast the station works.
    pub speeds: BTreeMap<usize, f64>,
}

impl Changes {
    /// Reads the options of all variants, in the order in which they are first named: those that
    /// begin with the same name, as in `fast: press=10%`, make one, and so do those without a name.
    ///
    /// # Errors
    /// Returns a reason as [`Changes::new`] does, or if a name is empty.
    pub fn variants(
        what_if: &[Setting],
        set: &[Setting],
        line: &Line,
    ) -> Result<Vec<Self>, Refused> {
        let mut named: Vec<(String, Vec<Setting>)> = Vec::new();
        for change in what_if {
            let (variant, change) = change.split_variant();
            let name = variant.unwrap_or_default();
            if variant.is_some_and(str::is_empty) || change.name().is_empty() {
                return Err(Refused::Usage(format!(
                    "`{}={}`: write the name of a variant, `:` and a number, such as `fast: capper.takes='2 s'`",
                    change.name(),
                    change.value()
                )));
            }
            match named.iter_mut().find(|(known, _)| known == name) {
                Some((_, changes)) => changes.push(change),
                None => named.push((name.to_owned(), vec![change])),
            }
        }
        let are_several = named.len() > 1;
        let variants = named.into_iter().map(|(name, what_if)| {
            let mut changes = Self::new(&what_if, set, line)?;
            changes.variant.name = if name.is_empty() && are_several {
                "what if".to_owned()
            } else {
                name
            };
            Ok(changes)
        });
        variants.collect()
    }

    /// Notes what the numbers of the variant are in the line as it is: as `set` for the run, or as
    /// in the file.
    pub fn compare_numbers(&mut self, set: &BTreeMap<&str, &str>, numbers: &[SettableNumber]) {
        for name in self.variant.set.keys() {
            let mut known = numbers.iter();
            let number = known.find(|number| number.names.contains(name));
            let in_file = number.and_then(|number| number.value.as_deref());
            let Some(value) = set.get(name.as_str()).copied().or(in_file) else {
                continue;
            };
            let per_step = if number.is_some_and(|number| number.per_step) {
                " per step"
            } else {
                ""
            };
            let value = format!("{value}{per_step}");
            self.variant.as_it_is.insert(name.clone(), value);
        }
    }

    /// Reads the options of one variant. `NAME=10%` with the name of a station makes it 10 %
    /// faster; everything else is set as by `--set`, and replaces a number that `--set` has set by
    /// the same name.
    ///
    /// # Errors
    /// Returns a reason if a percentage is not greater than -100 %, or has no `%`, or if a station
    /// has two.
    fn new(what_if: &[Setting], set: &[Setting], line: &Line) -> Result<Self, Refused> {
        let mut changes = Self::default();
        let mut changed: BTreeMap<usize, &Setting> = BTreeMap::new();
        let mut numbers = Vec::new();
        for change in what_if {
            let (name, value) = (change.name(), change.value());
            let stations = speed::stations_named(line, name);
            if !stations.is_empty() && value.parse::<f64>().is_ok() {
                return Err(Refused::Usage(format!(
                    "`{name}={value}`: write `{name}={value}%` if the station is to be {value} % faster, or set one of its numbers, such as `{name}.takes='{value} s'`"
                )));
            }
            let Some(percent) = value.strip_suffix('%').filter(|_| !stations.is_empty()) else {
                changes
                    .variant
                    .set
                    .insert(name.to_owned(), value.to_owned());
                numbers.push(change.clone().given_by("--what-if"));
                continue;
            };
            let speed = percent.trim().parse::<f64>().ok().map(|p| 1.0 + p / 100.0);
            let speed = speed
                .filter(|speed| (1e-3..=1e3).contains(speed))
                .ok_or_else(|| {
                    format!(
                        "`{name}={value}`: write by how many percent the station is faster, such as `{name}=10%`, or slower, such as `{name}=-10%`"
                    )
                })?;
            for node in stations {
                if let Some(first) = changed.insert(node, change) {
                    let both = [first, change].map(|of| of.clone().given_by("--what-if"));
                    let [first, second] = both;
                    return Err(Refused::Repeated(Box::new((first, second))));
                }
                changes.speeds.insert(node, speed);
            }
            changes.variant.speeds.insert(name.to_owned(), speed);
        }
        let stays = |setting: &&Setting| !changes.variant.set.contains_key(setting.name());
        changes.set = set.iter().filter(stays).cloned().collect();
        changes.set.extend(numbers);
        Ok(changes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_variant_knows_the_numbers_of_the_line() {
        let number = |names: &[&str], value: Option<&str>, per_step| SettableNumber {
            names: names.iter().map(|name| (*name).to_owned()).collect(),
            value: value.map(str::to_owned),
            per_step,
            place: None,
        };
        let numbers = [
            number(&["printer.time", "printer.layers.time"], Some("50 s"), true),
            number(&["belt.speed"], Some("0.2 m/s"), false),
            number(&["belt.power"], None, false),
        ];
        let mut changes = Changes::default();
        for name in ["printer.layers.time", "belt.speed", "belt.power"] {
            let value = "1".to_owned();
            changes.variant.set.insert(name.to_owned(), value);
        }
        changes.compare_numbers(&[("belt.speed", "0.3 m/s")].into(), &numbers);
        let known = changes.variant.as_it_is.into_iter();
        let known: Vec<String> = known
            .map(|(name, value)| format!("{name} {value}"))
            .collect();
        assert_eq!(
            known,
            ["belt.speed 0.3 m/s", "printer.layers.time 50 s per step"]
        );
    }
}
