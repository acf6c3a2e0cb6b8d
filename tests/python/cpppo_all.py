"""Drives an Arcline server with an unmodified cpppo client: cpppo_all.py HOST:PORT. cpppo does not browse."""

import struct
import sys

from cpppo.server.enip import client
from checks import *

host, port = sys.argv[1].split(":")

TAGS = [
    ("ABool", "(BOOL)1", [1]), ("ASint", "(SINT)-128", [-128]), ("AnInt", "(INT)-32768", [-32768]),
    ("ADint", "(DINT)-2147483648", [-2147483648]), ("ALint", "(LINT)-9", [-9]), ("AUsint", "(USINT)255", [255]),
    ("AUint", "(UINT)65535", [65535]), ("AUdint", "(UDINT)4294967295", [4294967295]),
    ("AUlint", "(ULINT)18446744073709551615", [18446744073709551615]), ("AReal", "(REAL)1.5", [1.5]),
    ("AnLreal", "(LREAL)0.1", [0.1]),
    # Elements, members, other scopes.
    ("Dints[2-4]", "(DINT)1,-2,3", [1, -2, 3]), ("Ints[0-6]", "(INT)1,2,3,4,5,6,7", [1, 2, 3, 4, 5, 6, 7]),
    ("Lints[1-2]", "(LINT)5,6", [5, 6]), ("Lreals[0-1]", "(LREAL)0.5,0.1", [0.5, 0.1]), ("Sints[1000]", "(SINT)7", [7]),
    ("Routes[1].Count", "(DINT)12", [12]), ("Routes[1].Points[2].At[0-1]", "(REAL)3.5,4.5", [3.5, 4.5]),
    ("Routes[1].Home.Valid", "(BOOL)1", [1]), ("AMixed.AnInt", "(INT)-2", [-2]), ("Corner", "(INT)6", [6]),
    ("Program:Main.Count", "(DINT)74", [74]), ("Program:Main.ADint", "(LINT)99", [99]),
    ("Program:Main.Points[1].Id", "(SINT)-4", [-4]),
]


def run(plc, *tags, **how):
    return list(plc.results(client.parse_operations(tags), timeout=20.0, **how))


def numbers(plc, **how):
    for tag, value, expected in TAGS:
        equal(f"{tag}, {how}", run(plc, f"{tag}={value}", tag, **how), [True, expected])
    written = run(plc, *(f"{tag}={value}" for tag, value, _ in TAGS), **how)
    equal(f"all written, {how}", written, [True] * len(TAGS))
    equal(f"all read, {how}", run(plc, *(tag for tag, *_ in TAGS), **how), [expected for *_, expected in TAGS])
    if "multiple" in how:
        return  # it raises on a packet of which one request failed
    equal(f"unknown among known, {how}", run(plc, "ADint", "Nothing", "AnInt", **how), [[-2147483648], None, [-32768]])
    equal(f"read-only, {how}", run(plc, "Fixed=(DINT)1", "Fixed", **how), [None, [42]])


def shapes(plc):
    recipe = [float(i) for i in range(3000)]
    for begin in range(0, 3000, 100):
        values = ",".join(str(value) for value in recipe[begin:begin + 100])
        equal(f"Recipe from {begin}", run(plc, f"Recipe[{begin}-{begin + 99}]=(REAL){values}"), [True])
    offset, read = 0, []
    while len(read) < 3000:
        part, = run(plc, f"Recipe[0-2999]+{offset}")
        holds("a fragment", part, part)
        read += part
        offset += 4 * len(part)
    equal("12,000 bytes in fragments", read, recipe)
    fragments = [4.0, 5.0, 6.0]
    equal("write a fragment", run(plc, "Recipe[0-2999]+8=(REAL)4.0,5.0,6.0", "Recipe[2-4]"), [True, fragments])


def move(plc, end, **how):
    position = ",".join(str(value) for value in end)
    equal("EnableIn off", run(plc, "Move1.EnableIn=(BOOL)0", **how), [True])
    equal("operands and EnableIn", run(plc, f"Move1.Position[0-2]=(REAL){position}", "Move1.EnableIn=(BOOL)1", **how),
          [True, True])
    eventually("PC", lambda: run(plc, "Move1.MotionControl.PC", **how)[0][0])
    equal("end of the move, exactly",
          run(plc, *(f"{axis}.CommandPosition" for axis in "XYZ"), **how), [[value] for value in end])


with client.connector(host=host, port=int(port), timeout=20.0) as plc:
    numbers(plc)
    numbers(plc, depth=8)
    numbers(plc, depth=4, multiple=400)
    shapes(plc)
    move(plc, (40.0, 20.0, 10.0))
    move(plc, (10.0, 5.0, 2.0), multiple=400)

    # Generic messages.
    identity, = plc.results([{"method": "get_attributes_all", "path": [{"class": 1}, {"instance": 1}]}], timeout=20.0)
    holds("Get Attributes All of Identity", identity and len(identity) > 15, identity)
    vendor, = plc.results([{"method": "get_attribute_single",
                            "path": [{"class": 1}, {"instance": 1}, {"attribute": 1}]}], timeout=20.0)
    equal("Get Attribute Single", len(vendor), 2)

    # A request among several that fails makes it raise; the next one is answered.
    try:
        run(plc, "ADint", "Nothing", "AnInt", multiple=400)
        holds("an unknown tag in a packet", False)
    except client.MSVCStatusError as error:
        equal("an unknown tag in a packet", error.status, 0x1E)

with client.connector(host=host, port=int(port), timeout=20.0) as plc:
    # MCLM as a service, with a check of each byte of its reply.
    def service(code, path, data):
        plc.service_code(code, path, data=list(data), timeout=5.0)
        reply, _ = client.await_response(plc, timeout=10.0)
        return bytes(bytearray(reply.enip.CIP.send_data.CPF.item[1].unconnected_send.request.input))

    path = [{"class": COORDINATE_SYSTEM}, {"instance": 1}]
    data = service(MCLM, path, linear_move("Generic7", (0, 0, 0), 400.0))
    equal("MCLM", data[:4], bytes((MCLM | 0x80, 0, 0, 0)))
    instance, = struct.unpack_from("<I", data, 4)
    flags, err, _ = motion_instruction(data[8:])
    equal("DN, no ER", (flags & (DN | ER), err), (DN, 0))
    eventually("PC", lambda: run(plc, "Generic7.PC")[0][0])
    equal("end of the move, exactly", run(plc, *(f"{axis}.CommandPosition" for axis in "XYZ")), [[0.0]] * 3)
    data = service(MCLM, path, linear_move("Generic7", (9, 9, 9), -1.0))
    equal("refused with ERR 13 and EXERR 4", data, bytes((MCLM | 0x80, 0, 0x1F, 2)) + struct.pack("<hh", 13, 4))

print("cpppo: all as expected")
