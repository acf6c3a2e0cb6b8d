//! The lines of the shell: from a terminal with editing, history and completion, or from a pipe.

use std::io;
use std::path::{Path, PathBuf};

use rustyline::completion::{Completer, FilenameCompleter, Pair};
use rustyline::error::ReadlineError;
use rustyline::highlight::Highlighter;
use rustyline::hint::{Hint, Hinter};
use rustyline::history::FileHistory;
use rustyline::validate::Validator;
use rustyline::{CompletionType, Config, Context, Editor, Helper};

use arcline_client::Tag;

use super::complete::Known;

/// Lines of the history.
const HISTORY_LINES: usize = 2000;
const PROMPT: &str = "arcline> ";

/// A line, or why there is none.
#[derive(Debug)]
pub(super) enum Read {
    Line(String),
    /// Ctrl-C on a line: it is dropped.
    Again,
    /// Ctrl-D, or the end of the input.
    End,
}

/// The source of lines.
#[derive(Debug)]
pub(super) enum Lines {
    /// A terminal.
    Terminal {
        editor: Box<Editor<LineHelper, FileHistory>>,
        history: Option<PathBuf>,
    },
    /// Standard input.
    Piped,
}

impl Lines {
    pub(super) fn new(known: Known, history: Option<&Path>, is_interactive: bool) -> io::Result<Self> {
        if !is_interactive {
            return Ok(Self::Piped);
        }
        let config = Config::builder()
            .completion_type(CompletionType::List)
            .auto_add_history(true)
            .max_history_size(HISTORY_LINES)
            .map_err(io::Error::other)?
            .build();
        let mut editor = Editor::with_config(config).map_err(io::Error::other)?;
        editor.set_helper(Some(LineHelper {
            known,
            files: FilenameCompleter::new(),
        }));
        let history = history.map(Path::to_path_buf);
        if let Some(file) = &history {
            // There is none before the first session, and a shell without history is still a shell.
            let _ = file.parent().map(std::fs::create_dir_all);
            let _ = editor.load_history(file);
        }
        Ok(Self::Terminal {
            editor: Box::new(editor),
            history,
        })
    }

    /// Waits for the next line.
    pub(super) fn next(mut self) -> (io::Result<Read>, Self) {
        let read = match &mut self {
            Self::Terminal { editor, history } => match editor.readline(PROMPT) {
                Ok(line) => {
                    if let Some(file) = history {
                        let _ = editor.append_history(file);
                    }
                    Ok(Read::Line(line))
                }
                Err(ReadlineError::Interrupted) => Ok(Read::Again),
                Err(ReadlineError::Eof) => Ok(Read::End),
                Err(error) => Err(io::Error::other(error)),
            },
            Self::Piped => {
                let mut line = String::new();
                let read = io::stdin().read_line(&mut line);
                read.map(|bytes| if bytes == 0 { Read::End } else { Read::Line(line) })
            }
        };
        (read, self)
    }

    /// The names on the server.
    pub(super) fn set_tags(&mut self, tags: Vec<Tag>) {
        if let Self::Terminal { editor, .. } = self
            && let Some(ask) = editor.helper_mut()
        {
            ask.known.tags = tags;
        }
    }
}

/// Answers the terminal's questions about a line.
pub(super) struct LineHelper {
    known: Known,
    files: FilenameCompleter,
}

impl std::fmt::Debug for LineHelper {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("LineHelper").finish_non_exhaustive()
    }
}

impl Completer for LineHelper {
    type Candidate = Pair;

    fn complete(&self, line: &str, at: usize, context: &Context<'_>) -> rustyline::Result<(usize, Vec<Pair>)> {
        let found = self.known.complete(line.get(..at).unwrap_or_default());
        if found.is_file {
            return self.files.complete(line, at, context);
        }
        let pairs = found.candidates.into_iter().map(|candidate| Pair {
            display: candidate.clone(),
            replacement: candidate,
        });
        Ok((found.start, pairs.collect()))
    }
}

/// Operands that are still to come: shown, never taken over.
#[derive(Debug)]
pub(super) struct ToCome(String);

impl Hint for ToCome {
    fn display(&self) -> &str {
        &self.0
    }

    fn completion(&self) -> Option<&str> {
        None
    }
}

impl Hinter for LineHelper {
    type Hint = ToCome;

    fn hint(&self, line: &str, at: usize, _: &Context<'_>) -> Option<ToCome> {
        if at < line.len() {
            return None;
        }
        self.known.hint(line).map(ToCome)
    }
}

impl Highlighter for LineHelper {
    fn highlight_hint<'h>(&self, hint: &'h str) -> std::borrow::Cow<'h, str> {
        format!("\x1b[2m{hint}\x1b[0m").into()
    }
}

impl Validator for LineHelper {}
impl Helper for LineHelper {}
