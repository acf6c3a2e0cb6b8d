//! The homing configuration of an axis (spec/axis-and-data-types.md §9.4, §11).

/// Homing of an axis.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Home {
    /// MAH moves the axis, or waits for the event while other instructions move it.
    pub mode: HomeMode,
    /// The event that marks the home point.
    pub sequence: HomeSequence,
    /// The direction in which an active sequence begins, and whether the axis returns to the home point.
    pub direction: HomeDirection,
    /// Home Position: the position of the axis at the home point, u; of a rotary axis within one turn.
    pub position: f64,
    /// Home Offset: the distance from the event to the Home Position, u.
    pub offset: f64,
    /// Home Speed of the first leg, u/s; above 0 if an active sequence moves the axis.
    pub speed: f64,
    /// Home Return Speed of later legs, u/s; above 0 if an active sequence moves the axis.
    pub return_speed: f64,
    /// Home Acceleration, u/s²; above 0.
    pub acceleration: f64,
    /// Home Deceleration, u/s². It may be 0 if the axis's Maximum Deceleration is 0: MAH errs with 54.
    pub deceleration: f64,
    /// The inputs that its drive can latch.
    pub inputs: HomeInputs,
}

impl Home {
    /// Immediate homing to position 0, the default of a configuration. Rates in u/s².
    pub fn immediate(acceleration: f64, deceleration: f64) -> Self {
        Home {
            mode: HomeMode::Active,
            sequence: HomeSequence::Immediate,
            direction: HomeDirection::BidirectionalForward,
            position: 0.0,
            offset: 0.0,
            speed: 0.0,
            return_speed: 0.0,
            acceleration,
            deceleration,
            inputs: HomeInputs::default(),
        }
    }
}

/// Home Mode.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum HomeMode {
    /// MAH waits for the event while other instructions move the axis.
    Passive,
    /// MAH moves the axis.
    Active,
}

/// Home Sequence.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum HomeSequence {
    /// The position at which the axis stands.
    Immediate,
    /// An edge of the switch.
    Switch,
    /// The marker.
    Marker,
    /// The first marker after an edge of the switch.
    SwitchMarker,
    /// A held torque level.
    Torque,
    /// The first marker after a held torque level.
    TorqueMarker,
}

impl HomeSequence {
    /// A held torque level begins the sequence.
    pub fn is_of_torque(self) -> bool {
        matches!(self, HomeSequence::Torque | HomeSequence::TorqueMarker)
    }
}

/// Home Direction.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum HomeDirection {
    /// Forward only.
    UnidirectionalForward,
    /// Forward, then back.
    BidirectionalForward,
    /// Reverse only.
    UnidirectionalReverse,
    /// Reverse, then back.
    BidirectionalReverse,
}

impl HomeDirection {
    /// 1 forward, -1 reverse.
    pub fn sign(self) -> f64 {
        match self {
            HomeDirection::UnidirectionalForward | HomeDirection::BidirectionalForward => 1.0,
            HomeDirection::UnidirectionalReverse | HomeDirection::BidirectionalReverse => -1.0,
        }
    }

    /// The axis returns to the home point.
    pub fn is_bidirectional(self) -> bool {
        matches!(
            self,
            HomeDirection::BidirectionalForward | HomeDirection::BidirectionalReverse
        )
    }
}

/// The inputs for homing that the drive of an axis has.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct HomeInputs {
    /// The home switch; `None`: not assigned.
    pub switch: Option<HomeSwitch>,
    /// The encoder has a marker.
    pub marker: bool,
    /// The axis has mechanical stops, which torque sequences need.
    pub stops: bool,
}

/// The directions in which a home switch becomes active.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum HomeSwitch {
    /// Forward: behind its edge it stays active.
    Forward,
    /// Reverse: behind its edge it stays active.
    Reverse,
    /// Both: it has two edges.
    Both,
}

impl HomeSwitch {
    /// The switch becomes active in the direction in which homing begins.
    pub fn becomes_active(self, direction: HomeDirection) -> bool {
        match self {
            HomeSwitch::Forward => direction.sign() > 0.0,
            HomeSwitch::Reverse => direction.sign() < 0.0,
            HomeSwitch::Both => true,
        }
    }
}
