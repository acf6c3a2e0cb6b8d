//! The dependency rule of ARCHITECTURE.md, checked against the packages that Cargo links.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use cargo_metadata::{DependencyKind, Metadata, MetadataCommand, PackageId};

/// Every package and the packages that it may name itself; it may also use the packages that those may use.
#[rustfmt::skip]
const MAY_USE: &[(&str, &[&str])] = &[
    ("arcline-tag",             &[]),
    ("arcline-geometry",        &[]),
    ("arcline-kinematics",      &["arcline-geometry", "arcline-profile"]),
    ("arcline-profile",         &[]),
    ("arcline-cam",             &[]),
    ("arcline-contour",         &["arcline-geometry", "arcline-profile"]),
    ("arcline-drive",           &["arcline-profile", "arcline-instruction-set"]),
    ("arcline-proto",           &["arcline-tag"]),
    ("arcline-instruction-set", &["arcline-tag"]),
    ("arcline-structured-text", &["arcline-instruction-set", "arcline-tag"]),
    ("arcline-planner",         &["arcline-geometry", "arcline-profile", "arcline-contour"]),
    ("arcline-motion",          &["arcline-planner", "arcline-cam", "arcline-kinematics", "arcline-drive",
                                  "arcline-instruction-set"]),
    ("arcline-controller",      &["arcline-motion"]),
    ("arcline-realtime",        &["arcline-controller"]),
    ("arcline-config",          &["arcline-controller"]),
    ("arcline-simulation",      &["arcline-config", "arcline-structured-text"]),
    ("arcline-mcap",            &[]),
    ("arcline-cases",           &["arcline-simulation", "arcline-mcap"]),
    ("arcline-routine",         &["arcline-instruction-set", "arcline-tag"]),
    ("arcline-l5x",             &["arcline-config", "arcline-routine"]),
    ("arcline-cell",            &["arcline-simulation", "arcline-routine"]),
    ("arcline-state",           &[]),
    ("arcline-gcode",           &[]),
    ("arcline-plot",            &[]),
    ("arcline-testing",         &[]),
    ("arcline-client",          &["arcline-proto", "arcline-structured-text", "arcline-instruction-set", "arcline-tag",
                                  "arcline-gcode", "arcline-mcap", "arcline-plot"]),
    ("arcline-server",          &["arcline-realtime", "arcline-simulation", "arcline-cases", "arcline-cell", "arcline-l5x",
                                  "arcline-state", "arcline-proto", "arcline-structured-text", "arcline-routine"]),
    ("arcline-shared-features", &[]),
    ("arcline-python",          &["arcline-cases", "arcline-cell", "arcline-l5x", "arcline-shared-features"]),
    ("arcline-fmu",             &["arcline-simulation", "arcline-shared-features"]),
];

/// Packages below the real-time thread: no thread, clock, file, socket or log.
const BEFORE_REALTIME: &[&str] = &[
    "arcline-tag",
    "arcline-instruction-set",
    "arcline-structured-text",
    "arcline-routine",
    "arcline-geometry",
    "arcline-kinematics",
    "arcline-profile",
    "arcline-cam",
    "arcline-contour",
    "arcline-planner",
    "arcline-drive",
    "arcline-motion",
    "arcline-controller",
    "arcline-config",
    "arcline-simulation",
    "arcline-cell",
    "arcline-proto",
    "arcline-gcode",
];

/// Packages that would give them a thread, clock, file, socket or log.
const FORBIDDEN_BEFORE_REALTIME: &[&str] = &[
    "tokio",
    "tokio-util",
    "async-std",
    "smol",
    "mio",
    "socket2",
    "rustix",
    "nix",
    "libc",
    "tracing",
    "log",
    "tracing-subscriber",
    "rand",
    "chrono",
    "time",
    "crossbeam-channel",
    "parking_lot",
    "rayon",
];

