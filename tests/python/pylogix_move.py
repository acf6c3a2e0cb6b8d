"""Drives an Arcline server with an unmodified pylogix: pylogix_move.py HOST:PORT."""

import struct
import sys

from pylogix import PLC
from checks import *

host, port = sys.argv[1].split(":")

PLAIN = [
    ("ABool", True), ("ASint", -128), ("AnInt", -32768), ("ADint", -2147483648), ("ALint", -9223372036854775808),
    ("AUsint", 255), ("AUint", 65535), ("AUdint", 4294967295), ("AUlint", 18446744073709551615),
    ("AReal", 1.5), ("AnLreal", 0.1), ("AString", "feed rate"),
]


def value(tag, count=1):
    response = plc.Read(tag, count)
    if response.Status != "Success":
        sys.exit(f"FAILED read {tag}: {response}")
    return response.Value


def write(tag, data):
    response = plc.Write(tag, data)
    if response.Status != "Success":
        sys.exit(f"FAILED write {tag}: {response}")


def positions():
    answers = plc.Read(["X.CommandPosition", "Y.CommandPosition", "Z.CommandPosition"])
    return [answer.Value for answer in answers]


with PLC(host, port=int(port)) as plc:
    # Browse.
    tags = {tag.TagName: tag for tag in plc.GetTagList().Value}
    for tag, expected in [("X", "AXIS_CIP_DRIVE"), ("A", "AXIS_VIRTUAL"), ("CS1", "COORDINATE_SYSTEM"),
                          ("Motion", "MOTION_GROUP"), ("ADint", "DINT")]:
        equal(f"type of {tag}", tags[tag].DataType, expected)
    equal("size of Dints", tags["Dints"].Size, 10)
    move = plc.UDT[tags["Move1"].DataTypeValue]
    for member in ("EnableIn", "EnableOut", "CoordinateSystem", "MotionControl", "Position", "Speed"):
        holds(f"Move1 has {member}", member in move.FieldsByName)
    instruction = plc.UDT[move.FieldsByName["MotionControl"].DataTypeValue]
    equal("its motion control", instruction.Name, "MOTION_INSTRUCTION")

    # Whole structures come as bytes.
    control = value("Move1.MotionControl")
    equal("MOTION_INSTRUCTION", motion_instruction(control), (0, 0, 0))
    equal("COORDINATE_SYSTEM has 104 bytes", len(value("CS1")), 104)
    equal("AXIS_CIP_DRIVE has 1040 bytes", len(value("X")), 1040)
    equal("MOTION_GROUP has 88 bytes", len(value("Motion")), 88)
    holds("Move1 as a whole", len(value("Move1")) > 16)

    # A move by tags, watched.
    write("Move1.Position[0]", [-60.0, 30.0, 90.0])
    write("Move1.Speed", 200.0)
    write("Move1.SpeedUnits", 0)
    write("Move1.TerminationType", 1)
    write("Move1.EnableIn", True)
    equal("DN, no ER", (value("Move1.MotionControl.DN"), value("Move1.MotionControl.ER")), (True, False))
    watch_straight_line("Move1", positions, (0, 0, 0), (-60, 30, 90), lambda: value("Move1.MotionControl.PC"))
    equal("end of Move1, exactly", positions(), [-60.0, 30.0, 90.0])
    write("Move1.EnableIn", False)

    # A refused operand.
    write("Move1.Speed", -5.0)
    write("Move1.EnableIn", True)
    flags, err, exerr = motion_instruction(value("Move1.MotionControl"))
    equal("ERR 13, EXERR 4 (Speed)", (flags & (ER | DN), err, exerr), (ER, 13, 4))
    write("Move1.Speed", 100.0)
    write("Move1.EnableIn", False)
    equal("nothing moved", positions(), [-60.0, 30.0, 90.0])

    # Plain data.
    for tag, data in PLAIN:
        write(tag, data)
        equal(f"{tag}", value(tag), data)
    answers = plc.Write(PLAIN)
    holds("all in one message", all(answer.Status == "Success" for answer in answers), answers)
    equal("read in one message", [answer.Value for answer in plc.Read([tag for tag, _ in PLAIN])],
          [data for _, data in PLAIN])
    dints = [7 * i - 30 for i in range(10)]
    write("Dints[0]", dints)
    equal("an array", value("Dints[0]", 10), dints)
    equal("from an element on", value("Dints[4]", 3), dints[4:7])
    write("Dints[0].3", True)
    equal("a bit", value("Dints[0]"), dints[0] | 8)
    bools = [i % 3 == 0 for i in range(64)]
    write("Bools[0]", bools)
    equal("an array of BOOL", value("Bools[0]", 64), bools)
    equal("one of them", value("Bools[33]"), True)
    write("Strings[1]", "second")
    equal("an element of an array of STRING", value("Strings[1]"), "second")
    recipe = [i / 8 for i in range(3000)]
    write("Recipe[0]", recipe)
    equal("12,000 bytes", value("Recipe[0]", 3000), recipe)

    # Requests that the server must refuse.
    equal("an axis is read-only", plc.Write("X.CommandPosition", 5.0).Status, "Privilege violation")
    equal("so is a motion control", plc.Write("Move1.MotionControl.FLAGS", 0).Status, "Privilege violation")
    holds("unknown tag", plc.Read("NoSuchTag").Status in ("Path destination unknown", "Path segment error"),
          plc.Read("NoSuchTag").Status)
    mixed = plc.Read(["ADint", "NoSuchTag", "AUint"])
    equal("unknown among known", [answer.Status == "Success" for answer in mixed], [True, False, True])
    equal("still connected", value("ADint"), -2147483648)

# pylogix sends generic messages unconnected.
with PLC(host, port=int(port)) as plc:
    def reply(response):
        if response.Status != "Success":
            sys.exit(f"FAILED {response}")
        return response.Value[44:]

    device = plc.GetDeviceProperties()
    equal("device properties", device.Status, "Success")
    data = reply(plc.Message(MCLM, COORDINATE_SYSTEM, 1, data=linear_move("Generic3", (0, 0, 0), 400.0)))
    instance = struct.unpack_from("<I", data)[0]
    flags, err, exerr = motion_instruction(data[4:])
    equal("MCLM, unconnected: DN, no ER", (flags & (DN | ER), err, exerr), (DN, 0, 0))
    eventually("PC by class 0x0303", lambda: motion_instruction(
        reply(plc.Message(GET_ATTRIBUTES_ALL, MOTION_INSTRUCTION, instance)))[0] & PC)
    refused = plc.Message(MCLM, COORDINATE_SYSTEM, 1, data=linear_move("Generic3", (9, 9, 9), -1.0))
    equal("refused with ERR 13 and EXERR 4 in the additional status", refused.Value[40:48],
          bytes((MCLM | 0x80, 0, 0x1F, 2)) + struct.pack("<hh", 13, 4))

with PLC(host, port=int(port)) as plc:
    equal("end of the move, exactly", positions(), [0.0, 0.0, 0.0])

print("pylogix: all as expected")
