//! Games with integers, arrays, counters and monitors, in Spectra's language.
//!
//! Each family has a size at which solvers need seconds, and a variant that is unrealizable for a
//! reason that shows late: one demand out of many that cannot be met.

use std::fmt::Write as _;

/// What a robot arm has to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Task {
    /// The sum of the joints' positions reaches a target. Neighbours differ by a quarter of the
    /// range at most.
    Sum,
    /// The sum of products of two joints' positions each, and of the remaining positions, reaches a
    /// target.
    Product,
    /// The environment selects a joint by its index, and a position for it. The arm carries a load,
    /// whose product with the reach (the sum of all positions) is limited.
    Index,
    /// The tip reaches a target in the plane, and keeps its distance from an obstacle that moves.
    Obstacle,
}

/// A robot arm whose joints have positions from 0 to `values` - 1, and move one position a step.
///
/// The environment chooses a target, and keeps it until the arm is there. If the last joint is
/// `jammed`, it does not reach its last position, and the arm cannot reach the farthest target.
pub fn robot_arm(joints: usize, values: usize, task: Task, jammed: bool) -> String {
    assert!(
        joints >= 5 && values >= 8,
        "a robot arm has five joints of eight positions or more"
    );
    let last = values - 1;
    let last_joint = joints - 1;
    let (environment, rules) = match task {
        Task::Sum => {
            let (bend, neighbours) = (values / 4, last_joint - 1);
            let environment = format!("env Int(0..{}) target;\n", joints * last);
            let rules = format!(
                "define tip := {};\n\n\
                 gar bends_little: alw forall i in Int(0..{neighbours}).\n    \
                     joint[i] <= joint[i + 1] + {bend} & joint[i + 1] <= joint[i] + {bend};\n\
                 asm target_stays: G tip != target -> next(target) = target;\n\
                 gar reaches_target: GF tip = target;\n",
                sum(0..joints)
            );
            (environment, rules)
        }
        Task::Product => {
            let pairs = last_joint / 2;
            let products = (0..pairs).map(|i| format!("joint[{}] * joint[{}]", 2 * i, 2 * i + 1));
            let singles = (2 * pairs..joints).map(|i| format!("joint[{i}]"));
            let terms = products.chain(singles).collect::<Vec<_>>().join(" + ");
            let greatest = pairs * last * last + (joints - 2 * pairs) * last;
            let environment = format!("env Int(0..{greatest}) target;\n");
            let rules = format!(
                "define tip := {terms};\n\n\
                 asm target_stays: G tip != target -> next(target) = target;\n\
                 gar reaches_target: GF tip = target;\n"
            );
            (environment, rules)
        }
        Task::Index => {
            let limit = joints * last + joints;
            let environment = format!(
                "env Joint selected;\n\
                 env Position wanted;\n\
                 env Int(1..{joints}) load;\n"
            );
            let rules = format!(
                "define reach := {};\n\n\
                 asm command_stays: G joint[selected] != wanted ->\n    \
                     next(selected) = selected & next(wanted) = wanted;\n\
                 asm load_stays: G reach > 0 -> next(load) = load;\n\
                 gar limits_torque: alw load * reach <= {limit};\n\
                 gar obeys: GF joint[selected] = wanted;\n\
                 gar folds: GF reach = 0;\n",
                sum(0..joints)
            );
            (environment, rules)
        }
        Task::Obstacle => {
            let middle = joints / 2;
            let (width, height) = (middle * last, (joints - middle) * last);
            let far = values / 4;
            let environment = format!(
                "env Int(0..{width}) target_x;\n\
                 env Int(0..{height}) target_y;\n\
                 env Int(0..{width}) obstacle_x;\n\
                 env Int(0..{height}) obstacle_y;\n"
            );
            let rules = format!(
                "define\n    x := {};\n    y := {};\n\n\
                 asm starts_away: obstacle_x = {width} & obstacle_y = {height};\n\
                 asm obstacle_moves_x: G\n    \
                     next(obstacle_x) <= obstacle_x + 1 & obstacle_x <= next(obstacle_x) + 1;\n\
                 asm obstacle_moves_y: G\n    \
                     next(obstacle_y) <= obstacle_y + 1 & obstacle_y <= next(obstacle_y) + 1;\n\
                 asm target_stays: G x != target_x | y != target_y ->\n    \
                     next(target_x) = target_x & next(target_y) = target_y;\n\
                 asm obstacle_leaves: GF\n    \
                     obstacle_x > target_x + {far} | target_x > obstacle_x + {far} |\n    \
                     obstacle_y > target_y + {far} | target_y > obstacle_y + {far};\n\
                 gar keeps_distance: alw\n    \
                     x > obstacle_x + 1 | obstacle_x > x + 1 |\n    \
                     y > obstacle_y + 1 | obstacle_y > y + 1;\n\
                 gar reaches_target: GF x = target_x & y = target_y;\n",
                sum(0..middle),
                sum(middle..joints)
            );
            (environment, rules)
        }
    };
    let (name, jam) = if jammed {
        (
            "Jammed",
            format!("gar jams: alw joint[{last_joint}] < {last};\n"),
        )
    } else {
        ("", String::new())
    };
    format!(
        "spec RobotArm{joints}x{values}{task:?}{name}\n\n\
         type Joint = Int(0..{last_joint});\n\
         type Position = Int(0..{last});\n\n\
         {environment}\
         sys Position[{joints}] joint;\n\n\
         gar starts_folded: forall i in Joint. joint[i] = 0;\n\
         gar moves_slowly: G forall i in Joint.\n    \
             next(joint[i]) <= joint[i] + 1 & joint[i] <= next(joint[i]) + 1;\n\
         {jam}\n\
         {rules}"
    )
}

