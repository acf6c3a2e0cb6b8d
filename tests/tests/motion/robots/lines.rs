//! Straight lines of the source between random places of the workspace: the tool stays on each of them to 1e-6, whatever the
//! joints do, and where a line cannot be followed it stops on it with one of the errors of transforms.

use arcline_instruction_set::Flag;
use arcline_tests::bench::OK;
use arcline_tests::random::Random;
use arcline_tests::robots::{ARTICULATED, DELTA, RobotMachine, SCARA};

use super::{LINK, apart, geometry, names, off_line, positions};

/// The operands from Speed on, fast enough for a short line.
const FAST: [&str; 2] = [
    "800, 0, 10000, 0, 10000, 0, 0, 100, 100, 2",
    "800, 0, 10000, 0, 10000, 0, 1, 100, 100, 2",
];

/// Joints between these are anywhere in the workspace.
const PLACES: [(&str, RobotMachine, [[f64; 2]; 3]); 3] = [
    ("delta", DELTA, [[-30.0, 70.0], [-30.0, 70.0], [-30.0, 70.0]]),
    ("scara", SCARA, [[-150.0, 150.0], [10.0, 150.0], [-100.0, 100.0]]),
    (
        "articulated",
        ARTICULATED,
        [[-150.0, 150.0], [0.0, 110.0], [-140.0, -20.0]],
    ),
];

#[test]
fn random_lines_keep_the_tool_on_them() {
    let lines = std::env::var("ARCLINE_ROBOT_LINES").map_or(15, |text| text.parse().expect("a number of lines"));
    for (why, machine, ranges) in PLACES {
        let robot = geometry(&machine);
        let [cart, joints] = names(&machine);
        let mut random = Random(7);
        let mut bench = machine.bench();
        assert_eq!(bench.call(LINK), OK, "{why}");
        let (mut followed, mut stopped) = (0, 0);
        for line in 0..lines {
            let to = ranges.map(|[low, high]| random.between(low, high));
            let to = robot.forward(to);
            let Ok(to) = to else { continue };
            let from = positions(&bench, cart);
            let call = format!("MCLM(CART, M, 0, {to:?}, {}, 1)", FAST[line % 2]);
            let (err, _) = bench.call(&call);
            if err != 0 {
                assert!([67, 68, 72].contains(&err), "{why}: ERR {err} of {call} from {from:?}");
                assert_eq!(positions(&bench, cart), from, "{why}: nothing moves");
                continue;
            }
            let mut ticks = 0;
            while !bench.control("M").has(Flag::Pc) {
                bench.tick();
                ticks += 1;
                assert!(ticks < 20_000, "{why}: {call} does not end");
                let tool = robot.forward(positions(&bench, joints)).expect("joints of a robot");
                assert!(
                    off_line(tool, from, to) < 1e-6,
                    "{why}: {tool:?} is off {call} from {from:?}"
                );
                if bench.control("T").has(Flag::Er)
                    && bench.axis("X").command[1] == 0.0
                    && !bench.control("M").has(Flag::Ip)
                {
                    break;
                }
            }
            if bench.control("T").has(Flag::Er) {
                let err = bench.control("T").err;
                assert!([67, 68, 69, 72].contains(&err), "{why}: ERR {err} on {call}");
                bench.until_rest();
                bench.rung_false("T");
                assert_eq!(bench.call(LINK), OK, "{why}: it can be linked again where it stands");
                stopped += 1;
            } else {
                assert!(apart(positions(&bench, cart), to) < 1e-9, "{why}: at the end of {call}");
                followed += 1;
            }
        }
        assert!(
            followed * 3 > lines,
            "{why}: {followed} of {lines} lines, {stopped} stopped"
        );
    }
}
