//! The program of `tests/libplctag`, a package of its own because it builds libplctag from C.

use std::net::SocketAddr;
use std::path::PathBuf;
use std::process::Command;
use std::time::Duration;

use crate::foreign::{self, Store};

/// The longest build of libplctag on a slow machine.
const BUILD: Duration = Duration::from_secs(900);

/// The program, built.
pub struct Libplctag {
    target: PathBuf,
}

impl Libplctag {
    /// Builds the program, if the tools for the build are here.
    ///
    /// # Errors
    /// Names the missing tool on this machine, or the error of the build.
    pub fn build() -> Result<Self, String> {
        for (program, package) in [("cmake", "cmake"), ("cc", "gcc")] {
            Command::new(program).arg("--version").output().map_err(|error| {
                format!("{program} cannot be started ({error}); install Debian's package {package}")
            })?;
        }
        if !has_libclang() {
            return Err("libclang is missing; install Debian's package libclang-dev".to_owned());
        }
        let store = Store::open("libplctag")?;
        let client = Self {
            target: store.folder().to_owned(),
        };
        foreign::attempt("cargo build", &mut client.cargo("build"), BUILD)?;
        Ok(client)
    }

    /// Runs it to its end and returns its output.
    ///
    /// # Panics
    /// As [`foreign::run`].
    #[must_use]
    pub fn run(&self, arguments: &[&str]) -> String {
        // `cargo run` lets the program find the shared library that was built with it.
        foreign::run("arcline-libplctag", self.cargo("run").arg("--").args(arguments))
    }

    /// Jogs the axis S of a server until its process is killed.
    #[must_use]
    pub fn jog(&self, server: SocketAddr) -> Command {
        let mut command = self.cargo("run");
        // On Unix `cargo run` becomes the program: it is the same process.
        command.arg("--").arg(server.to_string()).arg("jog");
        command
    }

    fn cargo(&self, command: &str) -> Command {
        let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
        // The sanitizers of a debug build of libplctag would have to be loaded before the program.
        cargo
            .args([command, "--release", "--quiet", "--locked", "--manifest-path"])
            .arg(crate::fixture("libplctag/Cargo.toml"))
            .arg("--target-dir")
            .arg(&self.target);
        cargo
    }
}

/// Whether the loader or `llvm-config` knows a libclang; the crate's build script looks for it in the same way.
fn has_libclang() -> bool {
    let names_it = |program: &str, argument: &str| {
        Command::new(program)
            .arg(argument)
            .output()
            .is_ok_and(|output| String::from_utf8_lossy(&output.stdout).contains("libclang"))
    };
    let in_folder = |folder: &std::path::Path| {
        std::fs::read_dir(folder).is_ok_and(|mut files| {
            files.any(|file| file.is_ok_and(|file| file.file_name().to_string_lossy().starts_with("libclang")))
        })
    };
    if std::env::var_os("LIBCLANG_PATH").is_some() || names_it("ldconfig", "-p") {
        return true;
    }
    std::fs::read_dir("/usr/lib").is_ok_and(|mut folders| {
        folders.any(|folder| {
            folder.is_ok_and(|folder| {
                folder.file_name().to_string_lossy().starts_with("llvm-") && in_folder(&folder.path().join("lib"))
            })
        })
    })
}
