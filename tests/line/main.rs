//! Lines: the runner, their proofs, and attacks on what is proved.

mod attack;
mod calls;
mod choices;
mod distributions;
mod logs;
mod models;
#[path = "../algebra/discharge/mutants.rs"]
mod mutants;
mod oracles;
mod proof;
#[path = "../program/hostile/reduce.rs"]
mod reduce;
mod runner;
mod simpy;
#[path = "../support/mod.rs"]
mod support;
#[path = "../algebra/discharge/tables.rs"]
mod tables;
mod uncontrolled;
