use linewright::*;
use std::time::Instant;
fn cpu() -> f64 { let s = std::fs::read_to_string("/proc/self/stat").unwrap(); let f: Vec<&str> = s.split(' ').collect(); (f[13].parse::<f64>().unwrap() + f[14].parse::<f64>().unwrap())/100.0 }
fn main() {
    for path in std::env::args().skip(1) {
        let c0 = cpu(); let _t0 = Instant::now();
        let text = std::fs::read_to_string(&path).unwrap();
        let f = interchange::Format::of_path(&path).unwrap();
        let r = interchange::read(f, "bench", source::FileId(0), &text);
        let spec = r.specification.unwrap();
        let c1 = cpu();
        let limits = game::Limits::default();
        let game::Outcome::Realizable(won) = game::solve(&spec, &limits) else { println!("not realizable"); continue };
        let c2 = cpu();
        let functions = mealy::functions::Functions::extract(&spec, &won, &limits).unwrap();
        let fs = &functions.controls;
        let c3 = cpu();
        drop(won);
        let c3b = cpu();
        let verdict = mealy::certify::certify(&spec, &functions, &limits).unwrap();
        let c4 = cpu();
        println!("certify {:.2} {verdict:?} (drop {:.2})", c4-c3b, c3b-c3);
        println!("{path}: read {:.2} solve {:.2} functions {:.2}; nodes {} ranking {} goals {} outputs {}", c1-c0, c2-c1, c3-c2, fs.diagram.nodes.len(), fs.ranking.diagram.nodes.len(), fs.goals.iter().map(|g| g.modes.len()).sum::<usize>(), fs.first.len());
    }
}
