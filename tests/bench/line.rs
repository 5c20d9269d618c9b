//! The runner alone: five stations with exponential services, buffers of three, blocking after
//! service, no log. The same line was used to measure other simulators: `SimPy` makes some thirty
//! thousand parts per second, and a bare heap in Rust written for only this line two and a half
//! million.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
#[path = "../line/models.rs"]
#[expect(dead_code, reason = "the tests need more of it")]
mod support;

use linewright::line::{Options, Plant};
use support::{Builder, Exponential};

const PARTS: u64 = 50_000;

fn plant() -> Plant {
    let mut builder = Builder::new(&["Part"]);
    builder.endless("source", "Part");
    let mut way = vec!["source".to_owned()];
    for i in 0..5 {
        if i > 0 {
            let name = format!("buffer{i}");
            builder.buffer(&name, 3);
            way.push(name);
        }
        let name = format!("station{i}");
        builder.station(&name, &["Part"], Exponential::new(&name));
        way.push(name);
    }
    builder.sink("sink");
    way.push("sink".to_owned());
    let way: Vec<&str> = way.iter().map(String::as_str).collect();
    builder.route("Part", &way);
    builder.plant(Options {
        parts: Some(PARTS),
        ..Options::default()
    })
}

fn five_stations(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("line");
    group.throughput(Throughput::Elements(PARTS));
    let mut plant = plant();
    group.bench_function("five stations", |b| b.iter(|| plant.run()));
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20);
    targets = five_stations
}
criterion_main!(benches);
