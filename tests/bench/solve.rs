//! Times of the stages from specification to verified machine, for the case study's contracts.

#[path = "../fixtures/mod.rs"]
mod fixtures;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use linewright::game::{Limits, Outcome, WonGame, solve};
use linewright::gr1::Specification;
use linewright::mealy::{extract::extract, verify::verify};
use std::hint::black_box;
use std::time::Duration;

fn won(specification: &Specification) -> WonGame {
    match solve(specification, &Limits::default()) {
        Outcome::Realizable(won) => won,
        other => panic!("{}: {other:?}", specification.name),
    }
}

fn stages(criterion: &mut Criterion) {
    let limits = Limits::default();
    let mut group = criterion.benchmark_group("contract");
    group
        .sample_size(20)
        .warm_up_time(Duration::from_millis(200))
        .measurement_time(Duration::from_secs(1));
    for specification in fixtures::contracts() {
        let name = specification.name.clone();
        let game = won(&specification);
        let machine = extract(&specification, &game, &limits).expect("no limit");
        group.bench_function(BenchmarkId::new("solve", &name), |b| {
            b.iter(|| solve(black_box(&specification), &limits));
        });
        group.bench_function(BenchmarkId::new("extract", &name), |b| {
            b.iter(|| extract(&specification, black_box(&game), &limits));
        });
        group.bench_function(BenchmarkId::new("verify", &name), |b| {
            b.iter(|| verify(&specification, black_box(&machine), &limits));
        });
    }
    group.finish();
}

criterion_group!(benches, stages);
criterion_main!(benches);
