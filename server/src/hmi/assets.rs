//! The files of the page, carried in the program (`build.rs`); or, for work on the page, those of a folder.

use std::borrow::Cow;
use std::path::{Component, Path, PathBuf};

/// A folder to take the files from instead: nothing is built to see a change.
pub(super) const FOLDER_VARIABLE: &str = "ARCLINE_HMI_ASSETS";

/// Name and content of every file, by name.
static FILES: &[(&str, &[u8])] = include!(concat!(env!("OUT_DIR"), "/assets.rs"));

/// The source of the page's files.
#[derive(Clone, Debug, Default)]
pub(super) struct Assets {
    folder: Option<PathBuf>,
}

impl Assets {
    /// The files in the program, unless the environment names a folder.
    pub(super) fn from_environment() -> Self {
        Assets {
            folder: std::env::var_os(FOLDER_VARIABLE).map(PathBuf::from),
        }
    }

    /// The file that a URL's path means, with its media type.
    pub(super) fn file(&self, path: &str) -> Option<(&'static str, Cow<'static, [u8]>)> {
        let name = match path {
            "/" => "index.html",
            path => path.strip_prefix("/assets/")?,
        };
        let kind = media_type(name)?;
        let content = match &self.folder {
            None => {
                let place = FILES.binary_search_by_key(&name, |(name, _)| name).ok()?;
                Cow::Borrowed(FILES[place].1)
            }
            Some(folder) => {
                let inside = Path::new(name)
                    .components()
                    .all(|part| matches!(part, Component::Normal(_)));
                let file = inside.then(|| folder.join(name))?;
                Cow::Owned(std::fs::read(file).ok()?)
            }
        };
        Some((kind, content))
    }
}

/// The media types of the files of a page; other files are not served.
fn media_type(name: &str) -> Option<&'static str> {
    let (_, ending) = name.rsplit_once('.')?;
    Some(match ending {
        "html" => "text/html; charset=utf-8",
        "js" | "mjs" => "text/javascript; charset=utf-8",
        "css" => "text/css; charset=utf-8",
        "svg" => "image/svg+xml",
        "png" => "image/png",
        "ico" => "image/x-icon",
        "json" | "webmanifest" => "application/json",
        "txt" => "text/plain; charset=utf-8",
        "woff2" => "font/woff2",
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_means_a_file_of_the_page_or_nothing() {
        let assets = Assets::default();
        #[rustfmt::skip]
        let cases = [
            ("the page",           "/",                        Some("text/html; charset=utf-8")),
            ("no such file",       "/assets/none.js",          None),
            ("not below assets",   "/index.js",                None),
            ("another folder",     "/assets/../Cargo.toml",    None),
            ("no ending",          "/assets/LICENSE",          None),
            ("the folder itself",  "/assets/",                 None),
        ];
        for (why, path, expected) in cases {
            assert_eq!(assets.file(path).map(|(kind, _)| kind), expected, "{why}: {path}");
        }
    }

    #[test]
    fn a_folder_is_not_left() {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::create_dir(folder.path().join("hmi")).expect("a folder in it");
        for (name, text) in [("hmi/a.js", "inside"), ("b.js", "outside")] {
            std::fs::write(folder.path().join(name), text).expect("a file");
        }
        let assets = Assets {
            folder: Some(folder.path().join("hmi")),
        };
        let content = |path: &str| assets.file(path).map(|(_, content)| content.into_owned());
        assert_eq!(content("/assets/a.js").as_deref(), Some(b"inside".as_slice()));
        let absolute = format!("/assets/{}", folder.path().join("b.js").display());
        for path in ["/assets/../b.js", "/assets//b.js", absolute.as_str()] {
            assert_eq!(content(path), None, "{path}");
        }
    }

    #[test]
    fn the_table_can_be_searched() {
        assert!(FILES.is_sorted_by_key(|(name, _)| *name));
    }
}
