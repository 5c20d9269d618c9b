//! Statistics of a running line: time by activity, lead times, and confidence intervals.

pub(super) use super::log::Activity;
use super::random::{Purpose, Stream};
use super::trace::{ByState, LeadTime, Oee, OverTime, Percentiles};

/// Books time by activity.
#[derive(Debug, Clone)]
pub(super) struct Clock {
    activity: Activity,
    since: f64,
    seconds: [f64; 7],
}

impl Clock {
    pub(super) fn new(activity: Activity) -> Self {
        Self {
            activity,
            since: 0.0,
            seconds: [0.0; 7],
        }
    }

    /// Switches to this activity at `now`.
    #[inline]
    pub(super) fn switch(&mut self, now: f64, activity: Activity) {
        self.seconds[self.activity as usize] += now - self.since;
        self.since = now;
        self.activity = activity;
    }

    /// The activity under which time is booked now.
    #[inline]
    pub(super) fn activity(&self) -> Activity {
        self.activity
    }

    /// Seconds booked up to `now`.
    pub(super) fn seconds_at(&self, now: f64, activity: Activity) -> f64 {
        let current = if activity == self.activity {
            now - self.since
        } else {
            0.0
        };
        self.seconds(activity) + current
    }

    /// Seconds booked up to the last switch.
    pub(super) fn seconds(&self, activity: Activity) -> f64 {
        self.seconds[activity as usize]
    }

    /// Total time booked up to the last switch, in seconds.
    pub(super) fn total(&self) -> f64 {
        self.seconds.iter().sum()
    }

    /// Seconds on shift, and in overtime, booked up to the last switch: the planned time.
    pub(super) fn planned(&self) -> f64 {
        let off_shift = [Activity::Idle, Activity::FailedOffShift];
        self.total() - off_shift.map(|a| self.seconds(a)).iter().sum::<f64>()
    }

    /// Forgets the time booked before `now`.
    pub(super) fn forget(&mut self, now: f64) {
        self.since = now;
        self.seconds = [0.0; 7];
    }

    /// A copy in which the time up to `now` is booked.
    pub(super) fn at(&self, now: f64) -> Self {
        let mut copy = self.clone();
        copy.switch(now, self.activity);
        copy
    }

    /// The time that was booked after `earlier`, an earlier copy.
    pub(super) fn after(&self, earlier: &Self) -> Self {
        let mut rest = self.clone();
        for (seconds, before) in rest.seconds.iter_mut().zip(earlier.seconds) {
            *seconds -= before;
        }
        rest
    }

    /// Seconds without work, up to the last switch.
    pub(super) fn outside_work(&self) -> f64 {
        (self.total() - self.seconds(Activity::Busy)).max(0.0)
    }

    /// The energy of a station by state: `joules` in all, of which the idle power outside work is
    /// divided. `visited` states whether any part ever reached the station.
    pub(super) fn energy(&self, joules: f64, idle_watts: f64, visited: bool) -> ByState {
        let shares = self.shares(visited);
        let idle = |share: f64| idle_watts * self.total() * share;
        ByState {
            busy: (joules - idle_watts * self.outside_work()).max(0.0),
            starved: idle(shares.starved),
            blocked: idle(shares.blocked),
            failed: idle(shares.failed),
            idle: idle(shares.idle),
            setup: idle(shares.setup),
        }
    }

    /// Shares of the total booked time. `visited` states whether any part ever reached the station.
    /// If no time was booked, the idle share is 1.
    pub(super) fn shares(&self, visited: bool) -> ByState {
        let total = self.total();
        if total <= 0.0 {
            return ByState {
                idle: 1.0,
                ..ByState::default()
            };
        }
        let share = |activity| self.seconds(activity) / total;
        let mut shares = ByState {
            busy: share(Activity::Busy),
            starved: share(Activity::Starved),
            blocked: share(Activity::Blocked),
            failed: share(Activity::Failed) + share(Activity::FailedOffShift),
            idle: share(Activity::Idle),
            setup: share(Activity::Setup),
        };
        if !visited {
            shares.idle += shares.starved;
            shares.starved = 0.0;
        }
        shares
    }
}

