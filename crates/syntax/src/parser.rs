//! Parser: converts a text to a syntax tree and findings.
//!
//! pest stops at the first error, so error recovery is part of the grammar: a `bad_*` rule consumes
//! text that matches no item, up to the next item. [`explain`] then parses that piece again with
//! the rule for its first word. The error of the second parse states the expected tokens and their
//! place.

mod lines;
mod recipes;
mod skills;

use super::ast::File;
use super::build::Builder;
use super::mend;
use super::value::{Value, ValueSyntax};
use super::words::is_reserved;
use linewright_core::diagnostics::{Diagnostic, codes, nearest};
use linewright_core::source::{FileId, Span};
use pest::Parser;
use pest::error::{ErrorVariant, InputLocation};

#[allow(missing_docs)] // the derive makes an undocumented enum of the rules
mod grammar {
    #[derive(pest_derive::Parser)]
    #[grammar = "lw.pest"]
    pub struct Grammar;
}
pub(super) use grammar::{Grammar, Rule};

/// Maximum nesting depth of brackets, conditionals and prefix words within one item, which limits
/// the parser's stack.
const MAX_DEPTH: usize = 200;
/// Maximum nesting depth that can be parsed on the stack of any thread.
const SMALL_DEPTH: usize = 12;
/// Stack size for `MAX_DEPTH` levels of the grammar's recursion, with a margin.
const STACK_BYTES: usize = 256 << 20;

/// Parses one file. Text that cannot be parsed is reported in the findings; the tree contains the
/// rest.
pub fn parse(file: FileId, text: &str) -> (File, Vec<Diagnostic>) {
    let scan = mend::scan(file, text);
    if scan.depth > MAX_DEPTH {
        return (File::default(), vec![too_deep(file, scan.deepest)]);
    }
    let source = scan.mended.as_deref().unwrap_or(text);
    let run = || {
        let mut builder = Builder::new(file, text.len());
        match Grammar::parse(Rule::file, source) {
            Ok(pairs) => builder.file(pairs),
            Err(error) => builder.findings.push(finding_of(file, 0, source, &error)),
        }
        (builder.tree, builder.findings)
    };
    let (tree, found) = if scan.depth <= SMALL_DEPTH {
        run()
    } else {
        on_large_stack(run).unwrap_or_else(|| {
            let finding = Diagnostic::error(
                codes::SYNTAX,
                Span::new(file, 0, 0),
                "there is not enough memory to parse this file",
            )
            .with_help("nest its formulas less, or give parts of them names with `define`");
            (File::default(), vec![finding])
        })
    };
    let mut findings = scan.findings;
    findings.extend(found.into_iter().filter(|f| {
        let start = f.span.map_or(0, |s| s.start as usize);
        !scan.silenced.iter().any(|r| r.contains(&start))
    }));
    for finding in &mut findings {
        finding.span = finding.span.map(|s| within(s, text));
    }
    (tree, findings)
}

/// Returns whether a text is a word of layouts, recipes and skill sets, which can be a name there.
pub fn is_word(text: &str) -> bool {
    is_whole(Rule::word, text)
}

/// Returns whether a text can be the label of a transfer: `in:3`.
pub fn is_transfer_label(text: &str) -> bool {
    is_whole(Rule::transfer_label, text)
}

fn is_whole(rule: Rule, text: &str) -> bool {
    Grammar::parse(rule, text).is_ok_and(|pairs| pairs.as_str().len() == text.len())
}

/// Parses a value that stands alone: the text from byte `from` on, which is a character boundary.
///
/// # Errors
/// Returns the findings if the text is not such a value.
pub fn parse_value(
    file: FileId,
    text: &str,
    from: usize,
    syntax: ValueSyntax,
) -> Result<Value, Vec<Diagnostic>> {
    if text[from..].trim().is_empty() {
        let place = Span::new(file, from, text.len());
        let finding = Diagnostic::error(codes::SYNTAX, place, "the value is missing");
        return Err(vec![finding.with_help("write it after the `=`")]);
    }
    // Blanks in the place of the text before the value keep all offsets.
    let source = " ".repeat(from) + &text[from..];
    let scan = mend::scan(file, &source);
    if scan.depth > MAX_DEPTH {
        return Err(vec![too_deep(file, scan.deepest)]);
    }
    if !scan.findings.is_empty() {
        return Err(scan.findings);
    }
    let run = || {
        let mut builder = Builder::new(file, text.len());
        match Grammar::parse(syntax.rule(), &source) {
            Ok(pairs) => {
                let value = builder.value(pairs, syntax);
                if builder.findings.is_empty() {
                    Ok(value)
                } else {
                    Err(builder.findings)
                }
            }
            Err(error) => {
                let mut finding = finding_of(file, 0, &source, &error);
                finding.span = finding.span.map(|span| within(span, text));
                // The value is all that there is.
                let help = finding.help.take();
                finding.help = help.map(|help| help.replace("end of the item", "end"));
                Err(vec![finding])
            }
        }
    };
    if scan.depth <= SMALL_DEPTH {
        return run();
    }
    on_large_stack(run).unwrap_or_else(|| Err(vec![too_deep(file, scan.deepest)]))
}

