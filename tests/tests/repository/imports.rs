//! No circle of imports between the files of a crate: a file can be read with those below it and without those above.
//!
//! The files of one type with several `impl` blocks are one place in several files: that a file with `impl Axis` names `Axis`
//! makes no circle. Test modules do not count.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Crates whose files import each other in one direction.
const ONE_DIRECTION: &[&str] = &["crates/motion"];

#[test]
fn files_import_each_other_in_one_direction() {
    for package in ONE_DIRECTION {
        let files = sources(&arcline_tests::workspace().join(package).join("src"));
        assert!(files.len() > 10, "{package} has sources");
        let circles = circles(&files);
        assert!(circles.is_empty(), "{package}: {}", circles.join("\n"));
    }
}

#[test]
fn a_circle_is_found() {
    let files = |pairs: &[(&str, &str)]| -> BTreeMap<String, String> {
        pairs
            .iter()
            .map(|(module, text)| ((*module).to_owned(), (*text).to_owned()))
            .collect()
    };
    let rows = [
        ("two files", "use crate::b::B;", "use super::a::{A, other::C};", 1),
        (
            "a path without `use`",
            "use crate::b::B;",
            "fn f() -> crate::a::A {}",
            1,
        ),
        ("a re-export", "use crate::B;", "use crate::a::A;", 1),
        ("one direction", "use crate::b::B;", "use std::fmt; // crate::a::A", 0),
        (
            "the type's own block",
            "use crate::b::B;",
            "use crate::a::A; impl A<'_> { fn f() {} }",
            0,
        ),
        (
            "a trait of the other's type",
            "use crate::b::B;",
            "use crate::a::A; impl From<B> for A {}",
            1,
        ),
        (
            "a block and more",
            "use crate::b::B;",
            "use crate::a::{A, MOST}; impl A {}",
            1,
        ),
        (
            "tests",
            "use crate::b::B;",
            "#[cfg(test)] mod tests { use crate::a::A; }",
            0,
        ),
        (
            "text",
            "use crate::b::B;",
            "fn f() { print(\"crate::a::A\", '\"'); }",
            0,
        ),
    ];
    for (why, a, b, found) in rows {
        let files = files(&[("", "mod a; mod b; pub use b::B;"), ("a", a), ("b", b)]);
        assert_eq!(circles(&files).len(), found, "{why}");
    }
    let child = [
        ("", "mod a;"),
        ("a", "mod b; fn f() { b::g(); }"),
        ("a/b", "use super::A;"),
    ];
    assert_eq!(circles(&files(&child)).len(), 1, "a path that begins with a child");
}

/// The text of every module of a crate, by its path: `axis/sum`, the root as ``.
fn sources(root: &Path) -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    let mut folders = vec![root.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).expect("a folder of sources can be read") {
            let path = entry.expect("an entry of a folder of sources").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let relative = path.strip_prefix(root).expect("a file below the root");
                let relative = relative.with_extension("");
                let module = relative.to_str().expect("names of sources are UTF-8");
                let module = module.strip_suffix("/mod").unwrap_or(module);
                let module = if module == "lib" { "" } else { module };
                if !module.split('/').any(|part| part.ends_with("tests")) {
                    let text = std::fs::read_to_string(&path).expect("a source can be read");
                    found.insert(module.to_owned(), text);
                }
            }
        }
    }
    found
}

/// Every circle as text: its modules, and the names that each takes from the others.
fn circles(files: &BTreeMap<String, String>) -> Vec<String> {
    let modules: BTreeMap<&str, Module> = files
        .iter()
        .map(|(name, text)| (name.as_str(), Module::read(name, text, files)))
        .collect();
    let imports: BTreeMap<&str, BTreeMap<&str, BTreeSet<String>>> = modules
        .iter()
        .map(|(name, module)| (*name, imports(name, module, &modules)))
        .collect();
    let reaches = |from: &str| -> BTreeSet<&str> {
        let mut reached = BTreeSet::new();
        let mut todo = vec![from];
        while let Some(next) = todo.pop() {
            for other in imports.get(next).into_iter().flat_map(BTreeMap::keys) {
                if reached.insert(*other) {
                    todo.push(*other);
                }
            }
        }
        reached
    };
    let reached: BTreeMap<&str, BTreeSet<&str>> = modules.keys().map(|name| (*name, reaches(name))).collect();
    let mut seen = BTreeSet::new();
    let mut found = Vec::new();
    for name in modules.keys() {
        if seen.contains(name) || !reached[name].contains(name) {
            continue;
        }
        let circle: Vec<&str> = reached[name]
            .iter()
            .copied()
            .filter(|other| reached[other].contains(name))
            .collect();
        let lines: Vec<String> = circle
            .iter()
            .map(|one| {
                let others = imports[one].iter().filter(|(other, _)| circle.contains(other));
                format!("  {one} -> {:?}", others.collect::<Vec<_>>())
            })
            .collect();
        seen.extend(circle);
        found.push(format!("a circle of imports:\n{}", lines.join("\n")));
    }
    found
}

