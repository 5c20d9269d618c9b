//! Conditions and numbers of a generated contract. Nested expressions are atoms or parenthesized.

use super::{Array, Generator, Kind, Leaf, Place};

impl Generator<'_> {
    /// A condition, in parentheses or an atom.
    pub fn boolean(&mut self, place: Place, depth: usize) -> String {
        let choice = self.bytes.below(if depth == 0 { 4 } else { 16 });
        match choice {
            0..4 => self.atom(place),
            4 => format!(
                "({} {})",
                self.bytes.pick(&["not", "!", "¬"]),
                self.boolean(place, depth - 1)
            ),
            5..10 => {
                let words = [
                    "and", "or", "->", "<->", "xor", "&", "\\/", "∧", "implies", "=",
                ];
                let word = self.bytes.pick(&words);
                let a = self.boolean(place, depth - 1);
                let b = self.boolean(place, depth - 1);
                format!("({a} {word} {b})")
            }
            10 => {
                let c = self.boolean(place, depth - 1);
                let a = self.boolean(place, depth - 1);
                let b = self.boolean(place, depth - 1);
                format!("(if {c} then {a} else {b})")
            }
            11 if place.past => self.looking_back(place, depth),
            12 if !self.arrays.is_empty() => self.over_elements(place, depth),
            13 if !self.predicates.is_empty() => self.call(place, depth),
            14 if place.next_outputs => {
                let body = self.boolean(place.without_next(), depth - 1);
                format!("(next ({body}))")
            }
            _ => {
                let ranges = self.visible(place, |kind| matches!(kind, Kind::Range(..)));
                if ranges.is_empty() {
                    return self.atom(place);
                }
                let unit = match ranges[self.bytes.below(ranges.len())].kind {
                    Kind::Range(_, unit) => unit,
                    _ => "",
                };
                let word = self.bytes.pick(&["<=", "=", "!=", "<", ">=", "≠"]);
                let (a, b) = (self.number(place, unit, 2), self.number(place, unit, 1));
                format!("({a} {word} {b})")
            }
        }
    }

    fn looking_back(&mut self, place: Place, depth: usize) -> String {
        let choice = self.bytes.below(6);
        if !self.remember(if choice < 4 { 1 } else { 2 }) {
            return self.atom(place);
        }
        let state = place.without_next();
        // The plant may mention previous values, even if the machine chose them.
        let before = if choice == 0 {
            Place {
                outputs: true,
                ..state
            }
        } else {
            state
        };
        let p = self.boolean(before, depth - 1);
        let steps = 1 + self.bytes.below(3);
        match choice {
            0 => format!("(previous {p})"),
            1 => format!("(once {p})"),
            2 => format!("(historically {p})"),
            3 => {
                let q = self.boolean(state, depth - 1);
                format!("({p} since {q})")
            }
            4 => format!("(once {p} within {steps} steps)"),
            _ => format!("(historically {p} within FEW steps)"),
        }
    }

    fn over_elements(&mut self, place: Place, depth: usize) -> String {
        let array = self.arrays[self.bytes.below(self.arrays.len())].clone();
        let word = self.bytes.pick(&["forall", "exists", "count"]);
        let (index, body) = self.with_element(&array, |g| g.boolean(place, depth - 1));
        let question = format!("({word} {index} in {}: {body})", array.name);
        if word == "count" {
            format!("({question} >= 1)")
        } else {
            question
        }
    }

    /// A name for the index of an array, and what is generated with its element in scope.
    pub fn with_element(
        &mut self,
        array: &Array,
        make: impl FnOnce(&mut Self) -> String,
    ) -> (String, String) {
        let index = format!("i{}", self.bound);
        self.bound += 1;
        self.leaves.push(Leaf {
            text: format!("{}[{index}]", array.name),
            kind: array.kind,
            output: array.output,
            variable: true,
        });
        let made = make(self);
        self.leaves.pop();
        self.bound -= 1;
        (index, made)
    }

    fn call(&mut self, place: Place, depth: usize) -> String {
        let (name, kinds) = self.predicates[0].clone();
        let arguments: Vec<String> = kinds
            .iter()
            .map(|kind| match kind {
                Kind::Bool => self.boolean(place, depth - 1),
                _ => self.number(place, "", 0),
            })
            .collect();
        format!("{name}({})", arguments.join(", "))
    }

    /// The values of these kinds that can be mentioned.
    fn visible(&self, place: Place, fits: impl Fn(Kind) -> bool) -> Vec<Leaf> {
        let visible = self.leaves.iter();
        visible
            .filter(|l| fits(l.kind) && (place.outputs || !l.output))
            .cloned()
            .collect()
    }

    /// An atomic condition on one variable.
    fn atom(&mut self, place: Place) -> String {
        let leaves = self.visible(place, |_| true);
        if leaves.is_empty() {
            return self.bytes.pick(&["true", "false"]).to_owned();
        }
        let leaf = leaves[self.bytes.below(leaves.len())].clone();
        let next = leaf.has_next(place) && self.bytes.one_in(2);
        self.test(&leaf, next)
    }

    pub fn test(&mut self, leaf: &Leaf, next: bool) -> String {
        let text = match (next, self.bytes.below(2)) {
            (false, _) => leaf.text.clone(),
            (true, 0) => format!("{}'", leaf.text),
            (true, _) => format!("(next {})", leaf.text),
        };
        match leaf.kind {
            Kind::Bool => text,
            Kind::Mode => match self.bytes.below(3) {
                0 => format!("({text} = {})", self.bytes.pick(&Kind::LABELS)),
                1 => format!(
                    "({text} in {{idle, {}}})",
                    self.bytes.pick(&Kind::LABELS[1..])
                ),
                _ => format!("({text} != {})", self.bytes.pick(&Kind::LABELS)),
            },
            Kind::Range(high, unit) => {
                let value = self.bytes.below(high + 1);
                let word = self.bytes.pick(&["=", "<=", ">", "!=", "in"]);
                let value = format!("{value} {unit}");
                let value = value.trim_end();
                match word {
                    "in" => format!("({text} in {{{value}}})"),
                    word => format!("({text} {word} {value})"),
                }
            }
        }
    }

    /// A number with or without a unit.
    fn number(&mut self, place: Place, unit: &'static str, depth: usize) -> String {
        match self.bytes.below(if depth == 0 { 6 } else { 12 }) {
            0..5 => {
                let fits = |kind| matches!(kind, Kind::Range(_, u) if u == unit);
                let leaves = self.visible(place, fits);
                if leaves.is_empty() {
                    return self.literal(unit);
                }
                let leaf = &leaves[self.bytes.below(leaves.len())];
                if leaf.has_next(place) && self.bytes.one_in(2) {
                    return format!("{}'", leaf.text);
                }
                leaf.text.clone()
            }
            5 => self.literal(unit),
            6..11 => {
                let word = self.bytes.pick(&["+", "-", "min", "max"]);
                let a = self.number(place, unit, depth - 1);
                let b = self.number(place, unit, depth - 1);
                match word {
                    "+" | "-" => format!("({a} {word} {b})"),
                    _ => format!("{word}({a}, {b})"),
                }
            }
            _ => {
                let a = self.number(place, unit, depth - 1);
                match self.bytes.below(4) {
                    0 => format!("abs({a})"),
                    1 => format!("(-{a})"),
                    2 if unit.is_empty() => format!("({a} mod {})", 1 + self.bytes.below(3)),
                    _ => format!("(2 * {a})"),
                }
            }
        }
    }

    fn literal(&mut self, unit: &str) -> String {
        let number = self.bytes.below(4);
        if unit.is_empty() {
            number.to_string()
        } else {
            format!("{number} {unit}")
        }
    }
}
