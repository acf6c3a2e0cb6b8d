//! Citations of the specification and links between pages: their targets exist.
//!
//! A citation outside of `docs/spec` names its page as `spec/NAME.md` on its own line or on the line before; a page of the
//! specification cites its own sections without a name.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use arcline_tests::workspace;

/// The section sign, written so that this file has none.
const SECTION: char = '\u{a7}';

/// Folders that Git or a build owns, and captured or generated data.
const SKIPPED: &[&str] = &[".git", "target", "node_modules", "corpus", "artifacts"];

#[test]
fn cited_sections_exist() {
    let pages = sections_by_page();
    let mut wrong = Vec::new();
    for file in files(&["rs", "js", "mjs", "md", "py", "toml"]) {
        let own = own_page(&file);
        let text = read(&file);
        let mut before = "";
        for (number, line) in text.lines().enumerate() {
            for (place, _) in line.match_indices(SECTION) {
                let (head, cited) = (&line[..place], section_at(&line[place..]));
                let folder = if own.is_some() { "" } else { "spec/" };
                let named = last_page(head, folder, &pages).or_else(|| last_page(before, folder, &pages));
                let exists = [named, own.as_deref()]
                    .into_iter()
                    .flatten()
                    .any(|page| pages.get(page).is_some_and(|sections| sections.contains(cited)));
                if !exists {
                    let page = named.or(own.as_deref()).unwrap_or("no page of docs/spec");
                    wrong.push(format!("{}:{}: {page}, section {cited:?}", shown(&file), number + 1));
                }
            }
            before = line;
        }
    }
    assert!(wrong.is_empty(), "sections that do not exist:\n{}", wrong.join("\n"));
}

#[test]
fn relative_links_lead_to_files_and_headings() {
    let mut wrong = Vec::new();
    for file in files(&["md"]) {
        for target in links(&read(&file)) {
            if target.contains("://") || target.starts_with("mailto:") {
                continue;
            }
            let (path, anchor) = target.split_once('#').unwrap_or((&target, ""));
            let linked = match path {
                "" => file.clone(),
                path => file.parent().expect("a file is in a folder").join(path),
            };
            let found = linked.exists() && (anchor.is_empty() || anchors(&read(&linked)).contains(anchor));
            if !found {
                wrong.push(format!("{}: {target}", shown(&file)));
            }
        }
    }
    assert!(wrong.is_empty(), "links that lead nowhere:\n{}", wrong.join("\n"));
}

