//! The generated specifications: sizes between and beyond those of the published files, and games
//! with arithmetic.

use crate::families::anzu::{amba, genbuf};
use crate::families::arithmetic::{Task, ahb, cinderella, elevator, robot_arm};
use crate::families::formula::Format;

/// Sizes of genbuf that are not among the published files, or not in every format.
const GENBUF: [usize; 10] = [7, 15, 25, 30, 50, 60, 80, 100, 150, 200];

/// Sizes of AMBA that are not among the published files, or not in every format.
const AMBA: [usize; 10] = [6, 7, 8, 9, 10, 11, 12, 13, 14, 15];

/// Name, extension, and generator of a specification's text.
pub type Instance = (String, &'static str, Box<dyn Fn() -> String>);

/// Returns all instances.
pub fn all() -> Vec<Instance> {
    let mut found: Vec<Instance> = Vec::new();
    for (format, ending) in [
        (Format::Slugsin, "slugsin"),
        (Format::Spc, "spc"),
        (Format::Spectra, "spectra"),
    ] {
        for size in GENBUF {
            let text = move || genbuf(size, format);
            found.push((format!("genbuf{size}"), ending, Box::new(text)));
        }
        for size in AMBA {
            let text = move || amba(size, format);
            found.push((format!("amba{size}"), ending, Box::new(text)));
        }
    }
    let mut add = |name: &str, text: Box<dyn Fn() -> String>| {
        found.push((name.to_owned(), "spectra", text));
    };
    for (name, values, task, jammed) in [
        ("arm-sum-16", 16, Task::Sum, false),
        ("arm-sum-32", 32, Task::Sum, false),
        ("arm-product-12", 12, Task::Product, false),
        ("arm-product-16", 16, Task::Product, false),
        ("arm-index-16", 16, Task::Index, false),
        ("arm-obstacle-8", 8, Task::Obstacle, false),
        ("arm-sum-12-jammed", 12, Task::Sum, true),
    ] {
        add(name, Box::new(move || robot_arm(5, values, task, jammed)));
    }
    add("elevator-4-1-19", Box::new(|| elevator(4, 1, Some(19))));
    add("elevator-4-2-10", Box::new(|| elevator(4, 2, Some(10))));
    add("elevator-5-1-26", Box::new(|| elevator(5, 1, Some(26))));
    add("elevator-5-2-14", Box::new(|| elevator(5, 2, Some(14))));
    for floors in [16, 20, 24] {
        let name = format!("elevator-{floors}-3");
        add(&name, Box::new(move || elevator(floors, 3, None)));
    }
    add("ahb-6", Box::new(|| ahb(6, false)));
    add("ahb-8", Box::new(|| ahb(8, false)));
    add("cinderella-5-2-9-5", Box::new(|| cinderella(5, 2, 9, 5)));
    add("cinderella-6-2-11-5", Box::new(|| cinderella(6, 2, 11, 5)));
    found
}
