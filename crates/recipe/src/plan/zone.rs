//! Sets of times: what is known of the times at which resources become free.
//!
//! Where a resource may wait, a plan loses nothing by beginning its next transition as late as it
//! likes, so a least time is all there is to know. A resource that may not wait begins its next
//! transition at once; the time at which it does (its *anchor*) can still be later than its least
//! value, and others depend on it. So a zone holds, for each variable x, lower bounds of x and of
//! x - a for each anchor a. This is a difference bound matrix (D. L. Dill, "Timing assumptions and
//! verification of finite-state concurrent systems", CAV 1989) without the columns that are never
//! needed. Its least solution satisfies all bounds at once.

/// No bound.
const FREE: i64 = i64::MIN / 4;

/// A set of times.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct Zone {
    /// Least value of each variable.
    pub low: Vec<i64>,
    /// Variables that are anchors, ascending.
    pub anchors: Vec<u16>,
    /// For each variable and anchor, the least difference of the two.
    apart: Vec<i64>,
    /// The negated greatest value of each anchor, or [`FREE`].
    high: Vec<i64>,
}

/// What an event does to a variable: the variable's resource is busy from the event's time plus
/// `begin` to the event's time plus `end`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shift {
    pub variable: u16,
    pub begin: i64,
    pub end: i64,
    /// Whether the variable is an anchor afterward.
    pub is_anchor: bool,
}

/// A square matrix of least differences between the origin, the anchors, and one new time.
struct Matrix {
    size: usize,
    cells: Vec<i64>,
}

impl Matrix {
    fn at(&self, x: usize, y: usize) -> i64 {
        self.cells[x * self.size + y]
    }

    fn raise(&mut self, x: usize, y: usize, value: i64) {
        let cell = &mut self.cells[x * self.size + y];
        *cell = (*cell).max(value);
    }

    /// Computes all consequences. Returns whether there is a solution.
    fn close(&mut self) -> bool {
        for via in 0..self.size {
            for x in 0..self.size {
                let first = self.at(x, via);
                if first <= FREE {
                    continue;
                }
                for y in 0..self.size {
                    let second = self.at(via, y);
                    if second > FREE {
                        self.raise(x, y, first + second);
                    }
                }
            }
        }
        (0..self.size).all(|x| self.at(x, x) <= 0)
    }
}

fn sum(a: i64, b: i64) -> i64 {
    if a <= FREE || b <= FREE { FREE } else { a + b }
}

impl Zone {
    /// Creates a zone in which each variable is at least its value, and each anchor equal to it.
    pub fn new(low: Vec<i64>, anchors: Vec<u16>) -> Self {
        let value = |a: &u16| low[*a as usize];
        let apart = (low.iter())
            .flat_map(|x| anchors.iter().map(move |a| x - value(a)))
            .collect();
        let high = anchors.iter().map(|a| -value(a)).collect();
        Self {
            low,
            anchors,
            apart,
            high,
        }
    }

    fn apart(&self, variable: usize, anchor: usize) -> i64 {
        self.apart[variable * self.anchors.len() + anchor]
    }

    /// Returns the matrix of the anchors, with one new time as the last.
    fn matrix(&self) -> Matrix {
        let count = self.anchors.len();
        let size = count + 2;
        let mut matrix = Matrix {
            size,
            cells: vec![FREE; size * size],
        };
        for x in 0..size {
            matrix.raise(x, x, 0);
        }
        for (k, variable) in self.anchors.iter().enumerate() {
            matrix.raise(k + 1, 0, self.low[*variable as usize]);
            matrix.raise(0, k + 1, self.high[k]);
            for other in 0..count {
                matrix.raise(k + 1, other + 1, self.apart(*variable as usize, other));
            }
        }
        matrix
    }

    /// Requires the new time to be at least a variable minus an offset.
    fn follow(&self, matrix: &mut Matrix, variable: u16, offset: i64) {
        let new = matrix.size - 1;
        matrix.raise(new, 0, self.low[variable as usize] - offset);
        for anchor in 0..self.anchors.len() {
            let apart = self.apart(variable as usize, anchor);
            if apart > FREE {
                matrix.raise(new, anchor + 1, apart - offset);
            }
        }
    }

    /// Returns the bounds of a variable against each time of a closed matrix.
    fn row(&self, matrix: &Matrix, variable: usize) -> Vec<i64> {
        let bound = |y: usize| {
            let anchors =
                (0..self.anchors.len()).map(|k| sum(self.apart(variable, k), matrix.at(k + 1, y)));
            let origin = sum(self.low[variable], matrix.at(0, y));
            anchors.fold(origin, i64::max)
        };
        (0..matrix.size).map(bound).collect()
    }

