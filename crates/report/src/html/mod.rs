//! Pages of HTML: each is one file, which asks no network for anything.
//!
//! [`document`] makes the page from its content; [`parts`] are what all pages have in common. Text,
//! tables and small charts are written here, as HTML and SVG. A script that is part of a page adds
//! what moves.

pub mod contract;
pub mod controller;
mod numbers;
pub mod parts;
pub mod run;
pub mod session;
pub mod terms;

use maud::{DOCTYPE, Markup, PreEscaped, html};

/// A page before it is written.
#[derive(Debug)]
pub struct Document<'a> {
    /// Title of the page.
    pub title: &'a str,
    /// Rules of the style sheet for this kind of page.
    pub style: &'a str,
    /// What is in the body.
    pub body: &'a Markup,
    /// What the script needs, as JSON. It must not contain `</`; see [`for_script`].
    pub data: Option<&'a str>,
    /// The script; empty if nothing moves.
    pub script: &'a str,
}

/// Returns the page.
pub fn document(document: &Document<'_>) -> String {
    let markup = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (document.title) }
                style { (PreEscaped(include_str!("page.css"))) (PreEscaped(document.style)) }
            }
            body {
                (document.body)
                @if let Some(data) = document.data {
                    script #data type="application/json" { (PreEscaped(data)) }
                }
                @if !document.script.is_empty() { script { (PreEscaped(document.script)) } }
            }
        }
    };
    markup.into_string()
}

/// Returns JSON that can stand in a script of a page: no text in it ends the script.
pub fn for_script(json: &str) -> String {
    json.replace('<', "\\u003c")
}
