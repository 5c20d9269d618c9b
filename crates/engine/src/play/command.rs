//! Parses an input line as a command. A line that does not begin with a command word is a move:
//! `name = value, name = value`, or values alone.

/// A command of the user.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Command {
    /// An empty line, or a comment.
    Nothing,
    /// A move.
    Move(Vec<Part>),
    /// Lists the legal moves.
    Moves,
    /// Shows which rules limit the moves, or why the last move was refused.
    Why,
    /// Shows which rules forbid a move.
    WhyNot(Vec<Part>),
    /// Shows the values of the last steps.
    State,
    /// Takes back this number of steps.
    Undo(usize),
    /// Takes back all steps.
    Reset,
    /// Makes this number of random legal moves.
    Random(usize),
    /// Runs the commands of a file.
    Replay(String),
    /// Writes the moves to a file.
    Save {
        /// Whether to include the opponent's values as expectations.
        test: bool,
        /// File to write.
        file: String,
    },
    /// Checks the values of the last step.
    Expect(Vec<Part>),
    /// Lists the commands.
    Help,
    /// Ends the session.
    Quit,
}

/// One value of a move.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Part {
    /// Variable name; `None` if only a value was given.
    pub name: Option<String>,
    /// The value as text.
    pub value: String,
}

/// Words that begin a command.
pub(super) const WORDS: [&str; 12] = [
    "moves", "why", "state", "undo", "reset", "random", "replay", "save", "expect", "help", "quit",
    "exit",
];

/// Output of `help`.
pub(super) const HELP: &str = "\
name = value, name = value  make a move; other variables keep their values if possible
value, value                make a move with values for all variables, in declaration order
moves                       list the legal moves
why                         show why the last move was refused, or which rules limit the next one
why not name = value        show which rules forbid this move
state                       show the values of the last steps, and when each goal was last met
undo [N]                    take back the last step, or the last N steps
reset                       take back all steps
random [N]                  make a random legal move, or N of them
save FILE                   write the moves to a file that `replay` and --script read
save test FILE              also write `expect` lines: replaying fails if a value differs
save FILE.svg               write the steps so far as a timing diagram
replay FILE                 run the commands in a file
expect name = value         fail unless the last step has these values
help                        show this text
quit                        end the session
# ...                       a comment
";

/// Parses an input line.
pub(super) fn parse(line: &str) -> Result<Command, String> {
    let line = without_comment(line).trim();
    let (word, rest) = match line.split_once(char::is_whitespace) {
        Some((word, rest)) => (word, rest.trim()),
        None => (line, ""),
    };
    // A variable can have the same name as a command.
    if !WORDS.contains(&word) || rest.starts_with('=') {
        return match line {
            "" => Ok(Command::Nothing),
            line => parts(line).map(Command::Move),
        };
    }
    let alone = |command: Command| match rest {
        "" => Ok(command),
        rest => Err(format!(
            "unexpected `{rest}` after `{word}`: write `{word}` alone"
        )),
    };
    let count = || match rest {
        "" => Ok(1),
        rest => match rest.parse::<usize>() {
            Ok(count) if count > 0 => Ok(count),
            _ => Err(format!(
                "`{rest}` is not a number of steps: write for example `{word} 3`"
            )),
        },
    };
    let file = |name: &str| match name {
        "" => Err(format!("`{word}` needs a file name")),
        name => Ok(name.to_owned()),
    };
    match word {
        "moves" => alone(Command::Moves),
        "state" => alone(Command::State),
        "reset" => alone(Command::Reset),
        "help" => alone(Command::Help),
        "quit" | "exit" => alone(Command::Quit),
        "undo" => count().map(Command::Undo),
        "random" => count().map(Command::Random),
        "replay" => file(rest).map(Command::Replay),
        "expect" => parts(rest).map(Command::Expect),
        "save" => {
            let test = rest
                .strip_prefix("test")
                .filter(|r| r.starts_with(char::is_whitespace));
            Ok(Command::Save {
                file: file(test.unwrap_or(rest).trim())?,
                test: test.is_some(),
            })
        }
        _ => match rest
            .strip_prefix("not")
            .filter(|r| r.starts_with(char::is_whitespace))
        {
            Some(moved) => parts(moved).map(Command::WhyNot),
            None if rest.is_empty() => Ok(Command::Why),
            None => Err("write `why`, or `why not name = value`".to_owned()),
        },
    }
}

