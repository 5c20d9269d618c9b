//! Messages of a controller: one wording for the emitted C and for the interpreter.
//!
//! Texts about formulas are fixed when the machine is emitted. Texts that contain a value are
//! assembled by `ffi/step.c` from the same pieces.

use super::{CallError, ErrorCode};
use linewright_core::gr1::Formula;
use linewright_language::contract::machine::{
    Component, Machine, PlantInput, PlantSource, RealExpr, Role,
};
use linewright_language::contract::{MAX_SECONDS, is_energy};
use linewright_language::order::lower::{INITIAL_SUFFIX, rule_name as order_rule};

/// Maximum number of characters of a formula in a message.
const MAX_FORMULA_CHARS: usize = 200;

/// The party that has to keep a formula.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Party {
    /// The plant, which has to keep assumptions.
    Plant,
    /// The machine, which has to keep guarantees.
    Machine,
    /// The caller of skills, inside or outside the machine, who has to keep orders.
    Caller,
}

impl Party {
    /// The party that has to keep a component's assumptions.
    pub fn of_assumptions(component: &Component) -> Self {
        match component.role {
            Role::Watch => Self::Caller,
            Role::Coordinator | Role::Action => Self::Plant,
        }
    }
}

/// Returns a rule's name, component first: `turn: gripped`. The formulas of an order for step 0 and
/// for later steps get the same name.
pub fn rule_name(component: &Component, formula: &Formula) -> String {
    let name = match component.role {
        Role::Watch => without_step_suffix(&formula.name),
        Role::Coordinator | Role::Action => &formula.name,
    };
    format!("{}: {name}", component.name)
}

fn without_step_suffix(name: &str) -> &str {
    name.strip_suffix(INITIAL_SUFFIX).unwrap_or(name)
}

/// Describes a violated formula: ``turn: the plant broke the assumption `gripped`: command =
/// turn -> grip``, or for an order ``PickAndPlace: the order `trays` is broken: after Down until
/// Up: never Left, Right``.
pub fn describe_violation(component: &Component, formula: &Formula, party: Party) -> String {
    let what = match party {
        Party::Plant => "the plant broke the assumption",
        Party::Machine => "the machine broke the guarantee",
        Party::Caller => {
            return format!(
                "{}: {} is broken: {}",
                component.name,
                order(formula),
                cut(&formula.text)
            );
        }
    };
    format!("{}: {what} {}", component.name, cite(formula))
}

/// Describes a justice assumption that did not hold before the step limit: ``the assumption `free`
/// of `turn` has not held: always eventually free``.
pub fn describe_unmet_justice(component: &Component, formula: &Formula) -> String {
    format!(
        "{} has not held: {}",
        describe_assumption(component, formula),
        cut(&formula.text)
    )
}

/// Describes a component's assumption: ``the assumption `gripped` of `turn` `` or ``the
/// order `trays` ``.
pub fn describe_assumption(component: &Component, formula: &Formula) -> String {
    match Party::of_assumptions(component) {
        Party::Caller => order(formula),
        Party::Plant | Party::Machine => {
            format!("the assumption {} of `{}`", name(formula), component.name)
        }
    }
}

/// Cites the order that a formula belongs to: ``the order `trays` (R-7)``. A rule that belongs to
/// no declared order is cited by its own name.
fn order(formula: &Formula) -> String {
    let requirement = formula.requirement.as_deref();
    match order_rule(&formula.name) {
        Some(declared) => format!("the order {}", named(declared, requirement)),
        None => named(without_step_suffix(&formula.name), requirement),
    }
}

fn cite(formula: &Formula) -> String {
    format!("{}: {}", name(formula), cut(&formula.text))
}

/// Cites a formula by its name and requirement: `` `gripped` (R-12)``.
fn name(formula: &Formula) -> String {
    named(&formula.name, formula.requirement.as_deref())
}

fn named(name: &str, requirement: Option<&str>) -> String {
    match requirement {
        Some(requirement) => format!("`{name}` ({requirement})"),
        None => format!("`{name}`"),
    }
}

