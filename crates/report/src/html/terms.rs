//! The list of terms and signs at the end of a page, with those that the page uses.

use super::parts::section;
use maud::{Markup, html};

/// The anchor and the heading of the list, for the links of a page.
pub const LINK: (&str, &str) = ("terms", "Terms and notation");

/// Where a page has to use a term, so that it is listed.
#[derive(Debug, Clone, Copy)]
enum Use {
    /// As a word of a formula.
    Word(&'static str),
    /// As signs of a formula.
    Sign(&'static str),
    /// In a sentence, or as part of a name.
    Text(&'static str),
}

/// Terms with what they mean, in the order of the list.
const TERMS: [(Use, &str, &str); 32] = [
    (
        Use::Text("plant"),
        "plant",
        "everything outside the controller: the process, its sensors, and the people at it",
    ),
    (
        Use::Text("counterstrategy"),
        "counterstrategy",
        "a strategy of the plant that keeps the assumptions and makes every controller break a guarantee",
    ),
    (
        Use::Text("induction"),
        "induction",
        "proof step by step: a rule holds in step 0, and in each later step if all rules held before; for a rule about step 0, the first part is enough",
    ),
    (
        Use::Text("justice"),
        "justice",
        "a rule of the form `always eventually p`",
    ),
    (
        Use::Text("discharged"),
        "discharged",
        "an assumption or a guarantee is discharged if the proof shows that it holds",
    ),
    (
        Use::Text("obligation"),
        "obligation",
        "what a proof has to show: an assumption of a component, or a guarantee of a contract that a machine refines",
    ),
    (
        Use::Text("refines"),
        "refines",
        "a machine refines a contract if its components together keep the guarantees as long as the contract's assumptions hold",
    ),
    (
        Use::Text("environment"),
        "environment",
        "everything outside a machine: its plant and its callers",
    ),
    (
        Use::Text("caller"),
        "caller",
        "a station of a line that asks a machine for an operation (a call); the check of a line examines all its calls: one that breaks a rule is a finding, and what could not be examined is listed as not decided",
    ),
    (
        Use::Text("composition"),
        "composition",
        "all components of a machine together, with the wires between them",
    ),
    (
        Use::Text("coordinator"),
        "coordinator",
        "the component of a machine that decides which of the others work",
    ),
    (Use::Sign("->"), "p -> q", "if p holds, q holds"),
    (Use::Sign("<->"), "p <-> q", "p holds exactly if q holds"),
    (Use::Word("xor"), "p xor q", "exactly one of p and q holds"),
    (Use::Word("in"), "x in {a, b}", "x is one of these values"),
    (Use::Word("always"), "always p", "p holds in every step"),
    (
        Use::Word("eventually"),
        "always eventually p",
        "p holds again and again, without end",
    ),
    (Use::Word("never"), "never p", "p holds in no step"),
    (Use::Word("next"), "next x", "x in the next step"),
    (
        Use::Word("previous"),
        "previous p",
        "p held in the step before; false in step 0",
    ),
    (
        Use::Word("once"),
        "once p",
        "p holds in this step or held in an earlier one",
    ),
    (
        Use::Word("historically"),
        "historically p",
        "p holds in this step and held in all earlier ones",
    ),
    (
        Use::Word("since"),
        "p since q",
        "q has held, and p in every step after the last q",
    ),
    (
        Use::Word("responds"),
        "q responds to p",
        "after each p there is a q, in the same step or later",
    ),
    (
        Use::Word("precedes"),
        "p precedes q",
        "q holds in no step before the first p",
    ),
    (
        Use::Word("within"),
        "within n steps",
        "at most n steps later, or with `once` or `historically`, earlier",
    ),
    (
        Use::Word("forall"),
        "forall i in D: p",
        "p holds for every i of D",
    ),
    (
        Use::Word("exists"),
        "exists i in D: p",
        "p holds for at least one i of D",
    ),
    (
        Use::Word("count"),
        "count i in D: p",
        "for how many i of D p holds",
    ),
    (
        Use::Word("sum"),
        "sum i in D: x",
        "the sum of x over all i of D",
    ),
    (
        Use::Word("mod"),
        "x mod n",
        "the remainder of x divided by n",
    ),
    (
        Use::Text("[i = "),
        "rule [i = 0]",
        "a rule with `forall i` stands for one rule for each value of i; this is the one for 0",
    ),
];

/// The section with the terms that are used above it; nothing if there are none.
pub fn terms(above: &Markup) -> Markup {
    let used = used(&above.0);
    if used.is_empty() {
        return html! {};
    }
    let inside = html! {
        details {
            summary { "Show what words and signs on this page mean" }
            dl.notation { @for (term, meaning) in used {
                dt { (term) }
                dd { (super::parts::with_code(meaning)) }
            } }
        }
    };
    section(LINK.0, LINK.1, &inside)
}

/// The terms that a page uses, given as HTML.
fn used(html: &str) -> Vec<(&'static str, &'static str)> {
    let (text, code) = texts(html);
    let is_word = |wanted: &str| {
        let mut words = code.split(|c: char| !(c.is_alphanumeric() || c == '_'));
        words.any(|word| word == wanted)
    };
    // The longer sign has the shorter one in it.
    let alone = code.replace("<->", " ");
    let is_sign = |wanted: &str| match wanted {
        "->" => alone.contains(wanted),
        _ => code.contains(wanted),
    };
    let terms = TERMS.into_iter().filter(|(place, ..)| match place {
        Use::Word(word) => is_word(word),
        Use::Sign(sign) => is_sign(sign),
        Use::Text(words) => text.contains(words),
    });
    terms.map(|(_, term, meaning)| (term, meaning)).collect()
}

/// The text of a page without its elements: all of it, and that of formulas.
fn texts(html: &str) -> (String, String) {
    let (mut text, mut code) = (String::new(), String::new());
    let mut depth = 0_usize;
    for (index, piece) in html.split('<').enumerate() {
        let (element, inside) = match piece.split_once('>') {
            Some(parts) if index > 0 => parts,
            _ => ("", piece),
        };
        match element {
            "/code" => {
                depth = depth.saturating_sub(1);
                code.push(' ');
            }
            _ if element.split(' ').next() == Some("code") => depth += 1,
            _ => {}
        }
        text.push_str(inside);
        if depth > 0 {
            code.push_str(inside);
        }
    }
    let plain = |html: String| {
        let html = html.replace("&lt;", "<").replace("&gt;", ">");
        html.replace("&quot;", "\"").replace("&amp;", "&")
    };
    (plain(text), plain(code))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::html::parts::formula;

    #[test]
    fn only_what_a_page_uses_is_listed() {
        let named = |page: &Markup| -> Vec<&str> {
            let terms = used(&page.0).into_iter();
            terms.map(|(term, _)| term).collect()
        };
        let page = html! {
            p { "The next count is not a formula." }
            td { (formula("always (asked <-> next lit)")) }
        };
        assert_eq!(named(&page), ["p <-> q", "always p", "next x"]);
        let page = html! {
            p { "The counterstrategy has 1 state." }
            td { (formula("previous_one -> lit")) }
            th { "keeps [i = 0]" }
        };
        assert_eq!(named(&page), ["counterstrategy", "p -> q", "rule [i = 0]"]);
        assert!(terms(&html! { p { "Nothing." } }).0.is_empty());
    }
}
