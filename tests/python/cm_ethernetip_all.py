"""Drives an Arcline server with an unmodified cm-ethernetip: cm_ethernetip_all.py HOST:PORT."""

import asyncio
import struct
import sys

from ethernetip.logix.tag_client import TagClient
from checks import *

host, port = sys.argv[1].split(":")

TYPES = [("ABool", 0xC1, b"\1"), ("ASint", 0xC2, b"\x80"), ("AnInt", 0xC3, b"\0\x80"), ("ADint", 0xC4, b"\0\0\0\x80"),
         ("ALint", 0xC5, b"\0" * 7 + b"\x80"), ("AUsint", 0xC6, b"\xff"), ("AUint", 0xC7, b"\xff\xff"),
         ("AUdint", 0xC8, b"\xff" * 4), ("AUlint", 0xC9, b"\xff" * 8), ("AReal", 0xCA, struct.pack("<f", 1.5)), ("AnLreal", 0xCB, struct.pack("<d", 0.1))]


async def values(plc):
    """Every type and shape, whichever way the messages go."""
    for tag, code, data in TYPES:
        await plc.write_raw(tag, code, 1, data)
        equal(f"{tag}", await plc.read_tag_raw(tag), struct.pack("<H", code) + data)
    await plc.write_dint("ADint", -7)
    equal("read_dint", await plc.read_dint("ADint"), -7)
    for kind, tag, value in [("sint", "ASint", -8), ("int", "AnInt", -9), ("lint", "ALint", -10), ("real", "AReal", 0.5),
                             ("lreal", "AnLreal", 0.25)]:
        await getattr(plc, f"write_{kind}")(tag, value)
        equal(f"read_{kind}", await getattr(plc, f"read_{kind}")(tag), value)
    await plc.write_string("AString", "feed rate", 0x0FCE)
    equal("read_string", await plc.read_string("AString"), "feed rate")
    await plc.write_string("Strings[1]", "two", 0x0FCE)
    equal("an element of an array of STRING", await plc.read_string("Strings[1]"), "two")

    # Arrays of one to three dimensions, BOOL arrays.
    for tag, code, data in [
            ("Dints[2]", 0xC4, struct.pack("<3i", 1, -2, 3)), ("Grid", 0xC3, struct.pack("<6h", *range(6))),
            ("Cube", 0xC4, struct.pack("<24i", *range(24))), ("Cube[1,0,0]", 0xC4, struct.pack("<12i", *range(12))),
            ("Sints", 0xC2, bytes(i % 256 for i in range(400))), ("Lreals", 0xCB, struct.pack("<5d", 1, 2, 3, 4, 0.1)),
            ("Bools", 0xD3, struct.pack("<2I", 0x80000001, 0x55))]:
        size = {0xC2: 1, 0xC3: 2, 0xC4: 4, 0xCB: 8, 0xD3: 4}[code]
        await plc.write_raw(tag, code, len(data) // size, data)
        equal(f"array {tag}", await plc.read_tag_raw(tag, len(data) // size), struct.pack("<H", code) + data)
    equal("one element", await plc.read_dint("Cube[1,2,3]"), 11)
    equal("an alias", await plc.read_int("Corner"), 5)

    # Programs.
    await plc.write_dint("Program:Main.Count", 72)
    equal("program scope", await plc.read_dint("Program:Main.Count"), 72)
    await plc.write_lint("Program:Main.ADint", 1 << 42)
    equal("its own ADint", await plc.read_lint("Program:Main.ADint"), 1 << 42)
    equal("the controller's", await plc.read_dint("ADint"), -7)

    # Several at once.
    both = await plc.read_multiple(["ADint", "AReal", "Routes[0].Count"])
    equal("several", struct.unpack("<Hi", both["ADint"]), (0xC4, -7))
    done = await plc.write_multiple([("ADint", 0xC4, struct.pack("<i", 8)), ("AnInt", 0xC3, struct.pack("<h", 9))])
    equal("written together", done, {"ADint": True, "AnInt": True})

    # Requests that the server must refuse.
    for what, call in [("unknown tag: 05", plc.read_dint("Nothing")), ("read-only: 0F", plc.write_dint("Fixed", 1)),
                       ("another type: FF", plc.write_real("ADint", 1.0)), ("beyond the end: FF", plc.read_dint("Dints[10]"))]:
        try:
            await call
            holds(what, False)
        except RuntimeError as error:
            holds(what, f"status=0x{what[-2:]}" in str(error), error)
    equal("still there", await plc.read_dint("Fixed"), 42)


async def structures(plc):
    browse = await plc.browse_tags()
    tags = {tag.name: tag for tag in browse.tags}
    equal("all pages", sum(f"Page{i:03}" in tags for i in range(300)), 300)
    for tag, dimensions, code in [("Grid", 2, 0xC3), ("Cube", 3, 0xC4), ("Bools", 1, 0xD3), ("ALint", 0, 0xC5)]:
        equal(f"{tag} in the list", (tags[tag].array_dimensions, tags[tag].type_code), (dimensions, code))
    holds("the tags of programs", any(name.endswith("Points") for name in tags), sorted(tags))
    route = tags["ARoute"].template
    equal("template", (route.name.split(";")[0], [member.name for member in route.members if not member.name.startswith("ZZZ")]),
          ("Route", ["Name", "Count", "Points", "Flags", "Home"]))
    point = tags["APoint"].template
    value = await plc.read_struct("APoint", point)
    equal("first value", (value.get_bool("Valid"), value.get_bool("Used"), value.get_sint("Id")), (True, False, 3))
    value.set_bool("Used", True)
    await plc.write_struct_value("APoint", value)
    equal("written", (await plc.read_struct("APoint", point)).to_bytes(), value.to_bytes())
    await plc.write_struct_value("Routes[1].Points[2]", value)
    equal("nested", (await plc.read_struct("Routes[1].Points[2]", point)).to_bytes(), value.to_bytes())
    whole = await plc.read_struct("Routes[1]", route)
    whole.set_string("Name", "north")
    whole.set_dint("Count", 5)
    await plc.write_struct_value("Routes[2]", whole)
    equal("an element of an array", (await plc.read_struct("Routes[2]", route)).to_bytes(), whole.to_bytes())
    equal("its member", await plc.read_string("Routes[2].Name"), "north")
    # The client cannot join a structure that comes in fragments: only the first one's type has four bytes for it.
    system = await plc.read_struct("CS1", tags["CS1"].template)
    equal("a coordinate system", (len(system.to_bytes()), system.get_bool("ReadyStatus")), (104, True))



async def move(plc, end):
    async def positions():
        return [await plc.read_real(f"{axis}.CommandPosition") for axis in "XYZ"]

    await plc.write_raw("Move1.EnableIn", 0xC1, 1, b"\0")
    await plc.write_raw("Move1.Position", 0xCA, 3, struct.pack("<3f", *end))
    await plc.write_raw("Move1.EnableIn", 0xC1, 1, b"\1")
    for _ in range(2000):
        if (await plc.read_tag_raw("Move1.MotionControl.PC"))[2]:
            break
        await asyncio.sleep(0.01)
    equal("end of the move, exactly", await positions(), list(end))


async def main():
    async with TagClient(host, int(port)) as plc:
        await values(plc)
        await structures(plc)
        await values(plc)  # now by instance
        await move(plc, (40.0, 20.0, 10.0))
    for arguments in ({"path": "1,0"}, {"use_connected": True}, {"path": "1,0", "use_connected": True}):
        async with TagClient(host, int(port), **arguments) as plc:
            await values(plc)
            await move(plc, (len(arguments) * 10.0, 5.0, 2.0))
    await asyncio.wait_for(services(), 60)
    print("cm-ethernetip: all as expected")


async def services():
    async with TagClient(host, int(port)) as plain, TagClient(host, int(port), use_connected=True) as connected:
        for plc in (plain, connected):
            path = bytes([0x21, 0, 0x02, 0x03, 0x24, 1])
            data = await plc._send_cip(MCLM, path, linear_move("Generic5", (0, 0, 0), 400.0))
            instance, = struct.unpack_from("<I", data)
            flags, err, _ = motion_instruction(data[4:])
            equal("MCLM: DN, no ER", (flags & (DN | ER), err), (DN, 0))
            where = bytes([0x21, 0, 0x03, 0x03, 0x26, 0]) + struct.pack("<I", instance)
            for _ in range(2000):
                flags, err, _ = motion_instruction(await plc._send_cip(GET_ATTRIBUTES_ALL, where, b""))
                if flags & PC:
                    break
                await asyncio.sleep(0.01)
            holds("PC by class 0x0303", flags & PC)
            refused, data = await plc._send_cip_with_status(MCLM, path, linear_move("Generic5", (9, 9, 9), -1.0))
            equal("refused", refused, 0x1F)


asyncio.run(asyncio.wait_for(main(), 100))