fn cut(text: &str) -> String {
    match text.char_indices().nth(MAX_FORMULA_CHARS) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    }
}

/// Returns the beginning of a message about a failed property abstraction: ``property `angle`:
/// plant input `cell` ``.
pub fn abstraction_prefix(machine: &Machine, input: &PlantInput) -> String {
    let mut names: Vec<&str> = Vec::new();
    if let PlantSource::Property(expr) = &input.source {
        for_each_property(expr, &mut |i| {
            let name = machine.properties[i].name.as_str();
            if !names.contains(&name) {
                names.push(name);
            }
        });
    }
    let quoted: Vec<String> = names.iter().map(|n| format!("`{n}`")).collect();
    let about = match quoted.len() {
        0 => String::new(),
        1 => format!("property {}: ", quoted[0]),
        _ => format!("properties {}: ", quoted.join(", ")),
    };
    format!("{about}plant input `{}`", input.name)
}

fn for_each_property(expr: &RealExpr, visit: &mut impl FnMut(usize)) {
    match expr {
        RealExpr::Number(_) | RealExpr::Wire(_) => {}
        RealExpr::Property(i) => visit(*i),
        RealExpr::Unary(_, a) => for_each_property(a, visit),
        RealExpr::Binary(_, a, b) => {
            for_each_property(a, visit);
            for_each_property(b, visit);
        }
        RealExpr::If(c, a, b) => {
            for_each_property(c, visit);
            for_each_property(a, visit);
            for_each_property(b, visit);
        }
    }
}

/// Formats a number with up to six decimals, without trailing zeros. `lw_write_real` in
/// `ffi/step.c` writes the same text.
fn real(value: f64) -> String {
    if value.is_nan() || value.abs() >= 1e12 {
        return "out of range".to_owned();
    }
    let millionths = (value.abs() * 1e6).round() as i64;
    let (whole, part) = (millionths / 1_000_000, millionths % 1_000_000);
    let sign = if value < 0.0 && millionths != 0 {
        "-"
    } else {
        ""
    };
    let decimals = format!(".{part:06}");
    format!("{sign}{whole}{}", decimals.trim_end_matches(['0', '.']))
}

impl CallError {
    fn plain(code: ErrorCode, message: String) -> Self {
        Self {
            code,
            rule: None,
            message,
        }
    }

    pub(super) fn operation(index: usize) -> Self {
        Self::plain(
            ErrorCode::Operation,
            format!("there is no operation {index}"),
        )
    }

    pub(super) fn value_count() -> Self {
        Self::plain(
            ErrorCode::Argument,
            "the property values are missing, or their number differs from the machine's number of properties".to_owned(),
        )
    }

    pub(super) fn plant_count() -> Self {
        Self::plain(
            ErrorCode::Argument,
            "the plant values are missing, or their number differs from the machine's number of plant inputs"
                .to_owned(),
        )
    }

    pub(super) fn output_count() -> Self {
        Self::plain(
            ErrorCode::Argument,
            "the size of the output array differs from the machine's number of outputs".to_owned(),
        )
    }

    pub(super) fn plant_domain(name: &str, value: i64, domain: &str) -> Self {
        Self::plain(
            ErrorCode::Domain,
            format!("plant input `{name}` is {value}, outside its domain {domain}"),
        )
    }

    pub(super) fn input_domain(component: &str, name: &str, value: i64, domain: &str) -> Self {
        Self::plain(
            ErrorCode::Domain,
            format!("{component}: input `{name}` is {value}, outside its domain {domain}"),
        )
    }

    pub(super) fn formula(component: &Component, formula: &Formula, party: Party) -> Self {
        Self {
            code: match party {
                Party::Plant => ErrorCode::Assumption,
                Party::Machine => ErrorCode::Guarantee,
                Party::Caller => ErrorCode::Order,
            },
            rule: Some(rule_name(component, formula)),
            message: describe_violation(component, formula, party),
        }
    }