/// What a station has made.
#[derive(Debug, Clone, Copy)]
pub(super) struct Output {
    /// Number of parts whose work ended.
    pub processed: u64,
    /// Number of parts that a failure scrapped during the work.
    pub broken: u64,
    /// Number of parts that were rejected because of the station, with those that are broken.
    pub scrapped: u64,
    /// Seconds of work that was lost because it began again after a failure.
    pub lost_seconds: f64,
}

impl Output {
    /// What was made after `earlier`, an earlier copy.
    pub(super) fn after(self, earlier: Self) -> Self {
        Self {
            processed: self.processed - earlier.processed,
            broken: self.broken - earlier.broken,
            scrapped: self.scrapped - earlier.scrapped,
            lost_seconds: self.lost_seconds - earlier.lost_seconds,
        }
    }

    /// Overall equipment effectiveness in the time of the clock; `None` without planned time,
    /// without work, or if no work ended. Planned time times quantity is the time in work without
    /// the work that was lost, which also holds for a part that is in work at the start or the end.
    pub(super) fn oee(&self, clock: &Clock) -> Option<Oee> {
        let (busy, planned) = (clock.seconds(Activity::Busy), clock.planned());
        (busy > 0.0 && planned > 0.0 && self.processed > 0).then(|| Oee {
            availability: (busy / planned).min(1.0),
            effectiveness: (1.0 - self.lost_seconds / busy).max(0.0),
            quality: (1.0 - self.scrapped as f64 / (self.processed + self.broken) as f64).max(0.0),
        })
    }
}

/// A number of parts that changes in steps, with its integral over time.
#[derive(Debug, Clone)]
pub(super) struct Level {
    now: u32,
    max: u32,
    capacity: u32,
    since: f64,
    seconds: f64,
    area: f64,
    full_seconds: f64,
}

impl Level {
    /// Begins at 0, at time 0. Time with `capacity` counts as full.
    pub(super) fn new(capacity: u32) -> Self {
        Self {
            now: 0,
            capacity,
            since: 0.0,
            seconds: 0.0,
            area: 0.0,
            full_seconds: 0.0,
            max: 0,
        }
    }

    /// Counts the time since the last change.
    #[inline]
    pub(super) fn advance(&mut self, now: f64) {
        let seconds = now - self.since;
        self.since = now;
        self.seconds += seconds;
        self.area += f64::from(self.now) * seconds;
        if self.now == self.capacity {
            self.full_seconds += seconds;
        }
    }

    /// Increases the number by one.
    #[inline]
    pub(super) fn increase(&mut self, now: f64) {
        self.advance(now);
        self.now += 1;
        self.max = self.max.max(self.now);
    }

    /// Decreases the number by one.
    #[inline]
    pub(super) fn decrease(&mut self, now: f64) {
        self.advance(now);
        self.now = self.now.saturating_sub(1);
    }

    /// Forgets the past, but not the number.
    pub(super) fn forget(&mut self, now: f64) {
        *self = Self {
            now: self.now,
            since: now,
            max: self.now,
            ..Self::new(self.capacity)
        };
    }

    /// A copy in which the time up to `now` is counted.
    pub(super) fn at(&self, now: f64) -> Self {
        let mut copy = self.clone();
        copy.advance(now);
        copy
    }

    /// What was counted after `earlier`, an earlier copy. The maximum is that of both.
    pub(super) fn after(&self, earlier: &Self) -> Self {
        Self {
            seconds: self.seconds - earlier.seconds,
            area: self.area - earlier.area,
            full_seconds: self.full_seconds - earlier.full_seconds,
            ..self.clone()
        }
    }

    /// The number now.
    #[inline]
    pub(super) fn level(&self) -> u32 {
        self.now
    }

