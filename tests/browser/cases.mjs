// What must hold in the browser, a function each. A case throws when it does not.

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { PATIENCE, close, go, open, operand, pixels, positions, probe, ready, take, until } from "./browser.mjs";

export { screenshots } from "./screenshots.mjs";

/** The longest that an axis may go on after the page is gone, before it begins to brake. */
const DEAD_MAN_MS = 250;
const PATH = ".view.path .path-canvas canvas";
const PREVIEW = ".preview-panel canvas";

/** A number as the page shows it. */
const shown = (text) => Number(text.replace("\u2212", "-"));
const actual = (page, axis) => page.locator(`.jog-row[aria-label="Axis ${axis}"] output`).textContent().then(shown);
const arrived = (page, axis, place) =>
  until(page, `${axis} at ${place}`, ([name, wanted]) =>
    Math.abs(Number(document.querySelector(`.jog-row[aria-label="Axis ${name}"] output`)?.textContent.replace("\u2212", "-")) - wanted) < 0.02, [axis, place]);

/** A preview, then the programmed path, then the trail are drawn where they belong. */
export async function a_path_is_drawn({ browser, url }) {
  const page = await open(browser, url, "drive");
  await take(page, "XY");
  await operand(page, "Speed", 5);
  await positions(page, "Position", [100, 50]);
  await ready(page, "[100,50]");
  await until(page, "a duration", () => /Takes/.test(document.querySelector(".preview-facts:not([hidden])")?.textContent ?? ""));
  await expectLine(page, PREVIEW, "--preview", 2, "the preview");
  assert.equal(await actual(page, "X"), 0, "a preview moves nothing");
  await page.locator(".form .run").click();
  await go(page, "path");
  await page.getByLabel("Coordinate system", { exact: true }).selectOption("XY");
  await expectLine(page, PATH, "--path", 2, "the programmed path");
  await go(page, "drive");
  await arrived(page, "X", 100);
  await go(page, "path");
  await page.getByRole("button", { name: "Fit" }).click();
  await pixels(page, PATH, "--trail", 40);
  await close(page);
}

/** Of a robot the tool is drawn, wherever its joints go. */
export async function a_robots_tool_is_drawn({ browser, url }) {
  const page = await open(browser, url, "drive");
  for (const system of ["CART", "PICKER"]) await take(page, system);
  await go(page, "program");
  const dynamics = "100, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2";
  const to = (name, x, y) => `MCLM(CART, ${name}, Absolute, [${x}, ${y}, -320], ${dynamics});\nWAIT(${name}.PC);\n`;
  await page.getByLabel("Program in Structured Text").fill(`MCT(CART, PICKER, T, [0, 0, 0], [0, 0, 0]);\n${to("M1", -60, -30)}${to("M2", 60, 30)}`);
  await page.locator(".editor-errors:empty").waitFor({ state: "attached" });
  await page.getByRole("button", { name: "Run", exact: true }).click();
  await page.locator(".view.program .toolbar .pill", { hasText: "Ended" }).waitFor();
  await go(page, "path");
  for (const system of ["CART", "PICKER"]) {
    await page.getByLabel("Coordinate system", { exact: true }).selectOption(system);
    await page.getByRole("button", { name: "Top", exact: true }).click();
    await page.getByRole("button", { name: "Fit" }).click();
    await expectLine(page, PATH, "--trail", 2, `the tool of ${system}`);
  }
  await until(page, "where the tool is", () => [...document.querySelectorAll(".dro > div")].some((row) =>
    row.querySelector(".dro-axis")?.textContent === "X1" && Math.abs(Number(row.querySelector("output").textContent) - 60) < 0.01));
  await close(page);
}

/** A straight line of a colour, so many times as wide as it is high. */
async function expectLine(page, canvas, property, ratio, what) {
  const { left, right, top, bottom, count } = await pixels(page, canvas, property, 40);
  const [wide, tall] = [right - left, bottom - top];
  assert.ok(wide > 60, `${what} is ${wide} pixels wide`);
  assert.ok(Math.abs(wide / tall - ratio) < 0.25 * ratio, `${what} is ${wide} by ${tall} pixels, not ${ratio} to 1`);
  assert.ok(count >= wide * 0.5, `${what} has ${count} pixels for a width of ${wide}`);
}

