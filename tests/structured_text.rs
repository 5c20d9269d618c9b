//! Controllers as Structured Text and PLCopen XML, run by an interpreter that is written from IEC 61131-3 and shares no code with
//! what writes them.

#[path = "structured_text/compiler.rs"]
mod compiler;
#[path = "structured_text/document.rs"]
mod document;
#[path = "structured_text/expressions.rs"]
mod expressions;
#[path = "structured_text/hostile.rs"]
mod hostile;
#[path = "structured_text/interpreter.rs"]
mod interpreter;
#[path = "structured_text/lexer.rs"]
mod lexer;
#[path = "structured_text/library.rs"]
mod library;
#[path = "structured_text/mutated.rs"]
mod mutated;
#[path = "structured_text/others.rs"]
mod others;
#[path = "structured_text/play.rs"]
mod play;
#[path = "structured_text/played.rs"]
mod played;
#[path = "structured_text/plcopen.rs"]
mod plcopen;
#[path = "structured_text/rules.rs"]
mod rules;
#[path = "structured_text/statements.rs"]
mod statements;
#[path = "support/mod.rs"]
mod support;
#[path = "structured_text/syntax.rs"]
mod syntax;
#[path = "order_monitor/unit.rs"]
mod unit;
#[path = "structured_text/wide.rs"]
mod wide;
#[path = "structured_text/written.rs"]
mod written;
