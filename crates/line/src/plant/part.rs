//! Mobile units: where they are kept, and what they are made of.

use linewright_language::contract::line::{InitialValue, Line};
use std::ops::{Index, IndexMut};

/// The place of a part in [`Parts`]; used again after the part is gone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct PartIndex(u32);

/// One mobile unit.
#[derive(Debug, Clone, Default)]
pub(super) struct Part {
    /// Unique in its run, from 1.
    pub number: u64,
    /// Its type.
    pub kind: usize,
    /// Whether it has entered the line; before that it is only kept by its source or store.
    pub entered: bool,
    /// When the first of what is in it entered.
    pub birth: f64,
    /// Its numbers, as the type names them.
    pub properties: Vec<f64>,
}

/// All parts that exist. Room of parts that are gone is used again, so that a run needs memory only
/// for what is in the line.
#[derive(Debug, Default)]
pub(super) struct Parts {
    slots: Vec<Part>,
    free: Vec<u32>,
    made: u64,
}

impl Parts {
    /// A new part. `component` finds the first component of a type that it is joined from.
    pub(super) fn create(
        &mut self,
        line: &Line,
        kind: usize,
        component: impl Fn(usize) -> Option<PartIndex>,
    ) -> PartIndex {
        self.made += 1;
        let index = self.free.pop().unwrap_or_else(|| {
            self.slots.push(Part::default());
            self.slots.len() as u32 - 1
        });
        let mut properties = std::mem::take(&mut self.slots[index as usize].properties);
        properties.clear();
        for property in &line.parts[kind].properties {
            properties.push(match property.initial {
                InitialValue::Number(value) => value,
                InitialValue::Component(from, number) => component(from)
                    .and_then(|part| self[part].properties.get(number).copied())
                    .unwrap_or(0.0),
            });
        }
        self.slots[index as usize] = Part {
            number: self.made,
            kind,
            entered: false,
            birth: 0.0,
            properties,
        };
        PartIndex(index)
    }

    /// The part is gone.
    pub(super) fn remove(&mut self, part: PartIndex) {
        self.free.push(part.0);
    }
}

impl Index<PartIndex> for Parts {
    type Output = Part;

    fn index(&self, part: PartIndex) -> &Part {
        &self.slots[part.0 as usize]
    }
}

impl IndexMut<PartIndex> for Parts {
    fn index_mut(&mut self, part: PartIndex) -> &mut Part {
        &mut self.slots[part.0 as usize]
    }
}

/// How many of part type `b` are in one of part type `a`, directly or in its components, at
/// `a * types + b`; a part contains itself once. Bills in a circle (which the resolver refuses) are
/// followed only so deep as there are types.
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
