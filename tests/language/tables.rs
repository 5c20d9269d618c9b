//! Tables of times: what is read from CSV files, and the findings about their cells.

use linewright::contract::line::{NodeKind, Supply};
use linewright::contract::{Library, load};
use linewright::diagnostics::Diagnostic;
use proptest::prelude::*;

/// A line whose source and station read the columns `at` and `time` of this table.
fn read(table: &str) -> (Library, Vec<Diagnostic>) {
    let line = "line L {
        part P
        source s: P at \"t.csv\" column at in min
        station m { takes empirical(\"t.csv\" column time in s) }
        sink e
        route P: s -> m -> e
    }";
    let files = [("line.lw".to_owned(), line.to_owned())];
    load(&files, &|path, importer| {
        assert_eq!((path, importer), ("t.csv", "line.lw"));
        Ok((path.to_owned(), table.to_owned()))
    })
}

/// Instants of the source and times of the station, in seconds.
fn numbers(table: &str) -> (Vec<f64>, Vec<f64>) {
    let (library, findings) = read(table);
    assert!(findings.is_empty(), "{table:?}: {findings:?}");
    let nodes = &library.lines[0].nodes;
    let NodeKind::Source {
        supply: Supply::At { instants },
        ..
    } = &nodes[0].kind
    else {
        panic!("{nodes:?}");
    };
    let NodeKind::Station(station) = &nodes[1].kind else {
        panic!("{nodes:?}");
    };
    let Some(linewright::contract::distribution::Distribution::Empirical(times)) =
        &station.tasks[0].time
    else {
        panic!("{nodes:?}");
    };
    (instants.to_vec(), times.to_vec())
}

/// Findings in the table: line, column, and message.
fn mistakes(table: &str) -> Vec<(usize, usize, String)> {
    let (library, findings) = read(table);
    let place = |finding: &Diagnostic| {
        let span = finding.span.expect("a place");
        assert_eq!(finding.code.id, "LW417");
        assert!(finding.help.is_some());
        let start = library.sources.start(span);
        (start.line, start.column, finding.message.clone())
    };
    findings.iter().map(place).collect()
}

#[test]
fn spellings_of_a_table_mean_the_same() {
    let wanted = (vec![0.0, 0.0, 90.0], vec![2.0, 3.0, 3.0]);
    for table in [
        "at,time\n0,3\n0,2\n1.5,3\n",
        "at,time\r\n0,3\r\n0,2\r\n1.5,3",
        "\u{feff}at;time\n0;3\n0;2\n1.5;3\n",
        "\n time \t at \n\n3\t0\n\n2\t0\n 3.0 \t 15e-1 \n\t\n",
        "\"at\",x,\"time\"\n\"0\",\"a,\nb\",\"3\"\n-0,,2,,\n1.5,\"\"\"\",3\n",
    ] {
        assert_eq!(numbers(table), wanted, "{table:?}");
    }
}

#[test]
fn each_wrong_cell_has_its_place() {
    let table = "at,time\n1,x\n0,-1\n5, inf \n6\n7,1,2\n,\n8,\"1,5\"\n9,1e-9\n";
    let found = mistakes(table);
    let wanted: Vec<(usize, usize, String)> = [
        (2, 3, "`x` is not a number"),
        (3, 1, "0 min is before the instant above it"),
        (3, 3, "-1 s is negative"),
        (4, 4, "`inf` is not finite"),
        (5, 1, "this row has no number in the column `time`"),
        (6, 1, "this row has 3 cells, but the first row has 2"),
        (8, 1, "`1,5` is not a number"),
        (9, 3, "1e-9 s is not a valid duration"),
    ]
    .map(|(line, column, message)| (line, column, message.to_owned()))
    .into();
    assert_eq!(found, wanted);
}

#[test]
fn findings_have_a_maximum_number() {
    let table = format!("at,time\n{}", "0,x\n".repeat(1000));
    let found = mistakes(&table);
    assert_eq!(found.len(), 21);
    let rest = "980 more cells of `time` in `t.csv` are wrong";
    assert!(
        found.iter().any(|(.., message)| message == rest),
        "{found:?}"
    );
}

#[test]
fn a_table_has_a_maximum_number_of_rows() {
    let rows = |count: usize| format!("at,time\n{}", "0,1\n".repeat(count));
    let most = linewright::contract::MAX_ROWS;
    assert_eq!(numbers(&rows(most)).0.len(), most);
    let found = mistakes(&rows(most + 1));
    let message = "this table has more than 1000000 rows".to_owned();
    assert_eq!(found, [(most + 2, 1, message)]);
}

/// A number in one of its spellings, and its value.
fn number() -> impl Strategy<Value = (String, f64)> {
    (0_u32..1_000_000, 0..4_usize).prop_map(|(number, form)| {
        let value = f64::from(number) / 100.0;
        let text = match form {
            0 => format!("{value}"),
            1 => format!("\"{value}\""),
            2 => format!(" {value:e} "),
            _ => format!("+{value:.2}"),
        };
        (text, value)
    })
}

proptest! {
    #[test]
    fn numbers_are_read_as_they_are_written(
        mut rows in prop::collection::vec((number(), number()), 1..40),
        separator in prop::sample::select(vec![",", ";", "\t"]),
        end in prop::sample::select(vec!["\n", "\r\n", "\n\n"]),
        note in "[a-z,;\t\n\"]{0,8}",
    ) {
        rows.sort_by(|a, b| a.0.1.total_cmp(&b.0.1));
        let note = format!("\"{}\"", note.replace('"', "\"\""));
        let mut table = ["time", "note", "at"].join(separator) + end;
        for ((at, _), (time, _)) in &rows {
            table.push_str(&[time, note.as_str(), at].join(separator));
            table.push_str(end);
        }
        let (instants, times) = numbers(&table);
        let wanted: Vec<f64> = rows.iter().map(|((_, at), _)| at * 60.0).collect();
        prop_assert_eq!(instants, wanted);
        let mut wanted: Vec<f64> = rows.iter().map(|(_, (_, time))| *time).collect();
        wanted.sort_by(f64::total_cmp);
        prop_assert_eq!(times, wanted);
    }

    /// Whatever a file contains, it is read or there is a finding with a place.
    #[test]
    fn no_text_is_too_strange(text in "(at)?[,;\t]?(time)?\n?[at0-9.,;\t\n\r\"e+\u{feff}é -]{0,60}") {
        let (library, findings) = read(&text);
        prop_assert_eq!(library.lines.is_empty(), !findings.is_empty());
        for finding in &findings {
            let span = finding.span.expect("a place");
            let whole = &library.sources.file(span.file).text;
            prop_assert!(whole.get(span.start as usize..span.end as usize).is_some());
            prop_assert!(span.start < span.end, "{:?}", finding);
        }
    }
}
