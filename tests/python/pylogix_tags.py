"""Every type and shape of tag by an unmodified pylogix: pylogix_tags.py HOST:PORT."""

import struct
import sys

from pylogix import PLC
from checks import *

host, port = sys.argv[1].split(":")

def ok(what, response):
    holds(what, response.Status == "Success", response)
    return response.Value


with PLC(host, port=int(port)) as plc:
    # Browse: pages, dimensions, structures, both programs.
    tags = {tag.TagName: tag for tag in ok("tag list", plc.GetTagList())}
    equal("all pages", sum(f"Page{i:03}" in tags for i in range(300)), 300)
    for tag, data_type, dimensions, size in [
            ("Sints", "SINT", 1, 1001), ("Grid", "INT", 2, 2), ("Cube", "DINT", 3, 2), ("Routes", "Route", 1, 4),
            ("APoint", "Point", 0, 0), ("Program:Main.Points", "Point", 1, 2), ("Program:Other.Text", "ASCIISTRING82", 0, 0)]:
        found = tags[tag]
        equal(f"{tag} in the list", (found.DataType, found.Array, found.Size), (data_type, dimensions, size))
    route = plc.UDT[tags["Routes"].DataTypeValue]
    equal("members of Route", [field.TagName for field in route.Fields], ["Name", "Count", "Points", "Flags", "Home"])
    equal("template by name", plc.UDTByName["Point"].FieldsByName["Id"].DataType, "SINT")
    programs = ok("program list", plc.GetProgramsList())
    equal("programs", sorted(programs), ["Program:Main", "Program:Other"])
    main = ok("tags of one program", plc.GetProgramTagList("Program:Main"))
    equal("their names", sorted(tag.TagName for tag in main),
          ["Program:Main.ADint", "Program:Main.Count", "Program:Main.Points"])

    # Arrays.
    for tag, values in [
            ("Sints[0]", [i % 256 - 128 for i in range(1001)]), ("Ints[0]", [-3, -2, -1, 0, 1, 2, 32767]),
            ("Lints[0]", [-(1 << 63), -1, 0, 1, (1 << 63) - 1]), ("Lreals[0]", [0.1, -0.1, 1e300, 0.0, 3.0]),
            ("Grid[0,0]", [1, 2, 3, 4, 5, 6]), ("Cube[0,0,0]", [i * i for i in range(24)]),
            ("Strings[0]", ["one", "", "x" * 82])]:
        ok(f"write {tag}", plc.Write(tag, values))
        equal(f"read {tag}", ok(tag, plc.Read(tag, len(values))), values)
    for tag, expected in [("Grid[1,2]", 6), ("Cube[1,2,3]", 23 * 23), ("Cube[0,1,2]", 36), ("Corner", 6),
                          ("Strings[2]", "x" * 82)]:
        equal(f"read {tag}", ok(tag, plc.Read(tag)), expected)
    for tag, value in [("Grid[0,1]", -7), ("Cube[1,0,2]", 99), ("Corner", -6), ("ADint.5", True), ("ADint.31", True),
                       ("Cube[0,0,1].4", True), ("Bools[37]", True), ("Strings[1]", "two")]:
        ok(f"write {tag}", plc.Write(tag, value))
        equal(f"read {tag} back", ok(tag, plc.Read(tag)), value)
    equal("the alias wrote its target", ok("Grid", plc.Read("Grid[1,2]")), -6)
    equal("BOOLs around", ok("Bools", plc.Read("Bools[32]", 32)), [i == 5 for i in range(32)])

    # Structures are bytes to pylogix, which reads them whole, in arrays and nested, and writes their members.
    equal("first value of a structure", ok("APoint", plc.Read("APoint"))[:10], struct.pack("<2fBb", 1.5, -2.5, 1, 3))
    equal("all of an array", len(ok("Routes", plc.Read("Routes[0]", 4))), 4 * len(ok("one", plc.Read("Routes[0]"))))
    equal("a nested one", len(ok("nested", plc.Read("Routes[2].Points[1]"))), 12)
    equal("two dimensions of them", len(ok("PointGrid", plc.Read("PointGrid[0,0]", 4))), 48)
    for tag, value in [("Routes[3].Name", "south"), ("Routes[3].Points[2].At[1]", 0.25), ("Routes[0].Home.Valid", True),
                       ("Routes[1].Flags[7]", True), ("AMixed.ABool", True), ("AMixed.ALint", -4), ("AMixed.AnLreal", 0.1),
                       ("Program:Main.Count", 71), ("Program:Main.ADint", 1 << 41), ("Program:Other.Text", "there"),
                       ("Program:Main.Points[1].At[0]", 2.5), ("PointGrid[1,0].Id", -5)]:
        ok(f"write {tag}", plc.Write(tag, value))
        equal(f"read {tag} back", ok(tag, plc.Read(tag)), value)

    # Several in one call, one of them unknown, one read-only.
    answers = plc.Read(["Corner", "Nothing", "Routes[3].Name", "Grid[5,0]"])
    equal("unknown among known", [answer.Status == "Success" for answer in answers], [True, False, True, False])
    answers = plc.Write([("Fixed", 1), ("ADint", 5)])
    equal("read-only among others", [answer.Status == "Success" for answer in answers], [False, True])
    equal("unchanged", ok("Fixed", plc.Read("Fixed")), 42)
    names = [f"Page{i:03}" for i in range(300)]
    holds("300 tags in one call", all(a.Status == "Success" for a in plc.Write([(n, i) for i, n in enumerate(names)])))
    equal("read back", [answer.Value for answer in plc.Read(names)], list(range(300)))

    # The rest that pylogix offers.
    ok("wall clock", plc.GetPLCTime())
    ok("device properties", plc.GetDeviceProperties())
    ok("module properties", plc.GetModuleProperties(0))

print("pylogix: all as expected")
