//! A parser of the generated SimTalk 2, based only on its texts: statements, `if`, assignments,
//! calls. Anything else in a text is an error.

/// An expression.
#[derive(Debug, Clone, PartialEq)]
pub enum Expression {
    /// A number or truth value, as written.
    Number(String),
    /// A text.
    Text(String),
    /// A variable or attribute: `?.LW_Handle`.
    Name(String),
    /// A call.
    Call(String, Vec<Expression>),
    /// `a < b`, `a + b`
    Operation(Box<Expression>, char, Box<Expression>),
}

/// A statement.
#[derive(Debug, Clone, PartialEq)]
pub enum Statement {
    /// `target := value`, also with `var` and a type.
    Assign(String, Expression),
    /// A call whose result is not used.
    Do(Expression),
    /// `print a, b`
    Print(Vec<Expression>),
    /// `if condition ... else ... end`
    If(Expression, Vec<Statement>, Vec<Statement>),
}

/// A method: its title and its statements.
pub struct Method {
    pub title: String,
    pub body: Vec<Statement>,
}

/// The methods of a text; one without a banner is a single method.
pub fn methods(text: &str) -> Vec<Method> {
    let mut titled: Vec<(String, Vec<&str>)> = vec![(String::new(), Vec::new())];
    for line in text.lines() {
        if let Some(title) = line.strip_prefix("-- ==== ") {
            titled.push((title.to_owned(), Vec::new()));
        } else if let Some((_, lines)) = titled.last_mut() {
            lines.push(line);
        }
    }
    let methods = titled.into_iter().map(|(title, lines)| {
        let mut lines = lines.into_iter().map(uncommented).filter(|l| !l.is_empty());
        let (body, end) = block(&mut lines);
        assert_eq!(end, "", "{title}: `{end}` without an if");
        Method { title, body }
    });
    methods
        .filter(|m| !m.title.is_empty() || !m.body.is_empty())
        .collect()
}

/// A line without its comment, trimmed.
fn uncommented(line: &str) -> String {
    let mut quoted = false;
    let characters: Vec<char> = line.chars().collect();
    for i in 0..characters.len() {
        quoted ^= characters[i] == '"';
        if !quoted && characters[i] == '-' && characters.get(i + 1) == Some(&'-') {
            return characters[..i].iter().collect::<String>().trim().to_owned();
        }
    }
    assert!(!quoted, "a text without an end: {line}");
    line.trim().to_owned()
}

/// Statements up to `else`, `end` or the end of the text, which is also returned.
fn block(lines: &mut impl Iterator<Item = String>) -> (Vec<Statement>, String) {
    let mut body = Vec::new();
    while let Some(line) = lines.next() {
        if line == "else" || line == "end" {
            return (body, line);
        }
        body.push(statement(&line, lines));
    }
    (body, String::new())
}

fn statement(line: &str, lines: &mut impl Iterator<Item = String>) -> Statement {
    if let Some(condition) = line.strip_prefix("if ") {
        let (then, end) = block(lines);
        let (otherwise, end) = if end == "else" {
            block(lines)
        } else {
            (Vec::new(), end)
        };
        assert_eq!(end, "end", "`{line}` has no end");
        return Statement::If(whole(condition), then, otherwise);
    }
    if let Some(shown) = line.strip_prefix("print ") {
        let mut reader = Reader::of(shown);
        return Statement::Print(reader.list(None));
    }
    if let Some((target, value)) = line.split_once(" := ") {
        let target = target.strip_prefix("var ").unwrap_or(target);
        let target = target.split_once(": ").map_or(target, |(name, _)| name);
        let plain = |c: char| c.is_ascii_alphanumeric() || "_.?@".contains(c);
        assert!(target.chars().all(plain), "no variable: {target}");
        return Statement::Assign(target.to_owned(), whole(value));
    }
    Statement::Do(whole(line))
}

fn whole(text: &str) -> Expression {
    let mut reader = Reader::of(text);
    let expression = reader.expression();
    assert_eq!(reader.rest.trim(), "", "in {text}");
    expression
}

struct Reader<'t> {
    rest: &'t str,
}

impl<'t> Reader<'t> {
    fn of(text: &'t str) -> Self {
        Self { rest: text }
    }

    fn take(&mut self, token: &str) -> bool {
        self.rest = self.rest.trim_start();
        match self.rest.strip_prefix(token) {
            Some(rest) => {
                self.rest = rest;
                true
            }
            None => false,
        }
    }

    fn expression(&mut self) -> Expression {
        let mut left = self.operand();
        for operator in ['+', '<'] {
            if self.take(&operator.to_string()) {
                let right = self.operand();
                left = Expression::Operation(Box::new(left), operator, Box::new(right));
            }
        }
        left
    }

    /// Expressions with commas, up to a closing token.
    fn list(&mut self, close: Option<&str>) -> Vec<Expression> {
        let mut all = Vec::new();
        if close.is_some_and(|c| self.take(c)) {
            return all;
        }
        loop {
            all.push(self.expression());
            if !self.take(",") {
                break;
            }
        }
        assert!(close.is_none_or(|c| self.take(c)), "no end: {}", self.rest);
        all
    }

    fn operand(&mut self) -> Expression {
        if self.take("\"") {
            let (text, rest) = self.rest.split_once('"').expect("a text's end");
            self.rest = rest;
            return Expression::Text(text.to_owned());
        }
        self.rest = self.rest.trim_start();
        let numeric = self
            .rest
            .starts_with(|c: char| c.is_ascii_digit() || c == '-');
        let belongs = |c: char| {
            c.is_ascii_alphanumeric()
                || "_.".contains(c)
                || (numeric && c == '-')
                || (!numeric && "?@".contains(c))
        };
        let end = self.rest.find(|c| !belongs(c)).unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at(end);
        assert!(!word.is_empty(), "nothing at: {}", self.rest);
        self.rest = rest;
        if numeric || word == "true" || word == "false" {
            return Expression::Number(word.to_owned());
        }
        if self.take("(") {
            return Expression::Call(word.to_owned(), self.list(Some(")")));
        }
        Expression::Name(word.to_owned())
    }
}
