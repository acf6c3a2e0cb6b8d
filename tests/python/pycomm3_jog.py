"""Jogs the axis S with an unmodified pycomm3 until it is killed: pycomm3_jog.py HOST:PORT."""

import sys
import time

from pycomm3 import LogixDriver

with LogixDriver(sys.argv[1]) as plc:
    written = plc.write(("Jog1.Speed", 50.0), ("Jog1.SpeedUnits", 0), ("Jog1.AccelRate", 5000.0), ("Jog1.AccelUnits", 0),
                        ("Jog1.DecelRate", 5000.0), ("Jog1.DecelUnits", 0), ("Jog1.EnableIn", True))
    if not all(written):
        sys.exit(f"FAILED {written}")
    while True:
        plc.read("S.CommandVelocity")
        time.sleep(0.1)
