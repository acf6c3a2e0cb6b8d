//! Retained state: the state that a project takes over from the last run, and the threads that store it for the next one.
//!
//! At start-up [`Retained::open`] reads the file and restores its state: axes at their last positions with their drives off, and plain tags
//! with their last written values. After that a [`ChangeTracker`] in the plant detects changes, and the thread of a [`StateWriter`] writes
//! them. The format of the file is that of `arcline-state`; the real-time thread has no part in it.

mod change_tracker;
mod state_writer;
#[cfg(test)]
pub(crate) mod tests;

use std::fmt::Write as _;
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use arcline_config::Project;
use arcline_controller::image::{self, Access, Image, TagId, TagKind};
use arcline_controller::machine;
use arcline_instruction_set::FaultSet;
use arcline_state::{
    Axis, AxisState, Damage, Disk, FileContents, LockedFile, OpenError, Pace, ReadError, RetainedState, Tag,
};
use arcline_tag::TagPath;

pub(crate) use change_tracker::ChangeTracker;
use change_tracker::KeptTags;
pub use state_writer::NotPersisted;
use state_writer::RecordSender;
pub(crate) use state_writer::{Job, PersistedReceiver, StateWriter, Turn, WriterWorker};

/// A project's retained state, read from its file and stored again.
pub(crate) struct Retained {
    /// The tags, the plain ones with their restored values.
    pub(crate) image: Image,
    /// Detects changes.
    pub(crate) watch: ChangeTracker,
    /// Writes it.
    pub(crate) writer: StateWriter,
}

/// The reason for which a file cannot store the state.
#[derive(Debug, thiserror::Error)]
pub(crate) enum RetainError {
    /// The file cannot be had.
    #[error("--state {file}: {error}")]
    Open {
        /// The file.
        file: PathBuf,
        /// The error of the lock.
        error: OpenError,
    },
    /// The file cannot be read.
    #[error("--state {file}: cannot be read: {error}")]
    Read {
        /// The file.
        file: PathBuf,
        /// The error of the system.
        error: io::Error,
    },
    /// The system has no thread left that could write the file.
    #[error("--state {file}: cannot be kept: {error}")]
    Thread {
        /// The file.
        file: PathBuf,
        /// The error of the system.
        error: io::Error,
    },
    /// A file that cannot be used cannot be renamed either.
    #[error("--state {file}: {damage}, and it cannot be set aside: {error}")]
    SetAside {
        /// The file.
        file: PathBuf,
        /// The defect of the file.
        damage: Unusable,
        /// The error of the renaming.
        error: io::Error,
    },
    /// The machine has more than a file of the state can hold.
    #[error("--state {file}: the state of this configuration cannot be kept: {damage}")]
    TooLarge {
        /// The file.
        file: PathBuf,
        /// The part that is too large.
        damage: Damage,
    },
}

/// The reason for which a file gives no state.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Unusable {
    /// The file is not whole, or does not hold a state.
    #[error(transparent)]
    Damage(Damage),
    /// The file is that of another machine.
    #[error("it is the state of another machine: none of its axes and tags are in this configuration")]
    Foreign,
}

impl Retained {
    /// Reads `file` and makes `project` start as it says, then begins to keep the state there. A file that is damaged
    /// or foreign is set aside and said so on standard error; the project then starts as it is configured.
    ///
    /// # Errors
    /// When the file cannot be used at all: see [`RetainError`].
    pub(crate) fn open(file: &Path, project: &mut Project) -> Result<Self, RetainError> {
        let at = |file: &Path| file.to_owned();
        let locked = LockedFile::lock(file).map_err(|error| RetainError::Open { file: at(file), error })?;
        let Start {
            locked,
            image,
            state,
            tags,
        } = Start::from(locked, project)?;
        let axes = state.axes.clone();
        let writer =
            StateWriter::start(locked, state).map_err(|error| RetainError::Thread { file: at(file), error })?;
        let watch = ChangeTracker::new(writer.records(), axes, tags, project.machine.period_ns);
        Ok(Retained { image, watch, writer })
    }
}

/// The initial state of a project: the tags, and the state that is stored from then on.
struct Start<D: Disk> {
    locked: LockedFile<D>,
    image: Image,
    state: RetainedState,
    tags: KeptTags,
}

