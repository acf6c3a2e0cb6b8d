"""Drives an Arcline server with an unmodified pycomm3: pycomm3_move.py HOST:PORT."""

import struct
import sys

from pycomm3 import CIPDriver, LogixDriver
from checks import *

server = sys.argv[1]

PLAIN = [
    ("ABool", True), ("ASint", -128), ("AnInt", -32768), ("ADint", -2147483648), ("ALint", -9223372036854775808),
    ("AUsint", 255), ("AUint", 65535), ("AUdint", 4294967295), ("AUlint", 18446744073709551615),
    ("AReal", 1.5), ("AnLreal", 0.1), ("AString", "feed rate"),
]


def positions(plc):
    return [tag.value for tag in plc.read("X.CommandPosition", "Y.CommandPosition", "Z.CommandPosition")]


with LogixDriver(server) as plc:
    # Browse.
    holds("identity", plc.info["product_name"], plc.info)
    types = {tag: info["data_type_name"] for tag, info in plc.tags.items()}
    for tag, expected in [("X", "AXIS_CIP_DRIVE"), ("A", "AXIS_VIRTUAL"), ("CS1", "COORDINATE_SYSTEM"),
                          ("Motion", "MOTION_GROUP"), ("ADint", "DINT"), ("AString", "STRING")]:
        equal(f"type of {tag}", types.get(tag), expected)
    holds("instruction tags are structures", {"Move1", "Arc1", "Change1", "Stop1"} <= set(types), sorted(types))
    equal("a dimension", plc.tags["Dints"]["dimensions"][0], 10)

    # Whole structures.
    axis, system, group, move = (tag.value for tag in plc.read("X", "CS1", "Motion", "Move1"))
    equal("X.CommandPosition at the start", axis["CommandPosition"], 0.0)
    equal("X.ServoActionStatus", axis["ServoActionStatus"], True)
    equal("CS1.ReadyStatus", system["ReadyStatus"], True)
    equal("CS1.ActualPosition has 8 elements", len(system["ActualPosition"]), 8)
    equal("Motion.GroupSynced", group["GroupSynced"], True)
    equal("Move1.CoordinateSystem", move["CoordinateSystem"], "CS1")
    equal("Move1.Speed", move["Speed"], 100.0)
    control = move["MotionControl"]
    equal("Move1.MotionControl at the start", (control["FLAGS"], control["ERR"], control["EXERR"]), (0, 0, 0))

    # A move by tags, watched.
    plc_writes = plc.write(
        ("Move1.Position{3}", [100.0, 50.0, 25.0]), ("Move1.Speed", 200.0), ("Move1.SpeedUnits", 0),
        ("Move1.TerminationType", 1), ("Move1.EnableIn", True))
    holds("operands and EnableIn in one message", all(plc_writes), plc_writes)
    control = plc.read("Move1.MotionControl").value
    equal("EN and DN, no ER", (control["EN"], control["DN"], control["ER"]), (True, True, False))
    watch_straight_line("Move1", lambda: positions(plc), (0, 0, 0), (100, 50, 25),
                        lambda: plc.read("Move1.MotionControl.PC").value)
    equal("end of Move1, exactly", positions(plc), [100.0, 50.0, 25.0])
    control = plc.read("Move1.MotionControl").value
    equal("IP and AC cleared", (control["IP"], control["AC"]), (False, False))
    eventually("actual positions arrive", lambda: all(
        abs(tag.value - end) < 0.01 for tag, end in
        zip(plc.read("X.ActualPosition", "Y.ActualPosition", "Z.ActualPosition"), (100, 50, 25))))
    plc.write("Move1.EnableIn", False)
    eventually("EN follows EnableIn", lambda: not plc.read("Move1.MotionControl.EN").value)

    # A refused operand.
    refused = plc.write(("Move1.Speed", -5.0), ("Move1.EnableIn", True))
    holds("the writes are accepted", all(refused), refused)
    control = plc.read("Move1.MotionControl").value
    equal("ERR 13, EXERR 4 (Speed)", (control["ER"], control["DN"], control["ERR"], control["EXERR"]),
          (True, False, 13, 4))
    plc.write(("Move1.Speed", 100.0), ("Move1.EnableIn", False))
    equal("nothing moved", positions(plc), [100.0, 50.0, 25.0])

    # Plain data.
    for tag, value in PLAIN:
        written = plc.write(tag, value)
        holds(f"write {tag}", written, written)
        equal(f"read {tag}", plc.read(tag).value, value)
    together = plc.write(*PLAIN)
    holds("all in one message", all(together), together)
    equal("read in one message", [tag.value for tag in plc.read(*(tag for tag, _ in PLAIN))],
          [value for _, value in PLAIN])
    dints = [7 * i - 30 for i in range(10)]
    holds("write an array", plc.write("Dints{10}", dints))
    equal("read an array", plc.read("Dints{10}").value, dints)
    equal("read from an element on", plc.read("Dints[4]{3}").value, dints[4:7])
    holds("write an element", plc.write("Dints[9]", -1))
    equal("read an element", plc.read("Dints[9]").value, -1)
    holds("write a bit", plc.write("Dints[0].3", True))
    equal("the bit is set", plc.read("Dints[0]").value, dints[0] | 8)
    bools = [i % 3 == 0 for i in range(64)]
    holds("write an array of BOOL", plc.write("Bools[0]{64}", bools))
    equal("read an array of BOOL", plc.read("Bools[0]{64}").value, bools)
    equal("read one of them", plc.read("Bools[33]").value, True)
    holds("write an element of an array of STRING", plc.write("Strings[1]", "second"))
    equal("read an array of STRING", plc.read("Strings{3}").value, ["", "second", ""])
    recipe = [i / 8 for i in range(3000)]
    holds("write 12,000 bytes", plc.write("Recipe{3000}", recipe))
    equal("read 12,000 bytes", plc.read("Recipe{3000}").value, recipe)

    # Requests that the server must refuse.
    for tag, value in [("X.CommandPosition", 5.0), ("Move1.MotionControl.FLAGS", 0), ("CS1.CoordinateSystemStatus", 0)]:
        written = plc.write(tag, value)
        holds(f"{tag} is read-only", not written and "Permission denied" in written.error, written)
    equal("and was not written", positions(plc), [100.0, 50.0, 25.0])
    holds("unknown tag", not plc.read("NoSuchTag"))

    # The generic service on a coordinate system, connected.
    reply = plc.generic_message(MCLM, COORDINATE_SYSTEM, 1, request_data=linear_move("Generic1", (0, 0, 0), 400.0))
    holds("MCLM, connected", reply, reply)
    instance = struct.unpack_from("<I", reply.value)[0]
    flags, err, exerr = motion_instruction(reply.value[4:])
    equal("DN, no ER, ERR 0", (flags & (DN | ER), err, exerr), (DN, 0, 0))

    def state(number):
        status = plc.generic_message(GET_ATTRIBUTES_ALL, MOTION_INSTRUCTION, number)
        return motion_instruction(status.value) if status else None

    eventually("PC by class 0x0303", lambda: state(instance)[0] & PC)
    equal("end of the move", positions(plc), [0.0, 0.0, 0.0])
    equal("an instance that never was", state(instance + 1000), None)
    packet = plc.generic_message(MCLM, COORDINATE_SYSTEM, 1, request_data=linear_move("Generic1", (9, 9, 9), -1.0),
                                 return_response_packet=True)
    raw = packet.value.raw
    equal("refused with ERR 13 and EXERR 4 in the additional status", raw[46:54],
          bytes((MCLM | 0x80, 0, 0x1F, 2)) + struct.pack("<hh", 13, 4))
    short = plc.generic_message(MCLM, COORDINATE_SYSTEM, 1, request_data=linear_move("G", (9, 9, 9), 1.0)[:-3],
                                return_response_packet=True)
    equal("data cut short: 0x13", short.value.raw[48], 0x13)

# The same without a connection, by the plain CIP driver.
with CIPDriver(server) as device:
    reply = device.generic_message(MCLM, COORDINATE_SYSTEM, 1, connected=False,
                                   request_data=linear_move("Generic2", (10, -10, 5), 400.0))
    holds("MCLM, unconnected", reply, reply)
    instance = struct.unpack_from("<I", reply.value)[0]
    eventually("PC by class 0x0303, unconnected", lambda: motion_instruction(device.generic_message(
        GET_ATTRIBUTES_ALL, MOTION_INSTRUCTION, instance, connected=False).value)[0] & PC)
    reply = device.generic_message(MCLM, COORDINATE_SYSTEM, 1, connected=True,
                                   request_data=linear_move("Generic2", (0, 0, 0), 400.0))
    holds("MCLM, connected by CIPDriver", reply, reply)

with LogixDriver(server) as plc:
    holds("motion control tags of services are tags", "Generic1" in plc.tags and "Generic2" in plc.tags)
    eventually("back at the start", lambda: plc.read("Generic2.PC").value)
    equal("exactly", positions(plc), [0.0, 0.0, 0.0])

print("pycomm3: all as expected")