/// The files of `server/src` with each source of chance: code that a simulation must not run is behind a seam there, or belongs to a program
/// that is not simulated (spec/reliability.md §4). `Instant::now` of tokio is no such source: its clock may be paused.
#[rustfmt::skip]
const CHANCE: &[(&str, &[&str], &[&str])] = &[
    ("a clock that is not the runtime's", &["std::time::Instant::now", "Instant::now"],
     &["health.rs", "hmi/preview.rs", "live/host.rs", "live/scanner.rs", "retained/state_writer.rs", "simulate/cell.rs",
       "simulate/mod.rs"]),
    ("the clock on the wall", &["SystemTime::now"],
     &["audit/file.rs", "audit/mod.rs", "live/host.rs", "plant/wall_clock.rs", "tls/mod.rs"]),
    ("random numbers", &["getrandom::"],
     &["audit/file.rs", "eip/datagram.rs", "eip/device.rs", "tls/certs.rs", "users/command.rs"]),
    ("threads", &["thread::Builder", "thread::spawn", "thread::scope", "thread::sleep"],
     &["audit/mod.rs", "doctor/real_time.rs", "eip/io/thread.rs", "guard/mod.rs", "live/mod.rs", "plant/looks.rs", "retained/state_writer.rs",
       "run.rs", "simulate/cell.rs", "trace/mod.rs"]),
    ("threads of the runtime", &["spawn_blocking"], &["hmi/preview.rs", "hmi/sessions/mod.rs", "hmi/workers.rs", "plant/looks.rs", "work_threads.rs"]),
    ("receivers that wake in a random order", &["tokio::sync::watch", ", watch}"], &[]),
    ("sockets", &["tokio::net"],
     &["eip/connection.rs", "eip/datagram.rs", "eip/listener.rs", "guard/watch.rs", "hmi/mod.rs", "hmi/serve.rs", "hmi/socket.rs",
       "tls/mod.rs"]),
];

fn metadata() -> Metadata {
    MetadataCommand::new()
        .manifest_path(arcline_tests::workspace().join("Cargo.toml"))
        .other_options(["--locked".to_owned()])
        .exec()
        .expect("cargo metadata describes the workspace")
}

/// Names of the normal dependencies of each package that Cargo has resolved.
fn normal_dependencies(metadata: &Metadata) -> BTreeMap<&PackageId, Vec<&PackageId>> {
    let resolve = metadata.resolve.as_ref().expect("cargo metadata resolves");
    resolve
        .nodes
        .iter()
        .map(|node| {
            let dependencies = node
                .deps
                .iter()
                .filter(|dependency| {
                    dependency
                        .dep_kinds
                        .iter()
                        .any(|kind| kind.kind == DependencyKind::Normal)
                })
                .map(|dependency| &dependency.pkg);
            (&node.id, dependencies.collect())
        })
        .collect()
}

fn name<'m>(metadata: &'m Metadata, id: &PackageId) -> &'m str {
    metadata[id].name.as_str()
}

/// Everything that the table lets a package use.
fn allowed(package: &str) -> BTreeSet<&'static str> {
    let (_, direct) = MAY_USE
        .iter()
        .find(|(name, _)| *name == package)
        .unwrap_or_else(|| panic!("{package} has no row in the table of this test"));
    direct
        .iter()
        .flat_map(|name| allowed(name).into_iter().chain([*name]))
        .collect()
}

#[test]
fn arrows_run_one_way() {
    let metadata = metadata();
    let dependencies = normal_dependencies(&metadata);
    for package in metadata.workspace_packages() {
        let package_name = package.name.as_str();
        if [
            "arcline-tests",
            "arcline-system-tests",
            "arcline-benchmarks",
            "arcline-sim",
        ]
        .contains(&package_name)
        {
            continue;
        }
        let allowed = allowed(package_name);
        for dependency in &dependencies[&package.id] {
            let dependency = name(&metadata, dependency);
            assert!(
                !dependency.starts_with("arcline-") || allowed.contains(dependency),
                "{package_name} must not use {dependency}: the table allows it {allowed:?}"
            );
        }
    }
}

/// The Rust files below a folder but those of tests, by their path in it, and their code without comments and test modules.
fn sources(folder: &Path) -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    let mut todo = vec![folder.to_owned()];
    while let Some(next) = todo.pop() {
        for entry in std::fs::read_dir(&next).expect("a folder of sources") {
            let path = entry.expect("an entry").path();
            let name = path
                .strip_prefix(folder)
                .expect("it is below")
                .to_string_lossy()
                .into_owned();
            let is_test = name.ends_with("tests.rs") || name.split('/').any(|part| part == "tests");
            if is_test {
                continue;
            }
            if path.is_dir() {
                todo.push(path);
            } else if name.ends_with(".rs") {
                let text = std::fs::read_to_string(&path).expect("it is text");
                let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
                let lines = code.lines().filter(|line| !line.trim_start().starts_with("//"));
                found.insert(name, lines.collect::<Vec<_>>().join("\n"));
            }
        }
    }
    found
}

/// Whether `Instant` is tokio's in a file.
fn has_instant_of_tokio(code: &str) -> bool {
    let uses = code
        .lines()
        .filter_map(|line| line.trim().strip_prefix("use tokio::time::"));
    uses.flat_map(|names| names.split(|letter: char| !letter.is_alphanumeric()))
        .any(|name| name == "Instant")
}

