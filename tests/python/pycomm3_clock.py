"""A server on the step clock with stock pycomm3: pycomm3_clock.py HOST:PORT LINE.

A move of ten seconds passes in steps, its positions are those of the virtual clock, and real time makes none of it pass.
"""

import struct
import sys
import time

from pycomm3 import LogixDriver, Services

from checks import holds as check

MACHINE = 0x0305
STEP = 0x36


def step(plc, ticks, until=""):
    """Ticks pass, `ticks` at most, until a tag is not 0. Returns the reply's error."""
    data = struct.pack("<I", ticks)
    if until:
        data += bytes([len(until)]) + until.encode()
    reply = plc.generic_message(service=STEP, class_code=MACHINE, instance=1, request_data=data, connected=True)
    return reply.error


def attribute(plc, number, layout):
    reply = plc.generic_message(service=Services.get_attribute_single, class_code=MACHINE, instance=1, attribute=number, connected=True)
    return struct.unpack(layout, reply.value)[0]



with LogixDriver(sys.argv[1]) as plc:
    check("the machine is on the step clock", attribute(plc, 6, "<?") is True)
    check("ClockStep is a DINT", plc.tags["ClockStep"]["data_type_name"] == "DINT")
    tick = plc.read("ClockStep").value
    time.sleep(0.05)
    check("real time lets no tick pass", plc.read("ClockStep").value == tick)

    plc.write(("Move1.Position{3}", [100.0, 50.0, 25.0]), ("Move1.Speed", 10.0), ("Move1.SpeedUnits", 0), ("Move1.EnableIn", True))
    check("the instruction is executed at the present tick", plc.read("Move1.MotionControl.IP").value is True)
    check("and no tick has passed", plc.read("ClockStep").value == tick)
    check("the axis has not moved", plc.read("X.CommandPosition").value == 0.0)

    check("ClockStep is written", plc.write(("ClockStep", 1000)).error is None)
    check("so many ticks have passed", plc.read("ClockStep").value == tick + 1000)
    at_one = plc.read("X.CommandPosition").value
    print(f"x after 1 s: {at_one!r}")
    check("the move goes on", 0.0 < at_one < 100.0 and plc.read("Move1.MotionControl.PC").value is False)

    began = time.monotonic()
    check("until the move has ended", step(plc, 100_000, "Move1.MotionControl.PC") is None)
    took = time.monotonic() - began
    ended = plc.read("ClockStep").value
    check("it is at its target", [plc.read(f"{axis}.CommandPosition").value for axis in "XYZ"] == [100.0, 50.0, 25.0])
    check("PC is set", plc.read("Move1.MotionControl.PC").value is True)
    check("the move took seconds of the machine", ended - tick > 10_000)
    print(f"ticks: {ended - tick}")
    print(f"{(ended - tick) / 1000:.3f} s of the machine in {took:.3f} s", file=sys.stderr)
    # Half a second with a debug build on a busy computer; a release build takes milliseconds.
    check("ten seconds of the machine take less than three", took < 3.0, took)
    check("a condition that holds lets nothing pass", step(plc, 1000, "Move1.PC") is None and plc.read("ClockStep").value == ended)
    check("the tick is an attribute", attribute(plc, 5, "<Q") == ended)

    check("a tag that is not there is refused", step(plc, 10, "Nobody") is not None)
    check("too many ticks are refused", step(plc, 1_000_001) is not None)
    check("negative ticks are refused", plc.write(("ClockStep", -1)).error is not None)
    check("nothing has passed", plc.read("ClockStep").value == ended)

    # STOP acts without a step, and the axis comes to rest after some steps.
    plc.write("Move1.EnableIn", False)
    plc.write(("Move1.Position{3}", [0.0, 0.0, 0.0]), ("Move1.EnableIn", True))
    step(plc, 500)
    plc.write("MotionInhibit", True)
    step(plc, 5000)
    stopped = plc.read("X.CommandPosition").value
    step(plc, 100)
    check("STOP stops", plc.read("X.CommandPosition").value == stopped and 0.0 < stopped < 100.0)
    print(f"stopped at {stopped!r}")
