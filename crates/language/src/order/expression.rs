//! Formatting of regular expressions over skills.

use super::Skills;
use linewright_automata::regex::Regex;

impl Skills {
    /// Formats a regular expression over these skills in the syntax of a file, with as few
    /// parentheses as needed.
    pub fn expression(&self, regex: &Regex) -> String {
        let name = |skill: &usize| self.skills[*skill].name.as_str();
        match regex {
            // The syntax has no expression that matches no word, so it is written as any skill
            // except all skills.
            Regex::Nothing => self.expression(&Regex::AnyBut((0..self.skills.len()).collect())),
            Regex::Empty => "()".to_owned(),
            Regex::Letter(skill) => name(skill).to_owned(),
            Regex::AnyBut(but) => match but.as_slice() {
                [] => ".".to_owned(),
                [skill] => format!("not {}", name(skill)),
                several => {
                    let names: Vec<&str> = several.iter().map(name).collect();
                    format!("not ({})", names.join(" | "))
                }
            },
            Regex::AnyOrder(several) => {
                let names: Vec<&str> = several.iter().map(name).collect();
                names.join(" & ")
            }
            Regex::Concat(parts) => {
                let parts = parts.iter().map(|part| match part {
                    Regex::Either(_) => format!("({})", self.expression(part)),
                    _ => self.expression(part),
                });
                parts.collect::<Vec<_>>().join(" ")
            }
            Regex::Either(parts) => {
                let parts = parts.iter().map(|part| self.expression(part));
                parts.collect::<Vec<_>>().join(" | ")
            }
            Regex::Repeat { of, low, high } => {
                let of_text = self.expression(of);
                let one = matches!(**of, Regex::Letter(_) | Regex::Empty)
                    || matches!(&**of, Regex::AnyBut(but) if but.is_empty());
                let of = if one { of_text } else { format!("({of_text})") };
                match (low, high) {
                    (0, None) => format!("{of}*"),
                    (1, None) => format!("{of}+"),
                    (0, Some(1)) => format!("{of}?"),
                    (low, None) => format!("{of}{{{low},}}"),
                    (low, Some(high)) if low == high => format!("{of}{{{low}}}"),
                    (low, Some(high)) => format!("{of}{{{low},{high}}}"),
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::order::fsm::Fsm;
    use crate::order::fsm::tests::pick_and_place;
    use crate::order::supervisor::Options;
    use linewright_automata::eliminate;
    use linewright_core::deadline::Deadline;

    fn text_of(rules: &[usize]) -> String {
        let mut skills = pick_and_place();
        skills.rules = rules.iter().map(|r| skills.rules[*r].clone()).collect();
        let fsm = Fsm::of(&skills, Options::default(), 1).expect("it is small");
        let regex = eliminate::regex(&fsm.one_by_one(), Deadline::NONE).expect("it is short");
        skills.expression(&regex)
    }

    #[test]
    fn the_papers_rules_are_short_expressions() {
        insta::assert_snapshot!(
            [&[][..], &[0], &[1], &[0, 1]].map(text_of).join("\n"),
            @r"
        .*
        (not Down)* (Down ((Up (not Down)*)? Down | Release | Grip)* (Up (not Down)*)?)?
        (not (Down | Release) | Down (not Up)* Up)* (Down (not Up)*)?
        (not (Down | Release) | Down (Down | Release | Grip)* Up)* (Down (Down | Release | Grip)*)?
        "
        );
    }
}
