//! How parts choose between several routes: in turn, or by chance.

use crate::random::{Purpose, Stream};
use linewright_language::contract::line::{Choice, Line};

/// State of a choice.
#[derive(Debug, Clone)]
pub(super) enum Chooser {
    /// It stays open until a place has room.
    Open,
    /// The number of the route whose turn it is, and the number of routes.
    Turn { next: u32, count: u32 },
    /// By chance. What was drawn holds until a part has taken the route, so that parts that
    /// overtake one another do not change the probabilities.
    Draw {
        shares: Vec<f64>,
        drawn: Option<u32>,
        stream: Stream,
    },
}

impl Chooser {
    /// The choices of a line, at the start of a run.
    pub(super) fn all(line: &Line, seed: u64) -> Vec<Self> {
        let mut names: Vec<(usize, usize)> = Vec::new();
        let mut choosers = Vec::new();
        for (index, choice) in line.choices.iter().enumerate() {
            let mut routes = line.routes.iter().filter(|r| r.choice == Some(index));
            let Some(first) = routes.next() else {
                choosers.push(Self::Open);
                continue;
            };
            choosers.push(match choice {
                Choice::FirstFree | Choice::ShortestQueue => Self::Open,
                Choice::RoundRobin => Self::Turn {
                    next: 0,
                    count: 1 + routes.count() as u32,
                },
                Choice::Probability { shares } => {
                    let start = (first.from, first.part);
                    let earlier = names.iter().filter(|name| **name == start).count();
                    names.push(start);
                    let (from, part) = (&line.nodes[first.from].name, &line.parts[first.part].name);
                    let name = if earlier == 0 {
                        format!("{from}.{part}")
                    } else {
                        format!("{from}.{part}.{}", earlier + 1)
                    };
                    Self::Draw {
                        shares: shares.clone(),
                        drawn: None,
                        stream: Stream::new(seed, Purpose::Routes, &name),
                    }
                }
            });
        }
        choosers
    }

    /// The number of the route that the next part takes; `None` if this is open.
    pub(super) fn choose(&mut self) -> Option<u32> {
        match self {
            Self::Open => None,
            Self::Turn { next, .. } => Some(*next),
            Self::Draw {
                shares,
                drawn,
                stream,
            } => Some(*drawn.get_or_insert_with(|| {
                let mut left = stream.unit();
                let last = shares.len() - 1;
                let drawn = shares[..last].iter().position(|share| {
                    left -= share;
                    left < 0.0
                });
                drawn.unwrap_or(last) as u32
            })),
        }
    }

    /// A part has taken a route of the choice.
    pub(super) fn chosen(&mut self) {
        match self {
            Self::Open => {}
            Self::Turn { next, count } => *next = (*next + 1) % *count,
            Self::Draw { drawn, .. } => *drawn = None,
        }
    }
}
