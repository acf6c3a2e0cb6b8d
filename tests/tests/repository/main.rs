//! Rules for the repository itself: which crate may use which, and that what code cites is there.

mod architecture;
mod campaign;
mod doc_tests;
mod imports;
mod readme;
mod security;
mod specification;
