//! Two machines as the resolver would produce them: a manipulator with a coordinator and four
//! actions, and a belt.

use super::explicit;
use linewright::contract::machine::{
    ActionTime, Component, Machine, Operation, PlantInput, PlantSource, Property, PropertyKind,
    RealBinary, RealExpr, RealUnary, Role,
};
use linewright::gr1::{
    BinaryOp, Domain, Expr, Formula, Owner, Side, Specification, Timing, UnaryOp, VarId, Variable,
};
use linewright::mealy;
use linewright::source::Span;
use std::sync::Arc;

pub const fn c(value: i64) -> Expr {
    Expr::Const(value)
}
pub fn v(index: u32) -> Expr {
    Expr::now(VarId(index))
}
pub fn n(index: u32) -> Expr {
    Expr::next(VarId(index))
}
pub fn op(op: BinaryOp, a: Expr, b: Expr) -> Expr {
    Expr::binary(op, a, b)
}
fn cond(c: Expr, a: Expr, b: Expr) -> Expr {
    Expr::If(Box::new(c), Box::new(a), Box::new(b))
}
fn ne(a: Expr, b: Expr) -> Expr {
    op(BinaryOp::Ne, a, b)
}

fn variable(name: &str, owner: Owner, domain: Domain) -> Variable {
    Variable {
        name: name.to_owned(),
        owner,
        internal: false,
        unit: String::new(),
        domain,
        span: Span::default(),
    }
}
fn input(name: &str, domain: Domain) -> Variable {
    variable(name, Owner::Environment, domain)
}
fn output(name: &str, domain: Domain) -> Variable {
    variable(name, Owner::System, domain)
}
fn range(low: i64, high: i64) -> Domain {
    Domain::Range { low, high }
}
fn labels(labels: &[&str]) -> Domain {
    Domain::Enum {
        name: None,
        labels: labels.iter().map(|l| (*l).to_owned()).collect(),
    }
}

fn formula(name: &str, text: &str, expr: Expr) -> Formula {
    Formula {
        defines: false,
        name: name.to_owned(),
        requirement: (name == "gripped").then(|| "R-12".to_owned()),
        expr,
        span: Span::default(),
        text: text.to_owned(),
    }
}

/// The upper layer: takes a request, commands an action until it reports its end, reports its own.
fn coordinator() -> Specification {
    let jobs = || labels(&["none", "turn", "pick"]);
    let (request, finished, command, done) = (0, 1, 2, 3);
    let idle = || v(command).equals(c(0)).and(v(done).not());
    let next_command = cond(
        v(done),
        c(0),
        cond(idle(), v(request), cond(v(finished), c(0), v(command))),
    );
    let next_done = ne(v(command), c(0)).and(v(finished));
    Specification {
        name: "Coordinate".to_owned(),
        timing: Timing::Moore,
        variables: vec![
            input("request", jobs()),
            input("finished", Domain::Bool),
            output("command", jobs()),
            output("done", Domain::Bool),
        ],
        assumptions: Side {
            safety: vec![formula(
                "request stays",
                "always (command != none -> next(request) = request)",
                ne(v(command), c(0)).implies(n(request).equals(v(request))),
            )],
            justice: vec![formula(
                "ends",
                "always eventually (command = none | finished)",
                v(command).equals(c(0)).or(v(finished)),
            )],
            ..Side::default()
        },
        guarantees: Side {
            initial: vec![formula("starts idle", "command = none & !done", idle())],
            safety: vec![
                formula(
                    "follows",
                    "always next(command) = ...",
                    n(command).equals(next_command),
                ),
                formula(
                    "reports",
                    "always (next(done) <-> command != none & finished)",
                    n(done).equals(next_done),
                ),
            ],
            ..Side::default()
        },
    }
}

