//! Inputs of simulated drives that are written instead of wired: the home switch, and the enable input.

use arcline_drive::simulated::{Sensor, Settings, SimulatedAxis, SimulatedDrives};
use arcline_drive::{
    ArmLatch, DriveInput, DriveState, Drives as _, Feedback, HOME_LATCH, Latch, SetPoint, Trigger, WrittenInput,
};
use arcline_instruction_set::AxisId;

const PERIOD: f64 = 0.001;

/// One axis that moves by a unit in each update.
struct Bench {
    drives: SimulatedDrives,
    set_point: SetPoint,
    feedback: Feedback,
}

impl Bench {
    fn new(sensor: Sensor) -> Self {
        let axis = SimulatedAxis::new(0.0, &Settings::default(), sensor);
        Bench {
            drives: SimulatedDrives::new(vec![Some(axis)], PERIOD),
            set_point: SetPoint {
                enable: true,
                ..SetPoint::default()
            },
            feedback: Feedback::default(),
        }
    }

    fn arm(&mut self, number: u32, trigger: Trigger, then_marker: bool) {
        self.set_point.latches[HOME_LATCH] = Some(ArmLatch {
            number,
            trigger,
            then_marker,
        });
    }

    fn moves(&mut self) -> Option<Latch> {
        self.set_point.position += 1.0;
        self.set_point.velocity = 1.0 / PERIOD;
        self.stands()
    }

    fn stands(&mut self) -> Option<Latch> {
        let feedback = std::slice::from_mut(&mut self.feedback);
        self.drives
            .exchange(&[self.set_point], feedback)
            .expect("it never fails");
        self.feedback.latches[HOME_LATCH]
    }

    fn write(&mut self, input: DriveInput, on: bool) {
        let written = WrittenInput {
            axis: AxisId(0),
            input,
            on,
            armed: None,
        };
        self.drives.write_input(&written, &mut self.feedback);
    }
}

#[test]
fn a_written_home_switch_closes_the_latch_where_the_axis_is() {
    let mut bench = Bench::new(Sensor::default());
    bench.arm(1, Trigger::SwitchOn, false);
    assert_eq!([bench.moves(), bench.moves()], [None, None]);
    let position = bench.feedback.motion.position;
    bench.write(DriveInput::Home, true);
    assert!(bench.feedback.inputs.home, "at once");
    let latch = bench.moves().expect("with the next exchange");
    assert_eq!(
        (latch.number, latch.position, latch.before_end_s),
        (1, position, PERIOD)
    );
    assert!(bench.feedback.inputs.home);
    // Only once, and not by a level.
    assert_eq!(bench.moves(), None);
    bench.arm(2, Trigger::SwitchOn, false);
    assert_eq!([bench.moves(), bench.moves()], [None, None], "it is active already");
    bench.write(DriveInput::Home, false);
    assert_eq!(bench.moves(), None, "the other edge");
    assert!(!bench.feedback.inputs.home);
    bench.arm(3, Trigger::SwitchOff, false);
    bench.write(DriveInput::Home, true);
    assert_eq!(bench.moves(), None);
    bench.write(DriveInput::Home, false);
    assert_eq!(bench.moves().map(|latch| latch.number), Some(3));
}

#[test]
fn an_axis_at_rest_sees_a_written_switch_and_a_marker_behind_it_needs_motion() {
    let sensor = Sensor {
        marker: Some((0.5, Some(10.0))),
        ..Sensor::default()
    };
    let mut bench = Bench::new(sensor);
    bench.arm(1, Trigger::SwitchOn, false);
    for _ in 0..5 {
        assert_eq!(bench.stands(), None);
    }
    bench.write(DriveInput::Home, true);
    assert_eq!(bench.stands().map(|latch| latch.position), Some(0.0));
    // The marker at 10.5 is the next one behind the position of the edge.
    bench.write(DriveInput::Home, false);
    assert_eq!([bench.moves(), bench.moves()], [None, None]);
    bench.arm(2, Trigger::SwitchOn, true);
    bench.write(DriveInput::Home, true);
    let latch = (0..12).find_map(|_| bench.moves()).expect("the marker");
    assert!((latch.position - 10.5).abs() < 1e-9, "{latch:?}");
}

#[test]
fn a_written_switch_is_beside_that_of_the_machine() {
    let sensor = Sensor {
        switch: Some([2.5, f64::INFINITY]),
        ..Sensor::default()
    };
    let mut bench = Bench::new(sensor);
    bench.arm(1, Trigger::SwitchOn, false);
    let latch = (0..5).find_map(|_| bench.moves()).expect("its own switch");
    assert!((latch.position - 2.5).abs() < 1e-9, "{latch:?}");
    bench.write(DriveInput::Home, false);
    assert!(bench.feedback.inputs.home, "its own one is active");
}

#[test]
fn a_drive_holds_the_axis_only_while_its_enable_input_is_active() {
    let mut bench = Bench::new(Sensor::default());
    bench.stands();
    assert_eq!(bench.feedback.state, DriveState::Enabled, "nobody writes the input");
    bench.write(DriveInput::Enable, false);
    bench.stands();
    assert_eq!(bench.feedback.state, DriveState::Off);
    bench.write(DriveInput::Enable, true);
    bench.stands();
    assert_eq!(bench.feedback.state, DriveState::Enabled);
}