/// Removes a comment: it begins with a `#` at the start of the line or after a space.
fn without_comment(line: &str) -> &str {
    let mut blank = true;
    for (at, c) in line.char_indices() {
        if c == '#' && blank {
            return &line[..at];
        }
        blank = c.is_whitespace();
    }
    line
}

fn parts(text: &str) -> Result<Vec<Part>, String> {
    let named = text.contains('=');
    let pieces: Vec<&str> = if named || text.contains(',') {
        text.split(',').collect()
    } else {
        text.split_whitespace().collect()
    };
    let read = |piece: &str| match piece.split_once('=') {
        None if named => Err(format!(
            "`{}` has no name: write either `name = value` for all values, or only values",
            piece.trim()
        )),
        None => Ok(Part {
            name: None,
            value: piece.trim().to_owned(),
        }),
        Some((name, value)) => Ok(Part {
            name: Some(name.trim().to_owned()),
            value: value.trim().to_owned(),
        }),
    };
    let parts: Vec<Part> = pieces.into_iter().map(read).collect::<Result<_, _>>()?;
    let empty = |p: &Part| p.value.is_empty() || p.name.as_ref().is_some_and(String::is_empty);
    if parts.is_empty() || parts.iter().any(empty) {
        return Err("a value is missing: write `name = value, name = value`".to_owned());
    }
    Ok(parts)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(name: &str, value: &str) -> Part {
        Part {
            name: Some(name.to_owned()).filter(|n| !n.is_empty()),
            value: value.to_owned(),
        }
    }

    #[test]
    fn lines_are_read() {
        for (line, wanted) in [
            ("", Command::Nothing),
            ("  # a comment", Command::Nothing),
            ("moves # a comment", Command::Moves),
            ("undo", Command::Undo(1)),
            ("undo 3", Command::Undo(3)),
            ("why", Command::Why),
            ("why not a = 1", Command::WhyNot(vec![part("a", "1")])),
            (
                "a = 1,b[2]=x",
                Command::Move(vec![part("a", "1"), part("b[2]", "x")]),
            ),
            (
                "1 true x",
                Command::Move(vec![part("", "1"), part("", "true"), part("", "x")]),
            ),
            (
                "1, 90 deg",
                Command::Move(vec![part("", "1"), part("", "90 deg")]),
            ),
            ("state = 1", Command::Move(vec![part("state", "1")])),
            ("replay a b.txt", Command::Replay("a b.txt".to_owned())),
            (
                "save test",
                Command::Save {
                    test: false,
                    file: "test".to_owned(),
                },
            ),
            (
                "save test x.txt",
                Command::Save {
                    test: true,
                    file: "x.txt".to_owned(),
                },
            ),
            ("expect a = 1", Command::Expect(vec![part("a", "1")])),
            ("quit", Command::Quit),
        ] {
            assert_eq!(parse(line), Ok(wanted), "{line}");
        }
    }

    #[test]
    fn mistakes_are_reported() {
        for line in [
            "moves now",
            "undo x",
            "undo 0",
            "save",
            "replay",
            "a = ",
            "= 1",
            "a = 1, 2",
            "why so",
            "expect",
            "a = 1,",
        ] {
            assert!(parse(line).is_err(), "{line}");
        }
    }

    #[test]
    fn help_names_every_command() {
        for word in WORDS.iter().filter(|w| **w != "exit") {
            assert!(HELP.lines().any(|l| l.starts_with(word)), "{word}");
        }
    }
}