/// The sum of the positions of some joints.
fn sum(joints: std::ops::Range<usize>) -> String {
    joints
        .map(|i| format!("joint[{i}]"))
        .collect::<Vec<_>>()
        .join(" + ")
}

/// Elevators that serve calls from `floors` floors with `cars` cars.
///
/// A door stays open for some steps, and while something blocks it. With a deadline, each call is
/// served in fewer steps than this, not counting those in which a door is blocked. Too short a
/// deadline is unrealizable.
pub fn elevator(floors: usize, cars: usize, deadline: Option<usize>) -> String {
    assert!(
        floors >= 2 && cars >= 1,
        "an elevator has two floors and a car"
    );
    let (top, last_car) = (floors - 1, cars - 1);
    let mut out = format!("spec Elevator{floors}Floors{cars}Cars");
    if let Some(deadline) = deadline {
        write!(out, "Deadline{deadline}").unwrap();
    }
    write!(
        out,
        "\n\n\
         type Floor = Int(0..{top});\n\
         type Car = Int(0..{last_car});\n\
         env boolean[{floors}] call;\n\
         env boolean[{cars}] blocked;\n\
         sys Floor[{cars}] floor;\n\
         sys boolean[{cars}] open;\n\n\
         gar starts_closed: forall c in Car. floor[c] = 0 & !open[c];\n\
         gar moves_slowly: G forall c in Car.\n    \
             next(floor[c]) <= floor[c] + 1 & floor[c] <= next(floor[c]) + 1;\n\
         gar moves_closed: G forall c in Car.\n    \
             open[c] | next(open[c]) -> next(floor[c]) = floor[c];\n\
         gar stays_open_if_blocked: G forall c in Car. open[c] & blocked[c] -> next(open[c]);\n\
         asm unblocked: GF forall c in Car. !blocked[c];\n"
    )
    .unwrap();
    for car in 0..cars {
        write!(
            out,
            "\ncounter open_time{car}(0..3) {{\n    \
                 open_time{car} = 0;\n    \
                 reset: !open[{car}];\n    \
                 inc: open[{car}] & !blocked[{car}];\n    \
                 overflow: keep;\n\
             }}\n\
             gar stays_open{car}: G open[{car}] & open_time{car} < 2 -> next(open[{car}]);\n"
        )
        .unwrap();
    }
    let unblocked = (0..cars)
        .map(|c| format!("!blocked[{c}]"))
        .collect::<Vec<_>>()
        .join(" & ");
    for floor in 0..floors {
        let served = (0..cars).map(|c| format!("(floor[{c}] = {floor} & open[{c}])"));
        let served = served.collect::<Vec<_>>().join(" | ");
        write!(
            out,
            "\nmonitor boolean pending{floor} {{\n    \
                 !pending{floor};\n    \
                 G next(pending{floor}) <-> (pending{floor} | call[{floor}]) &\n        \
                     !({served});\n\
             }}\n"
        )
        .unwrap();
        if let Some(deadline) = deadline {
            write!(
                out,
                "counter waited{floor}(0..{deadline}) {{\n    \
                     waited{floor} = 0;\n    \
                     reset: !pending{floor};\n    \
                     inc: pending{floor} & {unblocked};\n    \
                     overflow: keep;\n\
                 }}\n\
                 gar in_time{floor}: alw waited{floor} < {deadline};\n"
            )
            .unwrap();
        } else {
            writeln!(out, "gar serves{floor}: GF !pending{floor};").unwrap();
        }
    }
    out
}

