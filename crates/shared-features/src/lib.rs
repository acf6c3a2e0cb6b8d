//! No code: `Cargo.toml` asks for the features of crates of others that the whole workspace asks for, so that a package built by
//! itself takes what was built for all.
