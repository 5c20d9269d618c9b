//! Series over time in constant memory: a run's length is not known before it ends.
//!
//! Bins are first as narrow as the first of [`WIDTHS`]. When time runs over the last bin, as many
//! neighbours are united as make the next width. Since each width is a multiple of the one before,
//! and round times are multiples of one of them that is not much smaller, charts have bins of round
//! widths.

use crate::html::numbers::round_time;

/// Maximum number of bins before neighbours are united, which leaves at least a 24th of them.
const BINS: usize = 8192;

/// Maximum number of bins of a curve.
pub(super) const CURVE: usize = 480;

/// Widths of bins in seconds. After the last, each is ten times the one before.
const WIDTHS: [f64; 13] = [
    1e-6, 1e-5, 1e-4, 1e-3, 0.01, 0.1, 1.0, 10.0, 60.0, 600.0, 3600.0, 86_400.0, 864_000.0,
];

/// The width after this one, and how many bins become one.
fn wider(width: f64) -> (f64, usize) {
    let next = WIDTHS.into_iter().find(|next| *next > width * 1.5);
    let next = next.unwrap_or(width * 10.0);
    (next, (next / width).round() as usize)
}

/// How many bins of this width make one of a round width, so that up to `end` there are at most
/// `most`; and that width.
fn grouping(width: f64, end: f64, most: usize) -> (usize, f64) {
    let round = round_time(end / most as f64, width);
    ((round / width).round().max(1.0) as usize, round)
}

/// Sums over equal bins of time, at most [`BINS`].
#[derive(Debug, Clone)]
pub struct Sums {
    width: f64,
    sums: Vec<f64>,
}

impl Sums {
    /// Creates bins that are all 0.
    pub fn new() -> Self {
        Self {
            width: WIDTHS[0],
            sums: Vec::new(),
        }
    }

    /// Spreads an amount evenly over the time from `from` to `to`, in seconds. If that is no time,
    /// the amount belongs to the bin of that instant.
    pub fn spread(&mut self, from: f64, to: f64, amount: f64) {
        let (from, to) = (from.max(0.0), to.max(0.0));
        while to >= self.width * BINS as f64 {
            self.widen();
        }
        let (first, last) = (self.bin(from), self.bin(to));
        if self.sums.len() <= last {
            self.sums.resize(last + 1, 0.0);
        }
        if first >= last {
            self.sums[last] += amount;
            return;
        }
        let rate = amount / (to - from);
        for bin in first..=last {
            let start = from.max(bin as f64 * self.width);
            let end = to.min((bin + 1) as f64 * self.width);
            self.sums[bin] += rate * (end - start).max(0.0);
        }
    }

    /// The sums up to `end`, in seconds, in at most `most` bins of a round width, and that width.
    /// What is of the instant `end` is in the last bin.
    pub fn until(mut self, end: f64, most: usize) -> (Vec<f64>, f64) {
        self.spread(end, end, 0.0);
        let count = ((end / self.width).ceil() as usize).max(1);
        let at_end: f64 = self.sums.iter().skip(count).sum();
        self.sums.resize(count, 0.0);
        self.sums[count - 1] += at_end;
        let (each, width) = grouping(self.width, end, most);
        let bins = self.sums.chunks(each);
        (bins.map(|bin| bin.iter().sum()).collect(), width)
    }

    fn bin(&self, time: f64) -> usize {
        (time / self.width) as usize
    }

    fn widen(&mut self) {
        let (width, each) = wider(self.width);
        self.width = width;
        let bins = self.sums.chunks(each);
        self.sums = bins.map(|bin| bin.iter().sum()).collect();
    }
}

/// A number that changes at instants, such as that of the parts in a buffer: its mean and its
/// maximum in each bin of time.
#[derive(Debug, Clone)]
pub struct Steps {
    now: i64,
    since: f64,
    areas: Sums,
    maxima: Vec<i64>,
    maxima_width: f64,
}

impl Steps {
    /// Begins at 0, at time 0.
    pub fn new() -> Self {
        Self {
            now: 0,
            since: 0.0,
            areas: Sums::new(),
            maxima: Vec::new(),
            maxima_width: WIDTHS[0],
        }
    }

    /// Changes the number at this time, in seconds.
    pub fn add(&mut self, time: f64, change: i64) {
        self.advance(time);
        self.now += change;
        self.touch(time, time);
    }

