"""Every type and shape of tag by an unmodified pycomm3: pycomm3_tags.py HOST:PORT."""

import sys

from pycomm3 import CIPDriver, LogixDriver
from checks import *

server = sys.argv[1]

POINT = {"At": [1.5, -2.5], "Valid": True, "Used": False, "Id": -3}
ROUTE = {"Name": "north", "Count": 5, "Points": [dict(POINT, Id=i) for i in range(3)],
         "Flags": [i % 5 == 0 for i in range(32)], "Home": dict(POINT, Valid=False, Used=True)}
MIXED = {"ABool": True, "ASint": -1, "AnInt": -2, "ADint": -3, "ALint": -4, "AReal": 0.5, "AnLreal": 0.1}
ARRAYS = [
    ("Sints{1001}", [i % 256 - 128 for i in range(1001)]), ("Ints{7}", [-3, -2, -1, 0, 1, 2, 32767]),
    ("Lints{5}", [-(1 << 63), -1, 0, 1, (1 << 63) - 1]), ("Lreals{5}", [0.1, -0.1, 1e300, 0.0, 3.0]),
    ("Grid{6}", [1, 2, 3, 4, 5, 6]), ("Cube{24}", [i * i for i in range(24)]),
    ("Strings{3}", ["one", "", "x" * 82]),
]

