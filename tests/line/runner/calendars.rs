//! Calendars: several shifts, breaks, weekdays, holidays and nights, per line and per station.

use crate::models::{Builder, Logged, RunLogged, constant, every, plant_of};
use linewright::contract::calendar::{Shift, WorkCalendar};
use linewright::line::log::EventKind;
use linewright::line::random::{Purpose, Stream};
use linewright::line::{End, Options, Trace};

const HOUR: f64 = 3600.0;
/// Minutes of the weeks that the oracle knows.
const MINUTES: i64 = 3 * 7 * DAY;
/// Minutes of a day.
const DAY: i64 = 24 * 60;
const MINUTE: i64 = 60_000_000;

// ---- the calendar, against a grid of minutes ----------------------------------------------------

/// A random calendar whose times are whole minutes.
fn random_calendar(random: &mut Stream) -> WorkCalendar {
    let shifts = (0..=random.below(3)).map(|_| random_shift(random));
    let mut shifts: Vec<Shift> = shifts.collect();
    if random.below(20) == 0 {
        shifts.push(Shift::daily(0.0, 24.0 * HOUR));
    }
    let mut closed = Vec::new();
    let mut day = random.below(9) as i64 - 3;
    for _ in 0..random.below(4) {
        let longest = [1, 3, 12][random.below(3) as usize];
        let last = day + random.below(longest) as i64;
        closed.push((day, last));
        day = last + 2 + random.below(6) as i64;
    }
    WorkCalendar {
        first_weekday: random.below(7) as u8,
        shifts,
        closed,
    }
}

fn random_shift(random: &mut Stream) -> Shift {
    // Few different times, so that shifts often adjoin.
    let from = [0, 6, 14, 22][random.below(4) as usize] * 60 + [0, 0, 1][random.below(3) as usize];
    let length = match random.below(4) {
        0 if from == 0 => DAY,
        0 => DAY - 1,
        1 => 1 + random.below(30) as i64,
        _ => 8 * 60,
    };
    let mut days = [false; 7];
    for _ in 0..=random.below(10) {
        days[random.below(7) as usize] = true;
    }
    let mut breaks = Vec::new();
    for _ in 0..random.below(4) {
        let start = from + random.below(length as u64) as i64;
        let longest = (from + length - start).min(90) as u64;
        breaks.push((start, start + 1 + random.below(longest) as i64));
    }
    let mut shift = Shift {
        from: from * MINUTE,
        to: (from + length) * MINUTE,
        days,
        breaks: breaks
            .iter()
            .map(|(a, b)| (a * MINUTE, b * MINUTE))
            .collect(),
        finishes_work: random.below(2) == 0,
    };
    if shift.working_microseconds() == 0 {
        shift.breaks.clear();
    }
    shift
}

/// Whether a shift that begins on `day` works in this minute of the run.
fn works(calendar: &WorkCalendar, shift: &Shift, day: i64, minute: i64) -> bool {
    let weekday = (day + i64::from(calendar.first_weekday)).rem_euclid(7);
    let time = (minute - day * DAY) * MINUTE;
    let is_closed = calendar
        .closed
        .iter()
        .any(|(a, b)| (*a..=*b).contains(&day));
    let is_break = shift.breaks.iter().any(|(a, b)| (*a..*b).contains(&time));
    shift.days[weekday as usize]
        && (shift.from..shift.to).contains(&time)
        && !is_closed
        && !is_break
}

/// For each minute of the run: whether work goes on, and whether a shift works in it that finishes
/// work and does not work in the next minute.
fn grid(calendar: &WorkCalendar) -> Vec<(bool, bool)> {
    let in_minute = |minute: i64| {
        let mut found = (false, false);
        for day in minute / DAY - 2..=minute / DAY {
            for shift in &calendar.shifts {
                if works(calendar, shift, day, minute) {
                    found.0 = true;
                    found.1 |= shift.finishes_work && !works(calendar, shift, day, minute + 1);
                }
            }
        }
        found
    };
    (0..MINUTES).map(in_minute).collect()
}

