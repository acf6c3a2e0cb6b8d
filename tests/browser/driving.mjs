// Driving in the browser: forms, jogs, stops, rights, programs. A case throws when it does not hold.

import assert from "node:assert/strict";
import { VIEWS, actual, arrived, close, go, open, operand, pixels, positions, probe, ready, release, take, until } from "./browser.mjs";

/** The longest that an axis may go on after the page is gone, before it begins to brake. */
const DEAD_MAN_MS = 250;

/** The machine moves as the form says; without control it does not move. */
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
  await other.getByText("has control of CS1").waitFor();
  assert.ok(await other.locator(".form .run").isDisabled(), "one viewer drives at a time");
  await close(other);
  await go(page, "events");
  await page.locator(".event", { hasText: "MCLM" }).getByText("Complete").waitFor();
  await close(page);
}

/** Run, pressed right behind an edit, runs the line with the edit: before it is asked for, and while it is on its way. */
export async function a_press_behind_an_edit_runs_the_edit({ browser, url }) {
  const page = await open(browser, url, "drive");
  await take(page, "CS1");
  await positions(page, "Position", [5, 5, 5]);
  await ready(page, "[5,5,5]");
  // The page asks for a line 120 ms after an edit.
  for (const [wait, target] of [[0, 11], [60, -7], [121, 23], [125, -9]]) {
    await page.evaluate(async ([wait, target]) => {
      const input = document.querySelector('.target-table [data-member="Position"]');
      input.focus();
      input.value = String(target);
      input.dispatchEvent(new Event("input", { bubbles: true }));
      const press = () => document.querySelector(".form .run").click();
      if (wait) await new Promise((done) => setTimeout(() => done(press()), wait));
      else press();
    }, [wait, target]);
    await arrived(page, "X", target);
    await until(page, "one execution", () => document.querySelector(".form[data-ready=true]"));
  }
  // A form with an error is not executed, even if its earlier line was valid.
  await page.evaluate(() => {
    const input = document.querySelector('.target-table [data-member="Position"]');
    input.value = "";
    input.dispatchEvent(new Event("input", { bubbles: true }));
    document.querySelector(".form .run").click();
  });
  await page.locator(".form .run:disabled").waitFor();
  await arrived(page, "X", -9);
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
  const event = page.locator(".event.bad", { hasText: "MCCM" }).first();
  if (!(await event.locator("details").getAttribute("open"))?.length) await event.locator("details").evaluate((element) => (element.open = true));
  for (const words of ["ERR 44", "Cause", "What to do"]) await event.locator(".explanation").getByText(words).waitFor();
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
  /** The time for which the axis went on at full speed after a moment, in ms. */
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
    await page.locator(".form .run").click();
    await page.getByText("Axis Is Inhibited").first().waitFor();
    await page.getByText("Standing still").waitFor();
    await release(page);
  }
  for (const view of VIEWS) {
    await go(page, view);
    assert.ok(await page.locator(".stop").isVisible(), `STOP is there in ${view}`);
  }
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
  // Step by step: before the first statement, before the second, and on to the end.
  const state = (words) => page.locator(".view.program .toolbar .pill", { hasText: words }).waitFor();
  await page.getByRole("button", { name: "Step" }).click();
  await state("Paused, line 1 of 4");
  await page.getByRole("button", { name: "Step" }).click();
  await state("Paused, line 2 of 4");
  assert.equal(await page.locator(".view.program .toolbar progress").evaluate(({ value, max }) => value / max), 0.5, "the progress of the program");
  await page.getByRole("button", { name: "Continue" }).click();
  await state("Ended");
  // The dry run of a move that is too fast for an axis shows the peaks, and the first limit that it exceeds.
  await editor.fill("MAM(X, M3, Absolute, 500, 2000, Unitspersec, 9000, Unitspersec2, 9000, Unitspersec2);\nWAIT(M3.PC);\n");
  await page.locator(".editor-errors:empty").waitFor({ state: "attached" });
  await page.getByRole("button", { name: "Dry run" }).click();
  const facts = page.locator(".view.program .preview-facts");
  await facts.locator(".limit", { hasText: "X: speed 100" }).waitFor();
  assert.deepEqual(await facts.locator("tbody th").allTextContents(), ["X"], "the axes that move");
  assert.equal(await facts.locator("tbody td.over").count() > 0, true, "what is above its limit is marked");
  await editor.fill("WAIT(FALSE);\n");
  await page.locator(".editor-errors:empty").waitFor({ state: "attached" });
  await page.getByRole("button", { name: "Run", exact: true }).click();
  await state("Running");
  await page.getByRole("button", { name: "Stop", exact: true }).click();
  await page.locator(".view.program .toolbar .pill", { hasText: "Running" }).waitFor({ state: "detached" });
  await go(page, "drive");
  await arrived(page, "Y", 30);
  await close(page);
}
