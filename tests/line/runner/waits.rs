//! What stations wait for, on lines whose instants can be computed by hand.

use crate::models::plant_of;
use linewright::line::trace::{Wait, WaitKind};
use linewright::line::{Options, Trace};

fn run(body: &str, until: f64, warm_up: f64) -> Trace {
    let options = Options {
        until: Some(until),
        warm_up,
        ..Options::default()
    };
    plant_of(&format!("line L {{ {body} }}"), options).run()
}

/// The waits of a station in seconds: kind, place, station, in all, while failed, and off shift.
fn waits(trace: &Trace, station: usize) -> Vec<(WaitKind, &str, Option<&str>, [f64; 3])> {
    let seconds = |share: f64| (share * (trace.seconds - trace.warm_up) * 1e6).round() / 1e6;
    let all = trace.stations[station].waits.iter();
    all.map(|wait: &Wait| {
        let times = [wait.share, wait.failed, wait.off_shift].map(seconds);
        (
            wait.kind,
            wait.place.as_str(),
            wait.station.as_deref(),
            times,
        )
    })
    .collect()
}

/// `second` fails after three parts, which take 3 s each. Until 10 s, `first` is blocked for 2 s at
/// each of three parts. Then each cycle takes 15 s: `first` works for 3 s, and in 5 s of the other
/// 12 s `second` is under repair; in its sixth, `first` works.
#[test]
fn a_station_is_blocked_by_the_next_one_and_its_failures() {
    let body = "part P
        source rack: P every 0 s
        station first { takes 1 s }
        station second { takes 3 s failures mtbf constant(9 s) mttr constant(6 s) }
        sink out
        route P: rack -> first -> second -> out";
    let trace = run(body, 160.0, 0.0);
    assert_eq!(
        waits(&trace, 0),
        [(
            WaitKind::Blocked,
            "second",
            Some("second"),
            [126.0, 50.0, 0.0]
        )]
    );
    assert_eq!(
        waits(&trace, 1),
        [(WaitKind::Starved, "first", None, [1.0, 0.0, 0.0])]
    );
    // The warm-up cuts through a wait.
    let trace = run(body, 160.0, 12.0);
    assert_eq!(
        waits(&trace, 0),
        [(
            WaitKind::Blocked,
            "second",
            Some("second"),
            [119.0, 49.0, 0.0]
        )]
    );
}

/// A full buffer blocks, and the station behind it is the one that has failed.
#[test]
fn the_station_behind_a_full_buffer_is_found() {
    let body = "part P
        source rack: P every 0 s
        station first { takes 1 s }
        buffer queue capacity 2
        station second { takes 3 s failures mtbf constant(9 s) mttr constant(6 s) }
        sink out
        route P: rack -> first -> queue -> second -> out";
    let trace = run(body, 200.0, 50.0);
    let [(kind, place, station, [seconds, failed, _])] = waits(&trace, 0)[..] else {
        panic!("{:?}", trace.stations[0].waits);
    };
    assert_eq!(
        (kind, place, station),
        (WaitKind::Blocked, "queue", Some("second"))
    );
    // Ten cycles of 15 s; `first` works in the first second of a repair.
    assert_eq!((seconds, failed), (120.0, 50.0));
}

/// `first` works from 0 h to 1 h. `second` works on its last part until 30 s after that.
#[test]
fn a_station_is_starved_by_one_that_is_off_shift() {
    let body = "part P
        source rack: P every 0 s
        station first { takes 1 min shift 0 h to 1 h }
        station second { takes 30 s }
        sink out
        route P: rack -> first -> second -> out";
    let trace = run(body, 24.0 * 3600.0 + 60.0, 0.0);
    let all = waits(&trace, 1);
    let [(kind, place, station, [seconds, failed, off_shift])] = all[..] else {
        panic!("{all:?}");
    };
    assert_eq!((kind, place, station), (WaitKind::Starved, "first", None));
    assert_eq!((failed, off_shift), (0.0, 23.0 * 3600.0 - 30.0));
    // A minute at first, 30 s for each of the next 59 parts, and once until the next day.
    assert_eq!(seconds, 60.0 + 59.0 * 30.0 + 23.0 * 3600.0 + 30.0);
}