fn on_large_stack<T: Send>(run: impl FnOnce() -> T + Send) -> Option<T> {
    std::thread::scope(|scope| {
        std::thread::Builder::new()
            .stack_size(STACK_BYTES)
            .spawn_scoped(scope, run)
            .ok()
            .and_then(|handle| handle.join().ok())
    })
}

/// Limits a span to the text, since the mended copy can be longer, and moves it to character
/// boundaries.
fn within(span: Span, text: &str) -> Span {
    let boundary = |offset: u32| {
        let mut offset = (offset as usize).min(text.len());
        while !text.is_char_boundary(offset) {
            offset += 1;
        }
        offset
    };
    let start = boundary(span.start);
    Span::new(span.file, start, boundary(span.end).max(start))
}

fn too_deep(file: FileId, offset: usize) -> Diagnostic {
    Diagnostic::error(
        codes::SYNTAX,
        Span::new(file, offset, offset + 1),
        format!("this is nested more than {MAX_DEPTH} levels deep"),
    )
    .with_help("give the inner parts names with `define`, or use a constant array instead of a long `if ... else if`")
}

/// Returns the finding for text that matched no item. `context` is the `bad_*` rule that consumed
/// the text.
pub(super) fn explain(file: FileId, start: usize, piece: &str, context: Rule) -> Diagnostic {
    let text = piece.trim_end();
    if let Some(finding) = skills::explain(file, start, text, context) {
        return finding;
    }
    let first: String = after_comments(text)
        .chars()
        .take_while(|c| c.is_alphanumeric() || *c == '_')
        .collect();
    let in_line = matches!(context, Rule::bad_line_item | Rule::bad_station_item);
    if first == "shift" && in_line && has_clock_time(text) {
        let span = Span::new(file, start, start + code_end(text));
        return Diagnostic::error(codes::SYNTAX, span, "times of day are hours after midnight")
            .with_help("write `shift 6 h to 14 h`; half past six is `6.5 h`");
    }
    if let Some(finding) = lines::explain(file, start, text, context)
        .or_else(|| recipes::explain(file, start, text, context))
    {
        return finding;
    }
    let rule = match (context, first.as_str()) {
        (_, "import") => Some(Rule::only_import),
        (_, "type") => Some(Rule::only_type_decl),
        (_, "const") => Some(Rule::only_const_decl),
        (_, "define") => Some(Rule::only_define),
        (Rule::bad_item, "contract" | "moore") => Some(Rule::only_contract),
        (Rule::bad_item, "machine") => Some(Rule::only_machine),
        (Rule::bad_item, "line") => Some(Rule::only_line),
        (Rule::bad_item, "skills") => Some(Rule::only_skills),
        (Rule::bad_item, "layout") => Some(Rule::only_layout),
        (Rule::bad_item, "recipe") => Some(Rule::only_recipe),
        (Rule::bad_item, "realize") => Some(Rule::only_realize),
        (Rule::bad_layout_item, "resource" | "transport" | "at") => Some(Rule::only_layout_item),
        (Rule::bad_contract_item, "input" | "output" | "internal") => Some(Rule::only_variables),
        (Rule::bad_contract_item, "counter") => Some(Rule::only_counter),
        (Rule::bad_contract_item, "assume" | "guarantee") => Some(Rule::only_formula),
        (
            Rule::bad_machine_item,
            "step" | "idle" | "power" | "limit" | "failures" | "property" | "parameter" | "signal"
            | "abstract" | "coordinator" | "action" | "machine" | "operation" | "done" | "write"
            | "refines" | "skills" | "guarantee",
        ) => Some(Rule::only_machine_item),
        (Rule::bad_skills_item, "component" | "order") => Some(Rule::only_skills_item),
        (Rule::bad_skill_call, _) if !first.is_empty() => Some(Rule::only_skill_call),
        (
            Rule::bad_line_item,
            "part" | "product" | "source" | "store" | "sink" | "buffer" | "conveyor" | "station"
            | "route" | "requirement" | "shift" | "start" | "holiday" | "limit",
        ) => Some(Rule::only_line_item),
        (
            Rule::bad_station_item,
            "perform" | "takes" | "sets" | "setup" | "defect" | "failures" | "idle" | "power"
            | "shift",
        ) => Some(Rule::only_station_item),
        (Rule::bad_component_item, _) if !first.is_empty() => Some(Rule::only_component_item),
        _ => None,
    };
    if let Some(rule) = rule
        && let Err(error) = Grammar::parse(rule, text)
    {
        return finding_of(file, start, text, &error);
    }
    if let Some(finding) = explain_operand(file, start, text) {
        return finding;
    }
    let operator = operator_at(text);
    let about_operator = if operator == "=" {
        Some((
            "this `=` has no name before it or no value after it".to_owned(),
            "write `name = value`",
        ))
    } else if begins_with_operator(text) && !text.starts_with([')', ']']) {
        Some((
            format!("an operand of `{operator}` is missing"),
            "write an expression on each side of it",
        ))
    } else if operator == "," {
        Some((
            "declarations are not separated by commas".to_owned(),
            "remove the comma",
        ))
    } else if operator == "[" {
        Some((
            "an index or length does not belong here".to_owned(),
            "write the type of an array as `array[3] of bool`",
        ))
    } else {
        None
    };
    if let Some((message, help)) = about_operator {
        let span = Span::new(file, start, start + operator.len());
        return Diagnostic::error(codes::SYNTAX, span, message).with_help(help);
    }
    let code = after_comments(text);
    let at = start + text.len() - code.len();
    let word = word_at(code);
    if word.is_empty() {
        let line = text.lines().next().unwrap_or_default().trim_end();
        return Diagnostic::error(
            codes::SYNTAX,
            Span::new(file, start, start + line.len()),
            "no declaration follows this comment",
        )
        .with_help(
            "write a doc comment `///` directly before a declaration, and begin other comments with `//`",
        );
    }
    let span = Span::new(file, at, at + word.len());
    if word == "%" || context == Rule::bad_item && mend::UNITS.contains(&word.as_str()) {
        let message = "a unit stands behind a number, and behind nothing else";
        return Diagnostic::error(codes::SYNTAX, span, message).with_help(format!(
            "multiply what stands in brackets: `(30 + 5) * 1 {word}`"
        ));
    }
    let opening = match word.as_str() {
        ")" => Some("("),
        "]" => Some("["),
        "}" => Some("{"),
        _ => None,
    };
    if let Some(opening) = opening {
        let message = format!("this `{word}` has no matching `{opening}`");
        return Diagnostic::error(codes::SYNTAX, span, message).with_help(format!(
            "remove it, or add the missing `{opening}` before it"
        ));
    }
    let (place, words) = allowed(context);
    let list = format!(
        "{place} contains {}",
        words
            .iter()
            .map(|w| format!("`{w}`"))
            .collect::<Vec<_>>()
            .join(", ")
    );
    if context == Rule::bad_station_item && word == "time" {
        return Diagnostic::error(codes::SYNTAX, span, "a station has no processing time")
            .with_help("write it in an action of the station's machine: `time 30 s`");
    }
    if context == Rule::bad_line_item && word == "length" {
        return Diagnostic::error(codes::SYNTAX, span, "`length` is not given by itself").with_help(
            "the length of a conveyor is its places times its pitch: `conveyor belt places 4 pitch 0.25 m`",
        );
    }
    if context == Rule::bad_line_item && word == "per" {
        return Diagnostic::error(codes::SYNTAX, span, "`per` does not fit here").with_help(
            "only a throughput has a rate, `throughput >= 20 per hour`; every other metric is of the whole run: `products >= 400`",
        );
    }
    let near = nearest(&word, words.iter().copied());
    let help = match near.ok_or_else(|| unit_meant(&word)) {
        Ok(near) if near != word => format!("did you mean `{near}`? {list}"),
        Err(Some(unit)) => format!("did you mean the unit `{unit}`? {list}"),
        _ if word.starts_with(|c: char| c.is_alphanumeric() || c == '_') => list,
        _ => format!("{list}; is something missing before this?"),
    };
    Diagnostic::error(
        codes::SYNTAX,
        span,
        format!("`{word}` does not belong in {place}"),
    )
    .with_help(help)
}

