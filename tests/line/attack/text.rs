//! Text with blocks, and random choices.

use linewright::line::random::Stream;

/// Choices, all from one seed.
pub struct Chance(Stream);

impl Chance {
    pub fn new(seed: u64) -> Self {
        Self(Stream::from_seed(seed))
    }

    /// A number from 0 to `count - 1`.
    pub fn below(&mut self, count: usize) -> usize {
        self.0.below(count.max(1) as u64) as usize
    }

    pub fn percent(&mut self, percent: usize) -> bool {
        self.below(100) < percent
    }

    pub fn pick<'a>(&mut self, list: &[&'a str]) -> &'a str {
        list[self.below(list.len())]
    }
}

/// Declarations, one per line, indented.
#[derive(Debug, Default)]
pub struct Text(pub String);

impl Text {
    pub fn open(&mut self, head: &str) {
        self.line(&format!("{head} {{"));
    }

    pub fn close(&mut self) {
        self.line("}");
    }

    pub fn line(&mut self, line: &str) {
        let depth = |c| self.0.matches(c).count();
        let depth = depth('{') - depth('}') - usize::from(line == "}");
        self.0.push_str(&"    ".repeat(depth));
        self.0.push_str(line);
        self.0.push('\n');
    }
}