    /// Whether the number is the capacity, or above it.
    pub(super) fn is_full(&self) -> bool {
        self.now >= self.capacity
    }

    /// The integral over time, up to the last change.
    pub(super) fn area(&self) -> f64 {
        self.area
    }

    /// Mean over time, up to the last change; 0 if no time has passed.
    pub(super) fn mean(&self) -> f64 {
        if self.seconds > 0.0 {
            self.area / self.seconds
        } else {
            0.0
        }
    }

    /// Share of the time in which the number was the capacity; 0 if no time has passed.
    pub(super) fn full_share(&self) -> f64 {
        if self.seconds > 0.0 {
            self.full_seconds / self.seconds
        } else {
            0.0
        }
    }

    /// Maximum.
    pub(super) fn max(&self) -> u64 {
        u64::from(self.max)
    }
}

/// Maximum number of bins of a [`Profile`].
const MAX_BINS: usize = 300;

/// Widths of its bins in seconds. Each is a multiple of the one before, so that bins can be united.
const WIDTHS: [f64; 28] = [
    1e-6,
    5e-6,
    1e-5,
    5e-5,
    1e-4,
    5e-4,
    1e-3,
    5e-3,
    0.01,
    0.05,
    0.1,
    0.5,
    1.0,
    5.0,
    10.0,
    30.0,
    60.0,
    300.0,
    600.0,
    1800.0,
    3600.0,
    14_400.0,
    43_200.0,
    86_400.0,
    432_000.0,
    864_000.0,
    4_320_000.0,
    8_640_000.0,
];

/// A [`Level`] over time: its integral up to the end of each of equal bins. How long a run will
/// last is not known; when the bins do not suffice, neighbors are united. Between the ends of bins,
/// a change of the level costs a comparison.
#[derive(Debug, Clone)]
pub(super) struct Profile {
    /// Index into [`WIDTHS`].
    width: usize,
    /// End of the bin that is open, in seconds.
    end: f64,
    /// By closed bin: the integral up to its end.
    areas: Vec<f64>,
    /// The integral up to the time from which on the level counts.
    before: f64,
}

impl Default for Profile {
    fn default() -> Self {
        Self {
            width: 0,
            end: WIDTHS[0],
            areas: Vec::new(),
            before: 0.0,
        }
    }
}

impl Profile {
    /// Closes the bins that have ended at `now`. The level has not changed since they have.
    #[inline]
    pub(super) fn advance(&mut self, now: f64, level: &Level) {
        if now >= self.end {
            self.close(now, level);
        }
    }

    #[cold]
    #[inline(never)]
    fn close(&mut self, now: f64, level: &Level) {
        while now > WIDTHS[self.width] * MAX_BINS as f64 && self.width + 1 < WIDTHS.len() {
            let (narrow, wide) = (WIDTHS[self.width], WIDTHS[self.width + 1]);
            let each = (wide / narrow).round() as usize;
            self.width += 1;
            let ends = self.areas.iter().skip(each - 1).step_by(each);
            self.areas = ends.copied().collect();
            self.end = self.end_of_next();
        }
        while now >= self.end {
            let ahead = f64::from(level.now) * (self.end - level.since);
            self.areas.push(self.before + level.area + ahead);
            self.end = self.end_of_next();
        }
    }

    fn end_of_next(&self) -> f64 {
        (self.areas.len() + 1) as f64 * WIDTHS[self.width]
    }

    /// The level forgets its past at `now`.
    pub(super) fn forget(&mut self, now: f64, level: &Level) {
        self.advance(now, level);
        self.before += level.at(now).area;
    }

