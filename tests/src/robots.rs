//! Machines with one robot: a Cartesian system `CART` of virtual axes and the robot's joints as the system `ROBOT`.

use crate::bench::Bench;

/// A robot as its keys in a configuration, and joints to begin at.
#[derive(Clone, Copy, Debug)]
pub struct RobotMachine {
    /// Keys of the coordinate system.
    pub keys: &'static str,
    /// The positions of its joints at the start.
    pub joints: &'static [f64],
    /// Maximum Speed and Acceleration of each joint.
    pub joint_speed: f64,
    /// Further keys of `CART`.
    pub cart: &'static str,
    /// Coarse update period, ms.
    pub period: f64,
}

/// Three arms, in the middle of its workspace.
pub const DELTA: RobotMachine = RobotMachine {
    keys: "type = \"delta\"\nlink_lengths = [120.0, 260.0]\nbase_offsets = [60.0, 0.0, 0.0]\n\
           end_effector_offsets = [20.0, 0.0, -30.0]\nzero_angles = [3.0, -4.0, 2.0]\n",
    joints: &[23.0, 16.0, 22.0],
    joint_speed: 4000.0,
    cart: "",
    period: 1.0,
};

/// Two horizontal links, bent to the right.
pub const SCARA: RobotMachine = RobotMachine {
    keys: "type = \"scara_independent\"\nlink_lengths = [250.0, 200.0]\nzero_angles = [0.0, -5.0, 10.0]\n",
    joints: &[10.0, 75.0, 10.0],
    ..DELTA
};

/// A turning base and two links.
pub const ARTICULATED: RobotMachine = RobotMachine {
    keys: "type = \"articulated_independent\"\nlink_lengths = [300.0, 250.0]\nbase_offsets = [20.0, 0.0, 40.0]\n\
           end_effector_offsets = [30.0, 0.0, -15.0]\n",
    joints: &[0.0, 70.0, -80.0],
    ..DELTA
};

/// Two links in a plane.
pub const PLANAR: RobotMachine = RobotMachine {
    keys: "type = \"articulated_dependent\"\nlink_lengths = [300.0, 250.0]\n",
    joints: &[70.0, -10.0],
    ..DELTA
};

/// Two links in a plane, the second of which turns with the first.
pub const PLANAR_INDEPENDENT: RobotMachine = RobotMachine {
    keys: "type = \"articulated_independent\"\nlink_lengths = [300.0, 250.0]\nbase_offsets = [20.0, 40.0, 0.0]\n\
           end_effector_offsets = [30.0, -15.0, 0.0]\n",
    joints: &[70.0, -80.0],
    ..DELTA
};

/// A turning base and two links, the second of which keeps its angle.
pub const ARTICULATED_DEPENDENT: RobotMachine = RobotMachine {
    keys: "type = \"articulated_dependent\"\nlink_lengths = [300.0, 250.0]\nbase_offsets = [20.0, 0.0, 40.0]\n\
           end_effector_offsets = [30.0, 0.0, -15.0]\n",
    joints: &[0.0, 70.0, -10.0],
    ..DELTA
};

/// Two arms in a vertical plane.
pub const DELTA_2: RobotMachine = RobotMachine {
    keys: "type = \"delta\"\nlink_lengths = [120.0, 260.0]\nbase_offsets = [60.0, 0.0, 0.0]\n\
           end_effector_offsets = [20.0, -30.0, 0.0]\n",
    joints: &[20.0, 20.0],
    ..DELTA
};

/// Two arms that lie, and a vertical axis.
pub const SCARA_DELTA: RobotMachine = RobotMachine {
    keys: "type = \"scara_delta\"\nlink_lengths = [120.0, 260.0]\nbase_offsets = [60.0, 0.0, 0.0]\n\
           end_effector_offsets = [20.0, 0.0, 0.0]\n",
    joints: &[20.0, 20.0, 5.0],
    ..DELTA
};

/// Two arms and a joint that turns the tool.
pub const DELTA_J1J2J6: RobotMachine = RobotMachine {
    keys: "type = \"delta\"\ndefinition = \"J1J2J6\"\nlink_lengths = [120.0, 260.0]\nbase_offsets = [60.0, 0.0, 0.0]\n\
           end_effector_offsets = [20.0, 0.0, -30.0]\nzero_angles = [3.0, -4.0, 2.0]\n",
    joints: &[23.0, 16.0, 40.0],
    ..DELTA
};

/// Three arms and a joint that turns the tool.
pub const DELTA_J1J2J3J6: RobotMachine = RobotMachine {
    keys: "type = \"delta\"\ndefinition = \"J1J2J3J6\"\nlink_lengths = [120.0, 260.0]\nbase_offsets = [60.0, 0.0, 0.0]\n\
           end_effector_offsets = [20.0, 0.0, -30.0]\nzero_angles = [3.0, -4.0, 2.0, 5.0]\n",
    joints: &[23.0, 16.0, 22.0, 40.0],
    ..DELTA
};

/// Three arms, and joints that turn and tilt the tool.
pub const DELTA_J1J2J3J4J5: RobotMachine = RobotMachine {
    keys: "type = \"delta\"\ndefinition = \"J1J2J3J4J5\"\nlink_lengths = [120.0, 260.0]\nbase_offsets = [60.0, 0.0, 0.0]\n\
           end_effector_offsets = [20.0, 0.0, -30.0]\nzero_angles = [3.0, -4.0, 2.0, 5.0, -6.0]\n",
    joints: &[23.0, 16.0, 22.0, 40.0, 20.0],
    ..DELTA
};

