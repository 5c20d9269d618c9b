//! Topics of `explain` besides findings: the constructs of the language, whose pages are sections
//! of the language reference, and the commands.

use clap::Command;
use include_dir::{Dir, include_dir};
use schemars::JsonSchema;
use serde::Serialize;

static REFERENCE: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/docs/reference/language");

/// A construct or a command.
#[derive(Debug, JsonSchema, Serialize)]
pub struct Topic {
    /// The name: a heading of the reference, or a command as typed.
    name: String,
    /// Whether the topic is a construct or a command.
    kind: Kind,
    /// The names by which it can be requested.
    #[serde(skip)]
    keys: Vec<String>,
    /// The page: Markdown for a construct, the help text for a command.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub page: String,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
enum Kind {
    Construct,
    Command,
}

impl Topic {
    /// The topic's line in a list.
    pub fn line(&self) -> String {
        let name = self.name.replace('`', "");
        match self.kind {
            Kind::Construct => format!("construct  {name}"),
            Kind::Command => format!("command    {name}"),
        }
    }

    /// Returns the topic with an empty page.
    #[must_use]
    pub fn without_page(self) -> Self {
        Self {
            page: String::new(),
            ..self
        }
    }
}

/// All constructs in the order of the reference, then all commands.
pub fn all(program: &Command) -> Vec<Topic> {
    let mut files: Vec<_> = REFERENCE.files().collect();
    files.sort_by_key(|file| file.path());
    let texts = files.iter().filter_map(|file| file.contents_utf8());
    let mut topics: Vec<Topic> = texts.flat_map(constructs).collect();
    commands(program, "", &mut topics);
    topics
}

/// The topics that have exactly this name. If there are none, the constructs with this word in a
/// name, or with this keyword in their grammar. If there are none either, the constructs with a
/// table that has a row for this word; then the commands with this option; then the construct whose
/// text has this word or these words most often.
pub fn find(mut topics: Vec<Topic>, name: &str) -> Vec<Topic> {
    let keyword = format!("k_{name}");
    let word_rule = format!("{name}_word");
    let is_name = |topic: &Topic| topic.keys.iter().any(|key| key == name);
    let has_word = |topic: &Topic| {
        let mut words = topic.keys.iter().flat_map(|key| key.split_whitespace());
        let mut rules = topic.page.split(|c: char| !c.is_alphanumeric() && c != '_');
        topic.kind == Kind::Construct
            && (words.any(|word| word == name)
                || rules.any(|rule| rule == keyword || rule == word_rule))
    };
    let has_row = |topic: &Topic| {
        let rows = topic.page.lines().filter_map(|l| l.strip_prefix("| `"));
        let mut entries = rows.filter_map(|row| row.strip_prefix(name));
        topic.kind == Kind::Construct && entries.any(|rest| rest.starts_with(['`', '(']))
    };
    let option = format!("--{}", name.trim_start_matches('-'));
    let has_option = |topic: &Topic| {
        let mut words = topic.page.split_whitespace();
        topic.kind == Kind::Command && words.any(|word| word == option)
    };
    let constructs = topics.iter().filter(|t| t.kind == Kind::Construct);
    let most = constructs.map(|topic| mentions(&topic.page, name)).max();
    let mentions_it = |topic: &Topic| {
        let count = mentions(&topic.page, name);
        topic.kind == Kind::Construct && count > 0 && Some(count) == most
    };
    let matches: [&dyn Fn(&Topic) -> bool; 5] =
        [&is_name, &has_word, &has_row, &has_option, &mentions_it];
    let first = matches.into_iter().find(|fits| topics.iter().any(fits));
    topics.retain(|topic| first.is_some_and(|fits| fits(topic)));
    topics
}

/// How often the text of a page, without its blocks of code, has this word or these words. Hyphens
/// and underscores separate words.
fn mentions(page: &str, name: &str) -> usize {
    let mut fenced = false;
    let prose = page.lines().filter(|line| {
        let is_fence = line.starts_with("```");
        fenced ^= is_fence;
        !fenced && !is_fence
    });
    let prose: Vec<&str> = prose.flat_map(words).collect();
    let name: Vec<&str> = words(name).collect();
    let found = prose.windows(name.len().max(1));
    found.filter(|found| *found == name.as_slice()).count()
}

fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !c.is_alphanumeric())
        .filter(|word| !word.is_empty())
}

/// All names of topics, for suggestions.
pub fn names(topics: &[Topic]) -> impl Iterator<Item = &str> {
    let keys = topics.iter().flat_map(|topic| &topic.keys);
    keys.map(String::as_str)
}

/// Those sections of a reference page whose heading names a construct in backticks.
fn constructs(page: &str) -> Vec<Topic> {
    let mut sections: Vec<(&str, String)> = Vec::new();
    let mut fenced = false;
    for line in page.lines() {
        fenced ^= line.starts_with("```");
        if let (Some(heading), false) = (line.strip_prefix("## "), fenced) {
            sections.push((heading, String::new()));
        }
        if let Some((_, text)) = sections.last_mut() {
            text.push_str(line);
            text.push('\n');
        }
    }
    let topics = sections.into_iter().map(|(heading, text)| Topic {
        name: heading.to_owned(),
        kind: Kind::Construct,
        keys: code_spans(heading),
        page: format!("{}\n", text.trim_end()),
    });
    topics.filter(|topic| !topic.keys.is_empty()).collect()
}

/// The texts in backticks.
fn code_spans(text: &str) -> Vec<String> {
    let spans = text.split('`').skip(1).step_by(2);
    spans.map(str::to_owned).collect()
}

/// Adds the subcommands of a command, recursively.
fn commands(of: &Command, prefix: &str, topics: &mut Vec<Topic>) {
    for command in of.get_subcommands().filter(|c| c.get_name() != "help") {
        let name = format!("{prefix}{}", command.get_name());
        let help = command
            .clone()
            .bin_name(format!("linewright {name}"))
            .render_long_help();
        topics.push(Topic {
            name: name.clone(),
            kind: Kind::Command,
            keys: vec![name.clone()],
            page: help.to_string(),
        });
        commands(command, &format!("{name} "), topics);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sections_are_found_by_the_code_in_their_headings() {
        let page = "# Lines\n\n## In general\nx\n\n## `shift`\nHours.\n```text\n## `no`\n```\n\n\
                    ## `failures mtbf ... mttr` of a station\nRepairs.\n";
        let found = |name| {
            let topics = find(constructs(page), name);
            topics.into_iter().map(|t| t.page).collect::<Vec<_>>()
        };
        assert_eq!(
            found("shift"),
            ["## `shift`\nHours.\n```text\n## `no`\n```\n"]
        );
        assert_eq!(
            found("mttr"),
            ["## `failures mtbf ... mttr` of a station\nRepairs.\n"]
        );
        assert!(found("no").is_empty());
        assert!(found("general").is_empty());
        // Words of the text, and not of examples.
        assert_eq!(found("Repairs"), found("mttr"));
        assert!(found("x").is_empty());
    }
}
