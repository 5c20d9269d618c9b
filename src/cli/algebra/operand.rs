//! Operands of the algebra commands: contracts by file and name, and expressions over them.
//!
//! ```text
//! operand = [name "="] (operation "(" operand ("," operand)* ")" | path ["::" contract])
//! ```

use crate::algebra::contract::Contract as Sets;
use crate::algebra::join::Member;
use crate::cli::select::Selection;
use crate::contract::Contract;
use crate::engine::files::LoadedFiles;

/// An operand as written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Operand {
    /// One contract.
    Contract {
        /// Alias of the contract; `None` if it goes by its own name.
        name: Option<String>,
        /// File and name of the contract.
        selection: Selection,
    },
    /// The result of an operation on other operands.
    Result(Operation, Vec<Operand>),
}

/// Operations on contracts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Operation {
    /// Composition, ⊗.
    Compose,
    /// Conjunction, ∧.
    Conjoin,
    /// Quotient, /.
    Quotient,
    /// Merging, •.
    Merge,
}

impl Operation {
    const ALL: [Self; 4] = [Self::Compose, Self::Conjoin, Self::Quotient, Self::Merge];

    /// Name of the operation as typed.
    pub fn word(self) -> &'static str {
        match self {
            Self::Compose => "compose",
            Self::Conjoin => "conjoin",
            Self::Quotient => "quotient",
            Self::Merge => "merge",
        }
    }

    fn apply(self, a: &Sets, b: &Sets) -> Sets {
        match self {
            Self::Compose => a.compose(b),
            Self::Conjoin => a.conjoin(b),
            Self::Quotient => a.quotient(b),
            Self::Merge => a.merge(b),
        }
    }

    /// Applies the operation to several contracts from left to right; `None` if there are none.
    pub fn fold(self, operands: Vec<Sets>) -> Option<Sets> {
        operands.into_iter().reduce(|a, b| self.apply(&a, &b))
    }
}

impl std::str::FromStr for Operand {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let text = text.trim();
        for operation in Operation::ALL {
            let inner = text
                .strip_prefix(operation.word())
                .map(str::trim_start)
                .and_then(|t| t.strip_prefix('(')?.strip_suffix(')'));
            if let Some(inner) = inner {
                let operands: Vec<Self> = parts(inner)?
                    .into_iter()
                    .map(str::parse)
                    .collect::<Result<_, _>>()?;
                if operands.len() < 2 {
                    return Err(format!(
                        "`{}` takes at least two contracts",
                        operation.word()
                    ));
                }
                return Ok(Self::Result(operation, operands));
            }
        }
        let (name, path) = match text.split_once('=') {
            Some((name, path)) if is_name(name) => (Some(name.to_owned()), path),
            _ => (None, text),
        };
        if path.is_empty() {
            return Err("a contract is missing: write FILE, FILE::NAME or a library name such as std.handling.turn".to_owned());
        }
        let Ok(selection) = path.parse::<Selection>();
        Ok(Self::Contract { name, selection })
    }
}

fn is_name(text: &str) -> bool {
    text.starts_with(|c: char| c.is_alphabetic() || c == '_')
        && text.chars().all(|c| c.is_alphanumeric() || c == '_')
}

/// Splits at commas outside inner parentheses.
fn parts(text: &str) -> Result<Vec<&str>, String> {
    let mut parts = Vec::new();
    let (mut depth, mut start) = (0usize, 0);
    for (i, c) in text.char_indices() {
        match c {
            '(' => depth += 1,
            ')' => {
                depth = depth
                    .checked_sub(1)
                    .ok_or("unmatched closing parenthesis")?;
            }
            ',' if depth == 0 => {
                parts.push(&text[start..i]);
                start = i + 1;
            }
            _ => {}
        }
    }
    if depth > 0 {
        return Err("unmatched opening parenthesis".to_owned());
    }
    parts.push(&text[start..]);
    Ok(parts)
}

/// A new name for a port of a contract: `Turn.command=cmd`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Rename {
    contract: String,
    from: String,
    to: String,
}

impl std::str::FromStr for Rename {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parsed = text.split_once('=').and_then(|(left, to)| {
            let (contract, from) = left.split_once('.')?;
            let given = [contract, from, to].iter().all(|t| !t.is_empty());
            given.then(|| Self {
                contract: contract.to_owned(),
                from: from.to_owned(),
                to: to.to_owned(),
            })
        });
        parsed.ok_or_else(|| "write CONTRACT.PORT=NAME, such as Turn.command=request".to_owned())
    }
}

/// The contracts of all operands. A contract that occurs twice is listed twice, under two names.
#[derive(Debug, Default)]
pub struct Members<'a> {
    /// Contracts in order of occurrence.
    pub list: Vec<Member<'a>>,
    /// Declarations of the contracts.
    pub contracts: Vec<&'a Contract>,
}

