//! `run --what-if NAME=VALUE`: what differs in a variant of the line.

use crate::contract::line::Line;
use crate::contract::set::{SettableNumber, Setting};
use crate::diagnostics::Diagnostic;
use crate::engine::speed;
use crate::report::Variant;
use crate::source::SourceMap;
use std::collections::BTreeMap;
use std::ops::RangeInclusive;

/// How many times as fast a station can be made.
const SPEEDS: RangeInclusive<f64> = 1e-3..=1e3;

/// Number of pairs of runs if `--replications` does not say it.
pub const DEFAULT_PAIRS: u64 = 10;

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
    /// Options become sources if something is wrong with them.
    ///
    /// # Errors
    /// Returns a finding for each percentage that is not greater than -100 %, or has no `%`, for
    /// each station that has two in one variant, and for each empty name.
    pub fn variants(
        what_if: &[Setting],
        set: &[Setting],
        line: &Line,
        sources: &mut SourceMap,
    ) -> Result<Vec<Self>, Vec<Diagnostic>> {
        let mut named: Vec<(String, Vec<Setting>)> = Vec::new();
        let mut findings = Vec::new();
        for whole in what_if {
            let (variant, change) = whole.split_variant();
            let name = variant.unwrap_or_default();
            if variant.is_some_and(str::is_empty) || change.name().is_empty() {
                findings.push(
                    whole
                        .wrong_name(sources, "the name of a variant, or of a number, is missing")
                        .with_help("write the name of a variant, `:` and a number, such as `fast: capper.takes='2 s'`"),
                );
                continue;
            }
            let change = change.given_by("--what-if");
            match named.iter_mut().find(|(known, _)| known == name) {
                Some((_, changes)) => changes.push(change),
                None => named.push((name.to_owned(), vec![change])),
            }
        }
        let are_several = named.len() > 1;
        let variants = named.into_iter().map(|(name, what_if)| {
            let mut changes = Self::new(&what_if, set, line, sources, &mut findings);
            changes.variant.name = if name.is_empty() && are_several {
                "what if".to_owned()
            } else {
                name
            };
            changes
        });
        let variants = variants.collect();
        if findings.is_empty() {
            Ok(variants)
        } else {
            Err(findings)
        }
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
    fn new(
        what_if: &[Setting],
        set: &[Setting],
        line: &Line,
        sources: &mut SourceMap,
        findings: &mut Vec<Diagnostic>,
    ) -> Self {
        let mut changes = Self::default();
        let mut changed: BTreeMap<usize, &Setting> = BTreeMap::new();
        let mut numbers = Vec::new();
        for change in what_if {
            let (name, value) = (change.name(), change.value());
            let stations = speed::stations_named(line, name);
            if !stations.is_empty() && value.parse::<f64>().is_ok() {
                findings.push(
                    change
                        .wrong_value(sources, format!("`{value}` is not a percentage"))
                        .with_help(format!(
                            "write `{name}={value}%` if the station is to be {value} % faster, or set one of its numbers, such as `{name}.takes='{value} s'`"
                        )),
                );
                continue;
            }
            let percent = value.strip_suffix('%');
            if stations.is_empty() && percent.is_some() && line.nodes.iter().any(|n| n.name == name)
            {
                findings.push(
                    change
                        .wrong_name(sources, &format!("`{name}` is no station, so it does not work faster"))
                        .with_help("only stations work faster; set a number of it, or the speed of a station"),
                );
                continue;
            }
            let Some(percent) = percent.filter(|_| !stations.is_empty()) else {
                changes
                    .variant
                    .set
                    .insert(name.to_owned(), value.to_owned());
                numbers.push(change.clone());
                continue;
            };
            let speed = percent.trim().parse::<f64>().ok().map(|p| 1.0 + p / 100.0);
            let Some(speed) = speed.filter(|speed| SPEEDS.contains(speed)) else {
                findings.push(
                    change
                        .wrong_value(sources, format!("`{value}` is not a percentage from -99.9 % to 99,900 %"))
                        .with_help(format!(
                            "write by how many percent the station is faster, such as `{name}=10%`, or slower, such as `{name}=-10%`"
                        )),
                );
                continue;
            };
            let mut nodes = stations.iter();
            if let Some(first) = nodes.find_map(|node| changed.insert(*node, change)) {
                findings.push(change.repeats(first, sources));
            }
            for node in stations {
                changed.insert(node, change);
                changes.speeds.insert(node, speed);
            }
            changes.variant.speeds.insert(name.to_owned(), speed);
        }
        let stays = |setting: &&Setting| !changes.variant.set.contains_key(setting.name());
        changes.set = set.iter().filter(stays).cloned().collect();
        changes.set.extend(numbers);
        changes
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
