"""Jogs the axis S with an unmodified pylogix until it is killed: pylogix_jog.py HOST:PORT."""

import sys
import time

from pylogix import PLC

host, port = sys.argv[1].split(":")
with PLC(host, port=int(port)) as plc:
    for member, value in [("Speed", 50.0), ("SpeedUnits", 0), ("AccelRate", 5000.0), ("AccelUnits", 0), ("DecelRate", 5000.0),
                          ("DecelUnits", 0), ("EnableIn", True)]:
        response = plc.Write(f"Jog1.{member}", value)
        if response.Status != "Success":
            sys.exit(f"FAILED {member}: {response}")
    while True:
        plc.Read("S.CommandVelocity")
        time.sleep(0.1)
