//! Pages of HTML that commands write.

use crate::diagnostics::Diagnostic;
use crate::report::html::parts::Origin;
use crate::source::SourceMap;

/// Where a page comes from: this command, with the files that it read and what it found.
pub fn origin<'a>(
    command: &'a str,
    sources: &'a SourceMap,
    findings: &'a [Diagnostic],
) -> Origin<'a> {
    Origin {
        command,
        version: env!("CARGO_PKG_VERSION"),
        sources,
        findings,
    }
}

/// The command line, quoted for a shell where that is necessary.
pub fn command() -> String {
    quoted(std::env::args().skip(1))
}

fn quoted(arguments: impl Iterator<Item = String>) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "-_=+.,:/%@".contains(c);
    let quoted = arguments.map(|argument| {
        if !argument.is_empty() && argument.chars().all(is_plain) {
            argument
        } else {
            format!("'{}'", argument.replace('\'', r"'\''"))
        }
    });
    std::iter::once("linewright".to_owned())
        .chain(quoted)
        .collect::<Vec<_>>()
        .join(" ")
}

#[cfg(test)]
mod tests {
    use super::quoted;

    #[test]
    fn a_command_can_be_pasted_into_a_shell() {
        let arguments = [
            "run",
            "my line.lw",
            "--set",
            "a.takes='2 s'",
            "--parts",
            "5",
        ];
        assert_eq!(
            quoted(arguments.map(str::to_owned).into_iter()),
            r"linewright run 'my line.lw' --set 'a.takes='\''2 s'\''' --parts 5"
        );
    }
}