/// Turns by a quarter per step, if the axis is free, until the desired angle is reached.
fn turn() -> Specification {
    let (start, desired, gripped, free, angle, reached) = (0, 1, 2, 3, 4, 5);
    let turned = op(BinaryOp::Mod, op(BinaryOp::Add, v(angle), c(1)), c(4));
    let moves = || n(start).and(n(free)).and(ne(v(angle), n(desired)));
    Specification {
        name: "Turn".to_owned(),
        timing: Timing::Mealy,
        variables: vec![
            input("start", Domain::Bool),
            input("desired", range(0, 3)),
            input("gripped", Domain::Bool),
            input("free", Domain::Bool),
            output("angle", range(0, 3)),
            output("reached", Domain::Bool),
        ],
        assumptions: Side {
            initial: vec![formula("rest", "!start", v(start).not())],
            invariants: vec![formula(
                "gripped",
                "always (start -> gripped)",
                v(start).implies(v(gripped)),
            )],
            safety: vec![formula(
                "steady",
                "always (start & next(start) -> next(desired) = desired)",
                v(start)
                    .and(n(start))
                    .implies(n(desired).equals(v(desired))),
            )],
            justice: vec![
                formula("free", "always eventually free", v(free)),
                formula(
                    "moves on",
                    "always eventually (free & next(free))",
                    v(free).and(n(free)),
                ),
            ],
        },
        guarantees: Side {
            initial: vec![formula("at zero", "angle = 0", v(angle).equals(c(0)))],
            invariants: vec![formula(
                "reached",
                "always (reached <-> start & angle = desired)",
                v(reached).equals(v(start).and(v(angle).equals(v(desired)))),
            )],
            safety: vec![formula(
                "turns",
                "always next(angle) = (if next(start & free) & angle != next(desired) then (angle + 1) mod 4 else angle)",
                n(angle).equals(cond(moves(), turned, v(angle))),
            )],
            ..Side::default()
        },
    }
}

/// Picks from a height in three stages; only while the turner stands still at an even angle.
fn pick() -> Specification {
    let (start, height, angle, stage, depth) = (0, 1, 2, 3, 4);
    let down = op(
        BinaryOp::Mul,
        op(BinaryOp::Min, n(stage), c(2)),
        Expr::Unary(UnaryOp::Abs, Box::new(n(height))),
    );
    let shifted = op(BinaryOp::Sub, down, c(1));
    Specification {
        name: "Pick".to_owned(),
        timing: Timing::Mealy,
        variables: vec![
            input("start", Domain::Bool),
            input("height", range(-2, 2)),
            input("angle", range(0, 3)),
            output("stage", range(0, 3)),
            output("depth", range(-1, 3)),
        ],
        assumptions: Side {
            invariants: vec![formula(
                "even angle",
                "always (start -> angle mod 2 = 0) /* not *\u{2f} odd */",
                v(start).implies(op(BinaryOp::Mod, v(angle), c(2)).equals(c(0))),
            )],
            safety: vec![
                formula(
                    "height stays",
                    "always (start -> abs(next(height) - height) <= 1 | !next(start))",
                    v(start).implies(
                        op(
                            BinaryOp::Le,
                            Expr::Unary(
                                UnaryOp::Abs,
                                Box::new(op(BinaryOp::Sub, n(height), v(height))),
                            ),
                            c(1),
                        )
                        .or(n(start).not()),
                    ),
                ),
                // A transition without next values: it refers to the previous step.
                formula(
                    "low where it picks",
                    "always (next true -> !(stage = 1 & height = 2))",
                    v(stage).equals(c(1)).and(v(height).equals(c(2))).not(),
                ),
            ],
            ..Side::default()
        },
        guarantees: Side {
            initial: vec![formula(
                "up",
                "stage = 0 & depth = -1",
                v(stage).equals(c(0)).and(v(depth).equals(c(-1))),
            )],
            invariants: vec![formula(
                "no such stage",
                "always (true | stage = 5)",
                Expr::TRUE.or(v(stage).equals(c(5))),
            )],
            safety: vec![
                formula(
                    "stages",
                    "always next(stage) = (if next(start) then min(stage + 1, 3) else 0)",
                    n(stage).equals(cond(
                        n(start),
                        op(BinaryOp::Min, op(BinaryOp::Add, v(stage), c(1)), c(3)),
                        c(0),
                    )),
                ),
                formula(
                    "depth",
                    "always next(depth) = min(next(stage), 2) * abs(next(height)) - 1",
                    n(depth).equals(shifted),
                ),
            ],
            ..Side::default()
        },
    }
}

/// A lamp, a Moore action: shows in the next step that something works.
fn lamp() -> Specification {
    Specification {
        name: "Lamp".to_owned(),
        timing: Timing::Moore,
        variables: vec![input("works", Domain::Bool), output("lit", Domain::Bool)],
        assumptions: Side::default(),
        guarantees: Side {
            initial: vec![formula("dark", "!lit", v(1).not())],
            safety: vec![formula(
                "lit",
                "always (next(lit) <-> works)",
                n(1).equals(v(0)),
            )],
            ..Side::default()
        },
    }
}

