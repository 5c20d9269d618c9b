//! The subset of Structured Text used by function blocks: types, declarations, statements,
//! expressions.
//!
//! From IEC 61131-3, tables of operators and of statements. Operators are listed by decreasing
//! precedence, and associate to the left:
//!
//! ```text
//! - NOT    * / MOD    + -    < > <= >=    = <>    & AND    XOR    OR
//! ```

use super::lexer::{Placed, Token, tokens};

/// Declared types and function blocks.
#[derive(Debug, Default)]
pub struct Unit {
    pub types: Vec<(String, Spec)>,
    pub blocks: Vec<Block>,
}

/// A type as written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Spec {
    /// An elementary or declared type.
    Named(String),
    /// `STRING[80]`, with its maximum length.
    Text(i128),
    /// `INT(0..4)`
    Subrange(String, i128, i128),
    /// Labels.
    Enumeration(Vec<String>),
    /// Bounds of every dimension, and the type of the elements.
    Array(Vec<(i128, i128)>, Box<Spec>),
}

/// How a variable is declared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Section {
    Input,
    Output,
    Local,
    Constant,
    Temporary,
}

#[derive(Debug)]
pub struct Declaration {
    pub section: Section,
    pub name: String,
    pub spec: Spec,
    /// One value, or the values of an array.
    pub initial: Option<Vec<Expr>>,
}

#[derive(Debug)]
pub struct Block {
    pub name: String,
    pub declarations: Vec<Declaration>,
    pub body: Vec<Statement>,
}

/// A statement and its line.
#[derive(Debug)]
pub struct Statement {
    pub line: usize,
    pub kind: Kind,
}

#[derive(Debug)]
pub enum Kind {
    Assign(Expr, Expr),
    /// Conditions with their statements, and the ELSE statements.
    If(Vec<(Expr, Vec<Statement>)>, Vec<Statement>),
    Case(Expr, Vec<(Vec<Label>, Vec<Statement>)>, Vec<Statement>),
    For {
        variable: String,
        from: Expr,
        to: Expr,
        by: Option<Expr>,
        body: Vec<Statement>,
    },
    While(Expr, Vec<Statement>),
    Repeat(Vec<Statement>, Expr),
    Exit,
    Continue,
    Return,
}

