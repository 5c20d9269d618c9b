//! Past operators and counters, step by step.