#[test]
fn calendars_agree_with_a_grid_of_minutes() {
    let mut random = Stream::new(1, Purpose::Service, "calendars");
    let (mut changes, mut constant, mut finishing) = (0, 0, 0);
    for number in 0..2000 {
        let calendar = random_calendar(&mut random);
        assert!(calendar.is_valid(), "{number}: {calendar:?}");
        let grid = grid(&calendar);
        let mut worked = 0;
        // The end of the current run of equal minutes.
        let mut end = 0;
        for minute in 0..MINUTES {
            let (works, _) = grid[minute as usize];
            if end <= minute {
                let rest = &grid[minute as usize..];
                let equal = rest.iter().take_while(|m| m.0 == works).count();
                end = minute + equal as i64;
                // At the change, half a minute later, and half a minute before the next one.
                for at in [minute as f64, minute as f64 + 0.5, end as f64 - 0.5] {
                    let second = at * 60.0;
                    let what = || format!("{number}, minute {at}: {calendar:?}");
                    assert_eq!(calendar.works_at(second), works, "{}", what());
                    let change = calendar.next_change(second);
                    if end == MINUTES {
                        constant += u32::from(change.is_none());
                        let time = change.map_or(f64::INFINITY, |change| change.time);
                        assert!(time >= MINUTES as f64 * 60.0, "{}", what());
                        continue;
                    }
                    let change = change.unwrap_or_else(|| panic!("{}", what()));
                    assert_eq!(change.time, end as f64 * 60.0, "{}", what());
                    assert_eq!(change.works, !works, "{}", what());
                    let finishes = works && grid[end as usize - 1].1;
                    assert_eq!(change.finishes_work, finishes, "{}", what());
                    changes += 1;
                    finishing += u32::from(finishes);
                }
            }
            if minute % 97 == 0 || minute % DAY == 0 {
                let second = minute as f64 * 60.0 + 15.0;
                let wanted = worked as f64 * 60.0 + if works { 15.0 } else { 0.0 };
                let found = calendar.worked_until(second);
                assert!(
                    (found - wanted).abs() < 1e-6,
                    "{number}, minute {minute}: {found} is not {wanted}: {calendar:?}"
                );
            }
            worked += i64::from(works);
        }
    }
    assert!(changes > 100_000, "{changes}");
    assert!(
        constant > 10 && finishing > 20_000,
        "{constant}, {finishing}"
    );
}

/// Over many years, the working time is the sum of the times between the changes, and long closed
/// periods take no longer than short ones.
#[test]
fn changes_and_working_time_agree_for_years() {
    let mut random = Stream::new(2, Purpose::Service, "calendars");
    for _ in 0..8 {
        let mut calendar = random_calendar(&mut random);
        for (first, length) in [(400, 2000), (2500, 0), (3000, 30_000)] {
            calendar.closed.push((first, first + length));
        }
        let (mut time, mut worked) = (0.0, 0.0);
        let mut works = calendar.works_at(0.0);
        while let Some(change) = calendar.next_change(time) {
            assert!(change.time > time && change.works != works, "{calendar:?}");
            if works {
                worked += change.time - time;
            }
            (time, works) = (change.time, change.works);
            assert_eq!(calendar.works_at(time), works);
            let counted = calendar.worked_until(time);
            assert!((counted - worked).abs() < 1e-3, "{calendar:?}");
            if time > 34_000.0 * 24.0 * HOUR {
                break;
            }
        }
    }
}

