//! Generates small contracts from arbitrary bytes. Each byte is one choice; when none are left the
//! simplest option is taken, so that changing a byte changes the contract, and every text ends.
//!
//! The text always follows the grammar, and mostly the semantic rules: types fit, initial
//! assumptions are only about inputs, and so on. Only finer points are left for the resolver to
//! reject.

#[path = "expressions.rs"]
mod expressions;

use std::fmt::Write as _;

/// Maximum number of bits of a contract's variables and memory.
const VARIABLE_BITS: usize = 6;
const MEMORY_BITS: usize = 4;

/// Maximum nesting of operators.
const DEPTH: usize = 3;

/// Bytes used as choices.
struct Bytes<'b> {
    data: std::slice::Iter<'b, u8>,
}

impl Bytes<'_> {
    /// A number below `n`, which is at most 256; 0 when no bytes are left.
    fn below(&mut self, n: usize) -> usize {
        self.data.next().map_or(0, |b| usize::from(*b) % n)
    }

    /// True with probability 1/`n`; false when no bytes are left.
    fn one_in(&mut self, n: usize) -> bool {
        self.below(n) == n - 1
    }

    fn pick<'t>(&mut self, from: &[&'t str]) -> &'t str {
        from[self.below(from.len())]
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Bool,
    /// From 0 to this number, with a unit or as a bare number.
    Range(usize, &'static str),
    /// `Mode`, which has three labels.
    Mode,
}

impl Kind {
    const LABELS: [&'static str; 3] = ["idle", "busy", "done"];

    fn text(self) -> String {
        match self {
            Self::Bool => "bool".to_owned(),
            Self::Range(high, "") => format!("0..{high}"),
            Self::Range(high, unit) => format!("0..{high} {unit}"),
            Self::Mode => "Mode".to_owned(),
        }
    }

    fn bits(self) -> usize {
        match self {
            Self::Bool => 1,
            Self::Range(high, _) => high.ilog2() as usize + 1,
            Self::Mode => 2,
        }
    }
}

/// A value that an expression can mention.
#[derive(Clone)]
struct Leaf {
    text: String,
    kind: Kind,
    /// Whether the machine chooses it, at least in part.
    output: bool,
    /// Whether it is a variable, which has a next value.
    variable: bool,
}

impl Leaf {
    /// Whether its next value may be mentioned there.
    fn has_next(&self, place: Place) -> bool {
        let allowed = if self.output {
            place.next_outputs
        } else {
            place.next_inputs
        };
        self.variable && allowed
    }
}

/// An array of two elements.
#[derive(Clone)]
struct Array {
    name: &'static str,
    kind: Kind,
    output: bool,
}

/// What an expression may mention.
#[expect(clippy::struct_excessive_bools, reason = "four yes-or-no questions")]
#[derive(Clone, Copy)]
struct Place {
    /// Outputs.
    outputs: bool,
    /// Next values: of inputs, or of everything.
    next_inputs: bool,
    next_outputs: bool,
    /// Operators over the past.
    past: bool,
}

impl Place {
    fn without_next(self) -> Self {
        Self {
            next_inputs: false,
            next_outputs: false,
            ..self
        }
    }
}

const STATE: Place = Place {
    outputs: true,
    next_inputs: false,
    next_outputs: false,
    past: true,
};
const INPUTS: Place = Place {
    outputs: false,
    ..STATE
};
const STEP: Place = Place {
    next_inputs: true,
    next_outputs: true,
    ..STATE
};
const PLAIN: Place = Place {
    past: false,
    ..STATE
};

struct Generator<'b> {
    bytes: Bytes<'b>,
    text: String,
    leaves: Vec<Leaf>,
    arrays: Vec<Array>,
    /// Defines with parameters, by name and the parameters' kinds.
    predicates: Vec<(&'static str, Vec<Kind>)>,
    memory: usize,
    /// Number of bound variables' names in use.
    bound: usize,
}

/// Generates a contract.
pub fn contract(bytes: &[u8]) -> String {
    let mut g = Generator {
        bytes: Bytes { data: bytes.iter() },
        text: String::new(),
        leaves: Vec::new(),
        arrays: Vec::new(),
        predicates: Vec::new(),
        memory: MEMORY_BITS,
        bound: 0,
    };
    g.file();
    g.text
}

impl Generator<'_> {
    fn line(&mut self, line: &str) {
        self.text.push_str(line);
        self.text.push('\n');
    }

