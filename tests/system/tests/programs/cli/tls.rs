//! `arcline` over TLS: by options, by variables, and by the folder of its configuration.

use std::fs;
use std::process::Command;

use arcline_system_tests::command_line::command;
use arcline_system_tests::secured::{CLIENT, Secured};

/// The variables that choose TLS and its files.
const VARIABLES: [&str; 5] = [
    "ARCLINE_TLS",
    "ARCLINE_CA",
    "ARCLINE_CERTIFICATE",
    "ARCLINE_KEY",
    "XDG_CONFIG_HOME",
];

/// The case, options, variables, and the exit code.
type Case<'c> = (&'c str, &'c [&'c str], &'c [(&'c str, &'c str)], i32);

#[test]
fn tls_is_chosen_by_options_by_variables_and_by_a_folder() {
    let secured = Secured::start(arcline_config::DEFAULT, "plain = \"off\"\n", &[]);
    let stranger = Secured::start(arcline_config::DEFAULT, "", &[]);
    let at = secured.server.tls().expect("it has TLS");
    let file = |of: &Secured, name: &str| of.folder().join(name).to_str().expect("UTF-8").to_owned();
    let (ca, foreign_ca) = (file(&secured, "ca.pem"), file(&stranger, "ca.pem"));
    let certificate = file(&secured, &format!("{CLIENT}.pem"));
    let key = file(&secured, &format!("{CLIENT}.key"));
    let foreign = file(&stranger, &format!("{CLIENT}.pem"));
    let foreign_key = file(&stranger, &format!("{CLIENT}.key"));
    // The contents of the folder of a user's configuration: ~/.config, or the folder of the variable.
    let home = tempfile::tempdir().expect("a folder");
    let (config, empty) = (home.path().join(".config"), home.path().join("empty"));
    for folder in [config.join("arcline"), empty.clone()] {
        fs::create_dir_all(folder).expect("a writable folder");
    }
    for (from, to) in [(&ca, "ca.pem"), (&certificate, "client.pem"), (&key, "client.key")] {
        fs::copy(from, config.join("arcline").join(to)).expect("a writable folder");
    }
    let (config, empty) = (config.to_str().expect("UTF-8"), empty.to_str().expect("UTF-8"));
    let of_empty = ("XDG_CONFIG_HOME", empty);
    let all = ["--tls", "--ca", &ca, "--certificate", &certificate, "--key", &key];
    let all_variables = [
        ("ARCLINE_TLS", "1"),
        ("ARCLINE_CA", &ca),
        ("ARCLINE_CERTIFICATE", &certificate),
        ("ARCLINE_KEY", &key),
        of_empty,
    ];
    #[rustfmt::skip]
    let cases: &[Case<'_>] = &[
        ("options",                     &all,                                       &[of_empty], 0),
        ("variables",                   &[],                                        &all_variables, 0),
        ("the user's folder",           &["--tls"],                                 &[], 0),
        ("the folder of the variable",  &["--tls"],                                 &[("XDG_CONFIG_HOME", config)], 0),
        ("TLS by its variable",         &[],                                        &[("ARCLINE_TLS", "1")], 0),
        ("an option before a variable", &["--tls", "--ca", &ca],                    &[("ARCLINE_CA", &foreign_ca)], 0),
        ("a variable before the folder", &["--tls"],                                &[("ARCLINE_CA", &foreign_ca)], 3),
        ("the authority of another",    &["--tls", "--ca", &foreign_ca],            &[], 3),
        ("a certificate of another",    &["--tls", "--certificate", &foreign, "--key", &foreign_key], &[], 3),
        ("the server has another name", &["--tls", "--server-name", "other.example"], &[], 3),
        ("no TLS",                      &[],                                        &[], 3),
        ("TLS switched off",            &[],                                        &[("ARCLINE_TLS", "0")], 3),
        ("a folder without files",      &["--tls"],                                 &[of_empty], 2),
    ];
    for (why, options, variables, code) in cases {
        let mut command: Command = command(at, options);
        command.args(["read", "Move1.Speed"]).env("HOME", home.path());
        for variable in VARIABLES {
            command.env_remove(variable);
        }
        let output = command
            .envs(variables.iter().copied())
            .output()
            .expect("it was just built");
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(*code), "{why}: {said}");
        assert_eq!(output.stdout.is_empty(), *code != 0, "{why}");
        assert_eq!(said.is_empty(), *code == 0, "{why}: {said}");
        assert!(!said.contains("PRIVATE KEY"), "{why}: {said}");
    }
}
