//! Five stations in a row for NeXosim: exponential services of mean 1 s, buffers of three, blocking
//! after service, a source that is never empty. The argument is the number of parts.
//!
//! Each station is a model with the buffer in front of it. It knows how much room is left behind
//! it: it takes some for each part that it hands on, and gets it back when that part has left the
//! next station. One thread runs all models, because five small models do not gain by more.

use nexosim::model::{Context, Model, schedulable};
use nexosim::ports::Output;
use nexosim::simulation::{Mailbox, SimInit};
use nexosim::time::MonotonicTime;
use serde::{Deserialize, Serialize};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

/// Parts that have left the last station.
static MADE: AtomicU64 = AtomicU64::new(0);

const STATIONS: usize = 5;
/// Places in a buffer and in the station behind it.
const PLACES: u64 = 4;

#[derive(Serialize, Deserialize)]
struct Station {
    part: Output<()>,
    room: Output<()>,
    waiting: u64,
    places_behind: u64,
    works: bool,
    is_done: bool,
    is_last: bool,
    random: u64,
}

#[Model]
impl Station {
    #[nexosim(init)]
    async fn init(&mut self, context: &Context<Self>) {
        self.begin(context);
    }

    /// A part comes into the buffer.
    async fn arrive(&mut self, _: (), context: &Context<Self>) {
        self.waiting += 1;
        self.begin(context);
    }

    /// A part has left the next station.
    async fn make_room(&mut self, _: (), context: &Context<Self>) {
        self.places_behind += 1;
        self.hand_on(context).await;
    }

    #[nexosim(schedulable)]
    async fn end(&mut self, _: (), context: &Context<Self>) {
        self.is_done = true;
        self.hand_on(context).await;
    }

    async fn hand_on(&mut self, context: &Context<Self>) {
        if !self.is_done || self.places_behind == 0 {
            return;
        }
        self.works = false;
        self.is_done = false;
        if self.is_last {
            MADE.fetch_add(1, Ordering::Relaxed);
        } else {
            self.places_behind -= 1;
            self.part.send(()).await;
        }
        self.room.send(()).await;
        self.begin(context);
    }

    fn begin(&mut self, context: &Context<Self>) {
        if self.works || self.waiting == 0 {
            return;
        }
        self.works = true;
        self.waiting -= 1;
        let seconds = self.exponential().max(1e-9);
        context
            .schedule_event(
                Duration::from_secs_f64(seconds),
                schedulable!(Self::end),
                (),
            )
            .expect("the time is in the future");
    }

    /// An exponentially distributed number with mean 1, by SplitMix64.
    fn exponential(&mut self) -> f64 {
        self.random = self.random.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.random;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^= bits >> 31;
        -(1.0 - (bits >> 11) as f64 / (1_u64 << 53) as f64).ln()
    }
}

fn main() {
    let parts = std::env::args().nth(1).and_then(|count| count.parse().ok());
    let parts: u64 = parts.expect("the number of parts");
    let mailboxes: Vec<Mailbox<Station>> = (0..STATIONS).map(|_| Mailbox::new()).collect();
    let mut stations: Vec<Station> = (0..STATIONS)
        .map(|index| Station {
            part: Output::default(),
            room: Output::default(),
            waiting: if index == 0 { u64::MAX } else { 0 },
            places_behind: if index + 1 == STATIONS {
                u64::MAX
            } else {
                PLACES
            },
            works: false,
            is_done: false,
            is_last: index + 1 == STATIONS,
            random: index as u64,
        })
        .collect();
    for index in 1..STATIONS {
        stations[index - 1]
            .part
            .connect(Station::arrive, &mailboxes[index]);
        stations[index]
            .room
            .connect(Station::make_room, &mailboxes[index - 1]);
    }
    let mut bench = SimInit::with_num_threads(1);
    for (index, (station, mailbox)) in stations.into_iter().zip(mailboxes).enumerate() {
        bench = bench.add_model(station, mailbox, &format!("station{index}"));
    }
    let start = MonotonicTime::EPOCH;
    let mut simulation = bench.init(start).expect("the models start");
    while MADE.load(Ordering::Relaxed) < parts {
        simulation.step().expect("a step");
    }
    println!("{}", simulation.time().duration_since(start).as_secs_f64());
}
