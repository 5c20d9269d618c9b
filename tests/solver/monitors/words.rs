//! Many words at once: 256 side by side in the bits of four machine words, so that every lasso can
//! be tried.

use std::ops::{BitAnd, BitOr, Not};

/// A truth value in each of 256 words.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Lanes(pub [u64; 4]);

/// Number of bits of a word's number that select its lane.
const LANE_BITS: usize = 8;

impl Lanes {
    pub const NONE: Self = Self([0; 4]);
    pub const ALL: Self = Self([u64::MAX; 4]);

    /// Bit `k` of each lane's number.
    fn digit(k: usize) -> Self {
        const LOW: [u64; 6] = [
            0xAAAA_AAAA_AAAA_AAAA,
            0xCCCC_CCCC_CCCC_CCCC,
            0xF0F0_F0F0_F0F0_F0F0,
            0xFF00_FF00_FF00_FF00,
            0xFFFF_0000_FFFF_0000,
            0xFFFF_FFFF_0000_0000,
        ];
        match k {
            6 => Self([0, u64::MAX, 0, u64::MAX]),
            7 => Self([0, 0, u64::MAX, u64::MAX]),
            _ => Self([LOW[k]; 4]),
        }
    }

    /// Whether it is true in one lane.
    pub fn at(self, lane: usize) -> bool {
        self.0[lane / 64] >> (lane % 64) & 1 == 1
    }

    /// The first lane in which it is true.
    pub fn first(self) -> Option<usize> {
        (0..256).find(|lane| self.at(*lane))
    }
}

impl BitAnd for Lanes {
    type Output = Self;
    #[inline]
    fn bitand(self, b: Self) -> Self {
        let (a, b) = (self.0, b.0);
        Self([a[0] & b[0], a[1] & b[1], a[2] & b[2], a[3] & b[3]])
    }
}

impl BitOr for Lanes {
    type Output = Self;
    #[inline]
    fn bitor(self, b: Self) -> Self {
        let (a, b) = (self.0, b.0);
        Self([a[0] | b[0], a[1] | b[1], a[2] | b[2], a[3] | b[3]])
    }
}

impl Not for Lanes {
    type Output = Self;
    #[inline]
    fn not(self) -> Self {
        Self(self.0.map(|w| !w))
    }
}

/// The same where two are equal.
pub fn same(a: Lanes, b: Lanes) -> Lanes {
    (a & b) | (!a & !b)
}

/// 256 lassos of one shape: `letters[i][v]` is variable `v` at position `i`, and the last position
/// is followed by `back`.
pub struct Lassos {
    pub letters: Vec<Vec<Lanes>>,
    pub back: usize,
}

impl Lassos {
    /// The position after one.
    pub fn after(&self, position: usize) -> usize {
        if position + 1 == self.letters.len() {
            self.back
        } else {
            position + 1
        }
    }

    /// The letters of the first `length` steps.
    pub fn unrolled(&self, length: usize) -> Vec<Vec<Lanes>> {
        let mut position = 0;
        let mut word = Vec::new();
        for _ in 0..length {
            word.push(self.letters[position].clone());
            position = self.after(position);
        }
        word
    }

    /// One lasso as text: `p, -, pq | (r, -)`.
    pub fn show(&self, lane: usize, names: &[char]) -> String {
        let letter = |l: &Vec<Lanes>| {
            let pairs = names.iter().zip(l).filter(|(_, v)| v.at(lane));
            let text: String = pairs.map(|(n, _)| n).collect();
            if text.is_empty() {
                "-".to_owned()
            } else {
                text
            }
        };
        let letters: Vec<String> = self.letters.iter().map(letter).collect();
        let (stem, cycle) = letters.split_at(self.back);
        format!("{} ({})*", stem.join(", "), cycle.join(", "))
    }
}

/// Calls `visit` with all lassos over `variables` variables with at most `longest` positions, and
/// returns their number.
pub fn every_lasso(variables: usize, longest: usize, visit: &mut impl FnMut(&Lassos)) -> u64 {
    let mut count = 0;
    for length in 1..=longest {
        let bits = variables * length;
        for high in 0..1_u64 << bits.saturating_sub(LANE_BITS) {
            let digit = |k: usize| match k.checked_sub(LANE_BITS) {
                None => Lanes::digit(k),
                Some(k) if high >> k & 1 == 1 => Lanes::ALL,
                Some(_) => Lanes::NONE,
            };
            let letter = |i: usize| (0..variables).map(|v| digit(i * variables + v)).collect();
            let mut lassos = Lassos {
                letters: (0..length).map(letter).collect(),
                back: 0,
            };
            for back in 0..length {
                lassos.back = back;
                visit(&lassos);
                count += 1 << bits.min(LANE_BITS);
            }
        }
    }
    count
}

#[test]
fn lanes_are_all_different() {
    for lane in 0..256 {
        let number = (0..8).filter(|k| Lanes::digit(*k).at(lane));
        assert_eq!(number.map(|k| 1 << k).sum::<usize>(), lane);
    }
    // (2^1) * 1 + (2^2) * 2 + (2^3) * 3
    assert_eq!(every_lasso(1, 3, &mut |_| {}), 34);
    assert_eq!(every_lasso(2, 6, &mut |_| {}), 30_948);
}