/** What the form says is what the machine does; without the right it does nothing. */
export async function a_move_started_by_the_form_arrives({ browser, url }) {
  const page = await open(browser, url, "drive");
  await positions(page, "Position", [30, -20, 10]);
  await until(page, "the line", () => document.querySelector(".form .line code").textContent.includes("MCLM"));
  assert.ok(await page.locator(".form .run").isDisabled(), "nothing runs without the right to drive");
  await take(page, "CS1");
  await positions(page, "Position", [30, -20, 10]);
  await ready(page, "[30,-20,10]");
  await page.locator(".form .run").click();
  await arrived(page, "X", 30);
  await arrived(page, "Y", -20);
  await arrived(page, "Z", 10);
  const other = await open(browser, url, "drive");
  await other.getByText("drives CS1").waitFor();
  assert.ok(await other.locator(".form .run").isDisabled(), "one viewer drives at a time");
  await close(other);
  await go(page, "events");
  await page.locator(".life", { hasText: "MCLM" }).getByText("Complete").waitFor();
  await close(page);
}

/** An error has its text, cause and remedy in the form and among the events. */
export async function an_error_is_explained({ browser, url }) {
  const page = await open(browser, url, "drive");
  await take(page, "XY");
  await page.getByRole("button", { name: "Arc" }).click();
  await operand(page, "CircleType", 0);
  await positions(page, "Position", [100, 0]);
  await positions(page, "ViaCenterRadius", [50, 0]);
  await ready(page, "[100,0],Via,[50,0]");
  await page.locator(".form .run").click();
  const problem = page.locator(".form .problem");
  for (const words of ["ERR 44", "Cause", "What to do"]) await problem.getByText(words).waitFor();
  assert.equal(await actual(page, "X"), 0, "nothing moves");
  await go(page, "events");
  const life = page.locator(".life.bad", { hasText: "MCCM" }).first();
  if (!(await life.locator("details").getAttribute("open"))?.length) await life.locator("details").evaluate((element) => (element.open = true));
  for (const words of ["ERR 44", "Cause", "What to do"]) await life.locator(".explanation").getByText(words).waitFor();
  await go(page, "drive");
  await operand(page, "Speed", -5);
  await page.locator(".form .problem").getByText("0 or more is expected").waitFor();
  assert.ok(await page.locator(".form .run").isDisabled(), "an operand out of range does not run");
  await close(page);
}

/** A jog lasts as long as it is held, and ends with the page that holds it, however that ends. */
export async function a_jog_ends_with_its_page({ browser, url }) {
  const watcher = await open(browser, url, "machine");
  await probe(watcher, "X");
  const full = () => until(watcher, "X at full speed", () => Math.abs(window.samples.at(-1).speed - 50) < 0.01);
  /** Holds until the axis runs. On a machine that is too busy for the dead-man the server ends a jog: once more then. */
  const run = async (press, release) => {
    for (let times = 1; ; times++) {
      await press();
      const running = full().then(() => true, () => false);
      if (await Promise.race([running, new Promise((done) => setTimeout(done, 4000, false))])) return;
      assert.ok(times < 6, "X did not come to its speed");
      await release();
      await still();
    }
  };
  const still = () => until(watcher, "X stands still", () => window.samples.at(-1).speed === 0);
  /** How long after a moment the axis went on at full speed, in ms. */
  const went = (moment) => watcher.evaluate((since) => window.clockOf(window.samples.findLast(({ speed }) => Math.abs(speed - 50) < 0.01).tick) - since, moment);

  const hold = async () => {
    const page = await open(browser, url, "drive");
    await take(page, "CS1");
    await page.getByRole("button", { name: "Jog X forwards" }).hover();
    await run(() => page.mouse.down(), () => page.mouse.up());
    return page;
  };
  const page = await hold();
  await page.mouse.up();
  await still();
  await page.locator('.jog-row[aria-label="Axis X"][data-held=false]').waitFor();
  await run(() => page.mouse.down(), () => page.mouse.up());
  await page.evaluate(() => window.dispatchEvent(new Event("blur")));
  await still();
  await page.mouse.up();
  await page.getByLabel("Jog by keys").check();
  await run(() => page.keyboard.down("ArrowRight"), () => page.keyboard.up("ArrowRight"));
  await page.keyboard.up("ArrowRight");
  await still();
  await close(page);

  const ends = {
    closed: (held) => held.context().close(),
    crashed: async (held) => {
      const session = await held.context().newCDPSession(held);
      const crash = held.waitForEvent("crash");
      session.send("Page.crash").catch(() => {}); // the answer dies with the page
      await crash;
    },
    // The page hangs: its socket stays open and nothing comes from it.
    hung: (held) => held.evaluate((most) => {
      const began = Date.now();
      while (Date.now() - began < most);
      return began;
    }, 4 * DEAD_MAN_MS),
  };
  for (const [how, end] of Object.entries(ends)) {
    const held = await hold();
    const asked = Date.now();
    const moment = (await end(held)) ?? Date.now();
    await still();
    const after = await went(moment);
    console.log(`page ${how}: the axis began to brake ${Math.round(after)} ms after that, ${Math.round(after + moment - asked)} ms after it was asked for`);
    assert.ok(after <= DEAD_MAN_MS, `page ${how}: X went on for ${after} ms`);
    await held.context().close();
  }
  await close(watcher);
}

