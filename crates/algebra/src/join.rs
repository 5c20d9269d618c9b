//! Joins separate contracts into a system: after ports are renamed, variables with the same name
//! become one variable.

use super::system::{Component, System};
use linewright_core::gr1::{Domain, Expr, Specification, Time, VarId, Variable};
use linewright_core::source::Span;

/// A contract to be joined, with new names for its ports.
#[derive(Debug, Clone)]
pub struct Member<'a> {
    /// The contract itself.
    pub specification: &'a Specification,
    /// Name of the component, which distinguishes two uses of one contract.
    pub name: String,
    /// Ports and their new names. The name of an array renames all its elements.
    pub renamings: Vec<(String, String)>,
}

/// Whether several contracts can set one variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Sharing {
    /// At most one contract sets each variable, as in a composition.
    #[default]
    OneDriver,
    /// Several contracts describe one component, such as two views or two versions.
    SeveralViews,
}

/// Reason why contracts cannot be joined.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Mismatch {
    /// Two contracts use one name for variables with different domains or units.
    DifferentDomains {
        /// Name of the variable.
        name: String,
        /// First contract, domain of its variable as displayed, and place of the declaration.
        first: (String, String, Span),
        /// Second contract, with the same data.
        second: (String, String, Span),
    },
    /// Two contracts set the same variable.
    SeveralDrivers {
        /// Name of the variable.
        name: String,
        /// First contract, and place of its declaration of the variable.
        first: (String, Span),
        /// Second contract, with the same data.
        second: (String, Span),
    },
    /// A renamed port does not exist.
    UnknownPort {
        /// Name of the contract.
        contract: String,
        /// Name of the port.
        port: String,
        /// Existing ports.
        ports: Vec<String>,
    },
    /// Two ports of one contract have the same name after renaming.
    DuplicatePortName {
        /// Name of the contract.
        contract: String,
        /// Common name of the ports.
        name: String,
    },
}

/// Joins contracts into a system.
///
/// Monitors are not shared, and neither are internal variables of different components: if another
/// variable has the same name, their name is prefixed with that of their member. If the contracts
/// are views of one component, internal variables with the same name become one variable.
///
/// # Errors
/// If contracts cannot be joined; returns all mismatches.
pub fn join(members: &[Member<'_>], sharing: Sharing) -> Result<System, Vec<Mismatch>> {
    let mut system = System::default();
    let mut declared: Vec<(usize, Span)> = Vec::new();
    let mut mismatches = Vec::new();
    for (index, member) in members.iter().enumerate() {
        unknown_ports(member, &mut mismatches);
        let mut own: Vec<VarId> = Vec::new();
        for (i, variable) in member.specification.variables.iter().enumerate() {
            let id = VarId(i as u32);
            let apart = member.specification.is_auxiliary(id)
                || (variable.internal && sharing == Sharing::OneDriver);
            let mut name = renamed(&variable.name, &member.renamings);
            let known = system.variables.iter().position(|v| v.name == name);
            match known {
                Some(place) if !apart => {
                    let place = VarId(place as u32);
                    if own.contains(&place) {
                        mismatches.push(Mismatch::DuplicatePortName {
                            contract: member.name.clone(),
                            name: name.clone(),
                        });
                    }
                    same_domain(
                        &system,
                        place,
                        &declared,
                        member,
                        members,
                        variable,
                        &mut mismatches,
                    );
                    own.push(place);
                }
                _ => {
                    if known.is_some() {
                        name = system.fresh_name(&format!("{}.{name}", member.name));
                    }
                    own.push(VarId(system.variables.len() as u32));
                    system.variables.push(Variable {
                        name,
                        ..variable.clone()
                    });
                    declared.push((index, variable.span));
                }
            }
        }
        let component =
            Component::mapped(member.specification, &member.name, &mut |v, time: Time| {
                Expr::Var(own[v.index()], time)
            });
        if sharing == Sharing::OneDriver {
            for v in &component.drives {
                if let Some(first) = system.driver(*v) {
                    let at = own.iter().position(|o| o == v).unwrap_or(0);
                    mismatches.push(Mismatch::SeveralDrivers {
                        name: system.variables[v.index()].name.clone(),
                        first: (members[first].name.clone(), declared[v.index()].1),
                        second: (member.name.clone(), member.specification.variables[at].span),
                    });
                }
            }
        }
        system.components.push(component);
    }
    if mismatches.is_empty() {
        Ok(system)
    } else {
        Err(mismatches)
    }
}

/// Returns the name of a port after its own renaming or that of its array.
fn renamed(name: &str, renamings: &[(String, String)]) -> String {
    for (from, to) in renamings {
        if name == from {
            return to.clone();
        }
        if let Some(index) = name.strip_prefix(from.as_str())
            && (index.starts_with('[') || index.starts_with('.'))
        {
            return format!("{to}{index}");
        }
    }
    name.to_owned()
}

fn unknown_ports(member: &Member<'_>, mismatches: &mut Vec<Mismatch>) {
    let variables = &member.specification.variables;
    for (from, _) in &member.renamings {
        let one = std::slice::from_ref(from);
        let is = |name: &str| {
            let to = (one[0].clone(), String::new());
            renamed(name, &[to]) != name
        };
        if !variables.iter().any(|v| is(&v.name)) {
            mismatches.push(Mismatch::UnknownPort {
                contract: member.name.clone(),
                port: from.clone(),
                ports: variables.iter().map(|v| v.name.clone()).collect(),
            });
        }
    }
}

/// Checks that a variable has the same domain in both contracts. Enumerations are equal if their
/// labels are, even if their types have different names.
fn same_domain(
    system: &System,
    place: VarId,
    declared: &[(usize, Span)],
    member: &Member<'_>,
    members: &[Member<'_>],
    variable: &Variable,
    mismatches: &mut Vec<Mismatch>,
) {
    let known = &system.variables[place.index()];
    let same = match (&known.domain, &variable.domain) {
        (Domain::Enum { labels: a, .. }, Domain::Enum { labels: b, .. }) => a == b,
        (a, b) => a == b && known.unit == variable.unit,
    };
    if !same {
        let (first, span) = declared[place.index()];
        mismatches.push(Mismatch::DifferentDomains {
            name: known.name.clone(),
            first: (members[first].name.clone(), known.describe(), span),
            second: (member.name.clone(), variable.describe(), variable.span),
        });
    }
}
