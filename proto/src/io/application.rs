//! The application of an I/O connection: the assemblies that its path names, and the sizes that go with them
//! (spec/ethernet-ip.md §14.1).
//!
//! Not here: the limit on the number of connections. Sizes are in bytes.

use std::time::Duration;

use super::production::Trigger;
use crate::cip::{CipStatus, class};
use crate::connection::{ConnectionType, ForwardOpen};
use crate::epath::Segment;
use crate::status::connection as extended;

/// An assembly: bytes that are produced or consumed as a whole.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Assembly {
    /// Instance of class 0x04, and the connection point.
    pub instance: u32,
    /// Its data, without sequence count and run/idle header.
    pub size: u16,
}

/// The assemblies of a device.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Assemblies {
    /// Target to originator.
    pub input: Assembly,
    /// Originator to target, of the exclusive owner.
    pub output: Assembly,
    /// Configuration; it has no data.
    pub configuration: u32,
    /// In place of the output: a heartbeat without data, the connection only has inputs.
    pub input_only: u32,
    /// In place of the output: a heartbeat without data, the connection only listens to others' inputs.
    pub listen_only: u32,
}

/// The application of a connection.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Application {
    /// Writes the outputs and has the inputs; there is one at a time.
    ExclusiveOwner,
    /// Has the inputs.
    InputOnly,
    /// Has the inputs as long as another connection, that does not only listen, has them.
    ListenOnly,
}

impl Application {
    /// The application that a Forward Open asks for; `path` is its path without ports and key.
    ///
    /// # Errors
    /// 0x01 with the additional status of the field that is wrong.
    pub fn of(open: &ForwardOpen, path: &[Segment], assemblies: &Assemblies) -> Result<Self, CipStatus> {
        OpenRequest::new(open, path, assemblies).map(|request| request.application)
    }
}

/// The checked request of a Forward Open.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct OpenRequest {
    pub(super) application: Application,
    /// Whether the connected data begins with a 16-bit sequence count.
    pub(super) class_1: bool,
    /// Whether O→T data has a run/idle header.
    pub(super) header: bool,
    /// The trigger of T→O data.
    pub(super) trigger: Trigger,
    /// Whether T→O data goes to a group.
    pub(super) multicast: bool,
}

/// Bytes of the sequence count of class 1.
pub(super) const SEQUENCE_COUNT: u16 = 2;
/// Bytes of the run/idle header.
pub(super) const RUN_IDLE: u16 = 4;

impl OpenRequest {
    /// Looks at everything in a Forward Open but intervals, which other connections there are, and its key.
    /// `application` is its path without ports and key.
    ///
    /// # Errors
    /// 0x01 with the additional status, and the right size where that is wrong.
    pub(super) fn new(open: &ForwardOpen, application: &[Segment], assemblies: &Assemblies) -> Result<Self, CipStatus> {
        let class_1 = match open.transport_class() {
            0 => false,
            1 => true,
            _ => return Err(CipStatus::connection(extended::CLASS_UNSUPPORTED)),
        };
        let trigger = match open.transport & 0x70 {
            0x00 => Trigger::Cyclic,
            0x10 => Trigger::ChangeOfState {
                inhibit: inhibit_time(open),
            },
            // Nothing in the device decides when to produce.
            _ => return Err(CipStatus::connection(extended::TRIGGER_UNSUPPORTED)),
        };
        if open.multiplier > 7 {
            return Err(CipStatus::connection(extended::TIMEOUT_MULTIPLIER));
        }
        if open.o_to_t.connection_type != ConnectionType::PointToPoint {
            return Err(CipStatus::connection(extended::TYPE_O_TO_T));
        }
        let multicast = match open.t_to_o.connection_type {
            ConnectionType::PointToPoint => false,
            ConnectionType::Multicast => true,
            _ => return Err(CipStatus::connection(extended::TYPE_T_TO_O)),
        };
        if open.o_to_t.redundant_owner {
            return Err(CipStatus::connection(extended::REDUNDANT_OWNER));
        }
        let this = find(application, assemblies)?;
        let count = if class_1 { SEQUENCE_COUNT } else { 0 };
        let size_wrong = |code: u16, right: u16| Err(CipStatus::connection(code).with(right));
        let header = match this {
            Application::ExclusiveOwner => {
                let right = count + RUN_IDLE + assemblies.output.size;
                if open.o_to_t.size != right {
                    return size_wrong(extended::SIZE_O_TO_T, right);
                }
                true
            }
            // A heartbeat is empty, or a run/idle header that says nothing.
            Application::InputOnly | Application::ListenOnly => {
                if open.o_to_t.size != count && open.o_to_t.size != count + RUN_IDLE {
                    return size_wrong(extended::SIZE_O_TO_T, count);
                }
                open.o_to_t.size > count
            }
        };
        let right = count + assemblies.input.size;
        if open.t_to_o.size != right {
            return size_wrong(extended::SIZE_T_TO_O, right);
        }
        Ok(Self {
            application: this,
            class_1,
            header,
            trigger,
            multicast,
        })
    }
}

/// The production inhibit time, ms in a network segment `43 nn`; a quarter of the interval where there is none (CIP Vol. 1,
/// C-1.4.3). Never longer than the interval.
fn inhibit_time(open: &ForwardOpen) -> Duration {
    let inhibit = open.path.0.iter().find_map(|segment| match segment {
        Segment::Network { kind: 0x43, data } => data.first().copied().filter(|millis| *millis > 0),
        _ => None,
    });
    let interval = Duration::from_micros(open.t_to_o_rpi.into());
    let time = inhibit.map_or(interval / 4, |millis| Duration::from_millis(millis.into()));
    time.min(interval)
}

/// `20 04 [24 configuration] 2C output 2C input [80 0]`; instances and connection points mean the same, and the class may
/// be said again.
fn find(path: &[Segment], assemblies: &Assemblies) -> Result<Application, CipStatus> {
    let fail = |code: u16| Err(CipStatus::connection(code));
    let mut points = Vec::with_capacity(3);
    for segment in path {
        match segment {
            Segment::Class(id) if *id == u32::from(class::ASSEMBLY) => {}
            Segment::Class(_) => return fail(extended::INVALID_APPLICATION_PATH),
            Segment::Instance(id) | Segment::ConnectionPoint(id) if points.len() < 3 => points.push(*id),
            Segment::Data(data) if data.is_empty() => {}
            Segment::Data(_) => return Err(CipStatus::connection(extended::CONFIGURATION_SIZE).with(0)),
            _ => return fail(extended::INVALID_SEGMENT),
        }
    }
    if !matches!(path.first(), Some(Segment::Class(_))) {
        return fail(extended::INVALID_SEGMENT);
    }
    let (configuration, output, input) = match *points.as_slice() {
        [output, input] => (None, output, input),
        [configuration, output, input] => (Some(configuration), output, input),
        _ => return fail(extended::INVALID_APPLICATION_PATH),
    };
    if configuration.is_some_and(|instance| instance != assemblies.configuration) {
        return fail(extended::CONFIGURATION_PATH);
    }
    if input != assemblies.input.instance {
        return fail(extended::PRODUCING_PATH);
    }
    match output {
        _ if output == assemblies.output.instance => Ok(Application::ExclusiveOwner),
        _ if output == assemblies.input_only => Ok(Application::InputOnly),
        _ if output == assemblies.listen_only => Ok(Application::ListenOnly),
        _ => fail(extended::CONSUMING_PATH),
    }
}