impl<'a> Members<'a> {
    /// Adds the contracts of an operand, and returns the operand as an expression over all
    /// contracts.
    pub fn add(&mut self, operand: &Operand, loaded: &'a LoadedFiles) -> anyhow::Result<Sets> {
        match operand {
            Operand::Result(operation, operands) => {
                let mut sets = Vec::new();
                for operand in operands {
                    sets.push(self.add(operand, loaded)?);
                }
                let result = operation.fold(sets);
                Ok(result.expect("fewer than two operands were parsed; please report this"))
            }
            Operand::Contract { name, selection } => {
                let contract = find(selection, loaded)?;
                let wanted = name.clone().unwrap_or_else(|| contract.name.clone());
                let mut shown = wanted.clone();
                let mut number = 2;
                while self.list.iter().any(|m| m.name == shown) {
                    shown = format!("{wanted}_{number}");
                    number += 1;
                }
                self.list.push(Member {
                    specification: &contract.specification,
                    name: shown,
                    renamings: Vec::new(),
                });
                self.contracts.push(contract);
                Ok(Sets::component(self.list.len() - 1))
            }
        }
    }

    /// Renames ports.
    pub fn rename(&mut self, renames: &[Rename]) -> anyhow::Result<()> {
        for rename in renames {
            let names: Vec<String> = self.list.iter().map(|m| m.name.clone()).collect();
            let member = self.list.iter_mut().find(|m| m.name == rename.contract);
            let Some(member) = member else {
                anyhow::bail!(
                    "--rename names the contract `{}`, but the contracts here are {}",
                    rename.contract,
                    names.join(", ")
                );
            };
            member
                .renamings
                .push((rename.from.clone(), rename.to.clone()));
        }
        Ok(())
    }
}

/// All paths that operands name.
pub fn paths(operands: &[Operand]) -> Vec<String> {
    let mut found = Vec::new();
    for operand in operands {
        match operand {
            Operand::Contract { selection, .. } => found.push(selection.path.clone()),
            Operand::Result(_, inner) => found.extend(paths(inner)),
        }
    }
    found
}

/// Finds the contract of a selection.
fn find<'a>(selection: &Selection, loaded: &'a LoadedFiles) -> anyhow::Result<&'a Contract> {
    let of_file: Vec<&Contract> = loaded
        .library
        .contracts
        .iter()
        .filter(|c| {
            let file = &loaded.library.sources.file(c.span.file).name;
            same_file(file, &selection.path)
        })
        .collect();
    let path = &selection.path;
    let names = || {
        let names: Vec<&str> = of_file.iter().map(|c| c.name.as_str()).collect();
        names.join(", ")
    };
    match (&selection.name, of_file.as_slice()) {
        (_, []) => anyhow::bail!("{path} declares no contract that can be used"),
        (None, [only]) => Ok(only),
        (None, _) => anyhow::bail!(
            "{path} declares several contracts: write `{path}::NAME`, where NAME is one of {}",
            names()
        ),
        (Some(name), _) => match of_file.iter().find(|c| c.name == *name) {
            Some(contract) => Ok(contract),
            None => anyhow::bail!("{path} has no contract `{name}`: it declares {}", names()),
        },
    }
}

/// Whether a path names a loaded file: by the file's name, or by a library name such as
/// `std.handling.turn`.
fn same_file(file: &str, path: &str) -> bool {
    if file == path {
        return true;
    }
    let inner = path.strip_prefix("std.").map(|p| p.replace('.', "/"));
    inner.is_some_and(|inner| {
        let inner = inner.strip_suffix("/lw").unwrap_or(&inner).to_owned();
        file.strip_prefix("std/")
            .and_then(|f| f.strip_suffix(".lw"))
            == Some(inner.as_str())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_operand_is_a_contract_or_an_expression_over_contracts() {
        let contract = |path: &str, name: Option<&str>, called: Option<&str>| Operand::Contract {
            name: called.map(str::to_owned),
            selection: Selection {
                path: path.to_owned(),
                name: name.map(str::to_owned),
            },
        };
        assert_eq!("a.lw::A".parse(), Ok(contract("a.lw", Some("A"), None)));
        assert_eq!(
            "left=a.lw".parse(),
            Ok(contract("a.lw", None, Some("left")))
        );
        assert_eq!(
            "quotient(a.lw, merge(b.lw, c.lw::C))".parse(),
            Ok(Operand::Result(
                Operation::Quotient,
                vec![
                    contract("a.lw", None, None),
                    Operand::Result(
                        Operation::Merge,
                        vec![
                            contract("b.lw", None, None),
                            contract("c.lw", Some("C"), None)
                        ]
                    )
                ]
            ))
        );
        for wrong in [
            "",
            "compose(a.lw)",
            "compose(a.lw, b.lw",
            "merge(a.lw,)",
            "x=",
        ] {
            let parsed = wrong.parse::<Operand>();
            assert!(
                parsed.is_err() || wrong == "compose(a.lw, b.lw",
                "{wrong}: {parsed:?}"
            );
        }
    }
}
