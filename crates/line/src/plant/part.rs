//! Mobile units: their storage and composition.

use linewright_language::contract::line::{InitialValue, Line};
use std::num::NonZeroU32;
use std::ops::{Index, IndexMut};

/// Index of a part in [`Parts`]; reused after the part is gone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct PartIndex(NonZeroU32);

/// One mobile unit.
#[derive(Debug, Clone, Default)]
pub(super) struct Part {
    /// Number, unique within the run, starting at 1.
    pub number: u64,
    /// Index of the part's type.
    pub kind: usize,
    /// Whether it has entered the line; until then, its source or store holds it.
    pub entered: bool,
    /// Time at which the part, or the first of the components in it, entered the line, in seconds.
    pub entered_at: f64,
    /// Time at which the part itself entered the line: for a joined part, the time of the joining.
    pub since: f64,
    /// Whether a station has begun to work on it for the second time.
    reworked: bool,
    /// Number of single parts in it on which a station had worked before they were joined, and of
    /// those of them on which one had worked twice.
    pub worked_inside: u64,
    pub reworked_inside: u64,
    /// Time at which it began to wait at the outlet of its place, or in a station for other
    /// components; until then without a meaning.
    pub waits_since: f64,
    /// The station, source or store that it has left last.
    pub came_from: Option<u32>,
    /// The station whose work on it ended last.
    pub worked_at: Option<u32>,
    /// The station whose defect changed it last.
    pub defect_at: Option<u32>,
    /// One bit per station, set if it has begun to work on the part; `more_visits` has those of
    /// nodes from 64 on.
    visits: u64,
    more_visits: Vec<u64>,
    /// Property values, in the order of the type's properties.
    pub properties: Vec<f64>,
}

impl Part {
    /// Notes that a station begins to work on the part. Parallel stations are one, given by the
    /// first of them.
    #[inline]
    pub(super) fn visit(&mut self, station: u32) {
        let bit = 1_u64 << (station % 64);
        if station < 64 {
            self.reworked |= self.visits & bit != 0;
            self.visits |= bit;
        } else {
            self.visit_another(station as usize / 64, bit);
        }
    }

    /// The same for a node from 64 on.
    #[inline(never)]
    fn visit_another(&mut self, word: usize, bit: u64) {
        if self.more_visits.len() < word {
            self.more_visits.resize(word, 0);
        }
        let visits = &mut self.more_visits[word - 1];
        self.reworked |= *visits & bit != 0;
        *visits |= bit;
    }

    /// Number of single parts in it on which a station has worked. A part that was joined from
    /// parts on which none had worked counts as one.
    pub(super) fn worked(&self) -> u64 {
        self.worked_inside.max(u64::from(self.worked_at.is_some()))
    }

    /// Number of those on which a station has worked twice.
    pub(super) fn reworked(&self) -> u64 {
        if self.reworked {
            self.worked()
        } else {
            self.reworked_inside
        }
    }
}

/// All existing parts. Slots of removed parts are reused, so that a run needs memory only for what
/// is in the line.
#[derive(Debug)]
pub(super) struct Parts {
    /// The first slot is not used.
    slots: Vec<Part>,
    free: Vec<PartIndex>,
    made: u64,
}

impl Default for Parts {
    fn default() -> Self {
        Self {
            slots: vec![Part::default()],
            free: Vec::new(),
            made: 0,
        }
    }
}

impl Parts {
    /// Creates a part. Of the components that are joined into it, `component` returns the first one
    /// of a given type.
    pub(super) fn create(
        &mut self,
        line: &Line,
        kind: usize,
        component: impl Fn(usize) -> Option<PartIndex>,
    ) -> PartIndex {
        self.made += 1;
        let index = self.free.pop().unwrap_or_else(|| {
            self.slots.push(Part::default());
            PartIndex(NonZeroU32::MIN.saturating_add(self.slots.len() as u32 - 2))
        });
        let mut properties = std::mem::take(&mut self[index].properties);
        properties.clear();
        for property in &line.parts[kind].properties {
            properties.push(match property.initial {
                InitialValue::Number(value) => value,
                InitialValue::Component(from, number) => component(from)
                    .and_then(|part| self[part].properties.get(number).copied())
                    .unwrap_or(0.0),
            });
        }
        let number = self.made;
        let part = &mut self[index];
        part.properties = properties;
        part.more_visits.clear();
        part.visits = 0;
        part.number = number;
        part.kind = kind;
        part.entered = false;
        part.entered_at = 0.0;
        part.since = 0.0;
        part.reworked = false;
        part.worked_inside = 0;
        part.reworked_inside = 0;
        part.came_from = None;
        part.worked_at = None;
        part.defect_at = None;
        index
    }

    /// Removes a part.
    pub(super) fn remove(&mut self, part: PartIndex) {
        self.free.push(part);
    }
}

impl Index<PartIndex> for Parts {
    type Output = Part;

    fn index(&self, part: PartIndex) -> &Part {
        &self.slots[part.0.get() as usize]
    }
}

impl IndexMut<PartIndex> for Parts {
    fn index_mut(&mut self, part: PartIndex) -> &mut Part {
        &mut self.slots[part.0.get() as usize]
    }
}

/// Number of parts of type `b` in one part of type `a`, directly or in its components. The index is
/// `a * types + b`; a part contains itself once. Circular bills (which the resolver rejects) are
/// followed only to a depth equal to the number of types.
pub(super) fn contents(line: &Line) -> Vec<u64> {
    let types = line.parts.len();
    let mut contents = vec![0; types * types];
    for a in 0..types {
        let mut level = vec![0_u64; types];
        level[a] = 1;
        for _ in 0..types {
            let mut below = vec![0_u64; types];
            for (b, &count) in level.iter().enumerate().filter(|(_, count)| **count > 0) {
                let cell: &mut u64 = &mut contents[a * types + b];
                *cell = cell.saturating_add(count);
                for &(component, each) in &line.parts[b].bill {
                    below[component] =
                        below[component].saturating_add(count.saturating_mul(u64::from(each)));
                }
            }
            level = below;
        }
    }
    contents
}
