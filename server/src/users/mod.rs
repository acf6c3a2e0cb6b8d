//! The users of the page and the tokens of scripts: one file, which the commands `users` and `tokens` write and the server reads
//! (spec/security.md §7).
//!
//! The file holds hashes only: of a password Argon2id, of a token SHA-256. Not here: sessions (`hmi`).

pub(crate) mod command;
pub(crate) mod password;

use std::fs::{self, OpenOptions};
use std::io::{self, Read as _, Write as _};
use std::os::unix::fs::{MetadataExt as _, OpenOptionsExt as _};
use std::path::{Path, PathBuf};

use arcline_config::Role;
use serde::{Deserialize, Serialize};
use time::OffsetDateTime;

use self::password::Stored;

/// The content of the file.
#[derive(Clone, Debug, Default)]
pub(crate) struct Users {
    /// The users of the page.
    pub(crate) users: Vec<User>,
    /// The tokens of scripts.
    pub(crate) tokens: Vec<Token>,
}

/// A user of the page.
#[derive(Clone, Debug)]
pub(crate) struct User {
    /// The name; no other user has it.
    pub(crate) name: String,
    /// The role of a session that the user begins.
    pub(crate) role: Role,
    /// The hash of the password.
    pub(crate) password: Stored,
    /// Whether the user is disabled: it cannot log in.
    pub(crate) is_disabled: bool,
    /// How often an administrator has ended the sessions of the user by the command `users logout`.
    pub(crate) logouts: u32,
}

impl User {
    /// The text that a session of the user stores; a session with another one ends.
    pub(crate) fn credential(&self) -> String {
        format!("{} {}", self.password.text(), self.logouts)
    }
}

/// A token of a script.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) struct Token {
    /// The name; no other token has it.
    pub(crate) name: String,
    /// The role of a script that shows it.
    pub(crate) role: Role,
    /// SHA-256 of the token, hexadecimal.
    pub(crate) sha256: String,
    /// The last second at which it holds, Unix time.
    pub(crate) until: i64,
}

/// The reason for which the file cannot be used. It names the file and the row, never a hash.
#[derive(Debug, thiserror::Error)]
pub(crate) enum UsersError {
    /// The file cannot be read or written.
    #[error("{}: {error}", file.display())]
    File {
        /// The file.
        file: PathBuf,
        /// The reason.
        #[source]
        error: io::Error,
    },
    /// Other users of the computer can read or write it.
    #[error("{}: other users of this computer can read or write it; set its mode to 600", file.display())]
    Open {
        /// The file.
        file: PathBuf,
    },
    /// The file differs from the format that the commands write.
    #[error("{}: {reason}", file.display())]
    Content {
        /// The file.
        file: PathBuf,
        /// The error and its line.
        reason: String,
    },
}

impl Users {
    /// Reads a file.
    pub(crate) fn read(file: &Path) -> Result<Self, UsersError> {
        let failed = |error| UsersError::File {
            file: file.to_owned(),
            error,
        };
        let mut opened = fs::File::open(file).map_err(failed)?;
        let metadata = opened.metadata().map_err(failed)?;
        if !metadata.is_file() {
            return Err(failed(io::Error::other("it is no file")));
        }
        if metadata.mode() & 0o077 != 0 {
            return Err(UsersError::Open { file: file.to_owned() });
        }
        let mut text = String::new();
        let read = (&mut opened).take(LONGEST + 1).read_to_string(&mut text);
        read.map_err(failed)?;
        let reason = match text.len() as u64 > LONGEST {
            true => Err(format!("it is longer than {LONGEST} bytes")),
            false => Self::parse(&text),
        };
        reason.map_err(|reason| UsersError::Content {
            file: file.to_owned(),
            reason,
        })
    }