fn number(x: f64) -> RealExpr {
    RealExpr::Number(x)
}
fn property(i: usize) -> RealExpr {
    RealExpr::Property(i)
}
fn real(op: RealBinary, a: RealExpr, b: RealExpr) -> RealExpr {
    RealExpr::Binary(op, Box::new(a), Box::new(b))
}

fn component(
    name: &str,
    role: Role,
    specification: Specification,
    bindings: Vec<Expr>,
) -> Component {
    Component {
        name: name.to_owned(),
        contract: specification.name.clone(),
        role,
        specification: Arc::new(specification),
        bindings,
        active: None,
        time: None,
        watts: number(0.0),
        span: Span::default(),
    }
}

/// The machine from the manipulator's file, and a controller for each component.
pub fn manipulator() -> (Arc<Machine>, Arc<Vec<mealy::Controller>>) {
    // Wires: request 0, cell 1, grip 2, free 3, height 4; coordinator.command 5, .done 6;
    // turn.angle 7, .reached 8; pick.stage 9, .depth 10; lamp.lit 11; idle.stage 12, .depth 13.
    let plant = |name: &str, domain, source| PlantInput {
        name: name.to_owned(),
        unit: String::new(),
        domain,
        source,
        span: Span::default(),
    };
    let signal = |script: &[i64]| PlantSource::Signal {
        script: script.to_vec(),
    };
    let angle_cell = real(RealBinary::Div, property(0), number(90.0));
    let turning = || v(5).equals(c(1));
    let picking = || v(5).equals(c(2));
    let finished = turning().and(v(8)).or(picking().and(v(9).equals(c(3))));
    let coordinate = component(
        "coordinator",
        Role::Coordinator,
        coordinator(),
        vec![v(0), finished],
    );
    let mut turner = component(
        "turn",
        Role::Action,
        turn(),
        vec![turning(), v(1), v(2), v(3)],
    );
    turner.active = Some(turning());
    turner.time = Some(ActionTime::PerStep(real(
        RealBinary::Add,
        number(0.1),
        real(RealBinary::Mul, property(2), number(0.7)),
    )));
    turner.watts = real(RealBinary::Max, number(40.0), property(1));
    let mut picker = component("pick", Role::Action, pick(), vec![picking(), v(4), v(7)]);
    picker.active = Some(picking());
    picker.time = Some(ActionTime::PerExecution(number(2.5)));
    picker.watts = number(12.3);
    let mut light = component("lamp", Role::Action, lamp(), vec![turning().or(picking())]);
    light.active = Some(v(11));
    light.watts = number(0.5);
    // A second Pick that never starts, with arithmetic in its bindings.
    let below = op(
        BinaryOp::Sub,
        v(4),
        op(BinaryOp::Div, op(BinaryOp::Mul, v(4), c(3)), c(2)),
    );
    let idle = component(
        "idle",
        Role::Action,
        pick(),
        vec![c(0), below, op(BinaryOp::Sub, c(3), v(7))],
    );
    let property = |name: &str, unit: &str, default, kind| Property {
        domain: None,
        name: name.to_owned(),
        unit: unit.to_owned(),
        default,
        kind,
        span: Span::default(),
    };
    let operation = |name: &str, sequence: Vec<usize>, value| Operation {
        name: name.to_owned(),
        codes: vec![],
        sequence,
        value,
        span: Span::default(),
    };
    let machine = Machine {
        name: "Manipulator".to_owned(),
        doc: "Turns and picks; a fixture.".to_owned(),
        codes: vec![],
        components: vec![coordinate, turner, picker, light, idle],
        plant: vec![
            plant(
                "request",
                labels(&["none", "turn", "pick"]),
                PlantSource::Operation,
            ),
            plant("cell", range(0, 3), PlantSource::Property(angle_cell)),
            plant(
                "grip",
                Domain::Bool,
                PlantSource::Property(super::fixtures::property(1)),
            ),
            plant("free", Domain::Bool, signal(&[1, 0, 1])),
            plant("height", range(-2, 2), signal(&[-1])),
        ],
        properties: vec![
            property("angle", "deg", 0.0, PropertyKind::Part),
            property("grip", "", 1.0, PropertyKind::Parameter),
            property("steps", "", 0.3, PropertyKind::Part),
        ],
        operations: vec![
            operation("turning", vec![1], 1),
            operation("picking", vec![2], 2),
        ],
        writes: vec![
            (0, real(RealBinary::Mul, RealExpr::Wire(7), number(90.0))),
            (
                2,
                real(
                    RealBinary::Add,
                    super::fixtures::property(2),
                    RealExpr::Unary(RealUnary::Round, Box::new(number(0.1))),
                ),
            ),
        ],
        done: Some(v(6)),
        step_seconds: 0.25,
        base_watts: 100.1,
        idle_watts: 5.0,
        step_limit: 60,
        failures: Vec::new(),
        refines: Vec::new(),
        orders: Vec::new(),
        guarantees: linewright::contract::machine::Rules::default(),
        layers: linewright::contract::machine::Layers::default(),
        span: Span::default(),
    };
    with_controllers(machine)
}

