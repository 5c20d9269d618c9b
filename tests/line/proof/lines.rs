//! Random small lines.

use crate::models::{Builder, Work, every, took};
use linewright::contract::line::{Choice, InitialValue, Line, NodeKind, Supply};
use linewright::contract::machine::RealExpr;
use linewright::line::random::Stream;

/// One or two types that go different ways through shared places, or two that are joined and
/// continue; some go back for rework. The stations' times also come from the seed.
pub fn line(seed: u64) -> Builder {
    let mut stream = Stream::from_seed(seed);
    let shape = stream.below(4);
    let mut builder = match shape {
        0 => Builder::new(&["A"]),
        1 => Builder::new(&["A", "B"]),
        _ => {
            let mut builder = Builder::new(&["A", "B", "P"]);
            let each = 1 + stream.below(2) as u32;
            builder.bill("P", &[("A", each), ("B", 1)]);
            builder
        }
    };
    let types: Vec<String> = builder.line.parts.iter().map(|p| p.name.clone()).collect();
    for part in &types {
        builder.property(part, "again", InitialValue::Number(0.0));
    }
    for part in types.iter().filter(|p| *p != "P") {
        let name = format!("source_{part}");
        match stream.below(4) {
            0 => drop(builder.source(&name, part, Supply::OnOrder)),
            1 => drop(builder.endless(&name, part)),
            2 => drop(builder.store(&name, &[(part, 100_000)])),
            _ => drop(builder.source(&name, part, every(1.0 + stream.unit() * 4.0, None))),
        }
        if stream.below(3) == 0
            && builder
                .line
                .nodes
                .last()
                .unwrap()
                .name
                .starts_with("source")
        {
            at_most(&mut builder.line, &name, 1 + stream.below(4) as u32);
        }
    }
    // Some places, and for each type a way through some of them, in its own order.
    let pool = 2 + stream.below(3) as usize;
    let kinds: Vec<u64> = (0..pool).map(|_| stream.below(5)).collect();
    let mut ways: Vec<Vec<usize>> = Vec::new();
    for _ in &types {
        let mut places: Vec<usize> = (0..pool).filter(|_| stream.below(3) > 0).collect();
        for i in (1..places.len()).rev() {
            if stream.below(3) == 0 {
                places.swap(i, stream.below(i as u64 + 1) as usize);
            }
        }
        ways.push(places);
    }
    let work = |stream: &mut Stream| {
        let mut times = Stream::from_seed(stream.bits());
        let mean = [0.2, 1.0, 5.0][stream.below(3) as usize];
        Work(
            move |_, values: &mut [f64]| {
                values[0] = f64::from(u8::from(times.below(3) == 0));
                took(times.exponential(mean))
            },
            0,
        )
    };
    for (place, kind) in kinds.iter().enumerate() {
        let name = format!("place{place}");
        let size = 1 + stream.below(2) as u32;
        match kind {
            0 => drop(builder.buffer(&name, size)),
            1 => drop(builder.conveyor(&name, size, [0.1, 1.0, 10.0][stream.below(3) as usize])),
            _ => {
                let visits = types
                    .iter()
                    .zip(&ways)
                    .filter(|(_, way)| way.contains(&place));
                let visits: Vec<&str> = visits.map(|(part, _)| part.as_str()).collect();
                if visits.is_empty() {
                    builder.buffer(&name, size);
                } else {
                    let work = work(&mut stream);
                    builder
                        .station(&name, &visits, work)
                        .machine_properties(&name, &["again"]);
                }
            }
        }
    }
    if shape > 1 {
        let work = work(&mut stream);
        builder
            .station("cell", &["P"], work)
            .machine_properties("cell", &["again"]);
    }
    builder.sink("sink");
    for (part, way) in types.iter().zip(&ways) {
        let start = if part == "P" {
            "cell".to_owned()
        } else {
            format!("source_{part}")
        };
        let end = if shape > 1 && part != "P" {
            "cell"
        } else {
            "sink"
        };
        let mut path = vec![start];
        path.extend(way.iter().map(|p| format!("place{p}")));
        path.push(end.to_owned());
        // A station may send a part back to an earlier place.
        let back = way
            .iter()
            .enumerate()
            .skip(1)
            .find(|(_, place)| kinds[**place] > 1);
        if let (Some((at, from)), 0) = (back, stream.below(2)) {
            let to = way[stream.below(at as u64) as usize];
            let (from, to) = (format!("place{from}"), format!("place{to}"));
            builder.route_if(part, &from, &to, Some(RealExpr::Property(0)));
        }
        let path: Vec<&str> = path.iter().map(String::as_str).collect();
        for pair in path.windows(2) {
            let others: Vec<&str> = path[1..]
                .iter()
                .copied()
                .filter(|other| other != &pair[1])
                .collect();
            if others.is_empty() || pair[1] == "cell" || stream.below(4) > 0 {
                builder.route(part, pair);
                continue;
            }
            // One of two places, of which the other is farther ahead or behind.
            let other = others[stream.below(others.len() as u64) as usize];
            let mut to = [pair[1], other];
            if stream.below(2) == 0 && other != "sink" {
                to.swap(0, 1);
            }
            let choice = match stream.below(5) {
                0 | 1 => Choice::FirstFree,
                2 => Choice::ShortestQueue,
                3 => Choice::RoundRobin,
                _ => Choice::Probability {
                    shares: vec![0.5, 0.5],
                },
            };
            builder.route_choice(part, pair[0], &to, choice);
        }
    }
    builder
}

/// The source makes no part while this many of its parts are in the line.
pub fn at_most(line: &mut Line, name: &str, count: u32) {
    let source = line.nodes.iter_mut().find(|n| n.name == name);
    if let Some(NodeKind::Source { most, .. }) = source.map(|n| &mut n.kind) {
        *most = Some(count);
    }
}
