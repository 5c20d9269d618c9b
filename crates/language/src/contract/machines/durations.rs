//! Resolution of durations, distributions and failures.

use super::settings::non_negative;
use crate::contract::distribution::{Distribution, PROBABILITY_TOLERANCE, is_shape};
use crate::contract::elaborate::{Elaborator, nearest};
use crate::contract::machine::{Between, FailureMode, InterruptedWork};
use crate::contract::scope::{duplicate_name, duplicate_statement};
use crate::contract::table;
use crate::contract::units::MAX_SECONDS;
use crate::contract::value::Dimension;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::source::Span;
use linewright_syntax::ast::{self, ExprKind, Outcome, TimeValue};

/// A distribution's name, an example, and what its parameters are.
const DISTRIBUTIONS: [(&str, &str, &str); 13] = [
    ("constant", "constant(2 s)", "the duration"),
    ("uniform", "uniform(1 s, 3 s)", "minimum, maximum"),
    (
        "triangular",
        "triangular(1 s, 2 s, 4 s)",
        "minimum, most likely, maximum",
    ),
    ("normal", "normal(10 s, 2 s)", "mean, standard deviation"),
    (
        "lognormal",
        "lognormal(10 s, 2 s)",
        "mean, standard deviation",
    ),
    ("exponential", "exponential(10 s)", "mean"),
    ("erlang", "erlang(3, 10 s)", "number of stages, mean"),
    ("gamma", "gamma(2, 5 s)", "shape, scale"),
    ("weibull", "weibull(1.5, 8 h)", "shape, scale"),
    (
        "beta",
        "beta(2, 3, 1 s, 4 s)",
        "two shapes, minimum, maximum",
    ),
    (
        "pert",
        "pert(1 s, 2 s, 4 s)",
        "minimum, most likely, maximum",
    ),
    (
        "discrete",
        "discrete(2 s: 90 %, 30 s: 10 %)",
        "values with their probabilities",
    ),
    (
        "empirical",
        "empirical(\"times.csv\" column duration in s)",
        "a column of a CSV file, and the unit of its numbers",
    ),
];

/// Maximum number of stages of an Erlang distribution.
const MAX_STAGES: i64 = 10_000;

/// Resolves a duration. A bare value is constant.
pub(in crate::contract) fn duration<'a>(
    e: &mut Elaborator<'a>,
    written: &'a TimeValue,
) -> Option<Distribution> {
    match written {
        TimeValue::Value(value) => single(e, value).map(Distribution::Constant),
        TimeValue::Drawn {
            name,
            outcomes,
            span,
        } => drawn(e, name, outcomes, *span, Dimension::Time),
        TimeValue::Empirical { column, .. } => table::empirical(e, column),
    }
}

/// Resolves a duration whose bare value is the mean of an exponential distribution.
pub(in crate::contract) fn random_duration<'a>(
    e: &mut Elaborator<'a>,
    written: &'a TimeValue,
) -> Option<Distribution> {
    match written {
        TimeValue::Value(value) => single(e, value).map(|mean| Distribution::Exponential { mean }),
        TimeValue::Drawn { .. } | TimeValue::Empirical { .. } => duration(e, written),
    }
}

/// Resolves one value. A call of an unknown function was probably meant as a distribution.
fn single<'a>(e: &mut Elaborator<'a>, value: &'a ast::Expr) -> Option<f64> {
    if let ExprKind::Call(name, _) = &value.kind
        && !["min", "max", "abs"].contains(&name.text.as_str())
    {
        if let Some((_, example, parameters)) =
            DISTRIBUTIONS.iter().find(|(word, ..)| *word == name.text)
        {
            e.findings.error_with(
                codes::ARGUMENT,
                value.span,
                format!("`{}` does not take these parameters", name.text),
                format!("write `{example}`: {parameters}"),
            );
            return None;
        }
        let known = DISTRIBUTIONS.iter().map(|(word, ..)| *word);
        let help = match nearest(&name.text, known.clone()) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!(
                "the distributions are {}",
                known.collect::<Vec<_>>().join(", ")
            ),
        };
        e.findings.error_with(
            codes::NAME_UNKNOWN,
            name.span,
            format!("there is no distribution `{}`", name.text),
            help,
        );
        return None;
    }
    non_negative(e, value, Dimension::Time)
}

