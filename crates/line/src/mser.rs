//! Finds the warm-up of a run: MSER-5 (White, "An effective truncation heuristic for bias reduction
//! in simulation output", Simulation 69(6), 1997).
//!
//! The observations are divided into batches of five, whose means are `z`. Of all numbers of
//! batches that could be cut off at the beginning, up to half of them, the one is chosen for which
//! the mean of the rest is most precise. It minimizes the sum of the squared deviations of the rest
//! from its mean, divided by the square of its length.

/// Number of observations in a batch.
const BATCH: usize = 5;

/// Returns how many of the first observations belong to the warm-up. Returns `None` if the optimum
/// is at the end of the first half of the observations: there are too few of them, or they never
/// become steady. Runs in linear time.
pub fn mser5(observations: &[f64]) -> Option<usize> {
    let batches: Vec<f64> = observations
        .chunks_exact(BATCH)
        .map(|batch| batch.iter().sum::<f64>() / BATCH as f64)
        .collect();
    let last = batches.len().div_ceil(2).checked_sub(1)?;
    // From the end, mean and squared deviations of the rest are updated by Welford's method.
    let (mut mean, mut squares) = (0.0, 0.0);
    let mut best: Option<(f64, usize)> = None;
    for (cut, value) in batches.iter().enumerate().rev() {
        let left = (batches.len() - cut) as f64;
        let deviation = value - mean;
        mean += deviation / left;
        squares += deviation * (value - mean);
        let statistic = squares / (left * left);
        if cut <= last && best.is_none_or(|(least, _)| statistic <= least) {
            best = Some((statistic, cut));
        }
    }
    let (_, cut) = best?;
    (cut < last).then_some(cut * BATCH)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decaying(count: usize) -> Vec<f64> {
        (0..count)
            .map(|i| 10.0 * (-(i as f64) / 50.0).exp() + (i as f64).sin())
            .collect()
    }

    #[test]
    fn known_cuts() {
        assert_eq!(mser5(&decaying(500)), Some(180));
        assert_eq!(mser5(&decaying(1000)), Some(205));
    }

    /// The definition, with the minimum over the first half.
    fn naive(observations: &[f64]) -> usize {
        let batches: Vec<f64> = observations
            .chunks_exact(5)
            .map(|batch| batch.iter().sum::<f64>() / 5.0)
            .collect();
        let count = batches.len();
        let statistic = |cut: usize| {
            let rest = &batches[cut..];
            let mean = rest.iter().sum::<f64>() / rest.len() as f64;
            let squares: f64 = rest.iter().map(|z| (z - mean).powi(2)).sum();
            squares / (rest.len() as f64).powi(2)
        };
        let cuts = 0..count.div_ceil(2);
        let least = cuts.min_by(|a, b| statistic(*a).total_cmp(&statistic(*b)));
        least.unwrap_or(0) * 5
    }

    #[test]
    fn the_cut_is_that_of_the_definition() {
        let mut stream = crate::random::Stream::from_seed(5);
        for round in 0..50 {
            let decay = 10.0 + f64::from(round);
            let observations: Vec<f64> = (0..600)
                .map(|i| 20.0 * (-f64::from(i) / decay).exp() + stream.exponential(1.0))
                .collect();
            if let Some(cut) = mser5(&observations) {
                assert_eq!(cut, naive(&observations));
            }
        }
    }

    #[test]
    fn too_few_observations_have_no_cut() {
        assert_eq!(mser5(&[1.0; 9]), None);
        // It grows to the end: no part of it is steady.
        let growing: Vec<f64> = (0..1000).map(f64::from).collect();
        assert_eq!(mser5(&growing), None);
        // Constant from the start: nothing is cut off.
        assert_eq!(mser5(&[2.0; 1000]), Some(0));
    }
}
