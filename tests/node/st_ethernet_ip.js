// Drives an Arcline server with an unmodified st-ethernet-ip: node st_ethernet_ip.js ADDRESS. Its port is always 44818.
"use strict";

const assert = require("assert");
const path = require("path");
const { createRequire } = require("module");
const { equal, refused, run } = require("./checks.js");
// The packages are in a folder of their own, which is the working directory.
const { Controller, Tag, Structure, EthernetIP } = createRequire(path.join(process.cwd(), "x.js"))("st-ethernet-ip");

const address = process.argv[2];
const { SINT, INT, DINT, LINT, REAL, BOOL, USINT, UINT, BIT_STRING } = EthernetIP.CIP.DataTypes.Types;

async function write(plc, tag, value, size) {
    tag.value = value;
    await plc.writeTag(tag, null, size);
}

async function read(plc, name, type = null, program = null) {
    const tag = new Tag(name, program, type);
    await plc.readTag(tag);
    return tag.value;
}

async function types(plc) {
    for (const [name, type, value] of [
        ["ABool", BOOL, true], ["ASint", SINT, -128], ["AnInt", INT, -32768], ["ADint", DINT, -2147483648],
        ["ALint", LINT, -9223372036854775808n], ["AUsint", USINT, 255], ["AReal", REAL, 1.5],
        ["Grid[1,2]", INT, -5], ["Cube[1,0,2]", DINT, 99], ["Corner", INT, 6], ["Routes[1].Points[2].At[1]", REAL, 0.25],
        ["Routes[0].Home.Valid", BOOL, true], ["AMixed.ALint", LINT, -4n],
    ]) {
        await write(plc, new Tag(name, null, type), value);
        equal(`${name}`, await read(plc, name, type), value);
    }
    equal("a UINT, which it only reads", await read(plc, "AUint", UINT), 0);
    await write(plc, new Tag("Count", "Main", DINT), 73);
    equal("program scope", await read(plc, "Count", DINT, "Main"), 73);
    await write(plc, new Tag("ADint", "Main", LINT), 1n << 43n);
    equal("its own ADint", await read(plc, "ADint", LINT, "Main"), 1n << 43n);

    // Bits: of an integer, of a BOOL array.
    await write(plc, new Tag("ADint.4", null, DINT), true);
    equal("a bit of a DINT", await read(plc, "ADint.4", DINT), true);
    equal("only that bit", await read(plc, "ADint", DINT), -2147483648 + 16);
    await write(plc, new Tag("Bools[37]", null, BIT_STRING), true);
    equal("one BOOL of an array", await read(plc, "Bools[37]", BIT_STRING), true);

    // Arrays.
    const dints = new Tag("Dints", null, DINT, 0, 1, 10);
    await write(plc, dints, [1, -2, 3, -4, 5, -6, 7, -8, 9, -10], 10);
    const again = new Tag("Dints", null, DINT, 0, 1, 10);
    await plc.readTag(again, 10);
    equal("an array", again.value, [1, -2, 3, -4, 5, -6, 7, -8, 9, -10]);
    const recipe = new Tag("Recipe", null, REAL, 0, 1, 3000);
    const numbers = Array.from({ length: 3000 }, (_, i) => i / 8);
    await write(plc, recipe, numbers, 3000);
    const fragments = new Tag("Recipe", null, REAL, 0, 1, 3000);
    await plc.readTag(fragments, 3000);
    equal("12,000 bytes in fragments of its 500", fragments.value, numbers);

    await refused("an unknown tag", read(plc, "Nothing", DINT), 0x05);
    await refused("a read-only tag", write(plc, new Tag("Fixed", null, DINT), 1), 0x0f);
    await refused("another type", write(plc, new Tag("ADint", null, REAL), 1.5), 0xff);
    equal("still connected", await read(plc, "Fixed", DINT), 42);
}

// The client shows the hidden members that hold BOOLs.
function visible(value) {
    if (Array.isArray(value)) return value.map(visible);
    if (value === null || typeof value !== "object") return value;
    const shown = Object.entries(value).filter(([name]) => !name.startsWith("ZZZZZZZZZZ"));
    return Object.fromEntries(shown.map(([name, member]) => [name, visible(member)]));
}

