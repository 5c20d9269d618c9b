//! gr1c
