//! A run as text and as JSON.

use crate::models::{Builder, constant, refusing, span, took, verdict};
use linewright::contract::line::{Comparison, InitialValue, Measure, Requirement, Supply};
use linewright::contract::machine::RealExpr;
use linewright::line::{Options, Plant};
use linewright::report::{self, Intervals};
use linewright::station::{CallError, Controller, Service};

fn plant() -> Plant {
    let mut builder = Builder::new(&["Brick", "Printed", "Product"]);
    builder
        .property("Printed", "ok", InitialValue::Number(0.0))
        .bill("Product", &[("Brick", 2), ("Printed", 1)])
        .store("warehouse", &[("Brick", 100)])
        .source("feeder", "Printed", Supply::OnOrder)
        .station(
            "camera",
            &["Printed"],
            verdict(20.0, |call| f64::from(call != 3)),
        )
        .machine_properties("camera", &["ok"])
        .machine_watts("camera", 50.0)
        .conveyor("belt", 3, 2.0)
        .station(
            "assembly_cell_1",
            &["Product"],
            refusing(30.0, |call| call == 5),
        )
        .station("milling", &["Brick"], constant(5.0))
        .scrap("scrap", Some("feeder"))
        .route("Brick", &["warehouse", "assembly_cell_1"])
        .route("Printed", &["feeder", "camera"])
        .route_if("Printed", "camera", "belt", Some(RealExpr::Property(0)))
        .route("Printed", &["camera", "scrap"])
        .route("Printed", &["belt", "assembly_cell_1"])
        .route("Product", &["assembly_cell_1", "warehouse"])
        .require(Requirement {
            name: "pace".to_owned(),
            metric: Measure::Throughput.into(),
            comparison: Comparison::Ge,
            bound: 100.0,
            span: span(),
        })
        .require(Requirement {
            name: "calm".to_owned(),
            metric: Measure::Busy.at(5..6),
            comparison: Comparison::Lt,
            bound: 0.5,
            span: span(),
        });
    builder.plant(Options {
        parts: Some(6),
        ..Options::default()
    })
}