    fn parse(text: &str) -> Result<Self, String> {
        // The message of the parser shows the line, which may have a hash in it.
        let rows: Rows = toml::from_str(text).map_err(|error| {
            let at = error.span().map_or(0, |span| span.start);
            let line = text.get(..at).map_or(0, |before| before.matches('\n').count()) + 1;
            format!("line {line}: {}", error.message())
        })?;
        let mut all = Self::default();
        for row in rows.users {
            let wrong = |reason: &str| format!("user {:?}: {reason}", row.name);
            check_name(&row.name).map_err(|expected| wrong(&expected))?;
            if all.user(&row.name).is_some() {
                return Err(wrong("the name stands there twice"));
            }
            all.users.push(User {
                role: role_of(&row.role).map_err(|expected| wrong(&expected))?,
                password: Stored::parse(&row.password).map_err(wrong)?,
                is_disabled: row.disabled,
                logouts: row.logouts,
                name: row.name,
            });
        }
        for row in rows.tokens {
            let wrong = |reason: &str| format!("token {:?}: {reason}", row.name);
            check_name(&row.name).map_err(|expected| wrong(&expected))?;
            if all.tokens.iter().any(|token| token.name == row.name) {
                return Err(wrong("the name stands there twice"));
            }
            if row.sha256.len() != 64 || !row.sha256.bytes().all(|byte| byte.is_ascii_hexdigit()) {
                return Err(wrong("sha256: expected 64 hexadecimal digits"));
            }
            all.tokens.push(Token {
                role: role_of(&row.role).map_err(|expected| wrong(&expected))?,
                sha256: row.sha256.to_ascii_lowercase(),
                until: row.until,
                name: row.name,
            });
        }
        Ok(all)
    }

    /// Replaces a file as a whole; only its owner can read it.
    pub(crate) fn write(&self, file: &Path) -> Result<(), UsersError> {
        let rows = Rows {
            users: self
                .users
                .iter()
                .map(|user| UserRow {
                    name: user.name.clone(),
                    role: user.role.word().to_owned(),
                    password: user.password.text().to_owned(),
                    disabled: user.is_disabled,
                    logouts: user.logouts,
                })
                .collect(),
            tokens: self
                .tokens
                .iter()
                .map(|token| TokenRow {
                    name: token.name.clone(),
                    role: token.role.word().to_owned(),
                    sha256: token.sha256.clone(),
                    until: token.until,
                })
                .collect(),
        };
        let text = toml::to_string(&rows).map_err(|error| UsersError::Content {
            file: file.to_owned(),
            reason: error.to_string(),
        })?;
        let mut new = file.as_os_str().to_owned();
        new.push(".new");
        let new = PathBuf::from(new);
        let replace = || {
            let _ = fs::remove_file(&new);
            let mut opened = OpenOptions::new().write(true).create_new(true).mode(0o600).open(&new)?;
            opened.write_all(text.as_bytes())?;
            opened.sync_all()?;
            fs::rename(&new, file)
        };
        replace().map_err(|error| UsersError::File {
            file: file.to_owned(),
            error,
        })
    }

    /// The user of a name.
    pub(crate) fn user(&self, name: &str) -> Option<&User> {
        self.users.iter().find(|user| user.name == name)
    }

    /// The token of a hash that holds now.
    pub(crate) fn token(&self, sha256: &str) -> Option<&Token> {
        let now = OffsetDateTime::now_utc().unix_timestamp();
        let mut tokens = self.tokens.iter();
        // The token is a hash of 256 random bits, so the time of its comparison reveals nothing useful.
        tokens.find(|token| token.sha256 == sha256 && token.until >= now)
    }
}

/// 1 to 64 printable characters, of which the first and the last one is no space.
pub(crate) fn check_name(name: &str) -> Result<(), String> {
    let is_name = (1..=64).contains(&name.chars().count())
        && !name.chars().any(|letter| letter.is_control() || is_invisible(letter))
        && name.trim() == name;
    match is_name {
        true => Ok(()),
        false => Err("expected a name of 1 to 64 printable characters without spaces at its ends".to_owned()),
    }
}

/// Characters that change the direction of a text or take no room: with them two names may look alike.
fn is_invisible(letter: char) -> bool {
    matches!(letter, '\u{AD}' | '\u{200B}'..='\u{200F}' | '\u{2028}'..='\u{202E}' | '\u{2060}'..='\u{206F}' | '\u{FEFF}')
}

fn role_of(word: &str) -> Result<Role, String> {
    Role::of_word(word).ok_or_else(|| format!("role {word:?}: expected {}", words()))
}

