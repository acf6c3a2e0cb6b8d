//! `arcline-server users` and `tokens`: the users of the page and the tokens of scripts, in one file.

use std::fmt::Write as _;
use std::io::{self, BufRead as _, IsTerminal as _, Write as _};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use arcline_config::Role;
use clap::{Args, Subcommand};
use rustix::termios::{LocalModes, OptionalActions, tcgetattr, tcsetattr};
use time::{Duration, OffsetDateTime};

use super::{Token, User, Users, UsersError, password};
use crate::audit;
use crate::cli::{Failure, print};

/// The file, which both commands have.
#[derive(Args, Debug)]
pub(crate) struct InFile {
    /// The file of `users` in `[security]`.
    #[arg(value_name = "FILE")]
    file: PathBuf,
}

/// The commands of `users`.
#[derive(Subcommand, Debug)]
pub(crate) enum UsersCommand {
    /// Add a user; the password is asked for, or read from standard input.
    Add {
        #[command(flatten)]
        at: InFile,
        /// The name.
        #[arg(value_name = "NAME", value_parser = name)]
        name: String,
        /// The role of the user.
        #[arg(long, value_name = "ROLE", value_parser = role)]
        role: Role,
    },
    /// Give a user another password; the user's sessions end.
    Passwd {
        #[command(flatten)]
        at: InFile,
        /// The name.
        #[arg(value_name = "NAME")]
        name: String,
    },
    /// Give a user another role, also in open sessions.
    Role {
        #[command(flatten)]
        at: InFile,
        /// The name.
        #[arg(value_name = "NAME")]
        name: String,
        /// The role of the user.
        #[arg(long, value_name = "ROLE", value_parser = role)]
        role: Role,
    },
    /// Let a user not log in for now; the user's sessions end.
    Disable {
        #[command(flatten)]
        at: InFile,
        /// The name.
        #[arg(value_name = "NAME")]
        name: String,
    },
    /// Let a user log in again.
    Enable {
        #[command(flatten)]
        at: InFile,
        /// The name.
        #[arg(value_name = "NAME")]
        name: String,
    },
    /// End the sessions of a user, who can log in again.
    Logout {
        #[command(flatten)]
        at: InFile,
        /// The name.
        #[arg(value_name = "NAME")]
        name: String,
    },
    /// Remove a user; the user's sessions end.
    Remove {
        #[command(flatten)]
        at: InFile,
        /// The name.
        #[arg(value_name = "NAME")]
        name: String,
    },
    /// List the users.
    List {
        #[command(flatten)]
        at: InFile,
    },
}

/// The commands of `tokens`.
#[derive(Subcommand, Debug)]
pub(crate) enum TokensCommand {
    /// Make a token of a script and print it, once.
    Add {
        #[command(flatten)]
        at: InFile,
        /// The name.
        #[arg(value_name = "NAME", value_parser = name)]
        name: String,
        /// The role of the script.
        #[arg(long, value_name = "ROLE", value_parser = role)]
        role: Role,
        /// Days for which the token is valid.
        #[arg(long, value_name = "DAYS", default_value_t = 90, value_parser = clap::value_parser!(u16).range(1..=3650))]
        days: u16,
    },
    /// Remove a token; the connections that showed it end.
    Remove {
        #[command(flatten)]
        at: InFile,
        /// The name.
        #[arg(value_name = "NAME")]
        name: String,
    },
    /// List the tokens.
    List {
        #[command(flatten)]
        at: InFile,
    },
}

