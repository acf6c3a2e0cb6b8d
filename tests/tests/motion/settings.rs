//! Attributes of coordinate systems that are set while the machine runs count from the next instruction on (spec/axis-and-data-types.md §9.6).
//! Those of Dynamics Configuration Bits are beside the changes of moves.

use arcline_instruction_set::{Flag, Object, Quantity};
use arcline_tests::bench::{Bench, OK};

fn set(bench: &mut Bench, quantity: Quantity, value: f64) {
    bench.set_attribute(Object::CoordinateSystem, "CS1", quantity, value);
}

/// A move along X of 100 with a termination type, at 200 units/s.
fn to_x(termination: u8) -> String {
    format!("MCLM(CS1, M1, 0, [100, 0, 0], 200, 0, 2000, 0, 2000, 0, 0, 100, 100, 2, {termination})")
}

#[test]
fn a_blend_has_the_command_tolerance_at_its_execution() {
    // The least distance of the path from the corner (100, 0).
    let cut = |before: f64, behind_the_first: f64| {
        let mut bench = Bench::new();
        set(&mut bench, Quantity::CommandPositionTolerance, before);
        bench.execute(&to_x(2));
        set(&mut bench, Quantity::CommandPositionTolerance, behind_the_first);
        bench.execute("MCLM(CS1, M2, 0, [100, 100, 0], 200, 0, 2000, 0, 2000, 0, 0, 100, 100, 2, 1)");
        let mut least = f64::INFINITY;
        while !bench.control("M2").has(Flag::Pc) {
            bench.tick();
            least = least.min((bench.position("X") - 100.0).hypot(bench.position("Y")));
        }
        assert_eq!((bench.position("X"), bench.position("Y")), (100.0, 100.0));
        least
    };
    let (narrow, wide) = (cut(0.5, 0.5), cut(4.0, 4.0));
    assert!(narrow > 0.0 && wide > narrow, "{narrow}, {wide}");
    assert_eq!(cut(0.5, 4.0), narrow, "widened behind the first move");
    assert_eq!(cut(4.0, 0.5), wide, "narrowed behind the first move");
}

#[test]
fn a_move_settles_within_the_actual_tolerance_at_its_execution() {
    let slow = "max_deceleration_jerk = 200000.0\ndrive = { position_bandwidth_hz = 5.0, velocity_feedforward = 0.0, \
                position_error_tolerance = 0 }";
    let config = arcline_config::DEFAULT.replace("max_deceleration_jerk = 200000.0", slow);
    let config = config.replace("type = \"virtual\"", "type = \"servo\"");
    // What is left when the move of type 0 completes.
    let left = |before: f64, meanwhile: f64| {
        let mut bench = Bench::with(&config);
        set(&mut bench, Quantity::ActualPositionTolerance, before);
        bench.execute(&to_x(0));
        bench.run(100);
        set(&mut bench, Quantity::ActualPositionTolerance, meanwhile);
        bench.until("M1", Flag::Pc);
        (100.0 - bench.axis("X").actual[0], bench.now())
    };
    let (fine, coarse) = (left(0.01, 0.01), left(1.0, 1.0));
    assert!(
        fine.0 <= 0.01 && coarse.0 > 0.01 && coarse.0 <= 1.0,
        "{fine:?}, {coarse:?}"
    );
    assert_eq!(left(0.01, 1.0), fine, "widened during the move");
    // With 0 no move could settle: the present one does, and the next one errs.
    assert_eq!(left(1.0, 0.0), coarse, "withdrawn during the move");
    let mut bench = Bench::with(&config);
    set(&mut bench, Quantity::ActualPositionTolerance, 0.0);
    assert_eq!(bench.call(&to_x(0)), (51, 0));
    assert_eq!(bench.call(&to_x(1)), OK);
}

#[test]
fn percentages_are_of_the_maxima_at_the_execution() {
    // The greatest speed, acceleration and deceleration of a move at half of the maxima.
    let most = |before: Option<f64>, meanwhile: Option<f64>| {
        let mut bench = Bench::new();
        let half = |bench: &mut Bench, share: Option<f64>| {
            let machine = bench.machine();
            let system = &machine.systems[usize::from(machine.system("CS1").expect("it is there"))];
            let maxima = [system.max_speed, system.max_acceleration, system.max_deceleration];
            let quantities = [
                Quantity::MaximumSpeed,
                Quantity::MaximumAcceleration,
                Quantity::MaximumDeceleration,
            ];
            for (quantity, maximum) in quantities.into_iter().zip(maxima) {
                if let Some(share) = share {
                    set(bench, quantity, maximum * share);
                }
            }
        };
        half(&mut bench, before);
        bench.execute("MCLM(CS1, M1, 0, [400, 0, 0], 50, 1, 50, 1, 50, 1, 0, 100, 100, 2, 1)");
        bench.run(20);
        half(&mut bench, meanwhile);
        let mut most = [0.0_f64; 3];
        while !bench.control("M1").has(Flag::Pc) {
            bench.tick();
            let [_, speed, acceleration] = bench.axis("X").command;
            for (most, now) in most.iter_mut().zip([speed, acceleration, -acceleration]) {
                *most = most.max(now);
            }
        }
        assert_eq!(bench.position("X"), 400.0);
        most
    };
    let (full, halved) = (most(None, None), most(Some(0.5), None));
    for (full, halved) in full.iter().zip(halved) {
        assert!((halved / full - 0.5).abs() < 1e-12, "{full}, {halved}");
    }
    assert_eq!(most(None, Some(0.5)), full, "lowered during the move");
}

#[test]
fn the_maxima_of_an_axis_are_those_of_the_configuration() {
    let mut bench = Bench::new();
    bench.set_attribute(Object::Axis, "X", Quantity::MaximumSpeed, 1.0);
    bench.execute("MAM(X, M1, 0, 10, 100, 0, 2000, 0, 2000, 0, 0, 100, 100, 2)");
    bench.until("M1", Flag::Pc);
    assert_eq!(bench.position("X"), 10.0);
}