/// A page names files of the repository in backticks; they exist.
#[test]
fn named_files_exist() {
    const FOLDERS: [&str; 10] = [
        "crates/",
        "server/",
        "client/",
        "proto/",
        "tests/",
        "web/",
        "docs/",
        "fuzz/",
        ".ci/",
        "examples/",
    ];
    let mut wrong = Vec::new();
    for file in files(&["md"]) {
        for (number, line) in read(&file).lines().enumerate() {
            for code in line.split('`').skip(1).step_by(2) {
                let path = code.split('#').next().unwrap_or_default();
                let is_path = FOLDERS.iter().any(|folder| path.starts_with(folder));
                let is_pattern = path.contains(|c: char| c.is_whitespace() || "*{}()<>".contains(c));
                if is_path && !is_pattern && !workspace().join(path).exists() {
                    wrong.push(format!("{}:{}: {path}", shown(&file), number + 1));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "files that are not there:\n{}", wrong.join("\n"));
}

/// Each row of the second table of the glossary names a word that its files have.
#[test]
fn the_words_of_the_code_are_in_the_code() {
    let glossary = read(&workspace().join("docs/GLOSSARY.md"));
    let (_, rows) = glossary
        .split_once("\n## Words of the code\n")
        .expect("the glossary has its second table");
    let mut wrong = Vec::new();
    for row in rows.lines().filter(|line| line.starts_with("| ")).skip(1) {
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        let [_, word, _, places, _] = cells.as_slice() else {
            wrong.push(format!("not a row: {row}"));
            continue;
        };
        let word = word.split(' ').next().unwrap_or_default();
        for path in places.split('`').skip(1).step_by(2) {
            let text = fs::read_to_string(workspace().join(path)).unwrap_or_default();
            if !text.contains(word) {
                wrong.push(format!("{word} is not in {path}"));
            }
        }
    }
    assert!(
        wrong.is_empty(),
        "rows of the glossary to take away:\n{}",
        wrong.join("\n")
    );
}

/// A merge that was not finished leaves its markers in text that no compiler reads.
#[test]
fn no_page_has_a_merge_conflict() {
    let mut wrong = Vec::new();
    for file in files(&["md", "toml", "py", "js", "mjs", "css", "html", "txt"]) {
        let text = read(&file);
        let marker = |line: &&str| line.starts_with("<<<<<<< ") || line.starts_with(">>>>>>> ");
        wrong.extend(
            text.lines()
                .filter(marker)
                .map(|line| format!("{}: {line}", shown(&file))),
        );
    }
    assert!(wrong.is_empty(), "unfinished merges:\n{}", wrong.join("\n"));
}

/// The numbers of the headings of each page of the specification, by the page's name without `.md`.
fn sections_by_page() -> BTreeMap<String, BTreeSet<String>> {
    let folder = workspace().join("docs/spec");
    let pages: BTreeMap<_, _> = fs::read_dir(&folder)
        .expect("docs/spec can be read")
        .map(|entry| entry.expect("an entry of docs/spec").path())
        .filter_map(|page| {
            let name = own_page(&page)?;
            let numbers = headings(&read(&page))
                .filter_map(|title| {
                    title
                        .split_whitespace()
                        .next()
                        .map(|word| word.trim_end_matches('.').to_owned())
                })
                .filter(|word| word.starts_with(|first: char| first.is_ascii_digit()))
                .collect();
            Some((name, numbers))
        })
        .collect();
    assert!(pages.len() >= 5, "docs/spec has its pages");
    pages
}

/// The section number behind a section sign: digits and single dots.
fn section_at(text: &str) -> &str {
    let text = text.trim_start_matches(SECTION).trim_start();
    let end = text
        .find(|c: char| !c.is_ascii_digit() && c != '.')
        .unwrap_or(text.len());
    text[..end].trim_end_matches('.')
}

/// The page that `text` names last, as `NAME.md` behind `folder`.
fn last_page<'p>(text: &str, folder: &str, pages: &'p BTreeMap<String, BTreeSet<String>>) -> Option<&'p str> {
    pages
        .keys()
        .filter_map(|page| Some((text.rfind(&format!("{folder}{page}.md"))?, page.as_str())))
        .max()
        .map(|(_, page)| page)
}

/// The page of the specification that a file is.
fn own_page(file: &Path) -> Option<String> {
    let in_folder = file.parent().is_some_and(|folder| folder.ends_with("docs/spec"));
    let page = in_folder && file.extension().is_some_and(|extension| extension == "md");
    page.then(|| {
        file.file_stem()
            .expect("a page has a name")
            .to_string_lossy()
            .into_owned()
    })
}

/// The text of headings outside of code blocks.
fn headings(text: &str) -> impl Iterator<Item = &str> {
    prose(text)
        .filter(|line| line.starts_with('#'))
        .map(|line| line.trim_start_matches('#').trim())
}

/// The lines outside of code blocks.
fn prose(text: &str) -> impl Iterator<Item = &str> {
    let mut code = false;
    text.lines().filter(move |line| {
        let fence = line.trim_start().starts_with("```");
        code ^= fence;
        !code && !fence
    })
}

/// The anchors of a page's headings, as GitHub and mdbook make them.
fn anchors(text: &str) -> BTreeSet<String> {
    headings(text)
        .map(|title| {
            title
                .to_lowercase()
                .chars()
                .filter(|c| c.is_alphanumeric() || matches!(c, '-' | '_' | ' '))
                .map(|c| if c == ' ' { '-' } else { c })
                .collect()
        })
        .collect()
}

/// The targets of inline links outside of code.
fn links(text: &str) -> Vec<String> {
    prose(text)
        .map(|line| line.split('`').step_by(2).collect::<String>())
        .flat_map(|line| {
            line.split("](")
                .skip(1)
                .filter_map(|rest| rest.split_once(')').map(|(target, _)| target.to_owned()))
                .collect::<Vec<_>>()
        })
        .collect()
}

/// Files of the repository with one of these extensions.
pub(crate) fn files(extensions: &[&str]) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![workspace().to_path_buf()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).expect("a folder of the repository can be read") {
            let path = entry.expect("an entry of the repository").path();
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            if SKIPPED.contains(&name.as_str()) {
                continue;
            }
            if path.is_dir() {
                folders.push(path);
            } else if path
                .extension()
                .is_some_and(|extension| extensions.iter().any(|wanted| extension == *wanted))
            {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

pub(crate) fn read(file: &Path) -> String {
    fs::read_to_string(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()))
}

fn shown(file: &Path) -> String {
    file.strip_prefix(workspace()).unwrap_or(file).display().to_string()
}