/// The reason for which a command failed.
#[derive(Debug, thiserror::Error)]
enum CommandError {
    #[error(transparent)]
    Users(#[from] UsersError),
    #[error("there is no {kind} {name:?}")]
    Unknown { kind: &'static str, name: String },
    #[error("there is a {kind} {name:?} already")]
    Known { kind: &'static str, name: String },
    #[error("the password has {0} characters, expected {least} or more", least = password::LEAST)]
    Short(usize),
    #[error("the password has more than {most} bytes", most = password::MOST)]
    Long,
    #[error("the two passwords differ")]
    Differ,
    #[error("the password is the name of the user")]
    IsName,
    #[error("the password cannot be read: {0}")]
    Input(#[from] io::Error),
    #[error("the password cannot be hashed: {0}")]
    Hash(argon2::password_hash::Error),
    #[error("the system has no random numbers")]
    Random,
}

/// Runs a command of `users`.
pub(crate) fn run_users(command: &UsersCommand) -> Result<ExitCode, Failure> {
    done(match command {
        UsersCommand::Add { at, name, role } => add(&at.file, name, *role),
        UsersCommand::Passwd { at, name } => change(&at.file, name, |user| {
            user.password = new_password(name)?;
            Ok("has another password".to_owned())
        }),
        UsersCommand::Role { at, name, role } => change(&at.file, name, |user| {
            user.role = *role;
            Ok(format!("is {}", role.word()))
        }),
        UsersCommand::Disable { at, name } => change(&at.file, name, |user| {
            user.is_disabled = true;
            Ok("cannot log in any more".to_owned())
        }),
        UsersCommand::Enable { at, name } => change(&at.file, name, |user| {
            user.is_disabled = false;
            Ok("can log in".to_owned())
        }),
        UsersCommand::Logout { at, name } => change(&at.file, name, |user| {
            user.logouts = user.logouts.wrapping_add(1);
            Ok("is logged out".to_owned())
        }),
        UsersCommand::Remove { at, name } => remove(&at.file, "user", name, |users| {
            users.users.retain(|user| user.name != *name);
        }),
        UsersCommand::List { at } => Users::read(&at.file).map_err(CommandError::from).map(|users| {
            users.users.iter().fold(String::new(), |mut out, user| {
                let disabled = if user.is_disabled { "  disabled" } else { "" };
                // Writing to a String cannot fail.
                let _ = writeln!(out, "{:<13}  {}{disabled}", user.role.word(), user.name);
                out
            })
        }),
    })
}

/// Runs a command of `tokens`.
pub(crate) fn run_tokens(command: &TokensCommand) -> Result<ExitCode, Failure> {
    done(match command {
        TokensCommand::Add { at, name, role, days } => add_token(&at.file, name, *role, *days),
        TokensCommand::Remove { at, name } => remove(&at.file, "token", name, |users| {
            users.tokens.retain(|token| token.name != *name);
        }),
        TokensCommand::List { at } => Users::read(&at.file).map_err(CommandError::from).map(|users| {
            users.tokens.iter().fold(String::new(), |mut out, token| {
                let until = OffsetDateTime::from_unix_timestamp(token.until);
                let until = until.map_or_else(|_| token.until.to_string(), |until| until.date().to_string());
                // Writing to a String cannot fail.
                let _ = writeln!(out, "{:<13}  until {until}  {}", token.role.word(), token.name);
                out
            })
        }),
    })
}

fn done(result: Result<String, CommandError>) -> Result<ExitCode, Failure> {
    print(&result.map_err(|error| Failure::usage(error.to_string()))?)
}

/// The file, or none yet.
fn read_or_none(file: &Path) -> Result<Users, UsersError> {
    match Users::read(file) {
        Err(UsersError::File { error, .. }) if error.kind() == io::ErrorKind::NotFound => Ok(Users::default()),
        read => read,
    }
}

fn add(file: &Path, name: &str, role: Role) -> Result<String, CommandError> {
    let mut users = read_or_none(file)?;
    if users.user(name).is_some() {
        return Err(CommandError::Known {
            kind: "user",
            name: name.to_owned(),
        });
    }
    let password = new_password(name)?;
    users.users.push(User {
        name: name.to_owned(),
        role,
        password,
        is_disabled: false,
        logouts: 0,
    });
    users.write(file)?;
    Ok(format!("{}: {name} is {}\n", file.display(), role.word()))
}

fn change(
    file: &Path,
    name: &str,
    change: impl FnOnce(&mut User) -> Result<String, CommandError>,
) -> Result<String, CommandError> {
    let mut users = Users::read(file)?;
    let user = users.users.iter_mut().find(|user| user.name == name);
    let user = user.ok_or_else(|| CommandError::Unknown {
        kind: "user",
        name: name.to_owned(),
    })?;
    let what = change(user)?;
    users.write(file)?;
    Ok(format!("{}: {name} {what}\n", file.display()))
}

/// `drop_row` removes the row of the name.
fn remove(
    file: &Path,
    kind: &'static str,
    name: &str,
    drop_row: impl FnOnce(&mut Users),
) -> Result<String, CommandError> {
    let mut users = Users::read(file)?;
    let before = users.users.len() + users.tokens.len();
    drop_row(&mut users);
    if users.users.len() + users.tokens.len() == before {
        return Err(CommandError::Unknown {
            kind,
            name: name.to_owned(),
        });
    }
    users.write(file)?;
    Ok(format!("{}: the {kind} {name} was removed\n", file.display()))
}

fn add_token(file: &Path, name: &str, role: Role, days: u16) -> Result<String, CommandError> {
    let mut users = read_or_none(file)?;
    if users.tokens.iter().any(|token| token.name == name) {
        return Err(CommandError::Known {
            kind: "token",
            name: name.to_owned(),
        });
    }
    let token = format!("{TOKEN}{}", random_text().ok_or(CommandError::Random)?);
    users.tokens.push(Token {
        name: name.to_owned(),
        role,
        sha256: audit::sha256(&token),
        until: (OffsetDateTime::now_utc() + Duration::days(days.into())).unix_timestamp(),
    });
    users.write(file)?;
    Ok(format!("{token}\n"))
}

/// The beginning of every token, by which tools find one that was published by mistake.
const TOKEN: &str = "arc_";

/// 256 random bits as 43 letters, digits, `-` and `_` (base64url); `None`: the system has none.
pub(crate) fn random_text() -> Option<String> {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_";
    let mut bytes = [0_u8; 33];
    getrandom::fill(bytes.get_mut(..32)?).ok()?;
    let groups = bytes
        .chunks_exact(3)
        .map(|three| three.iter().fold(0, |all, byte| all << 8 | usize::from(*byte)));
    let digits = groups.flat_map(|group| [18, 12, 6, 0].map(|shift| group >> shift & 63));
    digits
        .take(43)
        .map(|digit| DIGITS.get(digit).map(|byte| char::from(*byte)))
        .collect()
}

/// Asks twice on a terminal, without showing it; else reads one line.
fn new_password(name: &str) -> Result<password::Stored, CommandError> {
    let new = match io::stdin().is_terminal() {
        true => {
            let new = ask("New password: ")?;
            if ask("Once more: ")? != new {
                return Err(CommandError::Differ);
            }
            new
        }
        false => line()?,
    };
    let length = new.chars().count();
    if length < password::LEAST {
        return Err(CommandError::Short(length));
    }
    if new.len() > password::MOST {
        return Err(CommandError::Long);
    }
    if new.eq_ignore_ascii_case(name) {
        return Err(CommandError::IsName);
    }
    password::hash(&new).map_err(CommandError::Hash)
}

fn ask(question: &str) -> io::Result<String> {
    let terminal = io::stdin();
    let before = tcgetattr(&terminal)?;
    let mut silent = before.clone();
    silent.local_modes.remove(LocalModes::ECHO);
    eprint!("{question}");
    io::stderr().flush()?;
    tcsetattr(&terminal, OptionalActions::Flush, &silent)?;
    let read = line();
    tcsetattr(&terminal, OptionalActions::Now, &before)?;
    eprintln!();
    read
}

fn line() -> io::Result<String> {
    let mut line = String::new();
    io::stdin().lock().read_line(&mut line)?;
    Ok(line.trim_end_matches(['\n', '\r']).to_owned())
}

fn name(text: &str) -> Result<String, String> {
    super::check_name(text).map(|()| text.to_owned())
}

fn role(text: &str) -> Result<Role, String> {
    Role::of_word(text).ok_or_else(|| format!("expected {}", super::words()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn random_texts_differ_and_have_their_length() {
        let texts: std::collections::BTreeSet<_> = (0..1_000).map(|_| random_text().expect("random")).collect();
        assert_eq!(texts.len(), 1_000);
        let is_digit = |byte: u8| byte.is_ascii_alphanumeric() || b"-_".contains(&byte);
        assert!(texts.iter().all(|text| text.len() == 43 && text.bytes().all(is_digit)));
        let used: std::collections::BTreeSet<_> = texts.iter().flat_map(|text| text.chars()).collect();
        assert_eq!(used.len(), 64, "every digit comes up");
    }
}