/// A value of a case, or the first and last of a range.
#[derive(Debug)]
pub struct Label {
    pub first: Expr,
    pub last: Option<Expr>,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Expr {
    Number(i128),
    Text(String),
    /// `INT#5`, `E_Command#turn`: the type and what follows it.
    Typed(String, Box<Expr>),
    Name(String),
    Index(String, Vec<Expr>),
    Unary(&'static str, Box<Expr>),
    Binary(&'static str, Box<Expr>, Box<Expr>),
    Call(String, Vec<Expr>),
}

/// Words that cannot be names.
const KEYWORDS: &str = "AND ARRAY BY CASE CONSTANT CONTINUE DO ELSE ELSIF END_CASE END_FOR END_FUNCTION_BLOCK END_IF END_REPEAT \
    END_TYPE END_VAR END_WHILE EXIT FALSE FOR FUNCTION_BLOCK IF MOD NOT OF OR REPEAT RETURN STEP END_STEP ACTION TRANSITION THEN TO \
    TRUE TYPE UNTIL VAR VAR_INPUT VAR_OUTPUT VAR_TEMP WHILE XOR BOOL SINT INT DINT LINT USINT UINT UDINT ULINT REAL LREAL TIME \
    DATE STRING WSTRING BYTE WORD DWORD LWORD ABS MIN MAX SEL LIMIT MOVE ADD SUB MUL DIV TON TOF TP RS SR CTU CTD R_TRIG F_TRIG \
    EN ENO TASK PROGRAM FUNCTION STRUCT AT WITH ON RESOURCE CONFIGURATION RETAIN";

/// Operators by precedence, the lowest first.
const LEVELS: [&[&str]; 7] = [
    &["OR"],
    &["XOR"],
    &["AND", "&"],
    &["=", "<>"],
    &["<", ">", "<=", ">="],
    &["+", "-"],
    &["*", "/", "MOD"],
];

/// Reads types and function blocks.
pub fn parse(text: &str) -> Result<Unit, String> {
    let mut parser = Parser::new(text)?;
    let mut unit = Unit::default();
    while parser.peek() != &Token::End {
        if parser.word("TYPE") {
            while !parser.word("END_TYPE") {
                let name = parser.name()?;
                parser.expect(":")?;
                let spec = parser.spec()?;
                parser.expect(";")?;
                unit.types.push((name, spec));
            }
        } else if parser.word("FUNCTION_BLOCK") {
            let name = parser.name()?;
            let mut declarations = Vec::new();
            while let Some(section) = parser.section() {
                parser.declarations(section, &mut declarations)?;
            }
            let body = parser.statements(&["END_FUNCTION_BLOCK"])?;
            parser.expect_word("END_FUNCTION_BLOCK")?;
            unit.blocks.push(Block {
                name,
                declarations,
                body,
            });
        } else {
            return Err(parser.unexpected("TYPE or FUNCTION_BLOCK"));
        }
    }
    Ok(unit)
}

struct Parser {
    tokens: Vec<Placed>,
    at: usize,
}

impl Parser {
    fn new(text: &str) -> Result<Self, String> {
        Ok(Self {
            tokens: tokens(text)?,
            at: 0,
        })
    }

    fn peek(&self) -> &Token {
        &self.tokens[self.at].token
    }

    fn line(&self) -> usize {
        self.tokens[self.at].line
    }

    fn unexpected(&self, wanted: &str) -> String {
        format!(
            "line {}: expected {wanted}, found {:?}",
            self.line(),
            self.peek()
        )
    }

    fn is_word(&self, word: &str) -> bool {
        matches!(self.peek(), Token::Word(w) if w == word)
    }

    fn word(&mut self, word: &str) -> bool {
        let found = self.is_word(word);
        self.at += usize::from(found);
        found
    }

    fn sign(&mut self, sign: &str) -> bool {
        let found = matches!(self.peek(), Token::Sign(s) if *s == sign);
        self.at += usize::from(found);
        found
    }

    fn expect(&mut self, sign: &str) -> Result<(), String> {
        if self.sign(sign) {
            Ok(())
        } else {
            Err(self.unexpected(sign))
        }
    }

    fn expect_word(&mut self, word: &str) -> Result<(), String> {
        if self.word(word) {
            Ok(())
        } else {
            Err(self.unexpected(word))
        }
    }

    /// A name that is no keyword.
    fn name(&mut self) -> Result<String, String> {
        match self.peek().clone() {
            Token::Word(word) if !KEYWORDS.split_whitespace().any(|k| k == word) => {
                self.at += 1;
                Ok(word)
            }
            _ => Err(self.unexpected("a name")),
        }
    }

    fn section(&mut self) -> Option<Section> {
        let sections = [
            ("VAR_INPUT", Section::Input),
            ("VAR_OUTPUT", Section::Output),
            ("VAR_TEMP", Section::Temporary),
            ("VAR", Section::Local),
        ];
        let (_, section) = sections.into_iter().find(|(word, _)| self.word(word))?;
        if section == Section::Local && self.word("CONSTANT") {
            return Some(Section::Constant);
        }
        Some(section)
    }

    fn declarations(
        &mut self,
        section: Section,
        found: &mut Vec<Declaration>,
    ) -> Result<(), String> {
        while !self.word("END_VAR") {
            let mut names = vec![self.name()?];
            while self.sign(",") {
                names.push(self.name()?);
            }
            self.expect(":")?;
            let spec = self.spec()?;
            let initial = if self.sign(":=") {
                Some(self.initial()?)
            } else {
                None
            };
            self.expect(";")?;
            for name in names {
                found.push(Declaration {
                    section,
                    name,
                    spec: spec.clone(),
                    initial: initial.clone(),
                });
            }
        }
        Ok(())
    }

    /// `3`, `[1, 2, 3]`, `[2(0), 1]`
    fn initial(&mut self) -> Result<Vec<Expr>, String> {
        if !self.sign("[") {
            return Ok(vec![self.expression()?]);
        }
        let mut values = Vec::new();
        loop {
            let counted = matches!(
                (&self.tokens[self.at].token, &self.tokens[self.at + 1].token),
                (Token::Number(_), Token::Sign("("))
            );
            if counted {
                let count = self.integer()?;
                self.expect("(")?;
                let value = self.expression()?;
                self.expect(")")?;
                for _ in 0..count {
                    values.push(value.clone());
                }
            } else {
                values.push(self.expression()?);
            }
            if !self.sign(",") {
                self.expect("]")?;
                return Ok(values);
            }
        }
    }

    fn integer(&mut self) -> Result<i128, String> {
        let negative = self.sign("-");
        match *self.peek() {
            Token::Number(value) => {
                self.at += 1;
                Ok(if negative { -value } else { value })
            }
            _ => Err(self.unexpected("a number")),
        }
    }

    fn spec(&mut self) -> Result<Spec, String> {
        if self.sign("(") {
            let mut labels = vec![self.name()?];
            while self.sign(",") {
                labels.push(self.name()?);
            }
            self.expect(")")?;
            return Ok(Spec::Enumeration(labels));
        }
        if self.word("ARRAY") {
            self.expect("[")?;
            let mut dimensions = vec![self.bounds()?];
            while self.sign(",") {
                dimensions.push(self.bounds()?);
            }
            self.expect("]")?;
            self.expect_word("OF")?;
            return Ok(Spec::Array(dimensions, Box::new(self.spec()?)));
        }
        let Token::Word(name) = self.peek().clone() else {
            return Err(self.unexpected("a type"));
        };
        self.at += 1;
        if name == "STRING" {
            self.expect("[")?;
            let length = self.integer()?;
            self.expect("]")?;
            return Ok(Spec::Text(length));
        }
        if self.sign("(") {
            let (low, high) = self.bounds()?;
            self.expect(")")?;
            return Ok(Spec::Subrange(name, low, high));
        }
        Ok(Spec::Named(name))
    }

    fn bounds(&mut self) -> Result<(i128, i128), String> {
        let low = self.integer()?;
        self.expect("..")?;
        Ok((low, self.integer()?))
    }

    /// Statements up to one of these words.
    fn statements(&mut self, ends: &[&str]) -> Result<Vec<Statement>, String> {
        let mut found = Vec::new();
        while !ends.iter().any(|e| self.is_word(e)) {
            if self.sign(";") {
                continue;
            }
            let line = self.line();
            let kind = self.statement()?;
            self.expect(";")?;
            found.push(Statement { line, kind });
        }
        Ok(found)
    }

    fn statement(&mut self) -> Result<Kind, String> {
        for (word, kind) in [
            ("EXIT", Kind::Exit),
            ("CONTINUE", Kind::Continue),
            ("RETURN", Kind::Return),
        ] {
            if self.word(word) {
                return Ok(kind);
            }
        }
        if self.word("IF") {
            let mut branches = Vec::new();
            loop {
                let condition = self.expression()?;
                self.expect_word("THEN")?;
                let body = self.statements(&["ELSIF", "ELSE", "END_IF"])?;
                branches.push((condition, body));
                if !self.word("ELSIF") {
                    break;
                }
            }
            let otherwise = self.otherwise("END_IF")?;
            return Ok(Kind::If(branches, otherwise));
        }
        if self.word("CASE") {
            return self.case();
        }
        if self.word("FOR") {
            let variable = self.name()?;
            self.expect(":=")?;
            let from = self.expression()?;
            self.expect_word("TO")?;
            let to = self.expression()?;
            let by = if self.word("BY") {
                Some(self.expression()?)
            } else {
                None
            };
            self.expect_word("DO")?;
            let body = self.statements(&["END_FOR"])?;
            self.expect_word("END_FOR")?;
            return Ok(Kind::For {
                variable,
                from,
                to,
                by,
                body,
            });
        }
        if self.word("WHILE") {
            let condition = self.expression()?;
            self.expect_word("DO")?;
            let body = self.statements(&["END_WHILE"])?;
            self.expect_word("END_WHILE")?;
            return Ok(Kind::While(condition, body));
        }
        if self.word("REPEAT") {
            let body = self.statements(&["UNTIL"])?;
            self.expect_word("UNTIL")?;
            let condition = self.expression()?;
            self.expect_word("END_REPEAT")?;
            return Ok(Kind::Repeat(body, condition));
        }
        let name = self.name()?;
        let target = if self.sign("[") {
            Expr::Index(name, self.list("]")?)
        } else {
            Expr::Name(name)
        };
        self.expect(":=")?;
        Ok(Kind::Assign(target, self.expression()?))
    }

    fn otherwise(&mut self, end: &str) -> Result<Vec<Statement>, String> {
        let otherwise = if self.word("ELSE") {
            self.statements(&[end])?
        } else {
            Vec::new()
        };
        self.expect_word(end)?;
        Ok(otherwise)
    }

    fn case(&mut self) -> Result<Kind, String> {
        let selector = self.expression()?;
        self.expect_word("OF")?;
        let mut branches = Vec::new();
        while !self.is_word("ELSE") && !self.is_word("END_CASE") {
            let mut labels = Vec::new();
            loop {
                let first = self.expression()?;
                let last = if self.sign("..") {
                    Some(self.expression()?)
                } else {
                    None
                };
                labels.push(Label { first, last });
                if !self.sign(",") {
                    break;
                }
            }
            self.expect(":")?;
            let mut body = Vec::new();
            while !self.case_ends() {
                if self.sign(";") {
                    continue;
                }
                let line = self.line();
                let kind = self.statement()?;
                self.expect(";")?;
                body.push(Statement { line, kind });
            }
            branches.push((labels, body));
        }
        let otherwise = self.otherwise("END_CASE")?;
        Ok(Kind::Case(selector, branches, otherwise))
    }

    /// Whether the next label or the end begins: a label is constants up to a colon.
    fn case_ends(&self) -> bool {
        if self.is_word("ELSE") || self.is_word("END_CASE") {
            return true;
        }
        let rest = self.tokens[self.at..].iter();
        let label = rest.take_while(|p| {
            !matches!(
                &p.token,
                Token::Sign(":" | ":=" | ";" | "(" | "[") | Token::End
            )
        });
        let end = self.at + label.count();
        end > self.at && self.tokens[end].token == Token::Sign(":")
    }

    fn list(&mut self, end: &str) -> Result<Vec<Expr>, String> {
        let mut items = Vec::new();
        if self.sign(end) {
            return Ok(items);
        }
        loop {
            items.push(self.expression()?);
            if !self.sign(",") {
                self.expect(end)?;
                return Ok(items);
            }
        }
    }

    fn expression(&mut self) -> Result<Expr, String> {
        self.level(0)
    }

    fn level(&mut self, level: usize) -> Result<Expr, String> {
        let Some(operators) = LEVELS.get(level) else {
            return self.unary();
        };
        let mut left = self.level(level + 1)?;
        while let Some(operator) = operators.iter().find(|o| self.word(o) || self.sign(o)) {
            let right = self.level(level + 1)?;
            let operator = if *operator == "&" { "AND" } else { operator };
            left = Expr::Binary(operator, Box::new(left), Box::new(right));
        }
        Ok(left)
    }

    fn unary(&mut self) -> Result<Expr, String> {
        if self.word("NOT") {
            return Ok(Expr::Unary("NOT", Box::new(self.unary()?)));
        }
        if self.sign("-") {
            return Ok(match self.unary()? {
                Expr::Number(value) => Expr::Number(-value),
                operand => Expr::Unary("-", Box::new(operand)),
            });
        }
        self.primary()
    }

    fn primary(&mut self) -> Result<Expr, String> {
        if self.sign("(") {
            let inner = self.expression()?;
            self.expect(")")?;
            return Ok(inner);
        }
        match self.peek().clone() {
            Token::Number(value) => {
                self.at += 1;
                Ok(Expr::Number(value))
            }
            Token::Text(text) => {
                self.at += 1;
                Ok(Expr::Text(text))
            }
            Token::Word(word) => {
                self.at += 1;
                if self.sign("#") {
                    return Ok(Expr::Typed(word, Box::new(self.unary()?)));
                }
                if self.sign("(") {
                    return Ok(Expr::Call(word, self.list(")")?));
                }
                if word == "TRUE" || word == "FALSE" {
                    return Ok(Expr::Name(word));
                }
                self.at -= 1;
                let name = self.name()?;
                if self.sign("[") {
                    return Ok(Expr::Index(name, self.list("]")?));
                }
                Ok(Expr::Name(name))
            }
            _ => Err(self.unexpected("a value")),
        }
    }
}