/// Explains an error in a piece that was meant to continue the statement `before`, with this rule
/// for the whole. Returns `None` if it does continue it.
fn explain_after(
    before: &str,
    rule: Rule,
    file: FileId,
    start: usize,
    piece: &str,
) -> Option<Diagnostic> {
    let text = format!("{before}{piece}");
    let error = Grammar::parse(rule, &text).err()?;
    let found = finding_of(file, 0, &text, &error);
    let place = found.span?;
    let moved = |offset: u32| start + (offset as usize).saturating_sub(before.len());
    let span = Span::new(file, moved(place.start), moved(place.end));
    Some(Diagnostic {
        span: Some(span),
        ..found
    })
}

/// Whether the text contains a time of day such as `6:30`.
fn has_clock_time(text: &str) -> bool {
    let digit = |c: Option<char>| c.is_some_and(|c| c.is_ascii_digit());
    text.match_indices(':').any(|(at, _)| {
        digit(text[..at].chars().next_back()) && digit(text[at + 1..].chars().next())
    })
}

/// Explains an error in a piece that begins with an operator. The expression before the operator is
/// complete, so a name replaces it, and the result is parsed again. Returns `None` if the error is
/// not after the operator, or if the operand is missing.
fn explain_operand(file: FileId, start: usize, piece: &str) -> Option<Diagnostic> {
    const BEFORE: &str = "guarantee always x ";
    if !begins_with_operator(piece) || piece.starts_with([')', ']']) {
        return None;
    }
    let text = format!("{BEFORE}{piece}");
    let error = Grammar::parse(Rule::only_formula, &text).err()?;
    let (InputLocation::Pos(at) | InputLocation::Span((at, _))) = error.location;
    let after_operator = BEFORE.len() + operator_at(piece).len();
    let found = finding_of(file, 0, &text, &error);
    let at_end = after_comments(text.get(at..)?).is_empty();
    let lacks_operand = found.help.iter().any(|h| h.contains("an expression"));
    if at < after_operator || at_end && lacks_operand {
        return None;
    }
    let place = found.span?;
    let shifted = |offset: u32| start + (offset as usize).saturating_sub(BEFORE.len());
    let span = Span::new(file, shifted(place.start), shifted(place.end));
    Some(Diagnostic {
        span: Some(span),
        ..found
    })
}