#[test]
fn invalid_calendars_are_refused() {
    let valid = WorkCalendar::daily(6.0 * HOUR, 14.0 * HOUR);
    assert!(valid.is_valid());
    assert!(WorkCalendar::daily(0.0, 24.0 * HOUR).is_valid());
    assert!(WorkCalendar::daily(22.0 * HOUR, 6.0 * HOUR).is_valid());
    let changes: [fn(&mut WorkCalendar); 8] = [
        |c| c.shifts.clear(),
        |c| c.first_weekday = 7,
        |c| c.shifts[0].days = [false; 7],
        |c| c.shifts[0].from = -1,
        |c| c.shifts[0].to = c.shifts[0].from,
        |c| c.shifts[0].breaks.push((0, MINUTE)),
        |c| c.shifts[0].breaks = vec![(c.shifts[0].from, c.shifts[0].to)],
        |c| c.closed = vec![(1, 2), (3, 3)],
    ];
    for change in changes {
        let mut calendar = valid.clone();
        change(&mut calendar);
        assert!(!calendar.is_valid(), "{calendar:?}");
        let mut builder = Builder::new(&["Part"]);
        builder
            .endless("source", "Part")
            .station("cell", &["Part"], constant(1.0))
            .with_station("cell", |station| station.calendar = Some(calendar))
            .sink("sink")
            .route("Part", &["source", "cell", "sink"]);
        let refused = linewright::line::Plant::new(
            std::sync::Arc::new(builder.line.clone()),
            std::mem::take(&mut builder.controllers),
            Options {
                parts: Some(1),
                ..Options::default()
            },
        );
        assert_eq!(refused.err().map(|f| f[0].code.id), Some("LW401"));
    }
}

// ---- runs with results of a manual calculation --------------------------------------------------

/// A line of one station that always has a part, with these statements in the station and the line.
fn one_station(station: &str, line: &str) -> String {
    format!(
        "line L {{ part P source rack: P every 0 s station cell {{ {station} }} sink out {line}
         route P: rack -> cell -> out }}"
    )
}

fn run(text: &str, hours: f64) -> Logged {
    let options = Options {
        until: Some(hours * HOUR),
        ..Options::default()
    };
    plant_of(text, options).run_logged()
}

/// The hours at which parts are finished.
fn finished(trace: &Logged) -> Vec<f64> {
    let finished = trace.log.iter().filter(|e| e.what == EventKind::Finished);
    finished.map(|e| e.time / HOUR).collect()
}

/// The hours of the first station that are busy, failed, idle and in all.
fn hours(trace: &Trace) -> [f64; 4] {
    let shares = trace.stations[0].shares;
    let all = trace.seconds / HOUR;
    [
        shares.busy * all,
        shares.failed * all,
        shares.idle * all,
        all,
    ]
    .map(|h| (h * 1e6).round() / 1e6)
}

#[test]
fn a_night_belongs_to_the_day_on_which_it_begins() {
    let text = one_station("takes 1 h", "shift 22 h to 6 h on Monday to Friday");
    let trace = run(&text, 7.0 * 24.0);
    let ends = finished(&trace);
    assert_eq!(
        ends[..9],
        [23.0, 24.0, 25.0, 26.0, 27.0, 28.0, 29.0, 30.0, 47.0]
    );
    // The last night ends on Saturday.
    assert_eq!((trace.products, ends[39]), (40, 5.0 * 24.0 + 6.0));
    assert_eq!(hours(&trace), [40.0, 0.0, 128.0, 168.0]);
    assert_eq!(trace.throughput_on_shift, Some(1.0));
    // If all nights are worked, a run begins within the one that began on Sunday.
    let trace = run(&one_station("takes 1 h", "shift 22 h to 6 h"), 24.0);
    assert_eq!(finished(&trace), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 23.0, 24.0]);
}

#[test]
fn breaks_interrupt_work() {
    let text = one_station(
        "takes 2 h",
        "shift 6 h to 14 h break 9 h to 9.25 h, 12 h to 12.5 h",
    );
    let trace = run(&text, 31.0);
    assert_eq!(finished(&trace), [8.0, 10.25, 12.75, 30.75]);
    assert_eq!(hours(&trace), [8.25, 0.0, 22.75, 31.0]);
}