/// An arbiter of an AHB bus with `masters` masters, as Bloem et al. formalize it ("Synthesis of
/// Reactive(1) designs", JCSS 2012), with numbers, arrays, a counter and a monitor.
///
/// Master 0 is the default master. If the bus may `stall`, the arbiter cannot serve everybody.
pub fn ahb(masters: usize, stall: bool) -> String {
    assert!(masters >= 2, "a bus has two masters");
    let last = masters - 1;
    let name = if stall { "Stalling" } else { "" };
    let ready = if stall {
        ""
    } else {
        "asm becomes_ready: GF hready;\n"
    };
    let mut out = format!(
        "spec Ahb{masters}{name}\n\n\
         type Master = Int(0..{last});\n\
         type Burst = {{SINGLE, BURST4, INCR}};\n\
         env boolean hready;\n\
         env boolean[{masters}] hbusreq;\n\
         env boolean[{masters}] hlock;\n\
         env Burst hburst;\n\
         sys Master hmaster;\n\
         sys Master granted;\n\
         sys boolean hmastlock;\n\
         sys boolean locked;\n\
         sys boolean start;\n\
         sys boolean decide;\n\n\
         define\n    \
             unlimited := hmastlock & start & hburst = INCR;\n    \
             four := hmastlock & start & hburst = BURST4;\n\n\
         asm idle_bus: !hready & (forall i in Master. !hbusreq[i] & !hlock[i]);\n\
         gar idle_arbiter: hmaster = 0 & granted = 0 & !hmastlock & !locked & start & decide;\n\n\
         asm lock_requests: alw forall i in Master. hlock[i] -> hbusreq[i];\n\
         {ready}\
         gar start_when_ready: G !hready -> !next(start);\n\n\
         pattern answers(response, stimulus) {{\n    \
             var boolean settled;\n    \
             settled;\n    \
             G next(settled) <-> response | (settled & !stimulus);\n    \
             GF settled;\n\
         }}\n\
         asm unlimited_burst_ends: answers(!hbusreq[hmaster], hmastlock & hburst = INCR);\n\n\
         monitor boolean occupied {{\n    \
             !occupied;\n    \
             G next(occupied) <-> (occupied | unlimited) & hbusreq[hmaster];\n\
         }}\n\
         gar unlimited_burst: alw occupied -> !start;\n\n\
         counter beats(0..4) {{\n    \
             beats = 0;\n    \
             reset: beats = 4 & hready;\n    \
             inc: (four & beats = 0) | (beats > 0 & beats < 4 & hready);\n    \
             overflow: keep;\n\
         }}\n\
         gar burst_of_four: alw beats > 0 -> !start;\n\n\
         gar hands_over: G hready -> next(hmaster) = granted & (next(hmastlock) <-> locked);\n\
         gar keeps_master: G !next(start) ->\n    \
             next(hmaster) = hmaster & (next(hmastlock) <-> hmastlock);\n\
         gar takes_lock: G forall i in Master.\n    \
             decide & next(granted) = i -> (next(locked) <-> hlock[i]);\n\
         gar keeps_decision: G !decide ->\n    \
             next(granted) = granted & (next(locked) <-> locked);\n\
         gar default_master: G decide & (forall i in Master. !hbusreq[i]) -> next(granted) = 0;\n"
    );
    for master in 1..masters {
        write!(
            out,
            "gar no_idle_grant{master}: G granted != {master} & !hbusreq[{master}] ->\n    \
                 next(granted) != {master};\n"
        )
        .unwrap();
    }
    for master in 0..masters {
        writeln!(
            out,
            "gar serves{master}: GF hmaster = {master} | !hbusreq[{master}];"
        )
        .unwrap();
    }
    out
}

/// Cinderella and her stepmother (Bodlaender et al., "The Cinderella game on holes and
/// anti-holes", 2011): the stepmother distributes `water` units over a circle of `buckets`
/// buckets, then Cinderella empties `reach` adjacent buckets, and none may ever overflow its
/// `capacity`.
pub fn cinderella(buckets: usize, reach: usize, capacity: usize, water: usize) -> String {
    assert!(reach < buckets, "Cinderella cannot reach all buckets");
    let last = buckets - 1;
    let poured = (0..buckets)
        .map(|i| format!("poured[{i}]"))
        .collect::<Vec<_>>()
        .join(" + ");
    let mut out = format!(
        "spec Cinderella{buckets}Buckets{capacity}By{water}Reach{reach}\n\n\
         env Int(0..{water})[{buckets}] poured;\n\
         sys Int(0..{capacity})[{buckets}] level;\n\
         sys Int(0..{last}) emptied;\n\n\
         asm pours_all: alw {poured} = {water};\n\
         gar starts_empty: forall i in Int(0..{last}). level[i] = 0;\n"
    );
    for bucket in 0..buckets {
        let firsts = (0..reach).map(|back| (bucket + buckets - back) % buckets);
        let empties = firsts
            .map(|first| format!("emptied = {first}"))
            .collect::<Vec<_>>();
        let empties = empties.join(" | ");
        write!(
            out,
            "gar empties{bucket}: G {empties} -> next(level[{bucket}]) = next(poured[{bucket}]);\n\
             gar fills{bucket}: G !({empties}) ->\n    \
                 next(level[{bucket}]) = level[{bucket}] + next(poured[{bucket}]);\n"
        )
        .unwrap();
    }
    out
}
