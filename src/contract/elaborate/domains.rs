//! Finite domains.

use super::{Elaborator, MAX_DOMAIN, MAX_EXPANSION, nearest};
use crate::diagnostics::codes;
use crate::gr1::Domain;
use crate::syntax::ast;

impl<'a> Elaborator<'a> {
    /// A finite domain, and the length of the array if it is one.
    pub fn domain(&mut self, domain: &'a ast::Domain) -> Option<(Domain, Option<usize>)> {
        match &domain.kind {
            ast::DomainKind::Labels(names) => {
                let mut labels: Vec<String> = Vec::new();
                for name in names {
                    if labels.contains(&name.text) {
                        self.error_with(
                            codes::NAME_DOUBLE,
                            name.span,
                            format!("the label `{}` is there already", name.text),
                            "leave it out, or give it another name",
                        );
                    } else {
                        labels.push(name.text.clone());
                    }
                }
                Some((Domain::Enum { name: None, labels }, None))
            }
            ast::DomainKind::Range(low, high, _) => {
                let (l, h) = (self.constant_int(low), self.constant_int(high));
                let (low, high) = (l?, h?);
                if low > high {
                    self.error_with(
                        codes::DOMAIN_EMPTY,
                        domain.span,
                        format!("{low}..{high} is empty"),
                        "write the smaller number first",
                    );
                    return None;
                }
                if high.saturating_sub(low) >= MAX_DOMAIN {
                    self.error_with(
                        codes::DOMAIN_EMPTY,
                        domain.span,
                        format!("{low}..{high} has more than {MAX_DOMAIN} values"),
                        "use a coarser abstraction",
                    );
                    return None;
                }
                Some((Domain::Range { low, high }, None))
            }
            ast::DomainKind::Array(length, of) => {
                let length_value = self.constant_int(length)?;
                if !(1..=MAX_EXPANSION).contains(&length_value) {
                    self.error_with(
                        codes::DOMAIN_EMPTY,
                        length.span,
                        format!("an array has 1 to {MAX_EXPANSION} elements, not {length_value}"),
                        "give the array a length in that range",
                    );
                    return None;
                }
                let (base, inner) = self.domain(of)?;
                if inner.is_some() {
                    self.error_with(
                        codes::TYPE_MISMATCH,
                        of.span,
                        "arrays of arrays are not known",
                        "use one array with `rows * columns` elements",
                    );
                    return None;
                }
                Some((base, Some(length_value as usize)))
            }
            ast::DomainKind::Named(name) if name.text == "bool" => Some((Domain::Bool, None)),
            ast::DomainKind::Named(name) => {
                if let Some(domain) = self.named_domains.get(&name.text) {
                    return Some((domain.clone(), None));
                }
                if self.broken.contains(&name.text) {
                    self.tainted = true;
                    return None;
                }
                let known: Vec<String> = self
                    .named_domains
                    .keys()
                    .cloned()
                    .chain(["bool".to_owned()])
                    .collect();
                let help = if matches!(name.text.as_str(), "int" | "integer" | "real" | "number") {
                    "a contract's numbers are bounded: write a range such as `0..9`".to_owned()
                } else {
                    match nearest(&name.text, known.iter().map(String::as_str)) {
                        Some(near) => format!("did you mean `{near}`?"),
                        None => "declare it with `type`, or import the file that does".to_owned(),
                    }
                };
                self.error_with(
                    codes::NAME_UNKNOWN,
                    name.span,
                    format!("there is no type `{}`", name.text),
                    help,
                );
                None
            }
            ast::DomainKind::Record(_) => {
                self.error_with(
                    codes::TYPE_MISMATCH,
                    domain.span,
                    "a record does not belong here",
                    "",
                );
                None
            }
            ast::DomainKind::Unit(unit) => {
                self.error_with(
                    codes::TYPE_MISMATCH,
                    domain.span,
                    format!("`{unit}` is a unit of the plant; a contract counts in whole numbers"),
                    "write a range such as `0..9`, and give its meaning in the machine with `abstract`",
                );
                None
            }
        }
    }
}