/// Returns the operator or word at the beginning of a text.
fn operator_at(text: &str) -> String {
    let signs = [
        "<->", "<=>", "->", "=>", "&&", "||", "==", "!=", "<=", ">=", "/\\", "\\/",
    ];
    let sign = signs.into_iter().find(|sign| text.starts_with(sign));
    sign.map_or_else(|| word_at(text), str::to_owned)
}

/// Returns whether a piece begins with an operator or a closing bracket, so that the expression
/// before it is not the one that the author meant.
pub(super) fn begins_with_operator(text: &str) -> bool {
    text.starts_with([
        ')', ']', '&', '|', '+', '-', '*', '<', '>', '=', '!', '∧', '∨', '→', '↔', '⇒', '⇔',
    ]) || text.starts_with('/') && !text.starts_with("//") && !text.starts_with("/*")
        || [
            "and", "or", "xor", "implies", "iff", "mod", "since", "until", "unless", "precedes",
            "responds", "within", "before", "between", "after",
        ]
        .contains(&word_at(text).as_str())
}

/// Returns the name of the context of a `bad_*` rule for messages, and the words that can begin an
/// item there.
fn allowed(context: Rule) -> (&'static str, &'static [&'static str]) {
    match context {
        Rule::bad_contract_item => (
            "a contract",
            &[
                "input",
                "output",
                "internal",
                "define",
                "assume",
                "guarantee",
                "counter",
                "type",
                "const",
            ],
        ),
        Rule::bad_machine_item => (
            "a machine",
            &[
                "property",
                "parameter",
                "signal",
                "abstract",
                "coordinator",
                "action",
                "machine",
                "operation",
                "done",
                "write",
                "refines",
                "skills",
                "guarantee",
                "step",
                "power",
                "idle power",
                "limit",
                "failures",
                "type",
                "const",
            ],
        ),
        Rule::bad_component_item => ("a component", &["input = ...", "time", "power"]),
        Rule::bad_line_item => (
            "a line",
            &[
                "part",
                "product",
                "source",
                "store",
                "sink",
                "buffer",
                "conveyor",
                "station",
                "route",
                "requirement",
                "shift",
                "start",
                "holiday",
                "limit",
                "const",
            ],
        ),
        Rule::bad_layout_item
        | Rule::bad_resource_item
        | Rule::bad_transport_item
        | Rule::bad_recipe_item => recipes::allowed(context),
        Rule::bad_skills_item => ("a set of skills", &["component", "order"]),
        Rule::bad_skill_call => ("the skills of a machine", &["Skill = ..."]),
        Rule::bad_station_item => (
            "a station",
            &[
                "perform",
                "takes",
                "sets",
                "setup",
                "defect",
                "failures",
                "power",
                "idle power",
                "shift",
            ],
        ),
        _ => (
            "a file",
            &[
                "import", "type", "const", "define", "contract", "machine", "line", "skills",
                "layout", "recipe", "realize",
            ],
        ),
    }
}

/// Returns the end of the last token that is neither blank nor comment.
fn code_end(text: &str) -> usize {
    let (mut end, mut i) = (0, 0);
    while i < text.len() {
        let rest = after_comments(&text[i..]);
        i = text.len() - rest.len();
        let quoted = rest
            .strip_prefix('"')
            .and_then(|r| r.find('"'))
            .map(|n| n + 2);
        let step = quoted.or_else(|| rest.chars().next().map(char::len_utf8));
        i += step.unwrap_or(0);
        if step.is_some() {
            end = i;
        }
    }
    end
}

/// Returns the text without blanks and comments at its beginning.
fn after_comments(text: &str) -> &str {
    let mut rest = text.trim_start();
    loop {
        rest = if rest.starts_with("//") {
            rest.find(['\n', '\r']).map_or("", |n| &rest[n..])
        } else if let Some(comment) = rest.strip_prefix("/*") {
            comment.split_once("*/").map_or("", |(_, after)| after)
        } else {
            return rest;
        }
        .trim_start();
    }
}

fn finding_of(
    file: FileId,
    start: usize,
    text: &str,
    error: &pest::error::Error<Rule>,
) -> Diagnostic {
    let at = match error.location {
        InputLocation::Pos(p) | InputLocation::Span((p, _)) => p,
    };
    // The place is the word that does not fit, without blanks and comments before it; at the end of
    // the text, it is directly after the last word.
    let at = text.len() - after_comments(&text[at..]).len();
    let (at, word) = if at == text.len() {
        (code_end(text), String::new())
    } else {
        (at, operator_at(&text[at..]))
    };
    if let ErrorVariant::ParsingError { positives, .. } = &error.variant
        && let Some(finding) = not_whole(file, start + at, &text[at..], positives)
    {
        return finding;
    }
    let (expected, hint) = match &error.variant {
        ErrorVariant::ParsingError { positives, .. } => {
            let around = (&text[..at], &text[at + word.len()..]);
            let hint = skills::hint(&word, around, positives);
            (
                expectations(positives),
                hint.or_else(|| scope_hint(positives))
                    .or_else(|| metric_hint(&text[..at], positives))
                    .or_else(|| lines::failures_hint(&text[..at], &word, positives)),
            )
        }
        ErrorVariant::CustomError { message } => (message.clone(), None),
    };
    let end = at + word.len();
    let message = if word.is_empty() {
        "something is missing here".to_owned()
    } else {
        format!("`{word}` does not fit here")
    };
    let span = Span::new(
        file,
        start + at,
        start + end.max(at + usize::from(at < text.len())),
    );
    let finding = Diagnostic::error(codes::SYNTAX, span, message);
    if let Some(hint) = hint {
        return finding.with_help(hint);
    }
    if (word == "%" || mend::UNITS.contains(&word.as_str())) && text[..at].trim_end().ends_with(')')
    {
        return finding.with_help(format!(
            "a unit stands behind a number: multiply what stands in brackets, `(30 + 5) * 1 {word}`"
        ));
    }
    let is_count = text[..at].trim().bytes().all(|byte| byte.is_ascii_digit());
    if is_count && expected == "the end of the item" {
        return finding.with_help("this number is a count, which has no unit");
    }
    if expected == "a name or `)`" && word.starts_with(|c: char| c.is_ascii_digit()) {
        return finding.with_help("write the name of the parameter, as in `duration = 38 s`");
    }
    if is_reserved(&word) && !expected.contains("an expression") && expected.contains("a name") {
        return finding.with_help(format!(
            "expected {expected}; `{word}` is a keyword and cannot be a name"
        ));
    }
    if expected.contains("an expression") && WIDE.contains(&word.as_str()) {
        return finding.with_help(format!(
            "put brackets around it: `{word}` extends as far to the right as possible, and cannot follow an operator that binds tighter"
        ));
    }
    if expected.contains("a unit")
        && let Some(near) = unit_meant(&word)
    {
        return finding.with_help(format!("did you mean the unit `{near}`?"));
    }
    if expected.is_empty() {
        finding.with_help("`linewright explain LW002` shows what a declaration looks like")
    } else {
        finding.with_help(format!("expected {expected}"))
    }
}

/// Returns the finding for a number with a sign, a fraction or an exponent at the start of the
/// text, where a count is expected.
fn not_whole(file: FileId, at: usize, text: &str, expected: &[Rule]) -> Option<Diagnostic> {
    let any_number = [Rule::expression, Rule::quantity, Rule::real, Rule::additive];
    if !expected.contains(&Rule::integer) || any_number.iter().any(|rule| expected.contains(rule)) {
        return None;
    }
    let sign = text.len() - text.strip_prefix('-').unwrap_or(text).trim_start().len();
    let digits = text[sign..].find(|c: char| !c.is_ascii_digit() && c != '.' && c != 'e');
    let end = sign + digits.unwrap_or(text.len() - sign);
    let number = text[..end].trim_end_matches(['.', 'e']);
    let value: f64 = number[sign.min(number.len())..].parse().ok()?;
    let message = if sign > 0 {
        format!("`{number}` is negative, and a count cannot be")
    } else {
        format!("`{number}` is not a whole number")
    };
    let example = value.round().max(1.0);
    let span = Span::new(file, at, at + number.len());
    Some(
        Diagnostic::error(codes::SYNTAX, span, message).with_help(format!(
            "write a whole number in digits, without a sign or a unit, such as `{example}`"
        )),
    )
}

/// Returns help if a scope is being parsed. In a scope, `and` is expected but `or` is not, because
/// only `between p and q` allows one without the other.
fn scope_hint(expected: &[Rule]) -> Option<String> {
    let in_scope = expected.contains(&Rule::and_op) && !expected.contains(&Rule::or_op);
    in_scope.then(|| {
        "write the scope as `between p and q`, with brackets around `p` or `q` if it has operators"
            .to_owned()
    })
}

/// Returns help for a requirement whose metric is not followed by a comparison, or has another
/// argument than a name.
fn metric_hint(before: &str, expected: &[Rule]) -> Option<String> {
    let after_metric = expected.contains(&Rule::compare_op) && !expected.contains(&Rule::and_op);
    let in_argument = expected == [Rule::name] && before.trim_end().ends_with('(');
    let in_requirement = before
        .lines()
        .next_back()
        .is_some_and(|line| line.trim_start().starts_with("requirement"));
    (in_requirement && (after_metric || in_argument)).then(|| {
        "compare one metric with a bound, as in `energy <= 2 kWh` or `busy(press) >= 20 %`"
            .to_owned()
    })
}

/// Returns the unit that an unknown unit word probably means.
fn unit_meant(word: &str) -> Option<&'static str> {
    Some(match word.to_lowercase().as_str() {
        "sec" | "secs" | "second" | "seconds" => "s",
        "minute" | "minutes" | "mins" => "min",
        "hour" | "hours" | "hr" => "h",
        "day" | "days" => "d",
        "millimeter" | "millimeters" | "millimetre" | "millimetres" => "mm",
        "meter" | "meters" | "metre" | "metres" => "m",
        "degree" | "degrees" => "deg",
        "watt" | "watts" => "W",
        "kilowatt" | "kilowatts" => "kW",
        "gram" | "grams" => "g",
        "kilogram" | "kilograms" | "kilo" => "kg",
        _ => return nearest(word, mend::UNITS.iter().copied()),
    })
}