/** The Esc key stops from everywhere, also out of a field; so does the button of every view. */
export async function esc_stops({ browser, url }) {
  const page = await open(browser, url, "drive");
  await take(page, "XY");
  await operand(page, "Speed", 2);
  for (const [far, stop] of [[500, () => page.locator(".target-table input").first().press("Escape")], [-500, () => page.locator(".stop").click()]]) {
    await positions(page, "Position", [far, 0]);
    await ready(page, `[${far},0]`);
    await page.locator(".form .run").click();
    await page.getByText(/ax[ei]s moving/).waitFor();
    await stop();
    await page.getByText("Standing still").waitFor();
    assert.ok(Math.abs(await actual(page, "X")) < 400, "it stopped on the way");
  }
  for (const view of ["machine", "path", "trends", "program", "tags", "events"]) {
    await go(page, view);
    assert.ok(await page.locator(".stop").isVisible(), `STOP is there in ${view}`);
  }
  await close(page);
}

/** A drag on the time bar shows an earlier moment in the numbers and in the picture; "Live" shows the present again. */
export async function the_scrub_shows_an_earlier_moment({ browser, url }) {
  const page = await open(browser, url, "drive");
  await take(page, "XY");
  await operand(page, "Speed", 20);
  await positions(page, "Position", [120, 60]);
  await ready(page, "[120,60]");
  await page.locator(".form .run").click();
  await arrived(page, "X", 120);
  await go(page, "path");
  await page.getByLabel("Coordinate system", { exact: true }).selectOption("XY");
  const x = () => page.locator(".dro output").first().textContent().then(shown);
  await until(page, "the present", () => document.querySelector(".dro output").textContent.startsWith("120."));
  const bar = page.locator(".view.path .timebar-strip canvas");
  const { width, height } = await bar.boundingBox();
  await bar.click({ position: { x: width * 0.02, y: height / 2 } });
  await page.getByText("An earlier moment is shown").waitFor();
  assert.ok(Math.abs(await x()) < 1, `at the beginning X stood at 0, shown is ${await x()}`);
  await bar.press("End");
  await until(page, "the present again", () => document.querySelector(".dro output").textContent.startsWith("120."));
  await go(page, "trends");
  await page.locator(".view.trends .timebar-strip canvas").press("ArrowLeft");
  await page.locator(".view.trends .plot canvas").click({ position: { x: 300, y: 60 } });
  await page.getByRole("button", { name: "Live" }).waitFor();
  for (const [button, beginning] of [["CSV", "tick,time_s,X.CommandPosition"], ["PNG", "\u0089PNG"]]) {
    const [download] = await Promise.all([page.waitForEvent("download"), page.getByRole("button", { name: button }).click()]);
    const content = await readFile(await download.path(), "latin1");
    assert.ok(content.startsWith(beginning), `${button} begins with ${content.slice(0, 40)}`);
  }
  await close(page);
}

