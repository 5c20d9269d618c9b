//! Suggested changes of a contract in words, by kind.

use super::document::ContractEntry;
use crate::contract::Contract;
use crate::engine::findings::lost::{Change, Suggestion};
use crate::game::{Advice, NewAssumption, Weakening};
use crate::gr1::text::text;
use crate::gr1::{BinaryOp, Expr, FormulaKind, Specification};
use crate::report::html::parts::{self, table_of, with_code};
use maud::{Markup, html};

/// The changes that would make a contract realizable, in one table for each kind.
pub(super) fn section(contract: &Contract, advice: &Advice, entry: &ContractEntry) -> Markup {
    let readings = readings(&contract.specification, advice);
    let suggestions: Vec<(&Suggestion, String)> = entry.suggestions.iter().zip(readings).collect();
    let of_kind = |kind: Change| suggestions.iter().filter(move |(s, _)| s.kind == kind);
    let kinds = [
        (
            Change::Assume,
            "Assume more, if it is true of your plant: one of these is enough",
        ),
        (Change::Weaken, "Require less: one of these is enough"),
    ];
    let has_shares = entry.suggestions.iter().any(|of| of.cost.contains('%'));
    html! {
        h4 { "Changes that would make it realizable" }
        @if has_shares { p { "Combinations of values are those of all signals in one step and in the next. All of them count equally, however often the plant would do them." } }
        @for (kind, heading) in kinds { @if of_kind(kind).next().is_some() {
            h5 { (heading) }
            (table_of("Changes", &["In words", "Line to write", "Cost"], &html! {
                @for (change, reading) in of_kind(kind) { tr {
                    td { (with_code(reading)) }
                    td { (parts::formula(&change.text)) }
                    td { (change.cost) }
                } }
            }))
        } }
    }
}

/// A reading of each suggestion, in the order of the suggestions: new assumptions, weaker
/// guarantees, guarantees to leave out.
fn readings(specification: &Specification, advice: &Advice) -> Vec<String> {
    let assumed = advice.assumptions.iter();
    let assumed = assumed.map(|new| assumption(specification, new));
    let weaker = advice.weakenings.iter();
    let weaker = weaker.map(|weakening| weaker_guarantee(specification, weakening));
    let left_out = (!advice.leave_out.is_empty())
        .then(|| "Leave these guarantees out, or repair one and check again.".to_owned());
    assumed.chain(weaker).chain(left_out).collect()
}

fn assumption(specification: &Specification, new: &NewAssumption) -> String {
    format!(
        "Assume that {}.",
        holds(specification, new.kind, &new.formula)
    )
}

fn weaker_guarantee(specification: &Specification, weakening: &Weakening) -> String {
    let name = &weakening.guarantee.formula(&specification.guarantees).name;
    match &weakening.unless {
        None => format!("Do without `{name}`."),
        Some(unless) => format!(
            "Keep `{name}`, except where `{}` holds.",
            text(specification, unless)
        ),
    }
}

/// When a formula holds, in words.
fn holds(specification: &Specification, kind: FormulaKind, formula: &Expr) -> String {
    let shown = |formula: &Expr| format!("`{}`", text(specification, formula));
    let whole = shown(formula);
    match (kind, formula) {
        (FormulaKind::Initial, _) => format!("{whole} holds at the start"),
        (FormulaKind::Justice, _) => {
            format!("{whole} comes again and again, however long it takes each time")
        }
        (FormulaKind::Invariant | FormulaKind::Safety, Expr::Binary(BinaryOp::Implies, a, b)) => {
            format!("whenever {} holds, {} holds too", shown(a), shown(b))
        }
        (FormulaKind::Invariant, _) => format!("{whole} holds in every step"),
        (FormulaKind::Safety, _) => format!("{whole} holds from every step to the next"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gr1::{Domain, Owner, Side, Time, Timing, VarId, Variable};
    use crate::source::{SourceMap, Span};

    #[test]
    fn an_assumption_is_read_by_its_kind() {
        let mut sources = SourceMap::default();
        let file = sources.add("a.lw", "");
        let variable = |name: &str| Variable {
            name: name.to_owned(),
            owner: Owner::Environment,
            internal: false,
            domain: Domain::Bool,
            unit: String::new(),
            span: Span::new(file, 0, 0),
        };
        let specification = Specification {
            name: "Clamp".to_owned(),
            timing: Timing::Mealy,
            variables: vec![variable("door"), variable("shut")],
            assumptions: Side::default(),
            guarantees: Side::default(),
        };
        let [door, shut] = [0, 1].map(|index| Expr::Var(VarId(index), Time::Now));
        let read = |kind, formula: &Expr| holds(&specification, kind, formula);
        assert_eq!(
            read(FormulaKind::Justice, &shut),
            "`shut` comes again and again, however long it takes each time"
        );
        assert_eq!(
            read(FormulaKind::Initial, &door),
            "`door` holds at the start"
        );
        assert_eq!(
            read(FormulaKind::Invariant, &door.clone().implies(shut.clone())),
            "whenever `door` holds, `shut` holds too"
        );
        assert_eq!(
            read(FormulaKind::Safety, &door.and(shut)),
            "`door and shut` holds from every step to the next"
        );
    }
}
