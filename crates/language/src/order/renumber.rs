//! Renumbering of skills, so that two skill sets can be compared call by call.

use super::{Event, Kind, Skills};

impl Skills {
    /// Returns the same set with skill `i` moved to index `places[i]`.
    ///
    /// # Panics
    /// When `places` is not a permutation of the skills' indices.
    #[must_use]
    pub fn renumbered(&self, places: &[usize]) -> Self {
        let mut skills = self.clone();
        let mut order: Vec<usize> = (0..places.len()).collect();
        order.sort_by_key(|i| places[*i]);
        skills.skills = order.iter().map(|i| self.skills[*i].clone()).collect();
        for (i, place) in places.iter().enumerate() {
            assert_eq!(
                skills.skills[*place], self.skills[i],
                "each place is taken once"
            );
        }
        for rule in &mut skills.rules {
            match &mut rule.kind {
                Kind::Never(events) => renumber(events, places),
                Kind::After { from, until, never } => {
                    for events in [from, until, never] {
                        renumber(events, places);
                    }
                }
                Kind::Before { first, then } => {
                    for events in [first, then] {
                        renumber(events, places);
                    }
                }
                Kind::OnlyAfter { what, after } => {
                    for events in [what, after] {
                        renumber(events, places);
                    }
                }
                Kind::AtMost {
                    of, from, until, ..
                } => {
                    for events in [of, from, until] {
                        renumber(events, places);
                    }
                }
                Kind::InARow(words) => {
                    for place in words.iter_mut().flatten() {
                        renumber(place, places);
                    }
                }
                Kind::Sequence(regex) => regex.renumber(places),
            }
        }
        skills
    }
}

fn renumber(events: &mut [Event], places: &[usize]) {
    for event in events {
        for skill in &mut event.0 {
            *skill = places[*skill];
        }
        event.0.sort_unstable();
    }
}