/** A page that comes later, or again, has what was before it came. */
export async function a_new_page_has_the_past({ browser, url }) {
  const page = await open(browser, url, "drive");
  await take(page, "XY");
  await operand(page, "Speed", 20);
  await positions(page, "Position", [80, 40]);
  await ready(page, "[80,40]");
  await page.locator(".form .run").click();
  await arrived(page, "X", 80);
  await close(page);
  const later = await open(browser, url, "path");
  await later.getByLabel("Coordinate system", { exact: true }).selectOption("XY");
  const x = () => later.locator(".dro output").first().textContent().then(shown);
  const bar = later.locator(".view.path .timebar-strip canvas");
  // The past comes piece by piece, the oldest last.
  for (const deadline = Date.now() + PATIENCE; ;) {
    await bar.press("Home");
    await later.getByText("An earlier moment is shown").waitFor();
    if (Math.abs(await x()) < 1) break;
    assert.ok(Date.now() < deadline, `at the beginning X stood at 0, shown is ${await x()}`);
    await new Promise((done) => setTimeout(done, 100));
  }
  await pixels(later, PATH, "--grid", 1);
  await bar.press("End");
  await later.getByRole("button", { name: "Fit" }).click();
  await pixels(later, PATH, "--trail", 40);
  await close(later);
}

/** What the page may take of the main thread for a frame, ms of processor time: of 60 a second each has 16.7. */
const FRAME_MS = 12;

/** With eight axes that move at 1 ms, each view leaves the browser most of every frame. */
export async function frames_leave_time({ browser, url }) {
  const page = await open(browser, url, "program");
  await page.getByRole("button", { name: "Take control" }).click();
  const { axes } = await page.evaluate(() => fetch("/api/machine").then((answer) => answer.json()));
  assert.ok(axes.length >= 8, `${axes.length} axes`);
  const sway = (to) => axes.map(({ name }, k) => `MAM(${name}, W${k}, Absolute, ${to * (k + 1)}, ${5 * (k + 1)}, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2, S-curve, 10000, 10000, Unitspersec3);`).join("\n");
  const last = `WAIT(W${axes.length - 1}.PC);`;
  await page.getByLabel("Program in Structured Text").fill(`WHILE TRUE DO\n${sway(10)}\n${last}\n${sway(0)}\n${last}\nEND_WHILE;`);
  await page.locator(".editor-errors:empty").waitFor({ state: "attached" });
  await page.getByRole("button", { name: "Run", exact: true }).click();
  const session = await page.context().newCDPSession(page);
  await session.send("Performance.enable", { timeDomain: "threadTicks" });
  const metrics = async () => Object.fromEntries((await session.send("Performance.getMetrics")).metrics.map(({ name, value }) => [name, value]));
  const wrong = [];
  for (const view of ["machine", "path", "trends", "drive", "program", "tags", "events"]) {
    await go(page, view);
    if (view === "trends") {
      for (const { name } of axes) {
        const choice = page.getByRole("group", { name: "Axes" }).getByRole("button", { name, exact: true });
        if ((await choice.getAttribute("aria-pressed")) === "false") await choice.click();
      }
    }
    const before = await metrics();
    const frames = await page.evaluate((most) => new Promise((done) => {
      let count = 0;
      const began = performance.now();
      const frame = () => {
        count += 1;
        if (performance.now() - began < most) requestAnimationFrame(frame);
        else done({ count, seconds: (performance.now() - began) / 1000 });
      };
      requestAnimationFrame(frame);
    }), 2000);
    const after = await metrics();
    // Where the machine is too busy to draw, what comes from the server is no part of the few frames that there are.
    const each = (name) => (1000 * (after[name] - before[name])) / Math.max(frames.count, 60 * frames.seconds);
    const [task, script, layout] = [each("TaskDuration"), each("ScriptDuration"), each("LayoutDuration") + each("RecalcStyleDuration")];
    console.log(`${view}: ${task.toFixed(2)} ms of the main thread for each of 60 frames a second (script ${script.toFixed(2)}, layout ${layout.toFixed(2)}); ${(frames.count / frames.seconds).toFixed(0)} frames a second were drawn`);
    if (task > FRAME_MS) wrong.push(`${view}: ${task.toFixed(2)} ms`);
  }
  assert.deepEqual(wrong, [], "each frame leaves time");
  await page.keyboard.press("Escape");
  await close(page);
}