    fn file(&mut self) {
        self.line("type Mode = {idle, busy, done}");
        self.line("type Pair = record { first: bool, second: 0..2 }");
        self.line("const FEW: 0..3 = 2");
        let moore = if self.bytes.one_in(3) { "moore " } else { "" };
        let parameters = self.bytes.pick(&["", "", "(n: 1..3 = 2)"]);
        self.line(&format!("{moore}contract Fuzzed{parameters} {{"));
        self.variables();
        self.defines(parameters.is_empty());
        for assumed in [true, false] {
            let count = self.bytes.below(if assumed { 4 } else { 5 });
            for number in 0..count {
                let word = if assumed { "assume" } else { "guarantee" };
                let letter = if assumed { 'a' } else { 'g' };
                let label = match self.bytes.below(4) {
                    0 => String::new(),
                    1 => format!("{letter}{number} [R-{number}]: "),
                    _ => format!("{letter}{number}: "),
                };
                let formula = self.formula(assumed, true);
                let end = self.bytes.pick(&["", ";", " // as it is"]);
                self.line(&format!("    {word} {label}{formula}{end}"));
            }
        }
        self.line("}");
    }

    fn kind(&mut self) -> Kind {
        match self.bytes.below(8) {
            0..4 => Kind::Bool,
            4 => Kind::Range(2, ""),
            5 => Kind::Range(3, ""),
            6 => Kind::Range(3, "mm"),
            _ => Kind::Mode,
        }
    }

    fn variables(&mut self) {
        let names = ["a", "b_1", "größe", "Dd"];
        let count = [2, 3, 1, 4, 3][self.bytes.below(5)];
        let mut left = VARIABLE_BITS;
        for name in &names[..count] {
            let owner = self
                .bytes
                .pick(&["output", "input", "input", "output", "internal"]);
            let output = owner != "input";
            let leaf = |text: String, kind| Leaf {
                text,
                kind,
                output,
                variable: true,
            };
            let shape = self.bytes.below(8);
            let kind = self.kind();
            if shape == 6 && left >= 3 {
                left -= 3;
                self.line(&format!("    {owner} {name}: Pair"));
                self.leaves.push(leaf(format!("{name}.first"), Kind::Bool));
                let second = Kind::Range(2, "");
                self.leaves.push(leaf(format!("{name}.second"), second));
            } else if shape == 7 && left >= 2 * kind.bits() {
                left -= 2 * kind.bits();
                self.line(&format!("    {owner} {name}: array[2] of {}", kind.text()));
                self.arrays.push(Array { name, kind, output });
                for index in 0..2 {
                    self.leaves.push(leaf(format!("{name}[{index}]"), kind));
                }
            } else if left >= kind.bits() {
                left -= kind.bits();
                self.line(&format!("    {owner} {name}: {}", kind.text()));
                self.leaves.push(leaf((*name).to_owned(), kind));
            }
        }
    }

    fn defines(&mut self, without_parameter: bool) {
        if !without_parameter {
            self.constant("n");
        }
        if self.bytes.one_in(3) {
            self.constant("FEW");
        }
        if self.bytes.one_in(4) {
            let (kind, typed) = if self.bytes.one_in(2) {
                (Kind::Range(3, ""), "n: 0..3")
            } else {
                (Kind::Bool, "q")
            };
            // Only the parameters are in scope, so that the arguments determine what it mentions.
            let outside = std::mem::take(&mut self.leaves);
            let arrays = std::mem::take(&mut self.arrays);
            for (name, kind) in [("p", Kind::Bool), (&typed[..1], kind)] {
                self.parameter(name.to_owned(), kind, false);
            }
            let body = self.boolean(PLAIN, 2);
            self.leaves = outside;
            self.arrays = arrays;
            self.line(&format!("    define both(p, {typed}) = {body}"));
            self.predicates.push(("both", vec![Kind::Bool, kind]));
        }
        for name in ["now", "later"] {
            if self.bytes.one_in(4) {
                let body = self.boolean(STATE, 2);
                self.line(&format!("    define {name} = {body}"));
                self.parameter(name.to_owned(), Kind::Bool, true);
            }
        }
        if self.bytes.one_in(4) && self.remember(2) {
            let high = 2 + self.bytes.below(2);
            let counts = self.boolean(PLAIN, 1);
            let mut counter = format!("    counter met: 0..{high} counts {counts}");
            if !self.bytes.one_in(3) {
                let _ = write!(counter, " resets {}", self.boolean(PLAIN, 1));
            }
            self.line(&counter);
            self.parameter("met".to_owned(), Kind::Range(high, ""), true);
        }
    }