/// Two shifts that adjoin are one: the work goes on without an interruption.
#[test]
fn shifts_that_adjoin_or_overlap_are_united() {
    let alone = run(&one_station("takes 3 h", "shift 6 h to 22 h"), 100.0);
    for shifts in [
        "shift 6 h to 14 h shift 14 h to 22 h",
        "shift 14 h to 22 h finish work; shift 6 h to 14 h finish work; shift 21 h to 22 h",
        "shift 6 h to 15.5 h break 14.5 h to 15 h shift 14.5 h to 22 h",
    ] {
        let trace = run(&one_station("takes 3 h", shifts), 100.0);
        if shifts.contains("finish") {
            assert_eq!(
                finished(&trace)[..7],
                [9.0, 12.0, 15.0, 18.0, 21.0, 24.0, 33.0]
            );
            continue;
        }
        assert_eq!(finished(&trace), finished(&alone), "{shifts}");
        assert_eq!(trace.events, alone.events, "{shifts}");
    }
}

#[test]
fn weekends_and_the_first_day() {
    let shift = "shift 6 h to 14 h on Monday to Friday";
    let trace = run(&one_station("takes 1 h", shift), 14.0 * 24.0);
    assert_eq!(trace.products, 80);
    assert_eq!(finished(&trace)[40], 7.0 * 24.0 + 7.0);
    // 2026-12-05 is a Saturday.
    let text = one_station("takes 1 h", &format!("start 2026-12-05 {shift}"));
    let trace = run(&text, 7.0 * 24.0);
    assert_eq!((trace.products, finished(&trace)[0]), (40, 55.0));
    let days = "shift 6 h to 14 h on Saturday to Monday, Wednesday";
    let trace = run(&one_station("takes 8 h", days), 7.0 * 24.0);
    let days: Vec<f64> = finished(&trace).iter().map(|h| (h - 14.0) / 24.0).collect();
    assert_eq!(days, [0.0, 2.0, 5.0, 6.0]);
}

#[test]
fn holidays_close_the_days_on_which_shifts_begin() {
    let text = one_station(
        "takes 1 h",
        "start 2026-12-21 shift 6 h to 14 h on Monday to Friday
         holiday 2026-12-24 to 2026-12-26 holiday 2027-01-01",
    );
    let trace = run(&text, 14.0 * 24.0);
    // Monday to Wednesday, and Monday to Thursday.
    assert_eq!(trace.products, 56);
    assert_eq!(trace.throughput_on_shift, Some(1.0));
    // The night that began before the holiday goes on.
    let text = one_station(
        "takes 1 h",
        "start 2026-12-21 shift 22 h to 6 h holiday 2026-12-22",
    );
    let trace = run(&text, 72.0);
    assert_eq!(hours(&trace), [16.0, 0.0, 56.0, 72.0]);
    assert_eq!(finished(&trace)[14..], [71.0, 72.0]);
    // A line without shifts works around the clock on all other days.
    let text = one_station("takes 1 h", "start 2026-12-24 holiday 2026-12-25");
    let trace = run(&text, 72.0);
    assert_eq!((trace.products, trace.throughput_on_shift), (48, Some(1.0)));
}

/// Two stations, with these statements in them and in the line, and perhaps a queue on the route.
fn pair(first: &str, second: &str, line: &str, route: &str) -> String {
    let queue = if route.contains("queue") {
        "buffer queue capacity 20"
    } else {
        ""
    };
    format!(
        "line L {{ part P source rack: P every 0 s {line} {queue} sink out
         station a {{ takes 1 h {first} }} station b {{ takes 1 h {second} }}
         route P: {route} }}"
    )
}

