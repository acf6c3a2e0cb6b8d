//! `arcline-server import` and `export`: they read and write the files for `arcline-l5x`, and print its findings.

use std::io::Read as _;
use std::path::Path;
use std::process::ExitCode;

use arcline_routine::{Finding, Line};

use crate::cli::{ExportArgs, Failure, ImportArgs, print, project};
use crate::simulate;

/// Turns an L5X file into a configuration. The findings of the import go to standard error.
pub(crate) fn import(args: &ImportArgs) -> Result<ExitCode, Failure> {
    let file = args.file.display().to_string();
    let text = read(&args.file)?;
    if args.report {
        return report(args, &text);
    }
    let import = arcline_l5x::import(&text, &file).map_err(|error| Failure::usage(error.to_string()))?;
    write(args.output.as_deref(), &arcline_config::format(&import.config))?;
    if import.report.is_empty() {
        return Ok(ExitCode::SUCCESS);
    }
    eprint!(
        "{file}: {} items were left out or changed\n{}",
        import.report.count(),
        import.report
    );
    Ok(ExitCode::from(u8::from(args.strict)))
}

/// The text of an L5X file.
pub(crate) fn read(path: &Path) -> Result<String, Failure> {
    let file = path.display().to_string();
    let unreadable = |error: String| Failure::usage(format!("{file}: cannot be read: {error}"));
    let mut bytes = Vec::new();
    // One byte more than the limit: the importer reports that the file is too long.
    let most = arcline_l5x::MAX_TEXT as u64 + 1;
    let open = std::fs::File::open(path).map_err(|error| unreadable(error.to_string()))?;
    open.take(most)
        .read_to_end(&mut bytes)
        .map_err(|error| unreadable(error.to_string()))?;
    String::from_utf8(bytes).map_err(|error| {
        let before = error.as_bytes().iter().take(error.utf8_error().valid_up_to());
        let line = before.filter(|byte| **byte == b'\n').count() + 1;
        Failure::usage(format!("{file}:{line}: not UTF-8, expected XML in UTF-8"))
    })
}

/// Lists the parts of a project's program that would not run.
fn report(args: &ImportArgs, text: &str) -> Result<ExitCode, Failure> {
    let file = args.file.display().to_string();
    let findings = simulate::findings(text, &file)?;
    let mut out = String::new();
    for (finding, count) in grouped(&findings) {
        if args.json {
            let (key, number) = match finding.place {
                Some(Line::Rung(number)) => ("rung", Some(number)),
                Some(Line::Text(number)) => ("line", Some(number)),
                None => ("rung", None),
            };
            let object = serde_json::json!({"kind": finding.kind.name(), "name": finding.name, "reason": finding.reason,
                "program": finding.program, "routine": finding.routine, key: number, "count": count});
            out.push_str(&format!("{object}\n"));
        } else {
            let times = if count > 1 {
                format!(" ({count} times)")
            } else {
                String::new()
            };
            out.push_str(&format!("{finding}{times}\n"));
        }
    }
    if !args.json && findings.is_empty() {
        out.push_str("everything runs\n");
    }
    print(&out)
}

/// Each finding once, with the number of those that differ in nothing but the place in a routine.
fn grouped(findings: &[Finding]) -> Vec<(&Finding, usize)> {
    let mut groups: Vec<(&Finding, usize)> = Vec::new();
    for finding in findings {
        let same = |one: &Finding| {
            (one.kind, &one.name, &one.reason, &one.program, &one.routine)
                == (
                    finding.kind,
                    &finding.name,
                    &finding.reason,
                    &finding.program,
                    &finding.routine,
                )
        };
        match groups.iter_mut().find(|(one, _)| same(one)) {
            Some((_, count)) => *count += 1,
            None => groups.push((finding, 1)),
        }
    }
    groups
}

/// Writes a configuration as L5X.
pub(crate) fn export(args: &ExportArgs) -> Result<ExitCode, Failure> {
    let project = project(args.config.as_deref())?;
    write(args.output.as_deref(), &arcline_l5x::export(&project))
}

fn write(output: Option<&Path>, text: &str) -> Result<ExitCode, Failure> {
    let Some(path) = output else { return print(text) };
    std::fs::write(path, text)
        .map_err(|error| Failure::usage(format!("{}: cannot be written: {error}", path.display())))?;
    Ok(ExitCode::SUCCESS)
}
