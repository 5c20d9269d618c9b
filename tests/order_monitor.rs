//! Monitors of skill orders: the one of this process, the one in C and the one in Structured Text say the same, call by call.

#[path = "order_monitor/automata.rs"]
mod automata;
#[path = "order_monitor/c.rs"]
mod c;
#[path = "structured_text/compiler.rs"]
mod compiler;
#[path = "structured_text/document.rs"]
mod document;
#[path = "structured_text/expressions.rs"]
mod expressions;
#[expect(
    dead_code,
    reason = "what is kept of a controller is compared elsewhere"
)]
#[path = "structured_text/interpreter.rs"]
mod interpreter;
#[path = "structured_text/lexer.rs"]
mod lexer;
#[expect(dead_code, reason = "tables need its random numbers only")]
#[path = "oracle/random.rs"]
mod random;
#[path = "order_monitor/reference.rs"]
mod reference;
#[path = "order_monitor/rust.rs"]
mod rust;
#[path = "structured_text/statements.rs"]
mod statements;
#[path = "order_monitor/structured_text.rs"]
mod structured_text;
#[path = "structured_text/syntax.rs"]
mod syntax;
#[path = "order_monitor/tables.rs"]
mod tables;
#[path = "order_monitor/unit.rs"]
mod unit;
