//! Seeded random numbers, the same on every platform and in every version.
//!
//! The generator is xoshiro256++ by Blackman and Vigna ("Scrambled linear pseudorandom number
//! generators", 2021), seeded through their `SplitMix64`, as they recommend. It is implemented
//! here, in forty lines, because a run must not change when a crate does.
//!
//! Every random quantity in a line has its own [`Stream`], identified by the run's seed, the
//! purpose and the name of the node. Adding a node, or drawing once more at a node, leaves all
//! other streams unchanged (common random numbers). Variants of a line can therefore be compared
//! under one seed.

use rand_core::TryRng;
use std::convert::Infallible;

/// Purpose of a stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// Times between a source's parts.
    Arrivals,
    /// Times between failures of a station.
    Failures,
    /// Defects made by a station.
    Defects,
    /// Selection of lead times for the sample behind the percentiles.
    Sample,
    /// Work of a station on parts of a type.
    Service,
    /// Repairs of a station.
    Repairs,
    /// Setups of a station.
    Setup,
    /// Choices between routes.
    Routes,
    /// Dwell times of parts in a buffer.
    Dwell,
    /// Outcomes of the tests of a recipe.
    Tests,
}

/// A sequence of random numbers.
#[derive(Debug, Clone)]
pub struct Stream {
    state: [u64; 4],
}

/// Returns the next number of `SplitMix64`.
fn split_mix(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

impl Stream {
    /// The stream for a run's seed, a purpose and a name.
    pub fn new(seed: u64, purpose: Purpose, name: &str) -> Self {
        // FNV-1a over the name; SplitMix64 then mixes it with seed and purpose.
        let hash = name.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        });
        let mut mixed = seed;
        mixed = split_mix(&mut mixed) ^ hash;
        mixed = split_mix(&mut mixed) ^ (purpose as u64 + 1);
        Self::from_seed(mixed)
    }

    /// The stream whose state is the first four numbers of `SplitMix64` from `seed`.
    pub fn from_seed(mut seed: u64) -> Self {
        Self {
            state: std::array::from_fn(|_| split_mix(&mut seed)),
        }
    }

    /// 64 random bits.
    #[inline]
    pub fn bits(&mut self) -> u64 {
        let [a, b, c, d] = &mut self.state;
        let result = a.wrapping_add(*d).rotate_left(23).wrapping_add(*a);
        let shifted = *b << 17;
        *c ^= *a;
        *d ^= *b;
        *b ^= *c;
        *a ^= *d;
        *c ^= shifted;
        *d = d.rotate_left(45);
        result
    }

    /// A uniform number in [0, 1) from 53 random bits.
    #[inline]
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * (1.0 / (1_u64 << 53) as f64)
    }

    /// An exponentially distributed number with this mean: finite and not negative.
    #[inline]
    pub fn exponential(&mut self, mean: f64) -> f64 {
        -mean * (1.0 - self.unit()).ln()
    }

    /// Returns true with this probability.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }

    /// A uniform number in `0..count`; 0 if `count` is 0.
    pub fn below(&mut self, count: u64) -> u64 {
        // The upper half of `count` times 64 random bits; the bias is below count / 2^64.
        ((u128::from(self.bits()) * u128::from(count)) >> 64) as u64
    }
}

impl TryRng for Stream {
    type Error = Infallible;

    fn try_next_u32(&mut self) -> Result<u32, Infallible> {
        // The upper bits of this generator are its best.
        Ok((self.bits() >> 32) as u32)
    }

    fn try_next_u64(&mut self) -> Result<u64, Infallible> {
        Ok(self.bits())
    }

    fn try_fill_bytes(&mut self, bytes: &mut [u8]) -> Result<(), Infallible> {
        for chunk in bytes.chunks_mut(8) {
            let bits = self.bits().to_le_bytes();
            chunk.copy_from_slice(&bits[..chunk.len()]);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reference_values_of_the_authors() {
        let mut seed = 1_234_567;
        assert_eq!(split_mix(&mut seed), 6_457_827_717_110_365_317);
        assert_eq!(split_mix(&mut seed), 3_203_168_211_198_807_973);
        let mut stream = Stream {
            state: [1, 2, 3, 4],
        };
        let expected = [
            41_943_041,
            58_720_359,
            3_588_806_011_781_223,
            3_591_011_842_654_386,
            9_228_616_714_210_784_205,
            9_973_669_472_204_895_162,
        ];
        assert_eq!(expected.map(|_| stream.bits()), expected);
    }

    #[test]
    fn streams_differ_and_repeat() {
        let draw = |seed, purpose, name| Stream::new(seed, purpose, name).bits();
        assert_eq!(
            draw(1, Purpose::Defects, "cell"),
            draw(1, Purpose::Defects, "cell")
        );
        assert_ne!(
            draw(1, Purpose::Defects, "cell"),
            draw(2, Purpose::Defects, "cell")
        );
        assert_ne!(
            draw(1, Purpose::Defects, "cell"),
            draw(1, Purpose::Failures, "cell")
        );
        assert_ne!(
            draw(1, Purpose::Defects, "cell"),
            draw(1, Purpose::Defects, "cell2")
        );
    }

    #[test]
    fn the_mean_is_the_mean() {
        let mut stream = Stream::from_seed(7);
        let count = 200_000;
        let mean = (0..count).map(|_| stream.exponential(3.0)).sum::<f64>() / f64::from(count);
        assert!((mean - 3.0).abs() < 0.03, "{mean}");
        let thirds = (0..count).filter(|_| stream.below(3) == 2).count() as f64;
        assert!((thirds / f64::from(count) - 1.0 / 3.0).abs() < 0.005);
    }
}