#[test]
fn as_text() {
    let mut plant = plant();
    let trace = plant.run();
    let text = report::table(plant.line(), &trace, None);
    assert!(text.lines().all(|l| l.chars().count() <= 100), "{text}");
    insta::assert_snapshot!(text, @r#"
    products     6 Product stored
    makespan     0:03:26
    throughput   104.85 an hour
    lead time    mean 0:01:01, median 0:01:00, 95th percentile 0:01:06, maximum 0:01:06
    WIP          mean 4.07 parts, maximum 5
    bottleneck   assembly_cell_1 (busy, set up or failed 87.4 % of the time)
    energy       2.750 Wh; 0.458 Wh a product
    parts        31 entered: 6 finished, 2 rejected, 21 joined into others, 2 still in the line
    rejected     1 Printed (1 ordered again), 1 Product (1 ordered again)
    quality      first-pass yield 85.7 %, scrap 14.3 %
    violations   1
                 0:02:26 assembly_cell_1, Product 23: turn: gripped
    
    station         machine            parts    time    Wh   busy starved blocked failed    idle setup
    camera          camera_machine         8 0:02:40 1.083 77.7 %  22.3 %   0.0 %  0.0 %   0.0 % 0.0 %
    assembly_cell_1 assembly_cell_1_m…     6 0:03:00 0.500 87.4 %  12.6 %   0.0 %  0.0 %   0.0 % 0.0 %
    milling         milling_machine        0     0 s 0.000  0.0 %   0.0 %   0.0 %  0.0 % 100.0 % 0.0 %
    
    station         work a part actions control    OEE availability effectiveness quality
    camera                 20 s    20 s     0 s 68.0 %       77.7 %       100.0 %  87.5 %
    assembly_cell_1        30 s    30 s     0 s 87.4 %       87.4 %       100.0 % 100.0 %
    
    conveyor machine parts mean length maximum moving    Wh
    belt     -           7        0.20       1   42 s 1.167
    
    by machine                 time    Wh
    camera_machine          0:02:40 1.083
    assembly_cell_1_machine 0:03:00 0.500
    milling_machine             0 s 0.000
    
    requirement verdict required                    measured
    pace        holds   throughput per hour >= 100   104.854
    calm        holds   busy share of milling < 0.5    0.000
    "#);
}

#[test]
fn as_json() {
    let mut plant = plant();
    let trace = plant.run();
    let mut document = report::json(plant.line(), &trace, None, None);
    assert!(document.get("wall_seconds").is_none());
    let over_time = document["wip"]["over_time"]["means"].take();
    assert_eq!(over_time.as_array().map(Vec::len), Some(206));
    insta::assert_snapshot!(serde_json::to_string_pretty(&document).unwrap(), @r#"
    {
      "schema": "linewright/run/1",
      "line": "test",
      "seed": 1,
      "end": "products",
      "simulated_seconds": 206.0,
      "warm_up_seconds": 0.0,
      "makespan_seconds": 206.0,
      "events": 21,
      "product": "Product",
      "products": 6,
      "stored": 6,
      "parts": {
        "before": 0,
        "entered": 31,
        "finished": 6,
        "rejected": 2,
        "consumed": 21,
        "in_progress": 2
      },
      "rejects": [
        {
          "part": "Printed",
          "count": 1,
          "reordered": 1
        },
        {
          "part": "Product",
          "count": 1,
          "reordered": 1
        }
      ],
      "first_pass_yield": 0.857143,
      "scrap_ratio": 0.142857,
      "throughput_per_hour": 104.854369,
      "throughput_per_hour_on_shift": null,
      "wip": {
        "mean": 4.067961,
        "max": 5,
        "over_time": {
          "bin_seconds": 1.0,
          "means": null
        }
      },
      "lead_time": {
        "mean": 60.666667,
        "p50": 60.0,
        "p95": 66.0,
        "max": 66.0
      },
      "energy_kwh": 0.00275,
      "energy_per_product_kwh": 0.000458333333,
      "bottleneck": "assembly_cell_1",
      "limited_by": {
        "kind": "station",
        "places": [
          "assembly_cell_1"
        ]
      },
      "sources": [
        {
          "name": "feeder",
          "passed": 8,
          "blocked": 0.582524,
          "lost": 0.0
        }
      ],
      "stations": [
        {
          "name": "camera",
          "machine": "camera_machine",
          "processed": 8,
          "busy": 0.776699,
          "starved": 0.223301,
          "blocked": 0.0,
          "failed": 0.0,
          "idle": 0.0,
          "setup": 0.0,
          "busy_seconds": 160.0,
          "energy_kwh": 0.001083333,
          "energy_by_state_kwh": {
            "busy": 0.000444444,
            "starved": 0.000638889,
            "blocked": 0.0,
            "failed": 0.0,
            "idle": 0.0,
            "setup": 0.0
          },
          "work": {
            "seconds": 20.0,
            "action_seconds": 20.0,
            "control_seconds": 0.0
          },
          "oee": {
            "index": 0.679612,
            "availability": 0.776699,
            "effectiveness": 1.0,
            "quality": 0.875
          },
          "scrapped": 1,
          "blocked_by": [],
          "starved_by": [
            {
              "place": "feeder",
              "share": 0.223301,
              "failed": 0.0,
              "off_shift": 0.0
            }
          ]
        },
        {
          "name": "assembly_cell_1",
          "machine": "assembly_cell_1_machine",
          "processed": 6,
          "busy": 0.873786,
          "starved": 0.126214,
          "blocked": 0.0,
          "failed": 0.0,
          "idle": 0.0,
          "setup": 0.0,
          "busy_seconds": 180.0,
          "energy_kwh": 0.0005,
          "energy_by_state_kwh": {
            "busy": 0.0005,
            "starved": 0.0,
            "blocked": 0.0,
            "failed": 0.0,
            "idle": 0.0,
            "setup": 0.0
          },
          "work": {
            "seconds": 30.0,
            "action_seconds": 30.0,
            "control_seconds": 0.0
          },
          "oee": {
            "index": 0.873786,
            "availability": 0.873786,
            "effectiveness": 1.0,
            "quality": 1.0
          },
          "scrapped": 0,
          "blocked_by": [],
          "starved_by": [
            {
              "place": "camera",
              "share": 0.126214,
              "failed": 0.0,
              "off_shift": 0.0
            }
          ]
        },
        {
          "name": "milling",
          "machine": "milling_machine",
          "processed": 0,
          "busy": 0.0,
          "starved": 0.0,
          "blocked": 0.0,
          "failed": 0.0,
          "idle": 1.0,
          "setup": 0.0,
          "busy_seconds": 0.0,
          "energy_kwh": 0.0,
          "energy_by_state_kwh": {
            "busy": 0.0,
            "starved": 0.0,
            "blocked": 0.0,
            "failed": 0.0,
            "idle": 0.0,
            "setup": 0.0
          },
          "work": null,
          "oee": null,
          "scrapped": 0,
          "blocked_by": [],
          "starved_by": []
        }
      ],
      "conveyors": [
        {
          "name": "belt",
          "machine": null,
          "carried": 7,
          "mean_length": 0.203883,
          "max_length": 1,
          "moving_seconds": 42.0,
          "energy_kwh": 0.001166667,
          "energy_by_state_kwh": {
            "moving": 0.001166667,
            "standing": 0.0
          }
        }
      ],
      "buffers": [],
      "machines": [
        {
          "name": "camera_machine",
          "busy_seconds": 160.0,
          "energy_kwh": 0.001083333
        },
        {
          "name": "assembly_cell_1_machine",
          "busy_seconds": 180.0,
          "energy_kwh": 0.0005
        },
        {
          "name": "milling_machine",
          "busy_seconds": 0.0,
          "energy_kwh": 0.0
        }
      ],
      "violations": [
        {
          "time": 146.0,
          "station": "assembly_cell_1",
          "rule": "turn: gripped",
          "code": -5,
          "message": "turn: the assumption gripped does not hold in step 3",
          "part": "Product",
          "part_number": 23
        }
      ],
      "violation_count": 1,
      "requirements": [
        {
          "name": "pace",
          "holds": true,
          "verdict": "holds",
          "value": 104.854368932
        },
        {
          "name": "calm",
          "holds": true,
          "verdict": "holds",
          "value": 0.0
        }
      ]
    }
    "#);
    let timed = report::json(plant.line(), &trace, None, Some(0.25));
    assert_eq!(timed["wall_seconds"], 0.25);
    for station in document["stations"].as_array().unwrap() {
        let shares = ["busy", "starved", "blocked", "failed", "idle", "setup"];
        let sum: f64 = shares.iter().map(|s| station[s].as_f64().unwrap()).sum();
        assert!((sum - 1.0).abs() < 1e-12);
    }
}

#[test]
fn replications_in_both() {
    let mut plant = plant();
    let (traces, figures) = plant.replicate(4);
    let document = report::json(
        plant.line(),
        &traces[0],
        Some(Intervals::Replications(&figures)),
        None,
    );
    assert_eq!(document["replications"]["count"], 4);
    let throughput = &document["replications"]["throughput_per_hour"];
    assert_eq!(
        throughput["low"], throughput["high"],
        "nothing is random here"
    );
    let text = report::table(
        plant.line(),
        &traces[0],
        Some(Intervals::Replications(&figures)),
    );
    assert!(text.contains("seeds 1 to 4, 95 %"));
}

/// A station that is slower in every run.
struct Slower(u64);

impl Controller for Slower {
    fn simulate(&mut self, _: usize, _: &mut [f64]) -> Result<Service, CallError> {
        took(10.0 * self.0 as f64)
    }

    fn step(&mut self, _: &[i64], _: &mut [i64]) -> Result<(), CallError> {
        Ok(())
    }

    fn reset(&mut self) {
        self.0 += 1;
    }
}

/// A station that gets faster from run to run: 200 s, 20 s, 10 s.
struct Faster(usize);

impl Controller for Faster {
    fn simulate(&mut self, _: usize, _: &mut [f64]) -> Result<Service, CallError> {
        took([200.0, 20.0, 10.0][self.0 - 1])
    }

    fn step(&mut self, _: &[i64], _: &mut [i64]) -> Result<(), CallError> {
        Ok(())
    }

    fn reset(&mut self) {
        self.0 += 1;
    }
}

/// A run without a product has no lead time and no makespan: it is not part of their means, and is
/// the worst run.
#[test]
fn runs_without_a_product_measure_nothing() {
    let mut builder = Builder::new(&["Part"]);
    let requirement = |name: &str, metric| Requirement {
        name: name.to_owned(),
        metric,
        comparison: Comparison::Le,
        bound: 100.0,
        span: span(),
    };
    builder
        .source("source", "Part", Supply::OnOrder)
        .station("cell", &["Part"], Faster(0))
        .sink("sink")
        .route("Part", &["source", "cell", "sink"])
        .require(requirement("done", Measure::Makespan.into()))
        .require(requirement("soon", Measure::LeadTime.into()));
    let mut plant = builder.plant(Options {
        parts: Some(1),
        until: Some(100.0),
        seed: 3,
        ..Options::default()
    });
    let (traces, figures) = plant.replicate(3);
    assert_eq!(
        traces.iter().map(|t| t.products).collect::<Vec<_>>(),
        [0, 1, 1]
    );
    assert_eq!(figures.makespan.expect("two were measured").mean, 15.0);
    let messages: Vec<&str> = figures
        .findings
        .iter()
        .map(|f| f.message.as_str())
        .collect();
    assert_eq!(
        messages,
        [
            "the requirement done does not hold in 1 of 3 runs: the makespan in seconds should be at most 100, and with seed 3 it was \
             not measured, since no product was finished",
            "the requirement soon does not hold in 1 of 3 runs: the mean lead time in seconds should be at most 100, and with seed 3 it \
             was not measured, since no product was finished",
        ]
    );
    let document = report::json(
        plant.line(),
        &traces[0],
        Some(Intervals::Replications(&figures)),
        None,
    );
    for requirement in document["requirements"].as_array().expect("they are there") {
        assert_eq!(requirement["value"], 15.0);
        assert_eq!(requirement["held_in"], 2);
        assert_eq!(requirement["worst"]["seed"], 3);
        assert!(requirement["worst"]["value"].is_null());
    }
    let table = report::table(
        plant.line(),
        &traces[0],
        Some(Intervals::Replications(&figures)),
    );
    let row = table.lines().find(|l| l.contains("soon")).expect("a row");
    assert!(row.contains("15.000") && row.ends_with('-'), "{table}");

    let figures = linewright::line::Replications::of(plant.line(), &traces[..1]);
    assert_eq!(figures.makespan, None);
    let document = report::json(
        plant.line(),
        &traces[0],
        Some(Intervals::Replications(&figures)),
        None,
    );
    assert!(document["replications"]["makespan_seconds"].is_null());
    assert!(document["requirements"][0]["value"].is_null());
}

/// Requirements are judged over all runs, consistently in findings, table and document.
#[test]
fn requirements_over_all_runs() {
    let mut builder = Builder::new(&["Part"]);
    let requirement = |name: &str, metric, comparison, bound| Requirement {
        name: name.to_owned(),
        metric,
        comparison,
        bound,
        span: span(),
    };
    builder
        .endless("source", "Part")
        .station("cell", &["Part"], Slower(0))
        .sink("sink")
        .route("Part", &["source", "cell", "sink"])
        .require(requirement(
            "pace",
            Measure::Throughput.into(),
            Comparison::Ge,
            150.0,
        ))
        .require(requirement(
            "short",
            Measure::Makespan.into(),
            Comparison::Le,
            -50.0,
        ))
        .require(requirement(
            "exact",
            Measure::Makespan.into(),
            Comparison::Eq,
            100.0,
        ))
        .require(requirement(
            "made",
            Measure::Products.into(),
            Comparison::Eq,
            10.0,
        ));
    let mut plant = builder.plant(Options {
        parts: Some(10),
        seed: 5,
        ..Options::default()
    });
    // 360, 180 and 120 per hour; 100, 200 and 300 s.
    let (traces, figures) = plant.replicate(3);
    let messages: Vec<&str> = figures
        .findings
        .iter()
        .map(|f| f.message.as_str())
        .collect();
    assert_eq!(
        messages,
        [
            "the requirement pace is undecided: the throughput in products an hour is 220 (95 % interval 0 to \
             530.269, 3 runs), and should be at least 150",
            "the requirement short does not hold: the makespan in seconds is 200 (95 % interval 0 to 448.414, 3 \
             runs), and should be at most -50",
            "the requirement exact is undecided: the makespan in seconds is 200 (95 % interval 0 to 448.414, 3 \
             runs), and should be exactly 100",
        ]
    );
    let helps: Vec<&str> = figures
        .findings
        .iter()
        .filter_map(|f| f.help.as_deref())
        .collect();
    assert_eq!(
        helps,
        [
            "About 12 more replications would decide it: `--replications 15`. Longer runs help, too.",
            "The bottleneck of test was cell; look there first, or change the requirement.",
            "A mean that varies is never exactly a number: use `<=` or `>=`.",
        ]
    );
    assert!(figures.findings.iter().all(|f| f.code.id == "LW406"));
    let gave_up: Vec<bool> = figures.findings.iter().map(|f| f.gave_up).collect();
    assert_eq!(gave_up, [true, false, true]);
    let document = report::json(
        plant.line(),
        &traces[0],
        Some(Intervals::Replications(&figures)),
        None,
    );
    let requirements = document["requirements"].as_array().expect("they are there");
    let verdicts: Vec<_> = requirements
        .iter()
        .map(|r| (r["verdict"].as_str().unwrap(), r["holds"] == true))
        .collect();
    assert_eq!(
        verdicts,
        [
            ("undecided", false),
            ("fails", false),
            ("undecided", false),
            ("holds", true)
        ]
    );
    let pace = &requirements[0];
    assert_eq!(
        (
            &pace["held_in"],
            &pace["replications"],
            &pace["more_replications"]
        ),
        (&2.into(), &3.into(), &12.into())
    );
    assert_eq!(pace["value"], 220.0);
    // t of 2 degrees of freedom 4.302653, standard deviation 124.899960, over the root of 3.
    assert!(
        (pace["high"].as_f64().unwrap() - (220.0 + 310.268)).abs() < 1e-2,
        "{pace}"
    );
    assert_eq!(pace["low"], 0.0, "the lower end is cut");
    assert_eq!(
        (&pace["worst"]["seed"], &pace["worst"]["value"]),
        (&7.into(), &120.0.into())
    );
    let text = report::table(
        plant.line(),
        &traces[0],
        Some(Intervals::Replications(&figures)),
    );
    assert!(text.lines().all(|l| l.chars().count() <= 100), "{text}");
    let rows: Vec<&str> = text
        .lines()
        .skip_while(|l| !l.contains("requirement"))
        .take(5)
        .collect();
    insta::assert_snapshot!(rows.join("\n"), @r"
      requirement verdict   required                      mean   from      to   worst
      pace        undecided throughput per hour >= 150 220.000  0.000 530.269 120.000
      short       fails     makespan in s <= -50       200.000  0.000 448.414 300.000
      exact       undecided makespan in s = 100        200.000  0.000 448.414 300.000
      made        holds     products = 10               10.000 10.000  10.000  10.000
    ");
}