    /// Means and maxima of the bins up to `end`, and the width of a bin, in seconds.
    pub fn until(mut self, end: f64) -> Curve {
        self.advance(end);
        let fine = self.areas.width;
        while self.maxima_width < fine {
            self.widen();
        }
        let (areas, width) = self.areas.until(end, CURVE);
        let (each, _) = grouping(fine, end, CURVE);
        let maxima = self.maxima.chunks(each);
        let mut maxima: Vec<i64> = maxima.map(greatest).collect();
        maxima.resize(areas.len(), 0);
        let means = areas.iter().enumerate().map(|(bin, area)| {
            let seconds = (end - bin as f64 * width).min(width);
            if seconds > 0.0 { area / seconds } else { 0.0 }
        });
        let means = means.collect();
        Curve {
            width,
            end,
            means,
            maxima,
        }
    }

    fn advance(&mut self, time: f64) {
        if time > self.since {
            self.areas
                .spread(self.since, time, self.now as f64 * (time - self.since));
            self.touch(self.since, time);
            self.since = time;
        }
    }

    /// Takes the number into account in the maxima of these bins.
    fn touch(&mut self, from: f64, to: f64) {
        while to >= self.maxima_width * BINS as f64 {
            self.widen();
        }
        let bin = |time: f64| (time / self.maxima_width) as usize;
        let (first, last) = (bin(from), bin(to));
        if self.maxima.len() <= last {
            self.maxima.resize(last + 1, 0);
        }
        for maximum in &mut self.maxima[first..=last] {
            *maximum = self.now.max(*maximum);
        }
    }

    fn widen(&mut self) {
        let (width, each) = wider(self.maxima_width);
        self.maxima_width = width;
        self.maxima = self.maxima.chunks(each).map(greatest).collect();
    }
}

fn greatest(numbers: &[i64]) -> i64 {
    numbers.iter().copied().max().unwrap_or(0)
}

/// A number over time, in bins.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Width of a bin in seconds; the last one may be cut off.
    pub width: f64,
    /// End of the last bin in seconds.
    pub end: f64,
    /// Mean in each bin, over time.
    pub means: Vec<f64>,
    /// Maximum in each bin.
    pub maxima: Vec<i64>,
}

/// How often times fall into classes of equal width, at most [`BINS`].
#[derive(Debug, Clone)]
pub struct Histogram {
    width: f64,
    counts: Vec<u64>,
}

/// Maximum number of columns of a chart.
const COLUMNS: usize = 48;

/// Share of the values above which the end of a histogram is cut off, if it is long and thin.
const NEARLY_ALL: f64 = 0.99;

/// The columns of a histogram.
#[derive(Debug, Clone, PartialEq)]
pub struct Columns {
    /// Width of a column in seconds.
    pub width: f64,
    /// Number of values in each column, from 0 on.
    pub counts: Vec<u64>,
    /// Number of values above the last column.
    pub beyond: u64,
}

impl Histogram {
    /// Creates an empty histogram.
    pub fn new() -> Self {
        Self {
            width: WIDTHS[0],
            counts: Vec::new(),
        }
    }

    /// Counts a time in seconds that is not negative.
    pub fn add(&mut self, seconds: f64) {
        while seconds >= self.width * BINS as f64 {
            let (width, each) = wider(self.width);
            self.width = width;
            let classes = self.counts.chunks(each);
            self.counts = classes.map(|class| class.iter().sum()).collect();
        }
        let class = (seconds / self.width) as usize;
        if self.counts.len() <= class {
            self.counts.resize(class + 1, 0);
        }
        self.counts[class] += 1;
    }