with LogixDriver(server) as plc:
    # Browse: pages, dimensions, structures, both programs.
    equal("all pages", [plc.tags[f"Page{i:03}"]["data_type"] for i in range(300)], ["DINT"] * 300)
    for tag, dimensions, data_type in [
            ("Sints", [1001, 0, 0], "SINT"), ("Grid", [2, 3, 0], "INT"), ("Cube", [2, 3, 4], "DINT"),
            ("Routes", [4, 0, 0], "Route"), ("PointGrid", [2, 2, 0], "Point"), ("APoint", [0, 0, 0], "Point"),
            ("Program:Main.Points", [2, 0, 0], "Point"), ("Program:Other.Text", [0, 0, 0], "STRING")]:
        info = plc.tags[tag]
        equal(f"{tag} in the list", (list(info["dimensions"]), info["data_type_name"]), (dimensions, data_type))
    equal("a read-only tag", plc.tags["Fixed"]["external_access"], "Read Only")
    equal("an alias", plc.tags["Corner"]["alias"], True)
    equal("the programs", sorted(plc.info["programs"]), ["Main", "Other"])
    equal("members of Route", plc.tags["Routes"]["data_type"]["attributes"], ["Name", "Count", "Points", "Flags", "Home"])

    # First values, then one at a time, then all in as few messages as pycomm3 makes of them.
    equal("first value of a structure", plc.read("APoint").value, {"At": [1.5, -2.5], "Valid": True, "Used": False, "Id": 3})
    equal("first value of two dimensions", plc.read("Grid{6}").value, [11, 12, 13, 21, 22, 23])
    for tag, value in ARRAYS:
        written = plc.write(tag, value)
        holds(f"write {tag}", written, written)
        equal(f"read {tag}", plc.read(tag).value, value)
    together = plc.write(*ARRAYS)
    holds("all arrays at once", all(together), together)
    equal("read at once", [tag.value for tag in plc.read(*(tag for tag, _ in ARRAYS))], [value for _, value in ARRAYS])
    for tag, expected in [("Grid[1,2]", 6), ("Cube[1,2,3]", 23 * 23), ("Cube[0,1,2]", 36), ("Grid[1,0]{3}", [4, 5, 6]),
                          ("Sints[999]{2}", ARRAYS[0][1][999:]), ("Strings[2]", "x" * 82), ("Corner", 6)]:
        equal(f"read {tag}", plc.read(tag).value, expected)
    for tag, value in [("Grid[0,1]", -7), ("Cube[1,0,2]", 99), ("Cube[1,2,0]{4}", [9, 8, 7, 6]), ("Corner", -6)]:
        holds(f"write {tag}", plc.write(tag, value))
        equal(f"read {tag} back", plc.read(tag).value, value)
    equal("the alias wrote its target", plc.read("Grid[1,2]").value, -6)
    holds("bit 31 of an element", plc.write("Cube[0,0,0].31", True))
    equal("bit 31 is set", plc.read("Cube[0,0,0].31", "Cube[0,0,0]")[1].value, -(1 << 31))
    holds("two bits of one word in one call", all(plc.write(("ADint.0", True), ("ADint.3", True))))
    equal("both are set", plc.read("ADint").value & 9, 9)
    holds("one BOOL of an array", plc.write("Bools[37]", True))
    equal("only that one", plc.read("Bools[32]{32}").value, [i == 5 for i in range(32)])

    # Types of programs, which it knows itself.
    equal("a TIMER", plc.read("Dwell").value, {"PRE": 500, "ACC": 20, "EN": True, "TT": False, "DN": False})
    holds("write a TIMER", plc.write("Dwell", {"PRE": 700, "ACC": 0, "EN": False, "TT": True, "DN": True}))
    equal("its bits", [plc.read(f"Dwell.{bit}").value for bit in ("EN", "TT", "DN", "PRE")], [False, True, True, 700])
    holds("a member of a COUNTER", plc.write("Parts[1].CU", True))
    equal("that COUNTER", plc.read("Parts[1]").value,
          {"PRE": 0, "ACC": 0, "CU": True, "CD": False, "DN": False, "OV": False, "UN": False})

    # Structures.
    for tag, value in [("AMixed", MIXED), ("APoint", POINT), ("ARoute", ROUTE), ("Routes[2]", ROUTE),
                       ("Routes[2].Points[1]", dict(POINT, Id=77)), ("PointGrid[1,0]", POINT),
                       ("Program:Main.Points[1]", POINT)]:
        written = plc.write(tag, value)
        holds(f"write {tag}", written, written)
        equal(f"read {tag}", plc.read(tag).value, value)
    routes = [dict(ROUTE, Count=i) for i in range(4)]
    written = plc.write("Routes{4}", routes)
    holds("an array of structures", written, written)
    equal("read it", plc.read("Routes{4}").value, routes)
    for tag, value in [("Routes[3].Name", "south"), ("Routes[3].Points[2].At[1]", 0.25), ("Routes[0].Home.Valid", True),
                       ("Routes[1].Flags[7]", True), ("AMixed.ABool", False), ("ARoute.Points[0].At{2}", [3.0, 4.0]),
                       ("Program:Main.Count", 70), ("Program:Main.ADint", 1 << 40), ("Program:Other.Text", "here")]:
        written = plc.write(tag, value)
        holds(f"write {tag}", written, written)
        equal(f"read {tag}", plc.read(tag).value, value)
    equal("neighbours stay", plc.read("Routes[0].Home").value, dict(ROUTE["Home"], Valid=True))
    holds("a program's tag is another", plc.read("ADint").value != 1 << 40)

    # Requests that the server must refuse one by one, without harm to their neighbours.
    written = plc.write(("Fixed", 1), ("ADint", 5))
    equal("read-only among others", [bool(tag) for tag in written], [False, True])
    equal("unchanged", plc.read("Fixed").value, 42)
    several = plc.read("ADint", "Nothing", "Grid[5,0]", "Program:None.X", "Corner")
    equal("unknown among known", [bool(tag) for tag in several], [True, False, False, False, True])

    # Several hundred tags in one call.
    equal("300 tags in one call", len([tag for tag in plc.write(*((f"Page{i:03}", i) for i in range(300))) if tag]), 300)
    equal("read back", [tag.value for tag in plc.read(*(f"Page{i:03}" for i in range(300)))], list(range(300)))

    # The rest that pycomm3 offers.
    holds("program name", plc.get_plc_name())
    holds("identity over CIP", plc.get_plc_info()["product_name"])
    holds("wall clock", plc.get_plc_time())
    reply = plc.generic_message(0x0E, 0x0300 + 1, 1, b"\x01\x03", name="16-bit class, unknown attribute")
    holds("a generic message gets an answer", reply.error is None or "timed out" not in reply.error, reply)

holds("ListIdentity over TCP", CIPDriver.list_identity(server)["product_name"])
print("pycomm3: all as expected")
