// Drives an Arcline server with an unmodified ethernet-ip: node ethernet_ip.js ADDRESS. Its port is always 44818.
//
// It does not browse, knows BOOL, SINT, INT, DINT and REAL, and sends everything unconnected over a route. It takes replies
// that come together for one reply and loses the second of two, so each request here waits for the answer of the one before.
"use strict";

const assert = require("assert");
const path = require("path");
const { createRequire } = require("module");
const { equal, refused, run } = require("./checks.js");
// The packages are in a folder of their own, which is the working directory.
const { Controller, Tag, TagGroup, EthernetIP } = createRequire(path.join(process.cwd(), "x.js"))("ethernet-ip");

const address = process.argv[2];
const { SINT, INT, DINT, REAL, BOOL, BIT_STRING } = EthernetIP.CIP.DataTypes.Types;

async function eventually(what, look) {
    const deadline = Date.now() + 20000;
    while (!look()) {
        assert(Date.now() < deadline, `${what}: not within 20 s`);
        await new Promise((resolve) => setTimeout(resolve, 5));
    }
    console.log(`ok  ${what}`);
}

async function read(plc, name, program = null) {
    const tag = new Tag(name, program);
    await plc.readTag(tag);
    return tag.value;
}

async function types(plc) {
    for (const [name, type, value] of [
        ["ABool", BOOL, true], ["ASint", SINT, -128], ["AnInt", INT, -32768], ["ADint", DINT, -2147483648], ["AReal", REAL, 1.5],
        // Elements, members, other scopes.
        ["Dints[9]", DINT, 4], ["Grid[1,2]", INT, -5], ["Cube[1,0,2]", DINT, 99], ["Recipe[2999]", REAL, 0.25], ["Corner", INT, 6],
        ["Routes[1].Points[2].At[1]", REAL, 0.25], ["Routes[0].Home.Valid", BOOL, true], ["AMixed.AnInt", INT, -2],
        ["Program:Main.Count", DINT, 73],
        // Bits.
        ["ASint.3", SINT, true], ["AnInt.9", INT, true], ["ADint.4", DINT, true],
    ]) {
        await plc.writeTag(new Tag(name, null, type), value);
        equal(name, await read(plc, name), value);
    }
    equal("only that bit", await read(plc, "ADint"), -2147483648 + 16);
    await plc.writeTag(new Tag("Bools[37]", null, BIT_STRING), true);
    const bits = new Tag("Bools[37]", null, BIT_STRING);
    await plc.readTag(bits);
    equal("one BOOL of an array", bits.value, true);
    const count = new Tag("Count", "Main");
    await plc.readTag(count);
    await plc.writeTag(count, 74);
    equal("a type that it has learned, in a program", await read(plc, "Count", "Main"), 74);

    await refused("an unknown tag", read(plc, "Nothing"), 0x05);
    await refused("a read-only tag", plc.writeTag(new Tag("Fixed", null, DINT), 1), 0x0f);
    await refused("another type", plc.writeTag(new Tag("ADint", null, REAL), 1.5), 0xff);
    equal("still there", await read(plc, "Fixed"), 42);
}

async function groups(plc) {
    const pages = new TagGroup();
    for (let page = 0; page < 300; page++) pages.add(new Tag(`Page${String(page).padStart(3, "0")}`));
    await plc.readTagGroup(pages);
    let next = 1;
    pages.forEach((tag) => { tag.value = next++; });
    await plc.writeTagGroup(pages);
    equal("the last of a group", await read(plc, "Page299"), 300);
    const some = new TagGroup();
    for (const name of ["ADint", "Nothing", "AReal"]) some.add(new Tag(name));
    await refused("an unknown tag in a group", plc.readTagGroup(some), 0x1e);
}

// By subscriptions: the next scan writes the changed values, and reports the values that the server has changed.
async function move(plc, end) {
    const names = ["EnableIn", "MotionControl.PC", "Position[0]", "Position[1]", "Position[2]"].map((name) => `Move1.${name}`);
    const tags = {};
    for (const name of [...names, "X.CommandPosition", "Y.CommandPosition", "Z.CommandPosition"]) {
        tags[name] = new Tag(name);
        plc.subscribe(tags[name]);
    }
    let changes = 0;
    tags["X.CommandPosition"].on("Changed", () => { changes++; });
    plc.scan_rate = 5;
    const scan = plc.scan();
    await eventually("the first scan", () => tags["Z.CommandPosition"].controller_value !== null);
    end.forEach((value, axis) => { tags[`Move1.Position[${axis}]`].value = value; });
    tags["Move1.EnableIn"].value = true;
    const arrived = () => ["X", "Y", "Z"].every((axis, place) => tags[`${axis}.CommandPosition`].controller_value === end[place]);
    await eventually("the move ends, exactly", () => arrived() && tags["Move1.MotionControl.PC"].controller_value);
    assert(changes > 2, `seen on the way: ${changes} changes`);
    tags["Move1.EnableIn"].value = false;
    await eventually("EnableIn is written", () => !tags["Move1.EnableIn"].write_ready);
    plc.pauseScan();
    await scan;
}

async function clock(plc) {
    // The client reads the clock only of a controller that it takes for a 5580.
    plc.properties.name += " (L8)";
    await plc.readWallClock();
    const shown = plc.properties.time.getTime();
    // The client takes the clock for one of its own time zone.
    const here = Date.now() + new Date().getTimezoneOffset() * 60000;
    assert(Math.abs(shown - here) < 60000, `the clock shows ${plc.time}`);
    console.log("ok  the clock");
    await plc.writeWallClock(new Date(2030, 0, 3, 4, 5, 6));
    await plc.readWallClock();
    const behind = plc.properties.time.getTime() - new Date(2030, 0, 3, 4, 5, 6).getTime();
    assert(behind >= 0 && behind < 60000, `the clock, set, shows ${plc.time}`);
    console.log("ok  the clock is set");
}

async function main() {
    const plc = new Controller();
    await plc.connect(address, 0);
    equal("identity", [plc.properties.name, plc.properties.faulted], ["Arcline demo", false]);
    await types(plc);
    await groups(plc);
    await move(plc, [40, 20, 10]);
    await clock(plc);
    plc.destroy();
    await new Promise((resolve) => plc.once("close", resolve));
}

run("ethernet-ip", main);