    pub(super) fn no_transition(component: &str) -> Self {
        Self::plain(
            ErrorCode::Internal,
            format!(
                "{component}: there is no transition for inputs that keep the assumptions; please report this"
            ),
        )
    }

    /// Error for a Moore component that has no outputs in its current state. A verified table has a
    /// row for every input that keeps the assumptions, so no input keeps them in this state.
    pub(super) fn no_legal_inputs(component: &str) -> Self {
        Self::plain(
            ErrorCode::Assumption,
            format!("{component}: its assumptions contradict each other here: no inputs keep them"),
        )
    }

    pub(super) fn property_not_finite(name: &str) -> Self {
        Self::plain(
            ErrorCode::Domain,
            format!("property `{name}` is not a finite number"),
        )
    }

    pub(super) fn abstraction(machine: &Machine, input: &PlantInput, value: f64) -> Self {
        Self::plain(
            ErrorCode::Domain,
            format!(
                "{} would be {}, not an integer of {}",
                abstraction_prefix(machine, input),
                real(value),
                input.describe()
            ),
        )
    }

    pub(super) fn power(component: &str) -> Self {
        Self::plain(
            ErrorCode::Domain,
            format!("{component}: its power is not a finite number"),
        )
    }

    pub(super) fn time(component: &str) -> Self {
        Self::plain(
            ErrorCode::Domain,
            format!("{component}: its time is not a finite number of at least 0"),
        )
    }

    /// Returns an error if a run of a line cannot record an operation's duration and energy: if the
    /// duration is outside 0 to [`MAX_SECONDS`], or the energy is negative or not finite.
    pub fn check_measurable(seconds: f64, joules: f64) -> Option<Self> {
        let sound = (0.0..=MAX_SECONDS).contains(&seconds) && is_energy(joules);
        (!sound).then(|| {
            Self::plain(
                ErrorCode::Domain,
                format!("the operation took {seconds} s and {joules} J: a run records at most {MAX_SECONDS:e} s and no negative energy"),
            )
        })
    }

    pub(super) fn write(property: &str) -> Self {
        Self::plain(
            ErrorCode::Domain,
            format!("property `{property}` would get a value that is not a finite number"),
        )
    }

    pub(super) fn write_range(property: &str) -> Self {
        Self::plain(
            ErrorCode::Domain,
            format!("property `{property}` would get a value outside its range"),
        )
    }

    /// `longest` is the justice assumption that has not held for the longest time, with its
    /// component and the number of steps.
    pub(super) fn limit(
        operation: &str,
        steps: u64,
        longest: Option<(&Component, &Formula, u64)>,
    ) -> Self {
        let begin = format!("`{operation}` did not end within {steps} steps");
        match longest {
            // In the last step, each of them held.
            None | Some((_, _, 0)) => Self::plain(ErrorCode::Limit, begin),
            Some((component, formula, silence)) => Self {
                code: ErrorCode::Limit,
                rule: Some(rule_name(component, formula)),
                message: format!(
                    "{begin}; for {silence} step{} {}",
                    if silence == 1 { "" } else { "s" },
                    describe_unmet_justice(component, formula)
                ),
            },
        }
    }
}

/// Formats an action count with its noun: `1 action`, `2 actions`.
pub fn format_action_count(count: usize) -> String {
    match count {
        1 => "1 action".to_owned(),
        _ => format!("{count} actions"),
    }
}

#[cfg(test)]
mod tests {
    use super::real;

    #[test]
    fn numbers_have_no_needless_digits() {
        let cases = [
            (0.0, "0"),
            (-0.0, "0"),
            (1.5, "1.5"),
            (-2.25, "-2.25"),
            (100.0, "100"),
            (1e-9, "0"),
            (0.000_001, "0.000001"),
            (1e15, "out of range"),
            (f64::NAN, "out of range"),
        ];
        for (value, text) in cases {
            assert_eq!(real(value), text);
        }
    }
}
