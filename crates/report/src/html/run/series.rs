//! Series over time in constant memory: a run's length is not known before it ends.

/// Number of bins in use at the end of a run: between this and twice as many.
const BINS: usize = 360;

/// Width of a bin at the start, in seconds.
const FIRST_WIDTH: f64 = 1e-6;

/// Sums over equal bins of time. When time runs over the last bin, neighbours are united, so that
/// there are never more than twice [`BINS`].
#[derive(Debug, Clone)]
pub struct Sums {
    width: f64,
    sums: Vec<f64>,
}

impl Sums {
    /// Creates bins that are all 0.
    pub fn new() -> Self {
        Self {
            width: FIRST_WIDTH,
            sums: Vec::new(),
        }
    }

    /// Width of a bin in seconds.
    pub fn width(&self) -> f64 {
        self.width
    }

    /// Spreads an amount evenly over the time from `from` to `to`, in seconds. If that is no time,
    /// the amount belongs to the bin of that instant.
    pub fn spread(&mut self, from: f64, to: f64, amount: f64) {
        let (from, to) = (from.max(0.0), to.max(0.0));
        while to >= self.width * (2 * BINS) as f64 {
            self.double();
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

    /// The sums of the bins up to `end`, in seconds.
    pub fn until(mut self, end: f64) -> Vec<f64> {
        let count = (end / self.width).ceil() as usize;
        self.sums.resize(count.clamp(1, 2 * BINS + 1), 0.0);
        self.sums
    }

    fn bin(&self, time: f64) -> usize {
        (time / self.width) as usize
    }

    fn double(&mut self) {
        self.width *= 2.0;
        let pairs = self.sums.chunks(2);
        self.sums = pairs.map(|pair| pair.iter().sum()).collect();
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
            maxima_width: FIRST_WIDTH,
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
        let width = self.areas.width();
        while self.maxima_width < width {
            self.double();
        }
        let areas = self.areas.until(end);
        let count = areas.len();
        let means = areas.iter().enumerate().map(|(bin, area)| {
            let seconds = (end - bin as f64 * width).min(width);
            if seconds > 0.0 { area / seconds } else { 0.0 }
        });
        let means = means.collect();
        self.maxima.resize(count, 0);
        Curve {
            width,
            end,
            means,
            maxima: self.maxima,
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
        while to >= self.maxima_width * (2 * BINS) as f64 {
            self.double();
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

    fn double(&mut self) {
        self.maxima_width *= 2.0;
        let pairs = self.maxima.chunks(2);
        self.maxima = pairs
            .map(|pair| pair.iter().copied().max().unwrap_or(0))
            .collect();
    }
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

/// How often values fall into classes of equal width. When a value lies above the last class,
/// neighbours are united.
#[derive(Debug, Clone)]
pub struct Histogram {
    width: f64,
    counts: Vec<u64>,
}

/// Maximum number of classes.
const CLASSES: usize = 1024;

/// Number of columns of a chart: at most this, and usually more than half of it.
const COLUMNS: usize = 48;

/// Share of the values above which the end of a histogram is cut off, if it is long and thin.
const NEARLY_ALL: f64 = 0.99;

/// The columns of a histogram.
#[derive(Debug, Clone, PartialEq)]
pub struct Columns {
    /// Width of a column, in the unit of the values.
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
            width: FIRST_WIDTH,
            counts: Vec::new(),
        }
    }

    /// Counts a value that is not negative.
    pub fn add(&mut self, value: f64) {
        while value >= self.width * CLASSES as f64 {
            self.width *= 2.0;
            let pairs = self.counts.chunks(2);
            self.counts = pairs.map(|pair| pair.iter().sum()).collect();
        }
        let class = (value / self.width) as usize;
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
        let united = shown.div_ceil(COLUMNS).max(1);
        let shown = (shown.div_ceil(united) * united).min(self.counts.len());
        let columns = self.counts[..shown].chunks(united);
        Columns {
            width: self.width * united as f64,
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
        let width = sums.width();
        let bins = sums.until(7000.0);
        assert!((BINS..=2 * BINS).contains(&bins.len()));
        assert!((bins.iter().sum::<f64>() - 20_005.0).abs() < 1e-6);
        // 2 in each 0.7 s.
        assert!((bins[100] / width - 2.0 / 0.7).abs() < 0.1);
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