/** The user's reference, MCCM Target Position Entry Dialog Box: headings, and which buttons are active. */
const DIALOG = [
  // move type, circle type, target column, via column, Set Targets, Set Vias
  [0, 0, "Target Position", "Via Position", true, true],
  [1, 0, "Target Increment", "Via Increment", false, false],
  [0, 1, "Target Position", "Center Position", true, true],
  [1, 1, "Target Increment", "Center Increment", false, false],
  [0, 2, "Target Position", "Radius", true, false],
  [1, 2, "Target Increment", "Radius", false, false],
  [0, 3, "Target Position", "Center Incremental", true, false],
  [1, 3, "Target Increment", "Center Incremental", false, false],
];

export async function the_target_dialog_is_the_users({ browser, url }) {
  const page = await open(browser, url, "drive");
  await page.getByLabel("What to drive").selectOption("XY");
  const enabled = (name) => page.getByRole("button", { name }).isEnabled();
  const heads = () => page.locator(".target-table thead th").allTextContents();
  await page.getByRole("button", { name: "Arc" }).click();
  for (const [move, circle, target, via, targets, vias] of DIALOG) {
    await operand(page, "MoveType", move);
    await operand(page, "CircleType", circle);
    const what = `move type ${move}, circle type ${circle}`;
    assert.deepEqual(await heads(), ["Axis Name", target, "Actual Position", via], what);
    assert.equal(await enabled("Set Targets = Actuals"), targets, `${what}: Set Targets = Actuals`);
    assert.equal(await enabled("Set Vias = Actuals"), vias, `${what}: Set Vias = Actuals`);
    assert.equal(await page.locator('.target-table [data-member="ViaCenterRadius"]').count(), circle === 2 ? 1 : 2, `${what}: a radius is one number`);
    assert.equal(await page.locator('.target-table tbody th').count(), 2, `${what}: a row for each axis`);
  }
  await page.getByRole("button", { name: "Move", exact: true }).click();
  for (const [move, target, targets] of [[0, "Target Position", true], [1, "Target Increment", false]]) {
    await operand(page, "MoveType", move);
    assert.deepEqual(await heads(), ["Axis Name", target, "Actual Position"], `a line, move type ${move}`);
    assert.equal(await enabled("Set Targets = Actuals"), targets, `a line, move type ${move}`);
  }
  await operand(page, "MoveType", 0);
  await positions(page, "Position", [77, 88]);
  await page.getByRole("button", { name: "Set Targets = Actuals" }).click();
  assert.deepEqual(await page.locator('.target-table [data-member="Position"]').evaluateAll((inputs) => inputs.map(({ value }) => value)), ["0", "0"]);
  await close(page);
}

/** A program: an error at its place, a dry run, then a run to its end. */
export async function a_program_runs({ browser, url }) {
  const page = await open(browser, url, "program");
  await page.getByRole("button", { name: "Take control" }).click();
  const editor = page.getByLabel("Program in Structured Text");
  await editor.fill("// one\nMCLM(CS1, M1, Absolute [1, 2, 3]);\n");
  await page.locator(".editor-gutter .wrong", { hasText: /^2$/ }).waitFor();
  const dynamics = "100, %ofMaximum, 100, %ofMaximum, 100, %ofMaximum";
  await editor.fill(`MCLM(CS1, M1, Absolute, [40, 0, 0], ${dynamics});\nWAIT(M1.PC);\nMCLM(CS1, M2, Absolute, [40, 30, 0], ${dynamics});\nWAIT(M2.PC);\n`);
  await page.locator(".editor-errors:empty").waitFor({ state: "attached" });
  await page.getByRole("button", { name: "Dry run" }).click();
  await page.locator(".view.program .preview-facts", { hasText: "Takes" }).waitFor();
  await pixels(page, ".view.program .path-canvas canvas", "--preview", 40);
  await page.getByRole("button", { name: "Run", exact: true }).click();
  await page.locator(".view.program .toolbar .pill", { hasText: "Ended" }).waitFor();
  await go(page, "drive");
  await arrived(page, "Y", 30);
  await close(page);
}

