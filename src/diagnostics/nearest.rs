//! "Did you mean ...?": the known word closest to a misspelt one.

/// The known name closest to a misspelt one, if any is close.
pub fn nearest<'n>(name: &str, known: impl Iterator<Item = &'n str>) -> Option<&'n str> {
    known
        .map(|k| (distance(name, k), k))
        .filter(|(d, k)| *d <= name.len().min(k.len()).div_ceil(4).min(name.len() / 2))
        .min()
        .map(|(_, k)| k)
}

/// How many letters must be changed, added, left out or exchanged with their neighbour (optimal string alignment).
pub fn distance(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().collect(), b.chars().collect());
    let mut before: Vec<usize> = Vec::new();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for i in 0..a.len() {
        let mut next = vec![i + 1];
        for j in 0..b.len() {
            let mut least = (row[j] + usize::from(a[i] != b[j])).min(row[j + 1] + 1);
            least = least.min(next[j] + 1);
            if i > 0 && j > 0 && a[i] == b[j - 1] && a[i - 1] == b[j] {
                least = least.min(before[j - 1] + 1);
            }
            next.push(least);
        }
        before = std::mem::replace(&mut row, next);
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distance_counts_slips() {
        assert_eq!(distance("", "abc"), 3);
        assert_eq!(distance("drehen", "dreehn"), 1);
        assert_eq!(distance("turn", "turn"), 0);
    }

    #[test]
    fn typical_slips_are_found() {
        let known = ["Turn", "turn", "command", "angle", "a"];
        for (slip, meant) in [
            ("Trun", Some("Turn")),
            ("comand", Some("command")),
            ("angel", Some("angle")),
            ("angles", Some("angle")),
            ("b", None),
            ("press", None),
        ] {
            assert_eq!(nearest(slip, known.into_iter()), meant, "{slip}");
        }
    }
}