async function structures(plc, first) {
    const list = plc.state.tagList;
    const has = (name, program = null) => list.getTag(name, program);
    equal("all pages", list.tags.filter((tag) => /^Page\d\d\d$/.test(tag.name)).length, 300);
    equal("dimensions", [has("Dints"), has("Grid"), has("Cube")].map((tag) => tag.type.arrayDims), [1, 2, 3]);
    equal("programs", list.programs.sort(), ["Main", "Other"]);
    equal("a tag of a program", has("Count", "Main").type.typeName, "DINT");
    equal("a structure's type", has("Routes").type.typeName, "Route");

    const string = new Structure("AString", list);
    await write(plc, string, "feed rate");
    const text = new Structure("AString", list);
    await plc.readTag(text);
    equal("a STRING", text.value, "feed rate");

    const point = new Structure("APoint", list);
    await plc.readTag(point);
    if (first) {
        const expected = { At: [1.5, -2.5], Valid: true, Used: false, Id: 3 };
        equal("first value of a structure", visible(point.value), expected);
    }
    point.value.Used = true;
    point.value.At[1] = 8.5;
    await plc.writeTag(point);
    const changed = new Structure("APoint", list);
    await plc.readTag(changed);
    equal("a structure", visible(changed.value), { At: [1.5, 8.5], Valid: true, Used: true, Id: 3 });

    const route = new Structure("ARoute", list);
    await plc.readTag(route);
    route.value.Name = "north";
    route.value.Count = 5;
    route.value.Points[2] = { ...route.value.Points[2], At: [3, 4], Valid: false, Used: true, Id: 7 };
    route.value.Flags[9] = true;
    await plc.writeTag(route);
    const nested = new Structure("ARoute", list);
    await plc.readTag(nested);
    equal("a nested structure", visible(nested.value), visible(route.value));
    equal("its name", nested.value.Name, "north");

    const routes = new Structure("Routes", list, null, null, 0, 1, 4);
    await plc.readTag(routes, 4);
    equal("an array of structures, in fragments", routes.value.length, 4);
    equal("one of it", routes.value[1].Points[2].At[1], 0.25);
    const axis = new Structure("X", list);
    await plc.readTag(axis);
    equal("a bit of an axis", axis.value.ServoActionStatus, true);
}

async function move(plc, end) {
    await write(plc, new Tag("Move1.EnableIn", null, BOOL), false);
    await write(plc, new Tag("Move1.Position", null, REAL, 0, 1, 3), end, 3);
    await write(plc, new Tag("Move1.EnableIn", null, BOOL), true);
    const deadline = Date.now() + 30000;
    while (!(await read(plc, "Move1.MotionControl.PC", BOOL))) {
        assert(Date.now() < deadline, "the move has not ended");
    }
    const positions = [];
    for (const axis of "XYZ") positions.push(await read(plc, `${axis}.CommandPosition`, REAL));
    equal("end of the move, exactly", positions, end);
}

// A generic message: the library has no call for one, so it is written as its own requests are and awaited likewise.
async function attribute(plc) {
    const vendor = await plc.getAttributeSingle(0x01, 1, 1);
    equal("Get Attribute Single", vendor.length, 2);
    await refused("an attribute that is not there", plc.getAttributeSingle(0x01, 1, 99), 0x14);
}

function mclm(name, position) {
    const typed = (code, parts) => {
        const head = Buffer.alloc(4);
        head.writeUInt16LE(code, 0);
        head.writeUInt16LE(parts.length, 2);
        return Buffer.concat([head, ...parts]);
    };
    const real = (...values) => typed(0xca, values.map((value) => { const b = Buffer.alloc(4); b.writeFloatLE(value); return b; }));
    const dint = (value) => { const b = Buffer.alloc(4); b.writeInt32LE(value); return typed(0xc4, [b]); };
    const text = Buffer.concat([Buffer.from([0xda, 0, 1, 0, name.length]), Buffer.from(name)]);
    return Buffer.concat([text, dint(0), real(...position), real(400), dint(0), real(2000), dint(0), real(2000), dint(0),
        dint(1), real(100), real(100), dint(2), dint(1)]);
}

async function service(plc) {
    const { MessageRouter } = EthernetIP.CIP;
    const message = MessageRouter.build(0x32, Buffer.from([0x21, 0, 0x02, 0x03, 0x24, 1]), mclm("Generic6", [0, 0, 0]));
    const event = plc.state.connectedMessaging ? "SendUnitData Received" : "SendRRData Received";
    const reply = new Promise((resolve, reject) => {
        plc.once(event, (items) => {
            const last = items[items.length - 1].data;
            resolve(MessageRouter.parse(plc.state.connectedMessaging ? last.slice(2) : last));
        });
        setTimeout(() => reject(new Error("no reply to MCLM")), 5000).unref();
    });
    plc.write_cip(message);
    const { service: code, generalStatusCode, data } = await reply;
    equal("MCLM", [code, generalStatusCode], [0xb2, 0]);
    equal("DN, no ER", (data.readUInt32LE(4) & 0x30000000) >>> 0, 0x20000000);
    const deadline = Date.now() + 30000;
    while (!(await read(plc, "Generic6.PC", BOOL))) {
        assert(Date.now() < deadline, "the move has not ended");
    }
    equal("at the end", await read(plc, "X.CommandPosition", REAL), 0);
}

async function main() {
    for (const connected of [true, false]) {
        const plc = new Controller(connected);
        await plc.connect(address);
        equal("identity", plc.properties.run, true);
        await types(plc);
        await structures(plc, connected);
        await attribute(plc);
        await move(plc, connected ? [40, 20, 10] : [10, 5, 2]);
        await service(plc);
        await plc.disconnect();
    }
}

run("st-ethernet-ip", main);