/// The names of other modules in a module.
#[derive(Default)]
struct Module {
    /// Absolute paths of `use`, by the name in this module.
    names: BTreeMap<String, Vec<String>>,
    /// Every absolute path that it names.
    paths: Vec<Vec<String>>,
    /// Types with an `impl` block of their own here.
    implemented: BTreeSet<String>,
}

impl Module {
    fn read(name: &str, text: &str, files: &BTreeMap<String, String>) -> Module {
        let tokens = without_tests(&tokens(text));
        let mut module = Module::default();
        let mut at = 0;
        while at < tokens.len() {
            let token = tokens[at].as_str();
            let is_visibility = at > 0 && tokens[at - 1] == "in";
            if token == "use" {
                let mut leaves = Vec::new();
                at = use_tree(&tokens, at + 1, &[], &mut leaves);
                for (path, alias) in leaves {
                    let Some(mut path) = absolute(name, &path, files) else {
                        continue;
                    };
                    if path.last().is_some_and(|last| last == "self" || last == "*") {
                        path.pop();
                    }
                    if let Some(last) = alias.as_ref().or(path.last()) {
                        module.names.insert(last.clone(), path.clone());
                    }
                    module.paths.push(path);
                }
            } else if token == "impl" {
                if let Some(own) = implemented(&tokens[at + 1..]) {
                    module.implemented.insert(own.to_owned());
                }
                at += 1;
            } else if is_name(token) && tokens.get(at + 1).is_some_and(|next| next == "::") {
                let mut path = vec![token.to_owned()];
                at += 1;
                while tokens.get(at).is_some_and(|next| next == "::")
                    && tokens.get(at + 1).is_some_and(|next| is_name(next))
                {
                    path.push(tokens[at + 1].clone());
                    at += 2;
                }
                if !is_visibility && let Some(path) = absolute(name, &path, files) {
                    module.paths.push(path);
                }
                at = at.max(1);
                if tokens.get(at).is_some_and(|next| next == "::") {
                    at += 1;
                }
            } else {
                at += 1;
            }
        }
        module
    }
}

/// The modules that a module names, and which of their names; a type that it has an `impl` block of its own for does not count.
fn imports<'m>(
    name: &str,
    module: &Module,
    modules: &BTreeMap<&'m str, Module>,
) -> BTreeMap<&'m str, BTreeSet<String>> {
    let mut found: BTreeMap<&str, BTreeSet<String>> = BTreeMap::new();
    for path in &module.paths {
        let home = home(path, modules, &mut BTreeSet::new());
        let item = path.last().cloned().unwrap_or_default();
        if home != name && !home.is_empty() && !module.implemented.contains(&item) {
            found.entry(home).or_default().insert(item);
        }
    }
    found
}

/// The module that defines the item of an absolute path, through re-exports.
fn home<'m>(path: &[String], modules: &BTreeMap<&'m str, Module>, seen: &mut BTreeSet<Vec<String>>) -> &'m str {
    let mut current = "";
    for (index, part) in path.iter().enumerate() {
        let below = if current.is_empty() {
            part.clone()
        } else {
            format!("{current}/{part}")
        };
        if let Some((module, _)) = modules.get_key_value(below.as_str()) {
            current = module;
            continue;
        }
        if let Some(exported) = modules[current].names.get(part) {
            let exported: Vec<String> = exported.iter().chain(&path[index + 1..]).cloned().collect();
            if seen.insert(exported.clone()) {
                return home(&exported, modules, seen);
            }
        }
        break;
    }
    current
}

/// A path as one from the root of the crate; `None`: into another crate.
fn absolute(module: &str, path: &[String], files: &BTreeMap<String, String>) -> Option<Vec<String>> {
    let own = || module.split('/').filter(|part| !part.is_empty()).map(str::to_owned);
    let (first, rest) = path.split_first()?;
    let mut base: Vec<String> = match first.as_str() {
        "crate" => return Some(rest.to_vec()),
        "self" | "super" => own().collect(),
        child => {
            let below: Vec<String> = own().chain([child.to_owned()]).collect();
            return files
                .contains_key(&below.join("/"))
                .then(|| below.into_iter().chain(rest.iter().cloned()).collect());
        }
    };
    let mut rest = path;
    while let Some((first, behind)) = rest.split_first() {
        match first.as_str() {
            "super" => {
                base.pop();
            }
            "self" => {}
            _ => break,
        }
        rest = behind;
    }
    base.extend(rest.iter().cloned());
    Some(base)
}

