//! Finds the declarations of a file and their extents without parsing it.
//!
//! A contract that does not parse is not in the library, but `check` must list it with its
//! findings. So this module only searches for `contract NAME`, `machine NAME`, `line NAME`,
//! `skills NAME {`, `layout NAME {`, `recipe NAME {`, and for the closing brace of each. The first
//! three are reserved words: at the beginning of a line they begin a declaration, even if a
//! preceding brace is missing. The others can also be names; the next tokens decide. It also finds
//! the statements `realize ... on NAME`.

use crate::source::{FileId, SourceMap, Span};
use crate::syntax::{
    begins_skill_set, declares_inner_machine, declares_layout_or_recipe, declares_skill_set,
};

/// Kind of a declaration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Kind {
    /// `contract`
    Contract,
    /// `machine`
    Machine,
    /// `line`
    Line,
    /// `skills`
    Skills,
    /// `layout`
    Layout,
    /// `recipe`
    Recipe,
    /// `realize`, whose name is the rest of the statement: `3 Hinge, 2 Plate on Pad`.
    Realize,
}

/// A declaration and its extent in the text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Declaration {
    /// Kind of declaration.
    pub kind: Kind,
    /// Declared name.
    pub name: String,
    /// From the keyword to the closing brace of the declaration; if the brace is missing, to the
    /// next declaration or the end of the file.
    pub extent: Span,
}

impl Declaration {
    /// Whether the declaration contains the start of a span.
    pub fn holds(&self, span: Span) -> bool {
        self.extent.file == span.file
            && self.extent.start <= span.start
            && span.start <= self.extent.end
    }
}

/// The declarations of a file in order.
pub fn declarations(sources: &SourceMap, file: FileId) -> Vec<Declaration> {
    let text = &sources.file(file).text;
    let mut found: Vec<Declaration> = Vec::new();
    let mut depth = 0usize;
    let mut open = false;
    let mut keyword: Option<(Kind, usize)> = None;
    let all = tokens(text);
    for (at, (start, token)) in all.iter().copied().enumerate() {
        match token {
            // A `machine` within a machine is a component, not a declaration of the file.
            "machine" if depth > 0 && declares_inner_machine(&text[start + token.len()..]) => {}
            "contract" | "machine" | "line" if depth == 0 || begins_line(text, start) => {
                depth = 0;
                keyword = Some((
                    match token {
                        "contract" => Kind::Contract,
                        "machine" => Kind::Machine,
                        _ => Kind::Line,
                    },
                    start,
                ));
            }
            "skills" if begins_skills(text, start + token.len(), depth) => {
                depth = 0;
                keyword = Some((Kind::Skills, start));
            }
            "layout" | "recipe" if begins_layout_or_recipe(text, start, token, depth) => {
                depth = 0;
                let kind = if token == "layout" {
                    Kind::Layout
                } else {
                    Kind::Recipe
                };
                keyword = Some((kind, start));
            }
            "realize" if depth == 0 || begins_line(text, start) => {
                if let Some((name, end)) = realization(&all[at + 1..]) {
                    close_before(&mut found, open, start);
                    depth = 0;
                    open = false;
                    keyword = None;
                    found.push(Declaration {
                        kind: Kind::Realize,
                        name,
                        extent: Span::new(file, start, end),
                    });
                }
            }
            "{" | "(" | "[" => depth += 1,
            "}" | ")" | "]" => {
                depth = depth.saturating_sub(1);
                if depth == 0 && open && token == "}" {
                    if let Some(last) = found.last_mut() {
                        last.extent.end = start as u32 + 1;
                    }
                    open = false;
                }
            }
            _ if depth > 0 => {}
            word => {
                if let Some((kind, from)) = keyword.take()
                    && is_name(word)
                {
                    close_before(&mut found, open, from);
                    found.push(Declaration {
                        kind,
                        name: word.to_owned(),
                        extent: Span::new(file, from, text.len()),
                    });
                    open = true;
                }
            }
        }
    }
    found
}

/// Whether a set of skills begins after this word.
fn begins_skills(text: &str, end: usize, depth: usize) -> bool {
    let (start, rest) = (end - "skills".len(), &text[end..]);
    depth == 0 && begins_skill_set(rest) || begins_line(text, start) && declares_skill_set(rest)
}

/// Whether `layout` or `recipe` begins a declaration.
fn begins_layout_or_recipe(text: &str, start: usize, word: &str, depth: usize) -> bool {
    (depth == 0 || begins_line(text, start))
        && declares_layout_or_recipe(&text[..start], &text[start + word.len()..])
}

/// Reads what follows the word `realize`: recipes, each with an optional number, `on` and a layout.
/// Returns it as text, and where it ends.
fn realization(tokens: &[(usize, &str)]) -> Option<(String, usize)> {
    let mut text = String::new();
    let mut before = ',';
    for (at, (_, token)) in tokens.iter().enumerate() {
        let first = token.chars().next()?;
        let is_digit = first.is_ascii_digit();
        // Digits are tokens of their own.
        if !text.is_empty() && first != ',' && !(is_digit && before.is_ascii_digit()) {
            text.push(' ');
        }
        text.push_str(token);
        // After a comma or a number, it is the name of a recipe.
        if *token == "on" && before != ',' && !before.is_ascii_digit() {
            let (start, layout) = *tokens.get(at + 1)?;
            return is_name(layout).then(|| (format!("{text} {layout}"), start + layout.len()));
        }
        if !is_digit && first != ',' && !is_name(token) {
            return None;
        }
        before = first;
    }
    None
}

/// Whether nothing but `moore` precedes this position in its line.
fn begins_line(text: &str, at: usize) -> bool {
    let line = text[..at].rfind(['\n', '\r']).map_or(0, |end| end + 1);
    matches!(text[line..at].trim(), "" | "moore")
}

