//! Recipes on layouts of resources: whether a cell can make a product, and how.
//!
//! The model is that of L. de Silva et al., "Synthesising process controllers from formal models
//! of transformable assembly systems", RCIM 58 (2019), 130-144. A *layout* is a set of resources;
//! each is a labelled transition system whose transitions are operations on parts, internal
//! operations, or transfers of a part to or from another resource. A *recipe* is a graph of
//! operations, with tests where it branches.
//!
//! - [`model`] has the two, their validation, and the duplication of a resource.
//! - [`topology`] has the reachable synchronous product of the resources, without parts.
//! - [`realize`] decides whether a recipe can be made on a layout, without the topology.
//! - [`controller`] has the result of that decision.
//! - [`plan`] plans several products at once, with least steps, time, energy or transfers.
//! - [`jobshop`] finds schedules of least makespan where buffers are ample.
//! - [`repair`] finds the smallest changes of a layout that make a recipe realizable.
//! - [`run`] carries a plan out, with the durations and outcomes of tests that occur.
//! - [`replay`] and [`replay_plan`] verify controllers and plans with code of their own.
//!
//! In each *vector*, a resource takes one transition or waits where its state permits. A transfer
//! takes a part from one resource to another, with the same label at both. The operations of a
//! vector are all those of one step of the recipe, or none. A test takes no vector and changes
//! nothing.

pub mod controller;
mod intern;
pub mod jobshop;
pub mod model;
pub mod plan;
pub mod realize;
pub mod repair;
pub mod replay;
pub mod replay_plan;
pub mod run;
pub mod topology;
