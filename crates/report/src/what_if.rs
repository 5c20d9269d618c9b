//! A line and a variant of it, as text and as a part of the JSON document of a run.

use super::columns::columns;
use super::intervals::{interval, shown_in};
use super::json::{estimate, round};
use linewright_language::contract::metric::Measure;
use linewright_line::comparison::Comparison;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// What differs in the variant.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Variant {
    /// Name, if there are several variants; empty otherwise.
    pub name: String,
    /// Numbers that are set, by name.
    pub set: BTreeMap<String, String>,
    /// What these numbers are in the line as it is, as far as this is known: `50 s per step`.
    pub as_it_is: BTreeMap<String, String>,
    /// Stations that work faster: 1.1 for 10 % faster, less than 1 for slower.
    pub speeds: BTreeMap<String, f64>,
}

impl Variant {
    /// What it is called in a table.
    pub fn label(&self) -> &str {
        if self.name.is_empty() {
            "what if"
        } else {
            &self.name
        }
    }
}

/// Returns the changes and the differences as text that ends with a line break.
pub fn what_if_table(variant: &Variant, comparisons: &[Comparison]) -> String {
    let mut out = String::from("\n");
    if !variant.name.is_empty() {
        let _ = writeln!(out, "  {:<12} {}", "variant", variant.name);
    }
    for (name, value) in &variant.set {
        let _ = writeln!(out, "  {:<12} {name} = {value}", "what if");
    }
    for (name, speed) in &variant.speeds {
        let percent = ((speed - 1.0).abs() * 1e4).round() / 100.0;
        let word = if *speed < 1.0 { "slower" } else { "faster" };
        let _ = writeln!(
            out,
            "  {:<12} {name} works {percent} % {word} (its times are divided by {})",
            "what if",
            round(*speed, 4)
        );
    }
    let shown = comparisons.iter().filter(|c| !is_unused_energy(c));
    let rows: Vec<Vec<String>> = shown.map(row).collect();
    let pairs = comparisons.iter().map(|c| c.pairs).max().unwrap_or(0);
    let title = format!("same seeds, {pairs} pairs");
    columns(
        &mut out,
        &[
            &title,
            "as it is",
            variant.label(),
            "difference",
            "from",
            "to",
            "more than noise",
        ],
        &rows,
    );
    out
}

/// Whether it compares the energy of a line that uses none.
fn is_unused_energy(comparison: &Comparison) -> bool {
    let of_energy = matches!(
        comparison.measure,
        Measure::Energy | Measure::EnergyPerProduct
    );
    of_energy && comparison.as_it_is == 0.0 && comparison.what_if == 0.0
}

fn row(comparison: &Comparison) -> Vec<String> {
    let label = comparison.measure.info().label.to_owned();
    let greatest = comparison.as_it_is.max(comparison.what_if);
    let (label, scale) = shown_in(comparison.measure, label, greatest);
    let difference = comparison.difference.scaled(scale);
    let [difference, from, to] = interval(Some(difference), 3);
    let significant = match comparison.is_significant() {
        Some(true) => "yes",
        Some(false) => "no",
        None => "-",
    };
    vec![
        label,
        format!("{:.3}", comparison.as_it_is * scale),
        format!("{:.3}", comparison.what_if * scale),
        difference,
        from,
        to,
        significant.to_owned(),
    ]
}

/// Returns the `what_if` object of the document of a run.
pub fn what_if_json(variant: &Variant, comparisons: &[Comparison]) -> Value {
    let measures: Vec<Value> = comparisons
        .iter()
        .map(|c| {
            json!({
                "name": c.measure.info().name,
                "pairs": c.pairs,
                "as_it_is": round(c.as_it_is, 9),
                "what_if": round(c.what_if, 9),
                "difference": estimate(Some(c.difference), 9),
                "more_than_noise": c.is_significant(),
            })
        })
        .collect();
    let mut document = json!({
        "set": variant.set,
        "speeds": variant.speeds,
        "confidence": 0.95,
        "measures": measures,
    });
    if !variant.name.is_empty() {
        document["name"] = json!(variant.name);
    }
    document
}