    /// Returns the zone after an event, or nothing if it is not possible. The event begins no
    /// earlier than the variables in `after`; `results` are new values, as offsets to its time.
    pub fn apply(&self, shifts: &[Shift], after: &[u16], results: &[(u16, i64)]) -> Option<Self> {
        if self.anchors.is_empty() && !shifts.iter().any(|s| s.is_anchor) {
            let before = shifts
                .iter()
                .map(|s| self.low[s.variable as usize] - s.begin);
            let after = after.iter().map(|v| self.low[*v as usize]);
            let time = before.chain(after).max().unwrap_or(0);
            let mut low = self.low.clone();
            for shift in shifts {
                low[shift.variable as usize] = time + shift.end;
            }
            for (variable, end) in results {
                low[*variable as usize] = time + end;
            }
            return Some(Self {
                low,
                anchors: Vec::new(),
                apart: Vec::new(),
                high: Vec::new(),
            });
        }
        let mut matrix = self.matrix();
        let new = matrix.size - 1;
        for shift in shifts {
            match self.anchors.binary_search(&shift.variable) {
                Ok(k) => {
                    matrix.raise(new, k + 1, -shift.begin);
                    matrix.raise(k + 1, new, shift.begin);
                }
                Err(_) => self.follow(&mut matrix, shift.variable, shift.begin),
            }
        }
        for variable in after {
            self.follow(&mut matrix, *variable, 0);
        }
        if !matrix.close() {
            return None;
        }
        // Each anchor as a time of the matrix with an offset.
        let moved = |v: u16| shifts.iter().find(|s| s.variable == v);
        let mut anchors: Vec<(u16, usize, i64)> = (self.anchors.iter().enumerate())
            .filter(|(_, v)| moved(**v).is_none())
            .map(|(k, v)| (*v, k + 1, 0))
            .collect();
        let begun = shifts.iter().filter(|s| s.is_anchor);
        anchors.extend(begun.map(|s| (s.variable, new, s.end)));
        anchors.sort_unstable();
        let end = |variable: usize| {
            let result = results.iter().find(|(v, _)| *v as usize == variable);
            (result.map(|r| r.1)).or_else(|| moved(variable as u16).map(|s| s.end))
        };
        let mut zone = Self {
            low: Vec::with_capacity(self.low.len()),
            anchors: anchors.iter().map(|a| a.0).collect(),
            apart: Vec::with_capacity(self.low.len() * anchors.len()),
            high: Vec::with_capacity(anchors.len()),
        };
        for variable in 0..self.low.len() {
            let row: Vec<i64> = match end(variable) {
                Some(end) => (0..matrix.size)
                    .map(|y| sum(matrix.at(new, y), end))
                    .collect(),
                None => self.row(&matrix, variable),
            };
            zone.low.push(row[0]);
            let columns = anchors.iter().map(|(_, y, offset)| sum(row[*y], -offset));
            zone.apart.extend(columns);
        }
        let highs = anchors
            .iter()
            .map(|(_, y, offset)| sum(matrix.at(0, *y), -offset));
        zone.high.extend(highs);
        Some(zone)
    }

    /// Returns the least time that follows some variables, is at least `least`, and is not after an
    /// anchor or, with `ends`, is equal to all anchors; and the least value of each variable then.
    /// Nothing if there is no such time.
    pub fn settle(&self, after: &[u16], least: i64, ends: bool) -> Option<(i64, Vec<i64>)> {
        let mut matrix = self.matrix();
        let new = matrix.size - 1;
        matrix.raise(new, 0, least);
        for variable in after {
            self.follow(&mut matrix, *variable, 0);
        }
        for k in 0..self.anchors.len() {
            matrix.raise(k + 1, new, 0);
            if ends {
                matrix.raise(new, k + 1, 0);
            }
        }
        if !matrix.close() {
            return None;
        }
        let low = (0..self.low.len()).map(|v| match self.anchors.binary_search(&(v as u16)) {
            Ok(k) => matrix.at(k + 1, 0),
            Err(_) => self.row(&matrix, v)[0],
        });
        Some((matrix.at(new, 0), low.collect()))
    }

    /// Returns whether what can follow the other zone can follow this one, no later, where both
    /// have the same anchors: this zone, moved to a later time as a whole, has all times of the
    /// other.
    pub fn includes(&self, other: &Self) -> bool {
        let highs = self.high.iter().zip(&other.high);
        let mut delay = 0;
        for (own, others) in highs {
            if own > others {
                if *others <= FREE {
                    return false;
                }
                delay = delay.max(own - others);
            }
        }
        let mut lows = self.low.iter().zip(&other.low);
        lows.all(|(a, b)| a + delay <= *b)
            && (self.apart.iter().zip(&other.apart)).all(|(a, b)| a <= b)
    }

    /// Raises each variable to that of the clock minus its lead, since nothing begins earlier.
    /// Returns whether this is possible.
    pub fn lift(&mut self, clock: u16, lead: impl Fn(u16) -> i64) -> bool {
        let clock = clock as usize;
        let width = self.anchors.len();
        for variable in 0..self.low.len() {
            let lead = lead(variable as u16);
            if let Ok(k) = self.anchors.binary_search(&(variable as u16)) {
                let is_past = self.high[k] > FREE && self.low[clock] - lead > -self.high[k];
                if is_past || self.apart(clock, k) - lead > 0 {
                    return false;
                }
                continue;
            }
            self.low[variable] = self.low[variable].max(self.low[clock] - lead);
            for k in 0..width {
                let least = sum(self.apart(clock, k), -lead);
                let own = &mut self.apart[variable * width + k];
                *own = (*own).max(least);
            }
        }
        true
    }

    /// Returns the zone with variables renumbered: variable `order[v]` becomes `v`. Anchors keep
    /// their numbers.
    pub fn reorder(&mut self, first: usize, order: &[usize]) {
        let width = self.anchors.len();
        let (low, apart) = (self.low.clone(), self.apart.clone());
        for (to, from) in order.iter().enumerate() {
            let (to, from) = (first + to, first + from);
            self.low[to] = low[from];
            self.apart[to * width..][..width].copy_from_slice(&apart[from * width..][..width]);
        }
    }
}
