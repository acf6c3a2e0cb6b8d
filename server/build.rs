//! Lists the files of the page as a table that `hmi::assets` includes: the server carries its web page with it.
//!
//! The sources of the page are in `web/` at the top of the repository; [`PAGE`] names those that a browser loads. A file's name in the
//! table is its path below `web/`, with `/` between folders. Hidden files are left out.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs, io};

/// Files and folders of `web/` that a browser loads; the others are its tests and the settings of its tools.
const PAGE: [&str; 4] = ["css", "icon.svg", "index.html", "js"];

fn main() -> io::Result<()> {
    println!("cargo::rerun-if-changed=build.rs");
    let of = |name: &str| env::var_os(name).map(PathBuf::from).unwrap_or_default();
    let web = of("CARGO_MANIFEST_DIR").join("../web").canonicalize()?;
    let mut files = Vec::new();
    for part in PAGE {
        let path = web.join(part);
        println!("cargo::rerun-if-changed={}", path.display());
        if path.is_dir() {
            collect(&path, format!("{part}/"), &mut files)?;
        } else {
            files.push((part.to_owned(), path));
        }
    }
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