    /// The mean of the level in each bin up to `now`. The last bin may be shorter.
    pub(super) fn over_time(mut self, now: f64, level: &Level) -> OverTime {
        self.advance(now, level);
        let width = WIDTHS[self.width];
        let mut start = 0.0;
        let mut means: Vec<f64> = Vec::with_capacity(self.areas.len() + 1);
        for area in &self.areas {
            means.push(((area - start) / width).max(0.0));
            start = *area;
        }
        let rest = now - self.areas.len() as f64 * width;
        if rest > 0.0 {
            let area = self.before + level.at(now).area;
            means.push(((area - start) / rest).max(0.0));
        }
        OverTime {
            bin_seconds: width,
            means,
        }
    }
}

/// Number, sum and maximum of waiting times.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Waits {
    pub count: u64,
    sum: f64,
    pub max: f64,
}

impl Waits {
    #[inline]
    pub(super) fn add(&mut self, seconds: f64) {
        self.count += 1;
        self.sum += seconds;
        if seconds > self.max {
            self.max = seconds;
        }
    }

    /// What was added after `earlier`, an earlier copy. The maximum is that of both.
    pub(super) fn after(self, earlier: Self) -> Self {
        Self {
            count: self.count - earlier.count,
            sum: self.sum - earlier.sum,
            max: self.max,
        }
    }

    /// The sum of all times.
    pub(super) fn sum(self) -> f64 {
        self.sum
    }

    /// Mean; 0 if nothing has waited.
    pub(super) fn mean(&self) -> f64 {
        if self.count > 0 {
            self.sum / self.count as f64
        } else {
            0.0
        }
    }
}

/// Maximum number of times stored for the percentiles. If there are more, each is equally
/// likely to be stored.
const SAMPLE: usize = 1 << 17;

/// Lead or waiting times: mean and maximum of all, percentiles of a bounded sample (Vitter's
/// reservoir, algorithm R).
#[derive(Debug)]
pub(super) struct Times {
    count: u64,
    sum: f64,
    max: f64,
    sample: Vec<f64>,
    stream: Stream,
}

impl Times {
    pub(super) fn new(seed: u64) -> Self {
        Self {
            count: 0,
            sum: 0.0,
            max: 0.0,
            sample: Vec::new(),
            stream: Stream::new(seed, Purpose::Sample, ""),
        }
    }

    pub(super) fn add(&mut self, seconds: f64) {
        self.count += 1;
        self.sum += seconds;
        self.max = self.max.max(seconds);
        if self.sample.len() < SAMPLE {
            self.sample.push(seconds);
        } else if let Some(kept) = self.sample.get_mut(self.stream.below(self.count) as usize) {
            *kept = seconds;
        }
    }

    /// Number of times.
    pub(super) fn count(&self) -> u64 {
        self.count
    }

    pub(super) fn summary(&mut self) -> LeadTime {
        if self.count == 0 {
            return LeadTime::default();
        }
        LeadTime {
            mean: self.sum / self.count as f64,
            p50: nearest_rank(&mut self.sample, 0.50),
            p95: nearest_rank(&mut self.sample, 0.95),
            max: self.max,
        }
    }

    /// The percentiles with these numbers; none without times.
    pub(super) fn percentiles(&mut self, numbers: &[u8]) -> Percentiles {
        if self.count == 0 {
            return Percentiles::default();
        }
        let numbers = numbers.iter();
        let percentiles = numbers.map(|number| {
            let share = f64::from(*number) / 100.0;
            (*number, nearest_rank(&mut self.sample, share))
        });
        Percentiles(percentiles.collect())
    }
}

/// The smallest value that at least this share of the values does not exceed (nearest rank); 0
/// without values. Reorders the values, in linear time.
fn nearest_rank(values: &mut [f64], share: f64) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let rank = (share * values.len() as f64).ceil() as usize;
    let index = rank.clamp(1, values.len()) - 1;
    *values.select_nth_unstable_by(index, f64::total_cmp).1
}