/// Resolves a distribution of durations, or of numbers without a unit.
fn drawn<'a>(
    e: &mut Elaborator<'a>,
    name: &ast::Name,
    outcomes: &'a [Outcome],
    span: Span,
    dimension: Dimension,
) -> Option<Distribution> {
    let word = name.text.as_str();
    let known = DISTRIBUTIONS.iter().find(|(known, ..)| *known == word);
    let help = match known {
        Some((_, example, parameters)) if dimension == Dimension::Time => {
            format!("write `{example}`: {parameters}")
        }
        Some((_, example, parameters)) => {
            let example = example.replace(" s", "").replace(" h", "");
            format!("write `{example}`: {parameters}")
        }
        None => String::new(),
    };
    if word == "discrete" {
        return discrete(e, outcomes, span, help, dimension);
    }
    if let Some(weight) = outcomes.iter().find_map(|o| o.weight.as_ref()) {
        e.findings.error_with(
            codes::ARGUMENT,
            weight.span,
            format!("`{word}` takes no probabilities"),
            help,
        );
        return None;
    }
    let values: Vec<&'a ast::Expr> = outcomes.iter().map(|o| &o.value).collect();
    let wanted = match word {
        "constant" | "exponential" => 1,
        "triangular" | "pert" => 3,
        "beta" => 4,
        _ => 2,
    };
    if values.len() != wanted {
        e.findings.error_with(
            codes::ARGUMENT,
            span,
            format!(
                "`{word}` takes {wanted} parameter{}, not {}",
                if wanted == 1 { "" } else { "s" },
                values.len()
            ),
            help,
        );
        return None;
    }
    let shapes = match word {
        "gamma" | "weibull" => 1,
        "beta" => 2,
        _ => 0,
    };
    if word == "erlang" {
        let stages = e.constant_int(values[0]);
        let mean = non_negative(e, values[1], dimension);
        let stages = stages?;
        if !(1..=MAX_STAGES).contains(&stages) {
            e.findings.error_with(
                codes::ARGUMENT,
                values[0].span,
                format!("the number of stages must be from 1 to {MAX_STAGES}"),
                help,
            );
            return None;
        }
        return Some(Distribution::Erlang {
            stages: stages as u32,
            mean: mean?,
        });
    }
    // The first wrong parameter is reported: the others are often wrong in the same way.
    let mut numbers = Vec::new();
    for (at, value) in values.iter().enumerate() {
        numbers.push(if at < shapes {
            shape(e, value)?
        } else {
            non_negative(e, value, dimension)?
        });
    }
    let distribution = match (word, numbers.as_slice()) {
        ("constant", &[value]) => Distribution::Constant(value),
        ("exponential", &[mean]) => Distribution::Exponential { mean },
        ("uniform", &[low, high]) => Distribution::Uniform { low, high },
        ("normal", &[mean, deviation]) => Distribution::Normal { mean, deviation },
        ("lognormal", &[mean, deviation]) => Distribution::Lognormal { mean, deviation },
        ("gamma", &[shape, scale]) => Distribution::Gamma { shape, scale },
        ("weibull", &[shape, scale]) => Distribution::Weibull { shape, scale },
        ("triangular", &[low, mode, high]) => Distribution::Triangular { low, mode, high },
        ("pert", &[low, mode, high]) => Distribution::Pert { low, mode, high },
        ("beta", &[alpha, beta, low, high]) => Distribution::Beta {
            alpha,
            beta,
            low,
            high,
        },
        _ => return None,
    };
    let bounds = match &distribution {
        Distribution::Uniform { .. }
        | Distribution::Triangular { .. }
        | Distribution::Pert { .. }
        | Distribution::Beta { .. } => &numbers[shapes..],
        _ => &[],
    };
    if !bounds.is_sorted() {
        e.findings.error_with(
            codes::ARGUMENT,
            span,
            format!(
                "the {} of `{word}` must be in order, the {} first",
                if dimension == Dimension::Time {
                    "durations"
                } else {
                    "numbers"
                },
                if dimension == Dimension::Time {
                    "shortest"
                } else {
                    "smallest"
                },
            ),
            help,
        );
        return None;
    }
    if matches!(distribution, Distribution::Lognormal { mean, .. } if mean == 0.0) {
        e.findings.error_with(
            codes::ARGUMENT,
            values[0].span,
            "the mean of a lognormal distribution must be greater than 0",
            help,
        );
        return None;
    }
    Some(distribution)
}

fn shape<'a>(e: &mut Elaborator<'a>, value: &'a ast::Expr) -> Option<f64> {
    let number = non_negative(e, value, Dimension::None)?;
    if !is_shape(number) {
        e.findings.error_with(
            codes::ARGUMENT,
            value.span,
            "the shape of a distribution must be from 0.01 to 10000",
            "the greater the shape, the less the values differ",
        );
        return None;
    }
    Some(number)
}

