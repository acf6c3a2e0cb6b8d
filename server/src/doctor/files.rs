//! Checks of the files that a server reads and writes beside its configuration: those of `[security]`, the retained state, the audit.

use std::fs::{self, OpenOptions};
use std::io::{self, ErrorKind};
use std::path::Path;

use arcline_config::Security;
use arcline_state::{LockedFile, OpenError};

use super::{Finding, Grade};
use crate::audit;
use crate::tls::Tls;
use crate::users::Users;

/// Reads the files of `[security]`; relative names begin at the folder of the configuration.
pub(super) fn security(security: &Security, folder: &Path) -> Vec<Finding> {
    let mut findings = Vec::new();
    if security.tls.or(security.hmi_tls).is_some() {
        findings.push(match Tls::check(security, folder) {
            Ok(()) => Finding::ok("certificates", "key and certificates can be used"),
            Err(error) => Finding::new(
                "certificates",
                Grade::Failed,
                error.to_string(),
                "`arcline-server certs init FOLDER` makes them; the user of the server must be able to read them (docs/SECURITY.md).",
            ),
        });
    }
    if let Some(file) = &security.users {
        findings.push(match Users::read(&folder.join(file)) {
            Ok(users) => Finding::ok("users", format!("{file}: {} users", users.users.len())),
            Err(error) => Finding::new(
                "users",
                Grade::Failed,
                error.to_string(),
                "`arcline-server users add FILE NAME --role ROLE` makes the file; the user of the server must be able to read it.",
            ),
        });
    }
    findings
}

/// Checks that the server can use the file of the retained state.
pub(super) fn state(file: &Path) -> Finding {
    let failed = |error: &OpenError, remedy: &str| {
        let found = format!("{}: {error}", file.display());
        Finding::new("state", Grade::Failed, found, remedy)
    };
    let found = LockedFile::examine(file);
    let found = found.and_then(|file| {
        let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty());
        probe(folder.unwrap_or(Path::new(".")))?;
        Ok(file)
    });
    match found {
        Ok(file) => Finding::ok("state", format!("{} can be written", file.display())),
        Err(error @ OpenError::InUse) => failed(&error, "Stop that server, or choose another file (--state)."),
        Err(error @ OpenError::NotAFile) => failed(&error, "Name a file, such as /var/lib/arcline/state."),
        Err(error @ OpenError::Io(_)) => failed(
            &error,
            "Make the folder and give it to the user of the server: install -d -o arcline FOLDER; under systemd StateDirectory=arcline does it.",
        ),
    }
}

/// Checks that the server can write the audit, which has a folder beside the file of the state; `None`: it makes this folder.
pub(super) fn audit(state: &Path) -> Option<Finding> {
    let folder = audit::folder_of(state);
    fs::symlink_metadata(&folder).ok()?;
    Some(match probe(&folder) {
        Ok(()) => Finding::ok("audit", format!("{} can be written", folder.display())),
        Err(error) => Finding::new(
            "audit",
            Grade::Failed,
            format!("{}: {error}", folder.display()),
            "Give the folder to the user of the server: chown -R arcline FOLDER; or choose another one (--audit).",
        ),
    })
}

/// Makes a file in a folder and removes it. It follows no link, and touches no file that is there.
fn probe(folder: &Path) -> io::Result<()> {
    let mut tries = 0..100;
    loop {
        let number = tries.next().ok_or(ErrorKind::AlreadyExists)?;
        let name = folder.join(format!(".arcline-doctor-{}-{number}", std::process::id()));
        match OpenOptions::new().write(true).create_new(true).open(&name) {
            Ok(_) => return fs::remove_file(name),
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error),
        }
    }
}