/// Prefix words whose operand extends as far to the right as possible.
const WIDE: &[&str] = &[
    "always",
    "eventually",
    "if",
    "forall",
    "exists",
    "count",
    "sum",
    "never",
];

fn word_at(text: &str) -> String {
    let mut chars = text.chars();
    let Some(first) = chars.next() else {
        return String::new();
    };
    if first.is_alphanumeric() || first == '_' {
        text.chars()
            .take_while(|c| c.is_alphanumeric() || *c == '_')
            .collect()
    } else {
        first.to_string()
    }
}

/// Lists the expected tokens, with one phrase for several rules.
fn expectations(rules: &[Rule]) -> String {
    let mut words: Vec<String> = Vec::new();
    for rule in rules {
        // The rule of a keyword is named `k_` followed by the word.
        let name = format!("{rule:?}");
        // After an order, leave out the words that begin the next item, because they would only
        // distract.
        if matches!(rule, Rule::k_component | Rule::k_order) && rules.contains(&Rule::EOI) {
            continue;
        }
        if let Some(keyword) = name.strip_prefix("k_") {
            let word = format!("`{keyword}`");
            if !words.contains(&word) {
                words.push(word);
            }
            continue;
        }
        let word = match rule {
            Rule::name | Rule::path | Rule::module => "a name",
            Rule::integer => "a whole number",
            Rule::expression
            | Rule::duration
            | Rule::drawn
            | Rule::empirical
            | Rule::empirical_word
            | Rule::distribution
            | Rule::outcome
            | Rule::operators
            | Rule::disjunction
            | Rule::past
            | Rule::past_op
            | Rule::never_word
            | Rule::wide_never
            | Rule::record
            | Rule::negation
            | Rule::prefix
            | Rule::comparison
            | Rule::additive
            | Rule::signed
            | Rule::sign
            | Rule::postfix
            | Rule::atom
            | Rule::parenthesis
            | Rule::list
            | Rule::call
            | Rule::quantity
            | Rule::boolean
            | Rule::wide
            | Rule::conditional
            | Rule::quantifier
            | Rule::wide_always
            | Rule::wide_eventually
            | Rule::not_op
            | Rule::next_op
            | Rule::minus
            | Rule::always_word
            | Rule::eventually_word
            | Rule::tight_always
            | Rule::tight_eventually
            | Rule::quantifier_op
            | Rule::real => "an expression",
            Rule::iff_op
            | Rule::implies_op
            | Rule::or_op
            | Rule::xor_op
            | Rule::and_op
            | Rule::since_op
            | Rule::until_op
            | Rule::until_word
            | Rule::pattern_op
            | Rule::field
            | Rule::compare_op
            | Rule::add_op
            | Rule::mul_op
            | Rule::membership
            | Rule::index
            | Rule::prime => "an operator",
            Rule::domain
            | Rule::labels
            | Rule::record_of
            | Rule::range
            | Rule::array_of
            | Rule::unit_type => "a type",
            Rule::unit => "a unit",
            Rule::parameters | Rule::parameter => "parameters",
            Rule::arguments | Rule::argument => "arguments",
            Rule::implements => "`implements`",
            Rule::code => "a code such as `din:4.3.1`",
            Rule::EOI => "the end of the item",
            Rule::set => "a set `{a, b}` or a range",
            Rule::string => "a path in quotes",
            Rule::column => "a table, such as `\"times.csv\" column duration in s`",
            Rule::column_word => "`column`",
            Rule::header => "the header of a column",
            Rule::on_order | Rule::every | Rule::at_column => "`every`, `on order` or `at`",
            Rule::open_brace => "`{`",
            Rule::open_bracket => "`[`",
            Rule::arrow => "`->`",
            Rule::dots => "`..`",
            Rule::close_paren => "`)`",
            Rule::close_bracket => "`]`",
            Rule::close_brace => "`}`",
            Rule::colon | Rule::label | Rule::requirement_id => "`:`",
            Rule::equals => "`=`",
            Rule::in_line => "`, at most N in the line`",
            Rule::at_most => "`at most`",
            Rule::date => "a date such as `2026-12-24`",
            Rule::the_line => "`the line`",
            other => match skills::phrase(*other).or_else(|| recipes::phrase(*other)) {
                Some(phrase) => phrase,
                None => continue,
            },
        };
        if !words.iter().any(|w| w == word) {
            words.push(word.to_owned());
        }
    }
    match words.as_slice() {
        [] => String::new(),
        [one] => one.clone(),
        [most @ .., last] => format!("{} or {last}", most.join(", ")),
    }
}