/// Two horizontal links, a vertical axis and a joint that turns the tool.
pub const SCARA_J1J2J3J6: RobotMachine = RobotMachine {
    keys: "type = \"scara_independent\"\ndefinition = \"J1J2J3J6\"\nlink_lengths = [250.0, 200.0]\n\
           zero_angles = [0.0, -5.0, 10.0, 15.0]\n",
    joints: &[10.0, 75.0, 10.0, 40.0],
    ..DELTA
};

/// An arm of six joints.
pub const SIX_AXES: RobotMachine = RobotMachine {
    keys: "type = \"articulated_independent\"\ndefinition = \"J1J2J3J4J5J6\"\nlink_lengths = [300.0, 250.0]\n\
           base_offsets = [20.0, 0.0, 40.0]\nend_effector_offsets = [60.0, 0.0, -15.0]\n",
    joints: &[5.0, 70.0, -80.0, 10.0, -60.0, 20.0],
    ..DELTA
};

/// Tags of a path move, `MCPM(…, Way, 1, Pace)`: 9.98 units along X and 10 degrees about Z from where it is, at 50 units/s and
/// 500 units/s²; it turns as fast as the line lets it.
pub const PATH_TAGS: &str = "[[tag]]\nname = \"Way\"\ntype = \"PATH_DATA\"\n\
    value = { InterpolationType = 1, Position = [9.98, 0, 0, 0, 0, 10, 0, 0, 0], MoveType = 1, TerminationType = 1 }\n\
    [[tag]]\nname = \"Pace\"\ntype = \"DYNAMICS_DATA\"\n\
    value = { UnitsMode = 1, Speed = 50, Acceleration = 500, Deceleration = 500, OrientationSpeed = 500, \
    OrientationAcceleration = 5000, OrientationDeceleration = 5000 }\n";

/// Tags for instructions of robots with wrists.
const TAGS: [(&str, &str); 6] = [
    ("Work", "POSITION_DATA"),
    ("Tool", "POSITION_DATA"),
    ("NoFrame", "POSITION_DATA"),
    ("Place", "REAL[6]"),
    ("Bits", "DINT"),
    ("Turns", "INT[4]"),
];

impl RobotMachine {
    /// Whether its system turns the tool too: `CART` then has `RX RY RZ` behind `X Y Z`.
    #[must_use]
    pub fn is_oriented(&self) -> bool {
        self.keys.contains("definition")
    }

    /// The configuration. Axes `X Y Z` are `CART`'s, `J1 J2 J3` the robot's, `U V W` a second Cartesian system `WORLD`'s; with a
    /// wrist there are tags for frames and results.
    pub fn config(&self) -> String {
        let mut text = format!(
            "[motion_group]\nname = \"Motion\"\ncoarse_update_period_ms = {:?}\n",
            self.period
        );
        let mut tags = String::new();
        let mut axis = |name: &str, units: &str, speed: f64, position: f64| {
            // Angles of an orientation may change by 180 degrees while the tool does not turn.
            let is_angle_of_tool = name.starts_with('R');
            text += &format!(
                "[[axis]]\nname = \"{name}\"\ntype = \"virtual\"\nunits = \"{units}\"\nmax_speed = {speed:?}\n\
                 max_acceleration = {:?}\ncommand_limits = {{ enabled = {:?} }}\nstart = {{ position = {position:?} }}\n",
                speed * 20.0,
                !is_angle_of_tool
            );
        };
        let axes = self.joints.len();
        for name in ["X", "Y", "Z", "U", "V", "W"] {
            axis(name, "mm", 2000.0, 0.0);
        }
        for name in ["RX", "RY", "RZ"].iter().filter(|_| self.is_oriented()) {
            axis(name, "deg", 3600.0, 0.0);
        }
        for (place, joint) in self.joints.iter().enumerate() {
            axis(&format!("J{}", place + 1), "deg", self.joint_speed, *joint);
        }
        let mut system = |name: &str, axes: &[&str], keys: &str| {
            text += &format!(
                "[[coordinate_system]]\nname = \"{name}\"\naxes = {axes:?}\nmax_speed = 1000.0\nmax_acceleration = 10000.0\n\
                 command_tolerance = 5.0\nqueue_depth = 8\n{keys}"
            );
        };
        if self.is_oriented() {
            for (name, kind) in TAGS {
                tags += &format!("[[tag]]\nname = \"{name}\"\ntype = \"{kind}\"\n");
            }
            let keys = format!("definition = \"XYZRxRyRz\"\n{}", self.cart);
            system("CART", &["X", "Y", "Z", "RX", "RY", "RZ"], &keys);
        } else {
            system("CART", &["X", "Y", "Z"][..axes], self.cart);
        }
        system("WORLD", &["U", "V", "W"][..axes.min(3)], "");
        system("ROBOT", &["J1", "J2", "J3", "J4", "J5", "J6"][..axes], self.keys);
        text + &tags
    }

    /// The machine at tick 0.
    pub fn bench(&self) -> Bench {
        Bench::with(&self.config())
    }
}
