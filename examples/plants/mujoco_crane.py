"""A load that swings under the trolley of a crane: MuJoCo is the plant of axis X. python mujoco_crane.py [PICTURE.png]

pip install mujoco matplotlib. The trolley goes 1.5 m with ramps as long as one swing of the load, which leave the load at rest, and back with short ones.
"""

import sys

import arcline
import mujoco
import numpy as np

LENGTH = 1.0  # of the rope, m
MODEL = f"""
<mujoco>
  <option timestep="0.001" integrator="RK4"/>
  <worldbody>
    <body name="trolley">
      <joint name="rail" type="slide" axis="1 0 0"/>
      <geom type="box" size=".15 .1 .05" mass="20"/>
      <body name="load">
        <joint name="swing" type="hinge" axis="0 1 0"/>
        <geom type="sphere" pos="0 0 -{LENGTH}" size=".01" mass="5"/>
      </body>
    </body>
  </worldbody>
  <actuator><motor joint="rail"/></actuator>
</mujoco>
"""
STIFFNESS, DAMPING = 250e3, 4e3  # of the position loop of the drive: N/m, N s/m
PERIOD = 2 * np.pi * np.sqrt(LENGTH / 9.81)  # of the swing, s
SPEED, DISTANCE = 500, 1500  # mm/s, mm
MOVE = "MAM(X, {tag}, Absolute, {to}, {speed}, Unitspersec, {rate}, Unitspersec2, {rate}, Unitspersec2, Trapezoidal); WAIT({tag}.PC); DELAY(3);\n"
PROGRAM = MOVE.format(tag="There", to=DISTANCE, speed=SPEED, rate=SPEED / PERIOD) + MOVE.format(tag="Back", to=0, speed=SPEED, rate=2000)


class Crane:
    """The drive of axis X, its trolley and the load: one step of MuJoCo in each tick. Arcline counts in mm, MuJoCo in m."""

    def __init__(self):
        self.model = mujoco.MjModel.from_xml_string(MODEL)
        self.data = mujoco.MjData(self.model)
        self.angles = []

    def __call__(self, set_points, feedback):
        data = self.data
        if set_points.enable[0]:
            behind = set_points.position[0] / 1e3 - data.qpos[0]
            slower = set_points.velocity[0] / 1e3 - data.qvel[0]
            data.ctrl[0] = STIFFNESS * behind + DAMPING * slower
        else:
            data.ctrl[0] = 0.0
        mujoco.mj_step(self.model, data)
        feedback.position[0] = data.qpos[0] * 1e3
        feedback.velocity[0] = data.qvel[0] * 1e3
        self.angles.append(np.degrees(data.qpos[1]))


def main(picture=None):
    crane = Crane()
    machine = arcline.Machine(plant=crane, plant_axes=["X"])
    program = machine.program(PROGRAM)
    rows = []
    while not program.done:
        rows.append(machine.trace(["X.CommandPosition", "X.ActualPosition"], 500))
    if program.error:
        raise program.error
    command, actual = np.concatenate(rows).T
    # The plant has seen the present tick, whose row comes with the next step.
    angle = np.array(crane.angles[: len(command)])
    if picture is not None:
        plot(command, actual, angle, picture)
    return command, actual, angle


def plot(command, actual, angle, file):
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, (upper, lower) = plt.subplots(2, 1, figsize=(9, 5), sharex=True, layout="constrained")
    times = np.arange(len(command)) / 1000
    upper.plot(times, command, label="X.CommandPosition")
    upper.plot(times, actual, "--", label="X.ActualPosition, of MuJoCo")
    upper.plot(times, actual - np.sin(np.radians(angle)) * LENGTH * 1e3, lw=1, label="the load")
    upper.set_ylabel("mm")
    upper.legend()
    lower.plot(times, angle, color="C2")
    lower.set_ylabel("angle of the rope, °")
    lower.set_xlabel("time, s")
    for axes in (upper, lower):
        axes.grid(alpha=0.3)
    figure.savefig(file, dpi=120)


if __name__ == "__main__":
    main(*sys.argv[1:])