    fn constant(&mut self, name: &str) {
        self.parameter(name.to_owned(), Kind::Range(3, ""), false);
    }

    /// A name without a next value.
    fn parameter(&mut self, text: String, kind: Kind, output: bool) {
        self.leaves.push(Leaf {
            text,
            kind,
            output,
            variable: false,
        });
    }

    /// Whether this many more bits may be remembered.
    fn remember(&mut self, bits: usize) -> bool {
        let enough = self.memory >= bits;
        if enough {
            self.memory -= bits;
        }
        enough
    }

    /// A formula of one side. Conjunctions and quantifiers of formulas occur only at the top level.
    fn formula(&mut self, assumed: bool, outside: bool) -> String {
        let state = if assumed { INPUTS } else { STATE };
        let choice = self.bytes.below(if outside { 12 } else { 8 });
        match choice {
            0 | 5 if assumed => self.assumed_step(),
            0 | 1 => {
                let body = self.boolean(if assumed { INPUTS } else { STEP }, DEPTH);
                format!("{} ({body})", self.bytes.pick(&["always", "G", "[]", "□"]))
            }
            2 => self.boolean(state, DEPTH),
            3 | 4 => {
                let place = if self.bytes.one_in(4) { STEP } else { STATE };
                let body = self.boolean(place, DEPTH);
                let word = ["always eventually", "GF", "[] <>", "□◇"];
                format!("{} ({body})", self.bytes.pick(&word))
            }
            5 => {
                let now = self.boolean(STATE, DEPTH - 1);
                let next = self.boolean(STEP, DEPTH - 1);
                format!("always ({now} -> {next})")
            }
            6 if self.remember(1) => {
                let (p, s) = (self.boolean(STATE, 2), self.boolean(STATE, 2));
                format!("always ({p} -> eventually {s})")
            }
            6..=8 => self.pattern(state),
            9 if !self.arrays.is_empty() => self.quantified(assumed),
            10 => {
                let (a, b) = (self.formula(assumed, false), self.formula(assumed, false));
                format!("({a}) and ({b})")
            }
            _ => self.formula(assumed, false),
        }
    }

    fn assumed_step(&mut self) -> String {
        let inputs = self.leaves.iter().filter(|l| !l.output && l.variable);
        let inputs: Vec<Leaf> = inputs.cloned().collect();
        if inputs.is_empty() {
            return format!("GF ({})", self.boolean(STATE, DEPTH));
        }
        let now = self.boolean(STATE, DEPTH - 1);
        let leaf = &inputs[self.bytes.below(inputs.len())];
        let changed = self.test(leaf, true);
        let operator = self.bytes.pick(&["and", "or", "<->"]);
        let next = Place {
            next_outputs: false,
            ..STEP
        };
        let next = self.boolean(next, DEPTH - 1);
        format!("always ({now} -> ({changed} {operator} {next}))")
    }

    fn pattern(&mut self, place: Place) -> String {
        if !self.remember(2) {
            return format!("always ({})", self.boolean(place, 2));
        }
        let steps = 1 + self.bytes.below(2);
        let within = if self.bytes.one_in(3) {
            format!(" within {steps} steps")
        } else {
            String::new()
        };
        let (p, s) = (self.boolean(place, 2), self.boolean(place, 1));
        let scope = match self.bytes.below(8) {
            4 => format!(" before {}", self.boolean(place, 1)),
            5 => format!(" after {}", self.boolean(place, 1)),
            6 => {
                let opens = self.boolean(place, 1);
                format!(" after {opens} until {}", self.boolean(place, 1))
            }
            7 => {
                let opens = self.boolean(place, 1);
                format!(" between {opens} and {}", self.boolean(place, 1))
            }
            _ => String::new(),
        };
        match self.bytes.below(5) {
            0 => format!("{s} responds to {p}{within}{scope}"),
            1 => format!("never {p}{scope}"),
            2 => format!("eventually {p}{within}{scope}"),
            3 => format!("{s} precedes {p}{scope}"),
            _ => format!("always {p}{scope}"),
        }
    }

    /// A formula for each element of an array.
    fn quantified(&mut self, assumed: bool) -> String {
        let array = self.arrays[self.bytes.below(self.arrays.len())].clone();
        let domain = if self.bytes.one_in(2) {
            array.name.to_owned()
        } else {
            "0..1".to_owned()
        };
        let (index, body) = self.with_element(&array, |g| g.formula(assumed, false));
        format!("forall {index} in {domain}: {body}")
    }
}
