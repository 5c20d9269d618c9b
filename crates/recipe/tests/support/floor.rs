//! Shop floors as layouts and recipes: job shops with ample buffers, and cells that block.

use super::jobs::Jobs;
use linewright_recipe::model::{
    Action, Demand, Guard, Layout, OperationCall, Part, Recipe, RecipeTransition, Resource, Step,
};

fn take(label: &str) -> Action {
    Action::In(label.to_owned())
}

fn give(label: &str) -> Action {
    Action::Out(label.to_owned())
}

/// Adds a transition with a duration.
fn add(resource: &mut Resource, from: &str, action: Action, to: &str, seconds: i64) {
    let mut changed = resource.clone().with(from, action, to);
    let last = changed
        .transitions
        .last_mut()
        .expect("it has just been added");
    last.seconds = Some(seconds as f64);
    *resource = changed;
}

/// Returns a recipe with one transition, whose operations keep or make the part.
fn recipe(name: &str, part: &str, steps: Vec<OperationCall>, remains: bool) -> Recipe {
    let steps = steps
        .into_iter()
        .map(|call| Step::new(vec![call]))
        .collect();
    Recipe {
        name: name.to_owned(),
        parts: vec![Part::new(part, part)],
        states: vec!["a".to_owned(), "b".to_owned()],
        start: "a".to_owned(),
        ends: vec!["b".to_owned()],
        leftover: if remains {
            vec![part.to_owned()]
        } else {
            Vec::new()
        },
        transitions: vec![RecipeTransition::new("a", "b", Guard::Always, steps)],
    }
}

/// Returns a job shop as a layout: a store with room for everything, machines for one part, and
/// ways that take no time. Each job has a recipe for a part that is in the store at the start.
pub fn job_shop(jobs: &Jobs) -> (Layout, Vec<Demand>) {
    let machines = jobs.iter().flatten().map(|t| t.0 + 1).max().unwrap_or(0);
    let mut resources = Vec::new();
    let mut store = Resource::new("store", &["s"], &[]).holding(jobs.len());
    store = store.with("s", take("store"), "s");
    for machine in 0..machines {
        let name = format!("m{machine}");
        store = store.with("s", give(&name), "s");
        let mut resource = Resource::new(&name, &["empty", "loaded", "done"], &[])
            .with("empty", take(&name), "loaded")
            .with("done", give("store"), "empty");
        for (number, job) in jobs.iter().enumerate() {
            for (_, seconds) in job.iter().filter(|t| t.0 == machine) {
                let work = Action::Operation(format!("{name} of job {number}"));
                add(&mut resource, "loaded", work, "done", *seconds);
            }
        }
        resources.push(resource);
    }
    let demand = |(number, job): (usize, &Vec<(usize, i64)>)| {
        let part = format!("part {number}");
        let call = |(machine, _): &(usize, i64)| {
            OperationCall::new(&format!("m{machine} of job {number}"), &[&part], &[&part])
        };
        let steps = job.iter().map(call).collect();
        Demand::new(recipe(&format!("Job{number}"), &part, steps, true), 1)
    };
    let demands = jobs.iter().enumerate().map(demand).collect();
    store.holds = (0..jobs.len()).map(|n| format!("part {n}")).collect();
    resources.push(store);
    let name = "JobShop".to_owned();
    (Layout { name, resources }, demands)
}

/// A cell with one transport, in which parts stay where they are until they are fetched.
pub struct Blocking {
    /// Name of the cell.
    pub name: &'static str,
    /// Number of stations. The first loads parts, the last takes them out.
    pub stations: usize,
    /// For each job, its stations and durations in seconds.
    pub jobs: Jobs,
}

impl Blocking {
    /// Returns the time of the way between two stations, in seconds.
    pub fn way(from: usize, to: usize) -> i64 {
        1 + (2 * from + 3 * to) as i64 % 4
    }