#[test]
fn each_station_can_have_a_calendar() {
    let (early, late) = ("shift 6 h to 14 h", "shift 14 h to 22 h");
    let trace = run(
        &pair(early, late, "", "rack -> a -> queue -> b -> out"),
        24.0,
    );
    let late_hours: Vec<f64> = (15..=22).map(f64::from).collect();
    assert_eq!(finished(&trace), late_hours);
    assert_eq!(trace.throughput_on_shift, None);
    for station in &trace.stations {
        assert_eq!(
            (station.busy_seconds, station.shares.idle),
            (8.0 * HOUR, 16.0 / 24.0)
        );
    }
    // Without a buffer, the part of the early shift waits for the late one. The order of the
    // stations does not matter.
    for (first, second, text) in [
        (early, late, "rack -> a -> b -> out"),
        (late, early, "rack -> b -> a -> out"),
    ] {
        let trace = run(&pair(first, second, "", text), 72.0);
        assert_eq!(finished(&trace), [15.0, 39.0, 63.0]);
    }
    // A station with a shift of its own does not work by that of the line.
    let line = format!("{early} on Monday");
    let trace = run(
        &pair("", late, &line, "rack -> a -> queue -> b -> out"),
        72.0,
    );
    assert_eq!(finished(&trace), late_hours);
    assert_eq!(trace.throughput_on_shift, Some(1.0));
}

/// A line that rests is blocked, although its stations are never on shift together, and although
/// shifts begin and end for ever.
#[test]
fn stations_with_different_shifts_are_blocked() {
    let text = pair(
        "shift 6 h to 14 h",
        "shift 14 h to 22 h",
        "",
        "rack -> a -> queue -> b -> out",
    );
    let text = text.replace("every 0 s", "every 0 s limit 2");
    let options = |parts, until| Options {
        parts,
        until,
        ..Options::default()
    };
    let trace = plant_of(&text, options(Some(3), None)).run();
    assert_eq!((trace.end, trace.products), (End::Blocked, 2));
    assert!(trace.seconds <= 30.0 * HOUR, "{}", trace.seconds);
    // Until the end of a run, the time is divided as if the shifts went on.
    let trace = plant_of(&text, options(None, Some(40_000.0 * 24.0 * HOUR))).run();
    assert_eq!((trace.end, trace.products), (End::Time, 2));
    assert!(trace.events < 100, "{}", trace.events);
    for station in &trace.stations {
        assert!((station.shares.idle - 2.0 / 3.0).abs() < 1e-9);
    }
}

/// From the second day on, everything is closed. The language refuses such a line.
#[test]
fn a_line_without_further_shifts_ends() {
    let build = || {
        let mut builder = Builder::new(&["Part"]);
        builder
            .endless("rack", "Part")
            .station("cell", &["Part"], constant(5.0 * HOUR))
            .sink("sink")
            .route("Part", &["rack", "cell", "sink"]);
        let mut calendar = WorkCalendar::daily(0.0, 24.0 * HOUR);
        calendar.closed = vec![(1, 3_000_000)];
        builder.line.calendar = Some(calendar);
        builder
    };
    let trace = build().run(100);
    assert_eq!((trace.end, trace.products), (End::Blocked, 4));
    // The end of the fifth part, as it was planned.
    assert_eq!(trace.seconds, 25.0 * HOUR);
    let finding = &trace.findings[0];
    assert!(
        finding.message.contains("cell has no further shift"),
        "{finding:?}"
    );
    let trace = build().run_until(240.0 * HOUR);
    assert_eq!(
        (trace.end, hours(&trace)),
        (End::Time, [24.0, 0.0, 216.0, 240.0])
    );
}

