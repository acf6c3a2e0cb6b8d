//! The states of an axis.

/// The axis state machine (spec/axis-and-data-types.md §12), as far as instructions see it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum AxisState {
    /// Ready, servo off.
    Stopped,
    /// MSO is under way.
    Starting,
    /// Servo on: the drive follows the command.
    Running,
    /// MSF is under way.
    Stopping,
    /// A fault brakes the axis; the servo goes off when it stands.
    Aborting,
    /// A fault has switched the servo off.
    Faulted,
    /// Shut down until a shutdown reset.
    Shutdown,
}