/** A server that says nothing is told unmistakably, and so is its return. */
export async function a_lost_server_is_told({ browser, url, server }) {
  const page = await open(browser, url, "machine");
  process.kill(server, "SIGSTOP");
  try {
    await page.getByRole("alert").getByText("No connection to the server").waitFor();
    assert.equal(await page.locator("html").getAttribute("data-connection"), "lost");
  } finally {
    process.kill(server, "SIGCONT");
  }
  await page.locator("html[data-connection=open]").waitFor({ state: "attached" });
  assert.ok(await page.locator(".lost").isHidden(), "the warning goes");
  page.faults.length = 0; // the browser writes each attempt to connect
  await close(page);
}

/** Tags are found, watched and written. */
export async function tags_are_watched_and_written({ browser, url }) {
  const page = await open(browser, url, "tags");
  await page.getByLabel("Search tags").fill("Move");
  await page.locator("tr.tag", { hasText: "Move1" }).waitFor();
  assert.equal(await page.locator("tr.tag", { hasText: "Arc1" }).count(), 0);
  await page.getByLabel("Name of a tag or member to watch").fill("Move1.Speed");
  await page.getByRole("button", { name: "Watch", exact: true }).click();
  const row = page.locator(".watch-list tbody tr", { hasText: "Move1.Speed" });
  await row.locator(".value", { hasText: /^100/ }).waitFor();
  await row.getByLabel("New value of Move1.Speed").fill("42");
  await row.getByRole("button", { name: "Write" }).click();
  await row.locator(".value", { hasText: /^42/ }).waitFor();
  await close(page);
}

