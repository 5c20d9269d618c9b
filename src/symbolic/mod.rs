//! The only module that knows a BDD package.