/// Ends an unclosed declaration where the next one begins.
fn close_before(found: &mut [Declaration], open: bool, from: usize) {
    if let Some(last) = found.last_mut().filter(|_| open) {
        last.extent.end = from as u32;
    }
}

fn is_name(word: &str) -> bool {
    word.starts_with(|c: char| c.is_alphabetic() || c == '_')
}

/// Words and single characters with their places, without comments, strings and white space.
fn tokens(text: &str) -> Vec<(usize, &str)> {
    let mut tokens = Vec::new();
    let mut at = 0;
    while let Some(c) = text[at..].chars().next() {
        let rest = &text[at..];
        let length = if rest.starts_with("//") {
            rest.find(['\n', '\r']).unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            rest.get(2..)
                .and_then(|inner| inner.find("*/"))
                .map_or(rest.len(), |end| end + 4)
        } else if c == '"' {
            let line = rest.find(['\n', '\r']).unwrap_or(rest.len());
            rest[1..line].find('"').map_or(line, |end| end + 2)
        } else if is_name(rest) {
            let end = rest.find(|c: char| !c.is_alphanumeric() && c != '_');
            let length = end.unwrap_or(rest.len());
            tokens.push((at, &rest[..length]));
            length
        } else {
            if !c.is_whitespace() {
                tokens.push((at, &rest[..c.len_utf8()]));
            }
            c.len_utf8()
        };
        at += length;
    }
    tokens
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outline(text: &str) -> Vec<(Kind, String, String)> {
        let mut sources = SourceMap::new();
        let file = sources.add("a.lw", text);
        declarations(&sources, file)
            .into_iter()
            .map(|d| (d.kind, d.name, sources.text(d.extent).to_owned()))
            .collect()
    }

    #[test]
    fn declarations_end_at_their_brace() {
        let text = "import \"contract X {\"\n// machine No {}\nmoore contract A(c: {x, y} = x) { output o: {a, b} /* } */ }\n\
                    type T = {contract, line}\nline L { machine M }";
        let found = outline(text);
        let short: Vec<(Kind, &str)> = found.iter().map(|d| (d.0, d.1.as_str())).collect();
        assert_eq!(short, [(Kind::Contract, "A"), (Kind::Line, "L")]);
        assert!(found[0].2.ends_with("/* } */ }"));
        assert_eq!(found[1].2, "line L { machine M }");
    }

    #[test]
    fn a_missing_brace_reaches_to_the_next_declaration() {
        let found = outline("contract A { guarantee x: (\nmoore contract B {}\nline C { x");
        assert_eq!(found.len(), 3);
        assert!(found[0].2.ends_with("moore "));
        assert_eq!(found[1].2, "contract B {}");
        assert_eq!(found[2].2, "line C { x");
    }

    #[test]
    fn the_tokens_after_skills_decide_whether_it_is_a_declaration() {
        let set = "skills S { component c { Go } }";
        let text = format!(
            "const a = skills\ndefine skills(x) = x\nmachine M {{ skills S {{ order = go }} done skills\n{set}\nline L {{}}"
        );
        let found = outline(&text);
        let short: Vec<(Kind, &str)> = found.iter().map(|d| (d.0, d.1.as_str())).collect();
        let wanted = [(Kind::Machine, "M"), (Kind::Skills, "S"), (Kind::Line, "L")];
        assert_eq!(short, wanted);
        assert_eq!(found[1].2, set);
        // Letters used as operators are names here.
        let set = "skills U { component c { G } }";
        let found = outline(set);
        assert_eq!((found[0].1.as_str(), found[0].2.as_str()), ("U", set));
    }

    #[test]
    fn a_layout_or_recipe_needs_a_name_and_a_brace() {
        let layout = "layout L { resource recipe at s { s -> s: a } }";
        let recipe = "recipe R { a -> b: layout()() }";
        let text = format!("const layout = 2\n{layout}\n{recipe}\nrealize R on L\nline N {{}}");
        let found = outline(&text);
        let short: Vec<(Kind, &str)> = found.iter().map(|d| (d.0, d.1.as_str())).collect();
        let wanted = [
            (Kind::Layout, "L"),
            (Kind::Recipe, "R"),
            (Kind::Realize, "R on L"),
            (Kind::Line, "N"),
        ];
        assert_eq!(short, wanted);
        assert_eq!((found[0].2.as_str(), found[1].2.as_str()), (layout, recipe));
        assert_eq!(found[2].2, "realize R on L");
        let many = outline("define realize(x) = x\nrealize 12 A , 3 on\non L recipe R {}");
        assert_eq!(many[0].1, "12 A, 3 on on L");
        assert_eq!(many.len(), 2);
        let open = outline("layout A { resource r at s {\nrecipe B { a -> b }");
        assert_eq!(open.len(), 2);
    }

    /// As in the grammar, a single carriage return also ends a line.
    #[test]
    fn a_comment_ends_with_its_line() {
        for end in ["\n", "\r", "\r\n"] {
            let text = [
                "// one",
                "contract A { output x: bool }",
                "/// two",
                "moore contract B { output \"y: bool }",
                "// three {",
                "line C {",
                "machine D {}",
            ];
            let found = outline(&text.join(end));
            let names: Vec<&str> = found.iter().map(|d| d.1.as_str()).collect();
            assert_eq!(names, ["A", "B", "C", "D"], "{end:?}");
        }
    }

    #[test]
    fn any_text_has_an_outline() {
        for text in [
            "",
            "contract",
            "contract {",
            "}}}",
            "/*",
            "\"",
            "contract ü {",
            "□ contract A",
        ] {
            outline(text);
        }
        assert_eq!(outline("contract A\ncontract B {}").len(), 2);
    }
}
