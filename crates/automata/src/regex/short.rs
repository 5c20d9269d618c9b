//! Constructors that simplify expressions.

use super::tree::Regex;

impl Regex {
    /// Returns the concatenation, without redundant parts.
    pub fn concat(parts: impl IntoIterator<Item = Self>) -> Self {
        let mut flat = Vec::new();
        for part in parts {
            match part {
                Self::Nothing => return Self::Nothing,
                Self::Empty => {}
                Self::Concat(inner) => flat.extend(inner),
                other => flat.push(other),
            }
        }
        // x* x is x+, and x* x* is x*.
        let mut short: Vec<Self> = Vec::new();
        for part in flat {
            match short.last().and_then(|last| merge(last, &part)) {
                Some(merged) => *short.last_mut().expect("`short` is not empty") = merged,
                None => short.push(part),
            }
        }
        match short.len() {
            0 => Self::Empty,
            1 => short.remove(0),
            _ => Self::Concat(short),
        }
    }

    /// Returns the union, without duplicates and with common prefixes and suffixes factored out.
    pub fn either(parts: impl IntoIterator<Item = Self>) -> Self {
        let mut flat = Vec::new();
        let mut empty = false;
        for part in parts {
            let inner = match part {
                Self::Either(inner) => inner,
                other => vec![other],
            };
            for part in inner {
                match part {
                    Self::Nothing => {}
                    Self::Empty => empty = true,
                    Self::Repeat {
                        of,
                        low: 0,
                        high: Some(1),
                    } => {
                        empty = true;
                        let inner = match *of {
                            Self::Either(inner) => inner,
                            other => vec![other],
                        };
                        for part in inner {
                            push_new(&mut flat, part);
                        }
                    }
                    other => push_new(&mut flat, other),
                }
            }
        }
        factor(&mut flat);
        let body = match flat.len() {
            0 if empty => return Self::Empty,
            0 => return Self::Nothing,
            1 => flat.remove(0),
            _ => Self::Either(flat),
        };
        if empty { body.optional() } else { body }
    }

    /// Returns an expression for any number of repetitions, including none.
    #[must_use]
    pub fn star(self) -> Self {
        let of = match self {
            Self::Nothing | Self::Empty => return Self::Empty,
            // (x*)*, (x+)* and (x?)* are x*.
            Self::Repeat {
                of,
                low: 0 | 1,
                high: None | Some(1),
            } => *of,
            other => other,
        };
        // Within a repetition, an inner repetition is redundant.
        let of = match of {
            Self::Either(parts) => {
                let bare = parts.into_iter().map(|part| match part {
                    Self::Repeat {
                        of,
                        low: 0 | 1,
                        high: None | Some(1),
                    } => *of,
                    other => other,
                });
                Self::either(bare)
            }
            other => other,
        };
        Self::Repeat {
            of: Box::new(of),
            low: 0,
            high: None,
        }
    }

    /// Returns the union of the expression and the empty word.
    #[must_use]
    pub fn optional(self) -> Self {
        match self {
            Self::Nothing | Self::Empty => Self::Empty,
            Self::Repeat {
                of,
                low: 0 | 1,
                high,
            } => Self::Repeat { of, low: 0, high },
            other if other.has_empty() => other,
            other => Self::Repeat {
                of: Box::new(other),
                low: 0,
                high: Some(1),
            },
        }
    }
}

fn push_new(parts: &mut Vec<Regex>, part: Regex) {
    if !parts.contains(&part) {
        parts.push(part);
    }
}

/// Merges two adjacent parts of a concatenation into one; `None` if that is not possible.
fn merge(a: &Regex, b: &Regex) -> Option<Regex> {
    let many = |of: &Regex, low| Regex::Repeat {
        of: Box::new(of.clone()),
        low,
        high: None,
    };
    let inside = |r: &Regex| match r {
        Regex::Repeat {
            of,
            low,
            high: None,
        } if *low < 2 => Some(((**of).clone(), *low)),
        _ => None,
    };
    match (inside(a), inside(b)) {
        (Some((x, n)), Some((y, m))) if x == y && n + m < 2 => Some(many(&x, n + m)),
        (Some((x, 0)), None) if x == *b => Some(many(&x, 1)),
        (None, Some((y, 0))) if y == *a => Some(many(&y, 1)),
        // x? x* is x*.
        (None, Some((y, 0))) => match a {
            Regex::Repeat {
                of,
                low: 0,
                high: Some(1),
            } if **of == y => Some(many(&y, 0)),
            _ => None,
        },
        (Some((x, 0)), None) => match b {
            Regex::Repeat {
                of,
                low: 0,
                high: Some(1),
            } if **of == x => Some(many(&x, 0)),
            _ => None,
        },
        _ => None,
    }
}

/// Returns the parts of a concatenation.
fn parts(regex: &Regex) -> Vec<Regex> {
    match regex {
        Regex::Concat(parts) => parts.clone(),
        other => vec![other.clone()],
    }
}

/// Factors out common prefixes and suffixes of alternatives, pair by pair: `x y | x z` becomes
/// `x (y | z)`.
fn factor(flat: &mut Vec<Regex>) {
    'again: loop {
        for i in 0..flat.len() {
            for j in i + 1..flat.len() {
                if let Some(shorter) = factor_pair(&flat[i], &flat[j]) {
                    flat[i] = shorter;
                    flat.remove(j);
                    continue 'again;
                }
            }
        }
        return;
    }
}

/// Factors out a common prefix of two alternatives or, if there is none, a common suffix. Returns
/// `None` if there is neither.
fn factor_pair(a: &Regex, b: &Regex) -> Option<Regex> {
    // Letters have no proper prefix or suffix.
    if matches!((a, b), (Regex::Letter(_), Regex::Letter(_))) {
        return None;
    }
    let (x, y) = (parts(a), parts(b));
    let first = x.iter().zip(&y).take_while(|(a, b)| a == b).count();
    let rests = |x: &[Regex], y: &[Regex]| {
        Regex::either([Regex::concat(x.to_vec()), Regex::concat(y.to_vec())])
    };
    if first > 0 {
        let rest = rests(&x[first..], &y[first..]);
        let common = x[..first].iter().cloned();
        return Some(Regex::concat(common.chain([rest])));
    }
    let last = x
        .iter()
        .rev()
        .zip(y.iter().rev())
        .take_while(|(a, b)| a == b)
        .count();
    if last > 0 {
        let rest = rests(&x[..x.len() - last], &y[..y.len() - last]);
        let common = x[x.len() - last..].iter().cloned();
        return Some(Regex::concat([rest].into_iter().chain(common)));
    }
    None
}