/// Reads a tree of `use` from a token on. Returns the token behind it.
fn use_tree(
    tokens: &[String],
    mut at: usize,
    before: &[String],
    leaves: &mut Vec<(Vec<String>, Option<String>)>,
) -> usize {
    let mut path = before.to_vec();
    while let Some(token) = tokens.get(at) {
        match token.as_str() {
            "{" => {
                at += 1;
                while tokens.get(at).is_some_and(|token| token != "}") {
                    at = use_tree(tokens, at, &path, leaves);
                    if tokens.get(at).is_some_and(|token| token == ",") {
                        at += 1;
                    }
                }
                return at + 1;
            }
            "as" => {
                leaves.push((path, tokens.get(at + 1).cloned()));
                return at + 2;
            }
            "," | "}" | ";" => break,
            "::" => {}
            _ => path.push(token.clone()),
        }
        at += 1;
    }
    leaves.push((path, None));
    at
}

/// The type of an `impl` block that is not of a trait, from the token behind `impl` on.
fn implemented(tokens: &[String]) -> Option<&str> {
    let head = tokens.iter().take_while(|token| *token != "{").collect::<Vec<_>>();
    if head.iter().any(|token| *token == "for") {
        return None;
    }
    let mut depth = 0;
    head.into_iter().map(String::as_str).find(|token| {
        match *token {
            "<" => depth += 1,
            ">" => depth -= 1,
            token => return depth == 0 && is_name(token),
        }
        false
    })
}

/// The tokens without `#[cfg(test)] mod … { … }`.
fn without_tests(tokens: &[String]) -> Vec<String> {
    const HEAD: [&str; 8] = ["#", "[", "cfg", "(", "test", ")", "]", "mod"];
    let mut kept = Vec::new();
    let mut at = 0;
    while at < tokens.len() {
        let is_head = tokens[at..]
            .iter()
            .zip(HEAD)
            .filter(|(token, head)| token == head)
            .count()
            == HEAD.len();
        if !is_head || tokens.get(at + HEAD.len() + 1).is_none_or(|token| token != "{") {
            kept.push(tokens[at].clone());
            at += 1;
            continue;
        }
        at += HEAD.len() + 2;
        let mut depth = 1;
        while depth > 0 && at < tokens.len() {
            match tokens[at].as_str() {
                "{" => depth += 1,
                "}" => depth -= 1,
                _ => {}
            }
            at += 1;
        }
    }
    kept
}

fn is_name(token: &str) -> bool {
    token.starts_with(|first: char| first.is_alphabetic() || first == '_')
}

/// Names, `::` and single signs of a source; no comments, and texts and characters as one sign.
fn tokens(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let name = rest
            .find(|sign: char| !sign.is_alphanumeric() && sign != '_')
            .unwrap_or(rest.len());
        let length = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            rest.find("*/").map_or(rest.len(), |end| end + 2)
        } else if let Some(length) = raw_text(rest).or_else(|| quoted(rest)) {
            found.push("\"".to_owned());
            length
        } else if first.is_whitespace() {
            first.len_utf8()
        } else if rest.starts_with("::") {
            found.push("::".to_owned());
            2
        } else if name > 0 {
            found.push(rest[..name].to_owned());
            name
        } else {
            found.push(first.to_string());
            first.len_utf8()
        };
        rest = &rest[length..];
    }
    found
}

/// The length of `r"…"` or `r#"…"#` at the beginning.
fn raw_text(text: &str) -> Option<usize> {
    let behind = text.strip_prefix('r')?;
    let hashes = behind.len() - behind.trim_start_matches('#').len();
    let inside = behind[hashes..].strip_prefix('"')?;
    let end = format!("\"{}", "#".repeat(hashes));
    Some(text.len() - inside.len() + inside.find(&end)? + end.len())
}

/// The length of a text or a character at the beginning; a lifetime is none.
fn quoted(text: &str) -> Option<usize> {
    let mut signs = text.char_indices();
    let (_, quote) = signs.next().filter(|(_, sign)| matches!(sign, '"' | '\''))?;
    if quote == '\'' && !text[1..].starts_with('\\') {
        let (_, sign) = signs.next()?;
        return text[1 + sign.len_utf8()..]
            .starts_with('\'')
            .then_some(2 + sign.len_utf8());
    }
    let mut escaped = false;
    for (at, sign) in signs {
        match sign {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            sign if sign == quote => return Some(at + 1),
            _ => {}
        }
    }
    None
}