/** The history of the page: eleven minutes at 1 ms, exact values and extrema, gaps and restarts told. In the page. */
export async function the_history_is_exact({ browser, url }) {
  const page = await open(browser, url, "machine");
  const found = await page.evaluate(async () => {
    const { Samples } = await import("/assets/js/samples.js");
    const wrong = [];
    const expect = (what, value, wanted) => Object.is(value, wanted) || wrong.push(`${what}: ${value}, expected ${wanted}`);
    const samples = new Samples({ period_s: 0.001, axes: [{ name: "X" }], coordinate_systems: [{ name: "CS" }] });
    // Whole numbers, so that what is kept in 32 bits is exact.
    const command = (tick) => ((tick * 7919) % 100_003) - 50_000;
    const speed = (tick) => (tick * 31) % 1009;
    const frame = (first, count) => {
      const buffer = new ArrayBuffer(24 + 5 * 8 + count * 5 * 4);
      const view = new DataView(buffer);
      view.setUint32(0, 0x31435241, true);
      view.setUint32(4, count, true);
      view.setUint32(8, 5, true);
      view.setBigUint64(16, BigInt(first), true);
      view.setFloat64(24, 1000.5, true);
      for (let row = 0; row < count; row++) {
        const tick = first + row;
        [command(tick), 2 * tick % 64, tick % 5, command(tick) - 0.25, speed(tick)].forEach((value, k) => view.setFloat32(64 + 4 * (5 * row + k), value, true));
      }
      // The fourth signal has a base as well: the actual position lags by a quarter.
      view.setFloat64(48, 1000.5, true);
      return buffer;
    };
    const last = 800_000;
    for (let tick = 5; tick < last; tick += 4000) samples.add(frame(tick, Math.min(4000, last - tick)));
    expect("the newest", samples.end, last);
    if (samples.end - samples.first < 600_000) wrong.push(`only ${samples.end - samples.first} ticks are kept`);
    const { position, actual, error, jerk } = samples.axis("X");
    for (const tick of [samples.first, samples.first + 1, 400_000, last - 1]) {
      expect(`position at ${tick}`, position.at(tick), command(tick) + 1000.5);
      expect(`error at ${tick}`, error.at(tick), 0.25);
      expect(`actual at ${tick}`, actual.at(tick), command(tick) + 1000.25);
      expect(`path speed at ${tick}`, samples.system("CS").speed.at(tick), speed(tick));
    }
    expect("jerk", jerk.at(400_000), (0 - 4) / 0.001);
    expect("before the oldest", position.at(samples.first - 1), NaN);
    const pair = [0, 0];
    for (const [from, length, bucket] of [[400_000, 64, 16], [400_000, 160, 16], [399_872, 512, 256], [300_032, 256_000, 256], [400_001, 37, 1]]) {
      const values = Array.from({ length }, (_, k) => speed(from + k));
      samples.system("CS").speed.extrema(from, from + length, bucket, pair);
      expect(`least of ${length} from ${from}`, pair[0], values.reduce((a, b) => Math.min(a, b)));
      expect(`greatest of ${length} from ${from}`, pair[1], values.reduce((a, b) => Math.max(a, b)));
    }
    // What was before, of a few ticks at a time: a signal that rises by its tick, with a peak in the second piece.
    const late = new Samples({ period_s: 0.001, axes: [{ name: "X" }], coordinate_systems: [] });
    const live = (first) => {
      const buffer = new ArrayBuffer(24 + 4 * 8 + 4 * 4);
      const view = new DataView(buffer);
      [0x31435241, 1, 4, 0].forEach((word, k) => view.setUint32(4 * k, word, true));
      view.setBigUint64(16, BigInt(first), true);
      [first, 1, 0, first - 2].forEach((base, k) => view.setFloat64(24 + 8 * k, base, true));
      return buffer;
    };
    const piece = (first, every, rows, signals, each) => {
      const buffer = new ArrayBuffer(24 + signals * 8 + rows * signals * each.length * 4);
      const view = new DataView(buffer);
      [0x32435241, rows, signals, every].forEach((word, k) => view.setUint32(4 * k, word, true));
      view.setBigUint64(16, BigInt(first), true);
      const bases = [first, 1, 0, first - 2, 7, 2].slice(0, signals);
      bases.forEach((base, k) => view.setFloat64(24 + 8 * k, base, true));
      const at = 24 + 8 * signals;
      for (let row = 0; row < rows; row++) {
        for (let k = 0; k < signals; k++) each.forEach((of, which) => view.setFloat32(at + 4 * ((row * signals + k) * each.length + which), of(row, k), true));
      }
      return buffer;
    };
    const rising = (row, k) => (k === 0 || k === 3 ? row * 16 : 0);
    const peak = (row, k) => (k === 0 || k === 3 ? row * 16 + 15 : k === 4 && row === 1 ? 1000 : 0);
    late.add(live(1000));
    expect("nothing is known before", late.axis("X").position.at(999), NaN);
    late.fill(piece(990, 1, 10, 4, [(row, k) => (k === 0 || k === 3 ? row : 0)]), 1000);
    expect("a piece of every tick", late.axis("X").position.at(995), 995);
    expect("and its error", late.axis("X").error.at(995), 2);
    late.fill(piece(960, 16, 2, 6, [rising, rising, peak]), 990);
    const x = late.axis("X");
    expect("the oldest", late.first, 960);
    for (const tick of [960, 970, 976]) expect(`a straight line at ${tick}`, x.position.at(tick), tick);
    expect("its last value stays", x.position.at(989), 976);
    expect("every tick is known here", late.step(995), 1);
    expect("not here", late.step(970), 16);
    const [low, high] = x.jerk.extrema(960, 992, 16, [0, 0]);
    expect("least jerk", low, 0);
    expect("greatest jerk", high, 1007);
    expect("what is live stays", x.position.at(1000), 1000);
    samples.add(frame(last + 100, 10));
    expect("in a gap", position.at(last + 50), NaN);
    expect("behind a gap", position.at(last + 105), command(last + 105) + 1000.5);
    samples.system("CS").speed.extrema(last, last + 100, 1, pair);
    expect("least of a gap", pair[0], NaN);
    samples.add(frame(0, 40));
    expect("the server began again", samples.end, 40);
    expect("and nothing older is left", samples.first, 0);
    return wrong;
  });
  assert.deepEqual(found, []);
  await close(page);
}