impl<D: Disk> Start<D> {
    /// Reads the locked file and makes `project` start as it says.
    fn from(locked: LockedFile<D>, project: &mut Project) -> Result<Self, RetainError> {
        let file = locked.file().to_owned();
        let at = |file: &Path| file.to_owned();
        let mut image = project.image();
        let contents = match locked.read() {
            Ok(Some(contents)) if is_foreign(&contents.state, project, &image) => Err(Unusable::Foreign),
            Ok(contents) => Ok(contents),
            Err(ReadError::Damage(damage)) => Err(Unusable::Damage(damage)),
            Err(ReadError::Io(error)) => return Err(RetainError::Read { file, error }),
        };
        let contents: Option<FileContents> = match contents {
            Ok(contents) => contents,
            Err(damage) => {
                match locked.set_aside() {
                    // Printed at every log level: the person who starts the server must see it.
                    Ok(aside) => eprintln!(
                        "arcline-server: --state {}: {damage}. It was renamed to {}, and everything starts as configured",
                        file.display(),
                        aside.display()
                    ),
                    Err(error) => return Err(RetainError::SetAside { file, damage, error }),
                }
                None
            }
        };
        if let Some(contents) = &contents {
            if contents.cut_off > 0 {
                tracing::warn!(
                    "{}: the last {} bytes were not whole and have been left out; the disk never had them when the last server ended",
                    file.display(),
                    contents.cut_off
                );
            }
            let taken = take_over(&contents.state, project, &mut image);
            taken.report(&file);
        }
        // Only later writes count as changes: the values that were taken over are not new.
        image.remember_written();
        let (state, tags) = state_of(project, &image);
        state.check().map_err(|damage| {
            let file = at(&file);
            RetainError::TooLarge { file, damage }
        })?;
        Ok(Start {
            locked,
            image,
            state,
            tags,
        })
    }
}

/// A project's retained state, read and stored by turns that the caller makes.
pub(crate) struct SteppedState<D: Disk> {
    /// The tags, the plain ones with their restored values.
    pub(crate) image: Image,
    /// Detects changes.
    pub(crate) watch: ChangeTracker,
    /// Writes it.
    pub(crate) worker: WriterWorker<D>,
}

impl<D: Disk> SteppedState<D> {
    /// As [`Retained::open`].
    ///
    /// # Errors
    /// See [`RetainError`].
    pub(crate) fn open(locked: LockedFile<D>, pace: Pace, project: &mut Project) -> Result<Self, RetainError> {
        let Start {
            locked,
            image,
            state,
            tags,
        } = Start::from(locked, project)?;
        let (records, queue) = RecordSender::channel();
        let watch = ChangeTracker::new(records, state.axes.clone(), tags, project.machine.period_ns);
        let worker = WriterWorker::start(locked, state, pace, Duration::ZERO, queue);
        Ok(SteppedState { image, watch, worker })
    }
}

/// The differences between a state and the configuration that takes it over.
#[derive(Debug, Default, PartialEq)]
struct Taken {
    /// Axes and tags of the state that the configuration does not have, or not as they were.
    left: Vec<String>,
    /// Axes that were moving.
    moving: Vec<String>,
}

impl Taken {
    fn report(&self, file: &Path) {
        let file = file.display();
        if !self.left.is_empty() {
            let left = self.left.join(", ");
            tracing::warn!(
                "{file}: values not used, since the configuration has no such tag or axis of that type: {left}"
            );
        }
        if !self.moving.is_empty() {
            let moving = self.moving.join(", ");
            tracing::warn!("{file}: not homed, since these axes were moving when the server ended: {moving}");
        }
    }
}

/// Whether a project has no axis and no tag of a state. A state with nothing but tags that clients have created is of any machine.
fn is_foreign(state: &RetainedState, project: &Project, image: &Image) -> bool {
    let of_any = state.axes.is_empty() && state.tags.iter().all(|tag| created(&tag.kind).0.is_some());
    let axis = state.axes.iter().any(|axis| find_axis(axis, project).is_some());
    let tag = state.tags.iter().any(|tag| find_tag(tag, image).is_some());
    !(of_any || axis || tag)
}

/// Makes a project and its tags start as a state says, wherever name and type are the same.
fn take_over(state: &RetainedState, project: &mut Project, image: &mut Image) -> Taken {
    let mut taken = Taken::default();
    for axis in &state.axes {
        let found = find_axis(axis, project).filter(|index| within_its_turn(axis, &project.machine.axes[*index]));
        let Some(index) = found else {
            taken.left.push(format!("axis {} ({})", axis.name, axis.kind));
            continue;
        };
        let AxisState {
            position,
            homed,
            moving,
            faults,
            redefined,
        } = axis.state;
        if moving {
            taken.moving.push(axis.name.clone());
        }
        project.machine.axes[index].start = machine::StartState {
            position,
            servo_on: false,
            homed: homed && !moving,
            faults: FaultSet::from_bits(faults),
            redefined,
        };
    }
    for tag in &state.tags {
        match find_tag(tag, image).or_else(|| create_again(tag, image)) {
            Some(id) => image.restore(id, &tag.bytes),
            None => taken.left.push(format!("tag {} ({})", tag.name, tag.kind)),
        }
    }
    taken
}