/// The 97.5 % quantile of Student's t distribution: half the width of a 95 % confidence interval,
/// in standard errors.
pub(super) fn student_t(degrees: u64) -> f64 {
    const TABLE: [f64; 30] = [
        12.706_205, 4.302_653, 3.182_446, 2.776_445, 2.570_582, 2.446_912, 2.364_624, 2.306_004,
        2.262_157, 2.228_139, 2.200_985, 2.178_813, 2.160_369, 2.144_787, 2.131_450, 2.119_905,
        2.109_816, 2.100_922, 2.093_024, 2.085_963, 2.079_614, 2.073_873, 2.068_658, 2.063_899,
        2.059_539, 2.055_529, 2.051_831, 2.048_407, 2.045_230, 2.042_272,
    ];
    match degrees {
        0 => f64::INFINITY,
        1..=30 => TABLE[degrees as usize - 1],
        _ => {
            // The Cornish-Fisher expansion of Student's t quantile around the normal quantile
            // (Abramowitz and Stegun 26.7.5). With 31 degrees of freedom, its error is less than
            // 2e-6.
            let z: f64 = 1.959_963_985;
            let n = degrees as f64;
            let first = (z.powi(3) + z) / 4.0;
            let second = (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / 96.0;
            let third = (3.0 * z.powi(7) + 19.0 * z.powi(5) + 17.0 * z.powi(3) - 15.0 * z) / 384.0;
            z + first / n + second / (n * n) + third / (n * n * n)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_nearest_ranks() {
        let mut times = Times::new(1);
        for x in (1..=20).rev() {
            times.add(f64::from(x));
        }
        let summary = times.summary();
        assert_eq!(
            (summary.mean, summary.p50, summary.p95, summary.max),
            (10.5, 10.0, 19.0, 20.0)
        );
        let percentiles = times.percentiles(&[1, 90, 99]);
        let of = |number| percentiles.get(number);
        assert_eq!(
            (of(1), of(90), of(99), of(98)),
            (Some(1.0), Some(18.0), Some(20.0), None)
        );
    }

    #[test]
    fn a_large_sample_stays_representative() {
        let mut times = Times::new(1);
        for x in 0..1_000_000_u32 {
            times.add(f64::from(x));
        }
        assert_eq!(times.sample.len(), SAMPLE);
        let summary = times.summary();
        assert!((summary.p50 / 500_000.0 - 1.0).abs() < 0.01);
        assert!((summary.p95 / 950_000.0 - 1.0).abs() < 0.01);
    }

    /// A level that is 1 in every second quarter of an hour, for two days, with a warm-up of a day.
    #[test]
    fn a_profile_has_the_means_of_its_bins() {
        let (mut level, mut profile) = (Level::new(u32::MAX), Profile::default());
        for quarter in 0..192_u32 {
            let now = 900.0 * f64::from(quarter);
            profile.advance(now, &level);
            if quarter == 96 {
                profile.forget(now, &level);
                level.forget(now);
            }
            if quarter % 2 == 0 {
                level.increase(now);
            } else {
                level.decrease(now);
            }
        }
        let end = 192.0 * 900.0 + 450.0;
        let over_time = profile.over_time(end, &level);
        assert!((over_time.bin_seconds - 600.0).abs() < 1e-9);
        assert_eq!(over_time.means.len(), 289);
        let third = [1.0, 0.5, 0.0];
        for (bin, mean) in over_time.means.iter().enumerate() {
            let wanted = if bin == 288 { 0.0 } else { third[bin % 3] };
            assert!((mean - wanted).abs() < 1e-9, "{bin}: {mean}");
        }
    }

    #[test]
    fn student_t_meets_the_tables() {
        // Printed values for 40, 60 and 120 degrees of freedom, and the step from the table to the
        // expansion.
        for (degrees, expected) in [(40, 2.021_08), (60, 2.000_30), (120, 1.979_93)] {
            assert!((student_t(degrees) - expected).abs() < 1e-5);
        }
        assert!((student_t(31) - 2.039_513).abs() < 5e-6);
        assert!((student_t(1_000_000) - 1.959_966).abs() < 1e-5);
    }
}