    /// The values in columns. A long and thin end is cut off.
    pub fn columns(&self) -> Columns {
        let all: u64 = self.counts.iter().sum();
        let mut below = 0;
        let nearly_all = self.counts.iter().position(|count| {
            below += count;
            below as f64 >= NEARLY_ALL * all as f64
        });
        let used = nearly_all.map_or(0, |last| last + 1);
        let shown = if 2 * used < self.counts.len() {
            used
        } else {
            self.counts.len()
        };
        let (united, width) = grouping(self.width, shown as f64 * self.width, COLUMNS);
        let shown = (shown.div_ceil(united) * united).min(self.counts.len());
        let columns = self.counts[..shown].chunks(united);
        Columns {
            width,
            counts: columns.map(|column| column.iter().sum()).collect(),
            beyond: self.counts[shown..].iter().sum(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_are_kept_while_bins_are_united() {
        let mut sums = Sums::new();
        for second in 0..10_000 {
            let start = f64::from(second) * 0.7;
            sums.spread(start, start + 0.5, 2.0);
        }
        sums.spread(3.0, 3.0, 5.0);
        let (bins, width) = sums.until(7000.0, CURVE);
        // 7000 s in at most 480 bins.
        assert_eq!((bins.len(), width), (467, 15.0));
        assert!((bins.iter().sum::<f64>() - 20_005.0).abs() < 1e-6);
        // 2 in each 0.7 s.
        assert!((bins[100] / width - 2.0 / 0.7).abs() < 0.1);
    }

    /// Bins go up to the end, also if nothing happened for long, and have what happened there.
    #[test]
    fn the_last_bin_has_the_end() {
        for (end, wanted) in [(7200.0, 480), (7210.0, 481), (86_400.0, 288)] {
            let mut sums = Sums::new();
            sums.spread(50.0, 50.0, 1.0);
            let (bins, _) = sums.clone().until(end, CURVE + 1);
            assert_eq!(
                (bins.len(), bins.iter().sum::<f64>()),
                (wanted, 1.0),
                "{end}"
            );
            sums.spread(end, end, 2.0);
            let (bins, _) = sums.until(end, CURVE + 1);
            assert_eq!(
                (bins.len(), bins.iter().sum::<f64>()),
                (wanted, 3.0),
                "{end}"
            );
            assert_eq!(bins.last(), Some(&2.0), "{end}");
        }
    }

    /// Bins of curves and columns of histograms have round widths, for runs of any length.
    #[test]
    fn widths_are_round() {
        for (end, bin, column) in [
            (0.9, 0.002, 0.02),
            (100.0, 0.5, 5.0),
            (3600.0, 10.0, 120.0),
            (86_400.0, 300.0, 1800.0),
            (604_800.0, 1800.0, 14_400.0),
            (31_536_000.0, 86_400.0, 1_209_600.0),
        ] {
            let (mut sums, mut histogram) = (Sums::new(), Histogram::new());
            for part in 0..1000 {
                let time = f64::from(part) * end / 1000.0;
                sums.spread(time, time, 1.0);
                histogram.add(time);
            }
            let (bins, width) = sums.until(end, CURVE);
            assert!((width / bin - 1.0).abs() < 1e-9, "{end}: {width}");
            assert!(bins.len() <= CURVE && bins.len() > CURVE / 4, "{end}");
            let columns = histogram.columns();
            let width = columns.width;
            assert!((width / column - 1.0).abs() < 1e-9, "{end}: {width}");
            assert_eq!(columns.counts.iter().sum::<u64>(), 1000);
        }
    }

    #[test]
    fn steps_have_their_means_and_maxima() {
        let mut steps = Steps::new();
        steps.add(0.0, 1);
        steps.add(10.0, 3);
        steps.add(10.0, -2);
        steps.add(50.0, -2);
        let curve = steps.until(100.0);
        let area: f64 = curve
            .means
            .iter()
            .enumerate()
            .map(|(bin, mean)| mean * (100.0 - bin as f64 * curve.width).min(curve.width))
            .sum();
        assert!((area - (10.0 + 2.0 * 40.0)).abs() < 1e-6);
        assert_eq!(curve.maxima.iter().max(), Some(&4));
        assert_eq!(*curve.maxima.last().unwrap(), 0);
        assert_eq!(curve.means.len(), curve.maxima.len());
    }

    #[test]
    fn a_histogram_counts_every_value() {
        let mut histogram = Histogram::new();
        for value in 0..1000 {
            histogram.add(f64::from(value) * 0.01);
        }
        let columns = histogram.columns();
        assert_eq!(columns.counts.iter().sum::<u64>(), 1000);
        assert!(columns.counts.len() <= COLUMNS);
        let first = (columns.width / 0.01).ceil() as u64;
        assert!(columns.counts[0].abs_diff(first) <= 1);
        histogram.add(1e6);
        let columns = histogram.columns();
        assert_eq!(
            (columns.counts.iter().sum::<u64>(), columns.beyond),
            (1000, 1)
        );
    }
}