fn find_axis(axis: &Axis, project: &Project) -> Option<usize> {
    let index = usize::from(project.machine.axis(&axis.name)?);
    (axis_kind(project.machine.axes.get(index)?) == axis.kind).then_some(index)
}

/// A machine relies on it.
fn within_its_turn(axis: &Axis, of: &machine::Axis) -> bool {
    of.unwind
        .is_none_or(|unwind| (0.0..unwind).contains(&axis.state.position))
}

fn find_tag(tag: &Tag, image: &Image) -> Option<TagId> {
    let known = image.find(&tag.name).filter(|known| is_kept(known, image))?;
    let (_, kind) = created(&tag.kind);
    let same = known.tag_type.to_string() == kind && image.bytes(known.id).len() == tag.bytes.len();
    same.then_some(known.id)
}

/// A tag that a client had created, and that is not in the configuration either.
fn create_again(tag: &Tag, image: &mut Image) -> Option<TagId> {
    let (access, kind) = created(&tag.kind);
    let access = access?;
    if image.find(&tag.name).is_some() {
        return None;
    }
    let tag_type = arcline_config::tag_type(kind, |name| image.declared(name))?;
    let path: TagPath = tag.name.parse().ok()?;
    let (program, name, _) = path.scope();
    let again = image::PlainTag {
        program: program.map(str::to_owned),
        access,
        ..image::PlainTag::new(name?, tag_type)
    };
    image.create(&again).ok()
}

/// Whether a client created a tag of this kind, with its access if so; and its type.
fn created(kind: &str) -> (Option<Access>, &str) {
    [(CREATED_READ_ONLY, Access::ReadOnly), (CREATED, Access::ReadWrite)]
        .into_iter()
        .find_map(|(prefix, access)| Some((Some(access), kind.strip_prefix(prefix)?)))
        .unwrap_or((None, kind))
}

/// The kind of a tag in the state: its type, and that a client has created it.
fn tag_kind(tag: &image::Tag, image: &Image) -> String {
    let prefix = match (image.is_created(tag.id), tag.access) {
        (false, _) => "",
        (true, Access::ReadWrite) => CREATED,
        (true, Access::ReadOnly) => CREATED_READ_ONLY,
    };
    format!("{prefix}{}", tag.tag_type)
}

/// In front of the type of a tag that a client has created.
const CREATED: &str = "created, ";
/// In front of the type of a created tag that clients may not write.
const CREATED_READ_ONLY: &str = "created, read-only, ";

/// A read-only tag of the configuration is as it is configured, and the tags of a program start with the values of its file.
fn is_kept(tag: &image::Tag, image: &Image) -> bool {
    let is_written = tag.access == Access::ReadWrite || image.is_created(tag.id);
    tag.kind == TagKind::Plain && is_written && !image.is_of_program(tag.id)
}

/// The kind of an axis's positions: a position of an axis in inches is not valid for one in millimetres.
fn axis_kind(axis: &machine::Axis) -> String {
    let kind = if axis.is_virtual() { "virtual" } else { "servo" };
    let mut text = format!("{kind}, {}", axis.units);
    if let Some(unwind) = axis.unwind {
        let _ = write!(text, ", unwind {unwind}");
    }
    text
}

/// The state at start-up, and the tags in it.
fn state_of(project: &Project, image: &Image) -> (RetainedState, KeptTags) {
    let axes = project.machine.axes.iter().map(|axis| Axis {
        name: axis.name.clone(),
        kind: axis_kind(axis),
        state: AxisState {
            position: axis.start.position,
            homed: axis.start.homed,
            moving: false,
            faults: axis.start.faults.bits(),
            redefined: axis.start.redefined,
        },
    });
    let (tags, ids) = tags_of(image);
    let kept = KeptTags::new(&tags, ids);
    let state = RetainedState {
        axes: axes.collect(),
        tags,
    };
    (state, kept)
}

/// The tags in the retained state, in order.
fn tags_of(image: &Image) -> (Vec<Tag>, Vec<TagId>) {
    let kept = image.tags().iter().filter(|tag| is_kept(tag, image));
    kept.map(|tag| {
        let kept = Tag {
            name: image.full_name(tag),
            kind: tag_kind(tag, image),
            bytes: image.bytes(tag.id).to_vec(),
        };
        (kept, tag.id)
    })
    .unzip()
}