#[test]
fn sources_of_chance_stand_behind_the_seams_of_the_simulation() {
    let sources = sources(&arcline_tests::workspace().join("server/src"));
    for (what, words, files) in CHANCE {
        let has = |code: &str| {
            words.iter().any(|word| {
                let is_of_runtime = *word == "Instant::now" && has_instant_of_tokio(code);
                code.contains(word) && !is_of_runtime
            })
        };
        let found: BTreeSet<&str> = sources
            .iter()
            .filter(|(_, code)| has(code))
            .map(|(name, _)| name.as_str())
            .collect();
        let named: BTreeSet<&str> = files.iter().copied().collect();
        assert_eq!(
            found, named,
            "{what}: the files with {words:?}, and those that the table names"
        );
    }
}

#[test]
fn every_row_of_the_table_is_a_package() {
    let metadata = metadata();
    let packages: BTreeSet<_> = metadata
        .workspace_packages()
        .iter()
        .map(|package| package.name.to_string())
        .collect();
    for (row, _) in MAY_USE {
        assert!(
            packages.contains(*row),
            "{row} stands in the table but not in the workspace"
        );
    }
}

#[test]
fn nothing_before_the_real_time_thread_reaches_the_system() {
    let metadata = metadata();
    let dependencies = normal_dependencies(&metadata);
    for package in metadata.workspace_packages() {
        if !BEFORE_REALTIME.contains(&package.name.as_str()) {
            continue;
        }
        let mut reached = BTreeMap::from([(&package.id, package.name.to_string())]);
        let mut todo = vec![&package.id];
        while let Some(next) = todo.pop() {
            for dependency in &dependencies[next] {
                if !reached.contains_key(dependency) {
                    let way = format!("{} -> {}", reached[next], name(&metadata, dependency));
                    reached.insert(dependency, way);
                    todo.push(dependency);
                }
            }
        }
        for (id, way) in reached {
            let reached = name(&metadata, id);
            assert!(!FORBIDDEN_BEFORE_REALTIME.contains(&reached), "{}: {way}", package.name);
        }
    }
}

#[test]
fn every_dependency_has_its_reason() {
    let metadata = metadata();
    let text = std::fs::read_to_string(arcline_tests::workspace().join("docs/DEPENDENCIES.md"))
        .expect("docs/DEPENDENCIES.md can be read");
    let listed: BTreeSet<&str> = text
        .lines()
        .filter_map(|line| line.strip_prefix("| `")?.split('`').next())
        .collect();
    let packages = metadata.workspace_packages();
    let named: BTreeSet<&str> = packages
        .iter()
        // Its crates are there anyway, and it uses none of them.
        .filter(|package| package.name.as_str() != "arcline-shared-features")
        .flat_map(|package| package.dependencies.iter())
        .map(|dependency| dependency.name.as_str())
        .filter(|name| !name.starts_with("arcline-"))
        .collect();
    let without_reason: Vec<_> = named.difference(&listed).collect();
    let unused: Vec<_> = listed.difference(&named).collect();
    assert!(
        without_reason.is_empty(),
        "docs/DEPENDENCIES.md gives no reason for {without_reason:?}"
    );
    assert!(
        unused.is_empty(),
        "docs/DEPENDENCIES.md lists {unused:?}, which no package uses"
    );
}

#[test]
fn properties_take_the_same_cases_in_every_run() {
    let seed = std::env::var("PROPTEST_RNG_SEED")
        .ok()
        .and_then(|seed| seed.parse::<u64>().ok());
    assert!(
        seed.is_some(),
        "cargo sets PROPTEST_RNG_SEED from .cargo/config.toml for every test that it starts"
    );
}

/// `cargo` chooses such versions when it resolves; an update by hand may not. `.ci/run minimum_rust` builds with that Rust where it is
/// installed.
#[test]
fn no_dependency_needs_a_newer_rust_than_the_workspace_promises() {
    let metadata = metadata();
    let promised = metadata.workspace_packages()[0].rust_version.clone();
    let promised = promised.expect("the workspace promises a version");
    for package in &metadata.packages {
        let needed = package.rust_version.as_ref();
        assert!(
            needed.is_none_or(|needed| *needed <= promised),
            "{} {} needs Rust {needed:?}, the workspace promises {promised}",
            package.name,
            package.version
        );
    }
}

#[test]
fn every_package_has_a_description() {
    for package in metadata().workspace_packages() {
        let description = package.description.as_deref().unwrap_or_default();
        assert!(description.len() > 20, "{}: {description:?}", package.name);
        let is_test =
            package.name.ends_with("tests") || ["arcline-benchmarks", "arcline-sim"].contains(&package.name.as_str());
        assert!(
            is_test || !package.keywords.is_empty() && package.keywords.len() <= 5 && !package.categories.is_empty(),
            "{} has one to five keywords, and categories",
            package.name
        );
    }
}
