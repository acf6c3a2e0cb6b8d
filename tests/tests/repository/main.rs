//! Rules for the repository itself: the permitted dependencies of each crate, and the existence of cited pages.

mod architecture;
mod campaign;
mod doc_tests;
mod features;
mod imports;
mod readme;
mod security;
mod specification;
