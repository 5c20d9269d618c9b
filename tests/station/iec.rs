//! An interpreter of Structured Text, implemented from IEC 61131-3.

pub mod compiler;
pub mod document;
pub mod expressions;
pub mod interpreter;
pub mod lexer;
pub mod statements;
pub mod syntax;
