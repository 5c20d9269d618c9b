//! Findings as SARIF 2.1.0 (OASIS standard), which code hosts and editors read.
//!
//! The document has one run. Every code that occurs is a rule, with its page as the help. There is
//! no `helpUri`, since the pages are embedded in the program. Region columns count characters
//! (`unicodeCodePoints`), as everywhere in this program. A finding's related places are
//! `relatedLocations`; its notes and its next step are appended to the message.

use super::json::Place;
use super::{Code, Diagnostic, Severity, explanations, render};
use crate::source::{SourceMap, Span};
use serde_json::{Value, json};
use std::fmt::Write as _;

/// Returns the whole SARIF document, findings sorted by file and place.
pub fn document(sources: &SourceMap, findings: &[Diagnostic]) -> Value {
    let findings = render::sorted(sources, findings);
    let mut rules: Vec<Code> = findings.iter().map(|d| d.code).collect();
    rules.sort_unstable();
    rules.dedup();
    let results: Vec<Value> = findings
        .iter()
        .map(|d| result(sources, d, &rules))
        .collect();
    run(&rules, &results)
}

/// Returns a document that describes these codes and has no findings.
pub fn catalogue(codes: &[Code]) -> Value {
    run(codes, &[])
}

fn run(rules: &[Code], results: &[Value]) -> Value {
    let rules: Vec<Value> = rules.iter().copied().map(rule).collect();
    json!({
        "$schema": "https://json.schemastore.org/sarif-2.1.0.json",
        "version": "2.1.0",
        "runs": [{
            "tool": {"driver": {
                "name": "linewright",
                "version": env!("CARGO_PKG_VERSION"),
                "rules": rules,
            }},
            "columnKind": "unicodeCodePoints",
            "results": results,
        }],
    })
}

fn rule(code: Code) -> Value {
    let mut rule = json!({"id": code.id, "shortDescription": {"text": code.title}});
    if let Some(page) = explanations::page(code) {
        rule["fullDescription"] = json!({"text": explanations::summary(page)});
        rule["help"] = json!({"text": explanations::plain(page), "markdown": page});
    }
    rule["properties"] = json!({"tags": [code.group().title]});
    rule
}

fn result(sources: &SourceMap, finding: &Diagnostic, rules: &[Code]) -> Value {
    let level = match finding.severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
        Severity::Note => "note",
    };
    let mut text = finding.message.clone();
    for note in &finding.notes {
        let _ = write!(text, "\nnote: {note}");
    }
    if let Some(help) = &finding.help {
        let _ = write!(text, "\nhelp: {help}");
    }
    let mut result = json!({
        "ruleId": finding.code.id,
        "ruleIndex": rules.binary_search(&finding.code).unwrap_or(0),
        "level": level,
        "message": {"text": text},
    });
    if let Some(span) = finding.span {
        result["locations"] = json!([location(sources, span)]);
    }
    if !finding.labels.is_empty() {
        result["relatedLocations"] = finding
            .labels
            .iter()
            .map(|(span, text)| {
                let mut location = location(sources, *span);
                location["message"] = json!({"text": text});
                location
            })
            .collect();
    }
    result
}

fn location(sources: &SourceMap, span: Span) -> Value {
    let place = Place::of(sources, span);
    json!({"physicalLocation": {
        "artifactLocation": {"uri": uri(&place.file)},
        "region": {
            "startLine": place.line,
            "startColumn": place.column,
            "endLine": place.end_line,
            "endColumn": place.end_column,
        },
    }})
}

/// Converts a file name to a URI reference (RFC 3986): characters not allowed in a path are
/// percent-encoded.
fn uri(name: &str) -> String {
    let mut uri = String::new();
    if name.starts_with('/') {
        uri.push_str("file://");
    }
    for byte in name.bytes() {
        match byte {
            b'\\' => uri.push('/'),
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'.' | b'_' | b'~' | b'/' => {
                uri.push(byte as char);
            }
            _ => {
                let _ = write!(uri, "%{byte:02X}");
            }
        }
    }
    uri
}

#[cfg(test)]
mod tests {
    use super::super::sample;
    use super::*;

    #[test]
    fn document_of_the_sample() {
        let (sources, findings) = sample::findings();
        let text = serde_json::to_string_pretty(&document(&sources, &findings)).unwrap();
        insta::assert_snapshot!(sample::with_sources(&sources, &text));
    }

    #[test]
    fn every_result_points_at_its_own_rule() {
        let (sources, findings) = sample::findings();
        let document = document(&sources, &findings);
        let run = &document["runs"][0];
        for result in run["results"].as_array().unwrap() {
            let index = result["ruleIndex"].as_u64().unwrap() as usize;
            assert_eq!(
                run["tool"]["driver"]["rules"][index]["id"],
                result["ruleId"]
            );
        }
    }

    #[test]
    fn names_become_uris() {
        assert_eq!(uri("a b/ü.lw"), "a%20b/%C3%BC.lw");
        assert_eq!(uri("/tmp/a.lw"), "file:///tmp/a.lw");
    }
}
