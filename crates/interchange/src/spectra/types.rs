//! Types: domains of variables and sizes of arrays.

use super::reader::{MAX_VARIABLES, Reader};
use super::syntax::{Base, Name, Node, TypeName};
use super::value::Kind;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::gr1::Domain;
use linewright_core::source::Span;

/// Maximum number of values of a domain, the same as in contracts.
const MAX_DOMAIN: i64 = 1 << 20;
/// Maximum length of a chain of types, each defined by the next.
const MAX_ALIASES: usize = 64;

impl Reader {
    /// The domain of a type, and the sizes of its array, the outermost first. If the type is
    /// invalid, reports this and returns `None`.
    pub fn domain(&mut self, of: &TypeName) -> Option<(Domain, Vec<i64>)> {
        let mut sizes = Vec::new();
        let (mut at, mut declared) = (of.clone(), None);
        for _ in 0..MAX_ALIASES {
            for size in &at.sizes {
                let value = self.number(size)?;
                if value < 1 || value > MAX_VARIABLES as i64 {
                    self.error(
                        codes::DOMAIN_EMPTY,
                        size.span,
                        format!("an array cannot have {value} elements"),
                        format!("use a size from 1 to {MAX_VARIABLES}"),
                    );
                    return None;
                }
                sizes.push(value);
            }
            let domain = match &at.base {
                Base::Bool => Domain::Bool,
                Base::Int(low, high) => self.integers(low, high, at.span)?,
                Base::Labels(labels) => self.enumeration(declared, labels)?,
                Base::Named(name) => {
                    let Some(next) = self.declared_type(name, at.span) else {
                        self.unknown("type", name, of.span);
                        return None;
                    };
                    declared = Some(name.clone());
                    at = (**next).clone();
                    continue;
                }
            };
            return Some((domain, sizes));
        }
        self.error(
            codes::DOMAIN_EMPTY,
            of.span,
            "this type is defined in terms of itself",
            "declare it as `boolean`, `Int(0..3)` or `{a, b}`",
        );
        None
    }

    fn integers(&mut self, low: &Node, high: &Node, span: Span) -> Option<Domain> {
        let (low, high) = (self.number(low), self.number(high));
        let (low, high) = (low?, high?);
        let message = if low > high {
            format!("the domain from {low} to {high} is empty")
        } else if high.saturating_sub(low) >= MAX_DOMAIN {
            format!("the domain has more than {MAX_DOMAIN} values")
        } else {
            return Some(Domain::Range { low, high });
        };
        self.error(
            codes::DOMAIN_EMPTY,
            span,
            message,
            "write the smaller number first, and use a range no larger than the model needs",
        );
        None
    }

    /// The domain of an enumeration. It is a range of numbers if the values are consecutive
    /// numbers.
    fn enumeration(&mut self, name: Option<String>, labels: &[Name]) -> Option<Domain> {
        for (index, label) in labels.iter().enumerate() {
            if let Some(first) = labels[..index].iter().find(|l| l.text == label.text) {
                let finding = Diagnostic::error(
                    codes::NAME_DUPLICATE,
                    label.span,
                    format!("the value `{}` appears twice", label.text),
                )
                .with_label(first.span, "the first one")
                .with_help("give each value of an enumeration its own name");
                self.findings.push(finding);
                return None;
            }
        }
        let numbers: Option<Vec<i64>> = labels.iter().map(|l| l.text.parse().ok()).collect();
        if let Some(numbers) = numbers
            && numbers.windows(2).all(|w| w[1] == w[0] + 1)
        {
            return Some(Domain::Range {
                low: numbers[0],
                high: numbers[numbers.len() - 1],
            });
        }
        Some(Domain::Enum {
            name,
            labels: labels.iter().map(|l| l.text.clone()).collect(),
        })
    }

    /// The value of a constant number. If the formula is anything else, reports this and returns
    /// `None`.
    pub fn number(&mut self, node: &Node) -> Option<i64> {
        let value = self.value(node)?;
        if let (Kind::Int, Some(number)) = (&value.kind, value.constant()) {
            return Some(number);
        }
        self.error(
            codes::NOT_CONSTANT,
            node.span,
            "this is not a constant number",
            "write a number, or a define with a constant value",
        );
        None
    }
}

/// The type of a variable with a domain.
pub(super) fn kind_of(domain: &Domain) -> Kind {
    match domain {
        Domain::Bool => Kind::Bool,
        Domain::Range { .. } => Kind::Int,
        Domain::Enum { labels, .. } => Kind::Labels(labels.clone().into()),
    }
}
