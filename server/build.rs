//! Lists the files of `hmi/` as a table that `hmi::assets` includes: the server carries its web page with it.
//!
//! A file's name in the table is its path below `hmi/`, with `/` between folders. Hidden files are left out.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs, io};

fn main() -> io::Result<()> {
    println!("cargo::rerun-if-changed=hmi");
    println!("cargo::rerun-if-changed=build.rs");
    let of = |name: &str| env::var_os(name).map(PathBuf::from).unwrap_or_default();
    let folder = of("CARGO_MANIFEST_DIR").join("hmi");
    let mut files = Vec::new();
    collect(&folder, String::new(), &mut files)?;
    files.sort();
    let mut table = String::from("&[\n");
    for (name, path) in &files {
        // Writing to a String cannot fail.
        let _ = writeln!(table, "    ({name:?}, include_bytes!({path:?}).as_slice()),");
    }
    table.push_str("]\n");
    fs::write(of("OUT_DIR").join("assets.rs"), table)
}

fn collect(folder: &Path, prefix: String, files: &mut Vec<(String, PathBuf)>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let name = entry.file_name().to_string_lossy().into_owned();
        if name.starts_with('.') {
            continue;
        }
        if entry.file_type()?.is_dir() {
            collect(&entry.path(), format!("{prefix}{name}/"), files)?;
        } else {
            files.push((format!("{prefix}{name}"), entry.path()));
        }
    }
    Ok(())
}