#[test]
fn work_is_finished_or_interrupted() {
    for (option, ends, busy) in [
        ("finish work", [9.0, 12.0, 15.0, 33.0], 9.0),
        ("", [9.0, 12.0, 31.0, 34.0], 8.0),
    ] {
        let shift = format!("shift 6 h to 14 h {option}");
        let trace = run(&one_station("takes 3 h", &shift), 48.0);
        assert_eq!(finished(&trace)[..4], ends);
        let day = run(&one_station("takes 3 h", &shift), 24.0);
        assert_eq!(hours(&day), [busy, 0.0, 24.0 - busy, 24.0]);
        // The rate on shift counts the hours of the calendar.
        assert_eq!(day.throughput_on_shift, Some(day.products as f64 / 8.0));
    }
    // A part that comes at the end of the shift waits, as long as nothing is done.
    let trace = run(
        &one_station("takes 4 h", "shift 6 h to 14 h finish work"),
        48.0,
    );
    assert_eq!(finished(&trace), [10.0, 14.0, 34.0, 38.0]);
    // A break is skipped, too.
    let shift = "shift 6 h to 14 h break 9 h to 10 h finish work";
    let trace = run(&one_station("takes 2 h", shift), 24.0);
    assert_eq!(finished(&trace), [8.0, 10.0, 12.0, 14.0]);
    assert_eq!(hours(&trace), [8.0, 0.0, 16.0, 24.0]);
    // The next shift may begin before the part is finished.
    let shift = "shift 6 h to 14 h break 9 h to 9.5 h finish work";
    let trace = run(&one_station("takes 2 h", shift), 24.0);
    assert_eq!(finished(&trace), [8.0, 10.0, 12.0, 14.0]);
}

#[test]
fn setup_and_failures_in_overtime() {
    let text = "line L { part P part Q product P source p: P every 0 s limit 1 source q: Q every 0 s limit 1
        station cell { takes 7 h setup 2 h shift 6 h to 14 h finish work }
        sink out route P: p -> cell -> out route Q: q -> cell -> out }";
    let trace = run(text, 48.0);
    // The setup for the second part goes on in overtime, and so does its service.
    assert_eq!(finished(&trace), [13.0, 22.0]);
    // Broken down from 14.5 h to 15.5 h, in overtime.
    let failures = "failures mtbf constant(14.5 h) mttr constant(1 h) by calendar";
    let station = format!("takes 3 h {failures}");
    let trace = run(
        &one_station(&station, "shift 6 h to 14 h finish work"),
        24.0,
    );
    assert_eq!(finished(&trace), [9.0, 12.0, 16.0]);
    assert_eq!(hours(&trace), [9.0, 1.0, 14.0, 24.0]);
}

#[test]
fn a_failure_during_a_break() {
    let shift = "shift 0 h to 24 h break 3 h to 4 h";
    for (repair, ends, hours_of) in [
        ("0.5 h", [2.0, 5.0], [5.0, 0.5, 0.5, 6.0]),
        ("1.25 h", [2.0, 5.5], [4.5, 1.25, 0.25, 6.0]),
    ] {
        let station =
            format!("takes 2 h failures mtbf constant(3.25 h) mttr constant({repair}) by calendar");
        let trace = run(&one_station(&station, shift), 6.0);
        assert_eq!(finished(&trace), ends);
        assert_eq!(hours(&trace), hours_of);
    }
    // Only working time leads to a failure: 2 h, and 1.5 h after the break.
    let station = "takes 10 h failures mtbf constant(3.5 h) mttr constant(1 h)";
    let trace = run(&one_station(station, shift), 8.0);
    let failed = trace.log.iter().find(|e| e.what == EventKind::Failed);
    assert_eq!(failed.map(|e| e.time / HOUR), Some(4.5));
}

/// A join waits for the shift of its station; its places are filled before.
#[test]
fn a_join_by_its_own_calendar() {
    let mut builder = Builder::new(&["C", "J"]);
    builder
        .bill("J", &[("C", 2)])
        .source("c", "C", every(HOUR, None))
        .station("cell", &["J"], constant(600.0))
        .with_station("cell", |station| {
            station.calendar = Some(WorkCalendar::daily(22.0 * HOUR, 2.0 * HOUR));
        })
        .sink("sink")
        .route("C", &["c", "cell"])
        .route("J", &["cell", "sink"]);
    let trace = builder.run_until(24.0 * HOUR);
    let started = trace.log.iter().filter(|e| e.what == EventKind::Started);
    let hours: Vec<f64> = started.map(|e| e.time / HOUR).collect();
    assert_eq!(hours[..2], [1.0, 22.0], "{hours:?}");
}