    /// Returns the layout and a recipe for each job.
    pub fn cell(&self) -> (Layout, Vec<Demand>) {
        let mut resources = Vec::new();
        let mut states = vec!["empty".to_owned()];
        states.extend((0..self.stations).map(|s| format!("from {s}")));
        let names: Vec<&str> = states.iter().map(String::as_str).collect();
        let mut transport = Resource::new("transport", &names, &[]);
        for station in 0..self.stations {
            let (first, last) = (station == 0, station + 1 == self.stations);
            let mut resource = Resource::new(
                &format!("station {station}"),
                &["empty", "loaded", "done"],
                &[],
            );
            if !first {
                resource = resource.with("empty", take(&format!("to {station}")), "loaded");
            }
            if !last {
                resource = resource.with("done", give(&format!("from {station}")), "empty");
                let from = take(&format!("from {station}"));
                transport = transport.with("empty", from, &format!("from {station}"));
            }
            for (number, job) in self.jobs.iter().enumerate() {
                for (_, seconds) in job.iter().filter(|t| t.0 == station) {
                    let work = Action::Operation(format!("work {station} of {number}"));
                    let from = if first { "empty" } else { "loaded" };
                    let to = if last { "empty" } else { "done" };
                    add(&mut resource, from, work, to, *seconds);
                }
            }
            for to in (1..self.stations).filter(|to| *to != station && !last) {
                let route = give(&format!("to {to}"));
                let state = format!("from {station}");
                add(
                    &mut transport,
                    &state,
                    route,
                    "empty",
                    Self::way(station, to),
                );
            }
            resources.push(resource);
        }
        resources.push(transport);
        let demand = |(number, job): (usize, &Vec<(usize, i64)>)| {
            let part = format!("part {number}");
            let call = |(at, (station, _)): (usize, &(usize, i64))| {
                let part = part.as_str();
                let inputs: &[&str] = if at == 0 { &[] } else { &[part] };
                let outputs: &[&str] = if at + 1 == job.len() { &[] } else { &[part] };
                OperationCall::new(&format!("work {station} of {number}"), inputs, outputs)
            };
            let steps = job.iter().enumerate().map(call).collect();
            Demand::new(recipe(&format!("Job{number}"), &part, steps, false), 1)
        };
        let demands = self.jobs.iter().enumerate().map(demand).collect();
        let name = "Blocking".to_owned();
        (Layout { name, resources }, demands)
    }

    /// Returns the cell as text for the model in Python: the ways, then a line for each job.
    pub fn text(&self) -> String {
        let mut text = format!("{}\n", self.stations);
        for from in 0..self.stations {
            let ways: Vec<String> = (0..self.stations)
                .map(|to| Self::way(from, to).to_string())
                .collect();
            text.push_str(&ways.join(" "));
            text.push('\n');
        }
        for job in &self.jobs {
            let tasks: Vec<String> = job.iter().map(|(s, d)| format!("{s} {d}")).collect();
            text.push_str(&tasks.join(" "));
            text.push('\n');
        }
        text
    }
}

/// Returns two cells that block.
pub fn blocking() -> [Blocking; 2] {
    [
        // A flow line: loading, two machines, unloading.
        Blocking {
            name: "flow",
            stations: 4,
            jobs: vec![
                vec![(0, 2), (1, 7), (2, 3), (3, 1)],
                vec![(0, 2), (1, 4), (2, 9), (3, 1)],
                vec![(0, 2), (1, 6), (2, 2), (3, 1)],
                vec![(0, 2), (1, 3), (2, 8), (3, 1)],
            ],
        },
        // Jobs with routes of their own through three machines.
        Blocking {
            name: "jobs",
            stations: 5,
            jobs: vec![
                vec![(0, 1), (1, 6), (3, 5), (4, 1)],
                vec![(0, 1), (2, 8), (1, 4), (4, 2)],
                vec![(0, 1), (3, 7), (4, 1)],
            ],
        },
    ]
}