/// A station that joins waits for the component that comes last.
#[test]
fn a_join_is_starved_by_its_slowest_component() {
    let body = "part A part B part C from 1 A, 1 B product C
        source fast: A every 0 s
        source slow: B every 10 s
        station cell { takes 2 s }
        sink out
        route A: fast -> cell
        route B: slow -> cell
        route C: cell -> out";
    let trace = run(body, 100.5, 0.0);
    let all = waits(&trace, 0);
    let [(WaitKind::Starved, "slow", None, [seconds, ..])] = all[..] else {
        panic!("{all:?}");
    };
    assert!((70.0..=91.0).contains(&seconds), "{seconds}");
}

/// The causes of the blocked time add up to it, with random times, failures and shifts; those of
/// the starved time do so but for a wait at the end.
#[test]
fn the_causes_add_up() {
    let body = "part P
        source rack: P every random 4 s
        buffer store capacity 3
        station first times 2 { takes exponential(6 s) failures mtbf 60 s mttr 20 s by calendar }
        buffer queue capacity 2
        station second { takes exponential(3 s) failures mtbf 50 s mttr 20 s restart
            shift 0 h to 7 h break 3 h to 3.5 h }
        station third { takes exponential(3 s) failures each: every 20 parts mttr 30 s }
        station fourth { takes exponential(3 s) failures mtbf 90 s mttr 9 s by calendar }
        sink out
        sink lost rejects
        route P: rack -> store, lost
        route P: store -> first -> queue -> second, third -> fourth -> out";
    let trace = run(body, 30.0 * 3600.0, 3600.0);
    let mut blocked = 0;
    for station in &trace.stations {
        let sum = |kind: WaitKind| {
            let causes = station.waits.iter().filter(|wait| wait.kind == kind);
            causes.map(|wait| wait.share).sum::<f64>()
        };
        let shares = station.shares;
        let left = shares.blocked - sum(WaitKind::Blocked);
        assert!(left.abs() < 1e-9, "{station:?}");
        let left = shares.starved - sum(WaitKind::Starved);
        assert!((-1e-9..0.001).contains(&left), "{station:?}");
        for wait in &station.waits {
            assert!(wait.failed >= 0.0 && wait.off_shift >= 0.0, "{wait:?}");
            assert!(wait.failed + wait.off_shift < wait.share + 1e-9, "{wait:?}");
            blocked += usize::from(wait.kind == WaitKind::Blocked && wait.failed > 0.001);
        }
    }
    assert!(blocked >= 3, "{:?}", trace.stations);
}

/// The shares by cause add up to the blocked and starved shares: with failures, shifts, a warm-up,
/// waits that last at the end of the run, and a line that rests.
#[test]
fn the_causes_add_up_to_the_waits() {
    let body = "part P
        source rack: P every random 20 s limit 400
        buffer tray capacity 2
        station first { takes exponential(12 s) failures mtbf 10 min mttr 1 min }
        station second { takes exponential(14 s) shift 6 h to 14 h }
        station third { takes 10 s failures every 7 parts mttr 2 min }
        sink out
        route P: rack -> first -> tray -> second -> third -> out";
    for (until, warm_up) in [(30_000.0, 0.0), (30_000.0, 25_000.0), (300_000.0, 20_000.0)] {
        let trace = run(body, until, warm_up);
        for station in &trace.stations {
            for (kind, share) in [
                (WaitKind::Blocked, station.shares.blocked),
                (WaitKind::Starved, station.shares.starved),
            ] {
                let causes = station.waits.iter().filter(|wait| wait.kind == kind);
                let sum: f64 = causes.map(|wait| wait.share).sum();
                assert!(
                    (sum - share).abs() < 1e-9,
                    "{} until {until}: {kind:?} {sum} of {share}",
                    station.name
                );
            }
        }
    }
}