/// The manipulator with an axis that gets stuck after half a turn: some operations do not end.
pub fn jammed() -> (Arc<Machine>, Arc<Vec<mealy::Controller>>) {
    let (machine, controllers) = manipulator();
    let mut machine = (*machine).clone();
    "Jammed".clone_into(&mut machine.name);
    let mut script = vec![0; 80];
    script[1] = 1;
    script[2] = 1;
    machine.plant[3].source = PlantSource::Signal { script };
    (Arc::new(machine), controllers)
}

/// A belt of three places that is only stepped.
pub fn belt() -> (Arc<Machine>, Arc<Vec<mealy::Controller>>) {
    // 0 load, 1 unload ready; 2, 3, 4 places; 5 ready.
    let (load, unload) = (0, 1);
    let place = |i: u32| 2 + i;
    // A place moves up if the one after it is free or moves too.
    let last_leaves = || v(place(2)).not().or(n(unload));
    let middle_moves = || v(place(1)).not().or(last_leaves());
    let first_moves = || v(place(0)).not().or(middle_moves());
    let moved = |free: Expr, from: Expr, own: u32| n(own).equals(cond(free, from, v(own)));
    let first = n(place(0)).equals(cond(first_moves(), n(load), v(place(0))));
    let specification = Specification {
        name: "Carry".to_owned(),
        timing: Timing::Mealy,
        variables: vec![
            input("load", Domain::Bool),
            input("unload", Domain::Bool),
            output("place[0]", Domain::Bool),
            output("place[1]", Domain::Bool),
            output("place[2]", Domain::Bool),
            output("ready", Domain::Bool),
        ],
        assumptions: Side {
            initial: vec![formula("starts empty", "!load", v(load).not())],
            safety: vec![formula(
                "only when ready",
                "always (next(load) -> ready)",
                n(load).implies(v(5)),
            )],
            justice: vec![formula("taken", "always eventually unload", v(unload))],
            ..Side::default()
        },
        guarantees: Side {
            initial: vec![formula(
                "empty",
                "!place[0] & !place[1] & !place[2]",
                v(2).not().and(v(3).not()).and(v(4).not()),
            )],
            invariants: vec![formula(
                "ready",
                "always (ready <-> !place[0])",
                v(5).equals(v(2).not()),
            )],
            safety: vec![
                formula("first", "always next(place[0]) = ...", first),
                formula(
                    "middle",
                    "always next(place[1]) = ...",
                    moved(middle_moves(), v(place(0)), place(1)),
                ),
                formula(
                    "last",
                    "always next(place[2]) = ...",
                    moved(last_leaves(), v(place(1)), place(2)),
                ),
            ],
            ..Side::default()
        },
    };
    let plant = |name: &str| PlantInput {
        name: name.to_owned(),
        unit: String::new(),
        domain: Domain::Bool,
        source: PlantSource::Signal { script: vec![0] },
        span: Span::default(),
    };
    with_controllers(Machine {
        name: "Belt3".to_owned(),
        doc: String::new(),
        codes: vec![],
        components: vec![component(
            "carry",
            Role::Action,
            specification,
            vec![v(0), v(1)],
        )],
        plant: vec![plant("load"), plant("unload")],
        properties: vec![],
        operations: vec![],
        writes: vec![],
        done: None,
        step_seconds: 1.0,
        base_watts: 0.0,
        idle_watts: 0.0,
        step_limit: 10,
        failures: Vec::new(),
        refines: Vec::new(),
        orders: Vec::new(),
        guarantees: linewright::contract::machine::Rules::default(),
        layers: linewright::contract::machine::Layers::default(),
        span: Span::default(),
    })
}

fn with_controllers(machine: Machine) -> (Arc<Machine>, Arc<Vec<mealy::Controller>>) {
    let controllers = machine
        .components
        .iter()
        .map(|c| explicit::controller(&c.specification).into())
        .collect();
    (Arc::new(machine), Arc::new(controllers))
}