fn discrete<'a>(
    e: &mut Elaborator<'a>,
    outcomes: &'a [Outcome],
    span: Span,
    help: String,
    dimension: Dimension,
) -> Option<Distribution> {
    let mut resolved = Vec::new();
    for Outcome { value, weight } in outcomes {
        let seconds = non_negative(e, value, dimension);
        let Some(weight) = weight else {
            e.findings.error_with(
                codes::ARGUMENT,
                value.span,
                "this value has no probability",
                help.clone(),
            );
            continue;
        };
        resolved.push(seconds.zip(non_negative(e, weight, Dimension::None)));
    }
    if resolved.len() < outcomes.len() {
        return None;
    }
    let resolved: Vec<(f64, f64)> = resolved.into_iter().collect::<Option<_>>()?;
    let total: f64 = resolved.iter().map(|(_, p)| p).sum();
    if (total - 1.0).abs() > PROBABILITY_TOLERANCE {
        let percent = (total * 1e8).round() / 1e6;
        e.findings.error_with(
            codes::ARGUMENT,
            span,
            format!("the probabilities add up to {percent} %, not to 100 %"),
            help,
        );
        return None;
    }
    Some(Distribution::Discrete(resolved))
}

/// Resolves the failure modes of a machine or a station. Each mode but one must have a name, and no
/// two have the same.
pub(in crate::contract) fn failures<'a>(
    e: &mut Elaborator<'a>,
    written: &[&'a ast::Failures],
) -> Vec<FailureMode> {
    let mut modes = Vec::new();
    for (at, mode) in written.iter().enumerate() {
        let same = |first: &&&ast::Failures| {
            first.name.as_ref().map(|n| &n.text) == mode.name.as_ref().map(|n| &n.text)
        };
        if let Some(first) = written[..at].iter().find(same) {
            let finding = match (&mode.name, &first.name) {
                (Some(name), Some(first)) => duplicate_name(name, first.span),
                _ => duplicate_statement(
                    "failures",
                    mode.span,
                    first.span,
                    "remove one of the two, or give the failure modes names: `failures jam: mtbf 2 h mttr 5 min`",
                ),
            };
            e.findings.push(finding);
        }
        modes.extend(failure_mode(e, mode));
    }
    modes
}

fn failure_mode<'a>(e: &mut Elaborator<'a>, mode: &'a ast::Failures) -> Option<FailureMode> {
    let between = match &mode.between {
        ast::Between::Time(time) => {
            let between = random_duration(e, time);
            if between.as_ref().is_some_and(|b| !b.takes_time()) {
                e.findings.error_with(
                    codes::ARGUMENT,
                    time.span(),
                    "the time between failures must be longer than 0",
                    "remove `failures` if the machine never fails",
                );
                None
            } else if mode.calendar {
                between.map(Between::Calendar)
            } else {
                between.map(Between::Working)
            }
        }
        ast::Between::Parts(count) => {
            check_parts_mode(e, mode);
            if *count == 0 {
                refuse_no_parts(e, mode.span);
                None
            } else {
                Some(Between::Parts(*count))
            }
        }
        ast::Between::DrawnParts(written) => {
            check_parts_mode(e, mode);
            drawn_parts(e, written).map(Between::DrawnParts)
        }
    };
    let repair = random_duration(e, &mode.mttr);
    Some(FailureMode {
        name: mode
            .name
            .as_ref()
            .map_or_else(String::new, |n| n.text.clone()),
        between: between?,
        repair: repair?,
        interrupted: mode.interrupted,
    })
}

/// Checks the words of a failure mode that goes by a number of parts.
fn check_parts_mode(e: &mut Elaborator<'_>, mode: &ast::Failures) {
    if mode.calendar {
        e.findings.error_with(
            codes::ARGUMENT,
            mode.span,
            "failures after a number of parts do not go by the calendar",
            "remove `by calendar`",
        );
    }
    if mode.interrupted != InterruptedWork::Resumes {
        let message = "a failure after a number of parts interrupts no work, since it comes when the work on a part ends";
        e.findings.push(
            Diagnostic::warning(codes::UNUSED, mode.span, message)
                .with_help("remove `restart` or `scrap`"),
        );
    }
}

fn refuse_no_parts(e: &mut Elaborator<'_>, span: Span) {
    e.findings.error_with(
        codes::ARGUMENT,
        span,
        "there must be at least 1 part between two failures",
        "remove `failures` if the machine never fails",
    );
}

/// Resolves the distribution of a number of parts.
fn drawn_parts<'a>(e: &mut Elaborator<'a>, written: &'a TimeValue) -> Option<Distribution> {
    let TimeValue::Drawn {
        name,
        outcomes,
        span,
    } = written
    else {
        return None;
    };
    let count = drawn(e, name, outcomes, *span, Dimension::None)?;
    if count.is_zero() {
        refuse_no_parts(e, *span);
        return None;
    }
    if !count.is_valid() {
        e.findings.error_with(
            codes::ARGUMENT,
            *span,
            "these are more parts than a run supports",
            format!("write numbers up to {MAX_SECONDS:e}"),
        );
        return None;
    }
    if count.mean_at_most() < 1.0 {
        e.findings.error_with(
            codes::ARGUMENT,
            *span,
            "this is less than 1 part between two failures on average, but at least 1 part is between them",
            "write numbers of parts, such as `every exponential(500) parts`; `every 1 part` fails after each part",
        );
        return None;
    }
    Some(count)
}
