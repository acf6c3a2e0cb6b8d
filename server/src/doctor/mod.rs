//! `doctor`: examines the ports, rights and real-time settings of this computer, and reports each defect with its remedy (docs/DOCTOR.md).

mod files;
mod network;
mod real_time;
mod system;
#[cfg(test)]
mod tests;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use arcline_config::Security;
use clap::Args;
use serde::Serialize;
use serde_json::json;

use crate::cli::{Failure, read};
use system::System;

/// Flags of `doctor`.
#[derive(Args, Debug)]
pub(crate) struct DoctorArgs {
    /// The configuration of the server; without it the embedded default.
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// The file that the server is to keep its state in.
    #[arg(long, value_name = "FILE")]
    state: Option<PathBuf>,
    /// Seconds for which ticks are measured.
    #[arg(long, value_name = "SECONDS", default_value = "2", value_parser = measured)]
    measure: f64,
    /// Print the result as one JSON object.
    #[arg(long)]
    json: bool,
}

/// What a server could not use of the files of `[security]`; relative names begin at `folder`.
pub(crate) fn defects_of_security(security: &Security, folder: &Path) -> impl Iterator<Item = Finding> {
    files::security(security, folder)
        .into_iter()
        .filter(|finding| finding.grade != Grade::Ok)
}

/// The value of --measure.
fn measured(text: &str) -> Result<f64, String> {
    let seconds = crate::cli::seconds(text)?;
    if seconds > LONGEST {
        return Err(format!("expected {LONGEST} seconds at most"));
    }
    Ok(seconds)
}

/// The longest measurement, s: a day.
const LONGEST: f64 = 86_400.0;

/// The result of a check, the better first.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Grade {
    /// No defect.
    Ok,
    /// A server runs, but ticks may be late, or a function may fail later.
    Warning,
    /// A server does not start.
    Failed,
}

/// The result of one check.
#[derive(Clone, PartialEq, Eq, Debug, Serialize)]
pub(crate) struct Finding {
    /// The name of the check.
    pub(crate) check: &'static str,
    pub(crate) grade: Grade,
    /// The result of the check in words.
    pub(crate) found: String,
    /// The remedy; empty if the user need not do anything.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub(crate) remedy: String,
}

impl Finding {
    pub(crate) fn ok(check: &'static str, found: impl Into<String>) -> Self {
        Self::new(check, Grade::Ok, found, "")
    }

    pub(crate) fn new(check: &'static str, grade: Grade, found: impl Into<String>, remedy: impl Into<String>) -> Self {
        Finding {
            check,
            grade,
            found: found.into(),
            remedy: remedy.into(),
        }
    }
}

/// Makes all checks. The exit code is 0 without a defect, 1 with a warning, and 2 if a server would not start.
pub(crate) fn run(args: &DoctorArgs) -> Result<ExitCode, Failure> {
    let findings = findings(args)?;
    let worst = findings.iter().map(|finding| finding.grade).max().unwrap_or(Grade::Ok);
    if args.json {
        let result = json!({"worst": worst, "version": env!("CARGO_PKG_VERSION"), "checks": findings});
        crate::cli::print(&format!("{result}\n"))?;
    } else {
        crate::cli::print(&text(&findings))?;
    }
    Ok(ExitCode::from(worst as u8))
}

fn findings(args: &DoctorArgs) -> Result<Vec<Finding>, Failure> {
    let (text, file) = read(args.config.as_deref())?;
    let project = match arcline_config::load(&text, &file) {
        Ok(project) => project,
        Err(error) => {
            let remedy = "Correct it; `arcline-server check --config FILE` tells all errors.";
            return Ok(vec![Finding::new(
                "configuration",
                Grade::Failed,
                error.to_string(),
                remedy,
            )]);
        }
    };
    let machine = &project.machine;
    let axes = machine.axes.len();
    let mut findings = vec![Finding::ok("configuration", format!("{file}: {axes} axes, valid"))];
    findings.extend(network::ports(&project.server));
    findings.push(system::descriptors(project.server.max_clients));
    let folder = args.config.as_deref().and_then(Path::parent);
    let security = &project.server.security;
    findings.extend(files::security(security, folder.unwrap_or(Path::new(""))));
    if let Some(state) = &args.state {
        findings.push(files::state(state));
        findings.extend(security.is_given.then(|| files::audit(state)).flatten());
    }
    let system = System::of_this_computer();
    findings.extend([
        system.processors(),
        system.kernel(),
        system.real_time_share(),
        system.clock_source(),
        system.governor(),
        system.swap(),
    ]);
    findings.extend(real_time::measure(machine, args.measure)?);
    Ok(findings)
}

/// A line of each check, and its remedy below.
fn text(findings: &[Finding]) -> String {
    let width = findings.iter().map(|finding| finding.check.len()).max().unwrap_or(0);
    let mut text = String::new();
    for Finding {
        check,
        grade,
        found,
        remedy,
    } in findings
    {
        let word = match grade {
            Grade::Ok => "ok",
            Grade::Warning => "warning",
            Grade::Failed => "FAILED",
        };
        let _ = writeln!(text, "{word:<8} {check:<width$}  {found}");
        if !remedy.is_empty() {
            let _ = writeln!(text, "{:<8} {:<width$}  -> {remedy}", "", "");
        }
    }
    let count = |grade| findings.iter().filter(|finding| finding.grade == grade).count();
    let _ = match (count(Grade::Failed), count(Grade::Warning)) {
        (0, 0) => writeln!(text, "Nothing is amiss."),
        (0, warnings) => writeln!(text, "A server starts here; {warnings} warnings."),
        (failed, warnings) => writeln!(
            text,
            "A server does not start here: {failed} failed, {warnings} warnings."
        ),
    };
    text
}