fn words() -> String {
    Role::ALL.map(Role::word).join(", ")
}

#[derive(Serialize, Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct Rows {
    #[serde(default)]
    users: Vec<UserRow>,
    #[serde(default)]
    tokens: Vec<TokenRow>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct UserRow {
    name: String,
    role: String,
    password: String,
    #[serde(default)]
    disabled: bool,
    #[serde(default, skip_serializing_if = "is_none")]
    logouts: u32,
}

fn is_none(count: &u32) -> bool {
    *count == 0
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct TokenRow {
    name: String,
    role: String,
    sha256: String,
    until: i64,
}

/// Bytes of the file.
const LONGEST: u64 = 1024 * 1024;

#[cfg(test)]
mod tests {
    use super::*;

    fn hash() -> String {
        password::hash("a good password")
            .expect("it is hashed")
            .text()
            .to_owned()
    }

    #[test]
    fn users_are_written_and_read() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("users.toml");
        let text = format!(
            "[[users]]\nname = \"Anna Ö\"\nrole = \"operator\"\npassword = {:?}\n[[tokens]]\nname = \"backup\"\nrole = \"viewer\"\n\
             sha256 = \"{}\"\nuntil = 4102444800\n",
            hash(),
            "0a".repeat(32)
        );
        let users = Users::parse(&text).expect("it is valid");
        users.write(&file).expect("a writable folder");
        let again = Users::read(&file).expect("it is valid");
        assert_eq!(
            again.user("Anna Ö").map(|user| (user.role, user.is_disabled)),
            Some((Role::Operator, false))
        );
        assert_eq!(again.tokens, users.tokens);
        assert_eq!(
            again.token(&"0a".repeat(32)).map(|token| token.role),
            Some(Role::Viewer)
        );
        assert_eq!(again.token(&"0b".repeat(32)), None, "another token");
        let mode = fs::metadata(&file).expect("it is there").mode();
        assert_eq!(mode & 0o777, 0o600, "{mode:o}");
        fs::set_permissions(&file, std::os::unix::fs::PermissionsExt::from_mode(0o640)).expect("it is ours");
        assert!(
            matches!(Users::read(&file), Err(UsersError::Open { .. })),
            "readable by others"
        );
    }

    /// A message names the row, and never shows a hash.
    #[test]
    fn a_file_that_is_wrong_is_refused() {
        let good = hash();
        let user = |name: &str, role: &str, password: &str| {
            format!("[[users]]\nname = \"{name}\"\nrole = {role:?}\npassword = {password:?}\n")
        };
        let dear = good.replace("m=19456", "m=1048576");
        let other = good.replace("argon2id", "argon2i");
        #[rustfmt::skip]
        let cases = [
            ("an unknown role",       user("anna", "boss", &good),                                   "user \"anna\": role \"boss\""),
            ("twice",                 user("anna", "viewer", &good) + &user("anna", "viewer", &good), "user \"anna\": the name"),
            ("a password in clear",   user("anna", "viewer", "secret of anna"),                      "user \"anna\": password"),
            ("more than 64 MiB",      user("anna", "viewer", &dear),                                 "user \"anna\": password"),
            ("another function",      user("anna", "viewer", &other),                                "user \"anna\": password"),
            ("a control character",   user("an\\u0007na", "viewer", &good),                            "expected a name"),
            ("a turned text",         user("an\u{202E}na", "viewer", &good),                         "expected a name"),
            ("an unknown key",        "[[users]]\npin = \"secret of anna\"".to_owned(),              "line 2"),
            ("no TOML",               "secret of anna = = 1".to_owned(),                             "line 1"),
            ("a short hash",          "[[tokens]]\nname = \"t\"\nrole = \"viewer\"\nsha256 = \"12\"\nuntil = 1".to_owned(), "token \"t\": sha256"),
        ];
        for (why, text, expected) in cases {
            let reason = Users::parse(&text).expect_err(why);
            assert!(reason.contains(expected), "{why}: {reason}");
            assert!(
                !reason.contains("secret of anna") && !reason.contains("argon2"),
                "{why}: {reason}"
            );
        }
    }
}
