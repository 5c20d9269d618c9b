//! Documents of B2MML: what is written is read again as it was and is valid; what other programs
//! write; what is wrong; mutated documents.

mod foreign;
mod invalid;
mod mutated;
mod names;
mod page;
mod round_trips;
mod schema;
mod support;
mod wrong;
