// The page shows the truth, and shows it once: errors, control, the present and the past, impossible values. A case
// throws when it fails.

import assert from "node:assert/strict";
import { PATIENCE, arrived, close, go, open, operand, positions, ready, take, until } from "./browser.mjs";

const toast = (page, text) => page.locator(".toast.bad", { hasText: text });

/** A reload of the view of the tags, which asks before it is connected, is no error. */
export async function a_reload_shows_no_error({ browser, url }) {
  const page = await open(browser, url, "tags");
  for (let times = 0; times < 3; times++) {
    await page.reload();
    await page.locator("tr.tag").first().waitFor();
    assert.equal(await page.locator(".toast.bad").count(), 0, await page.locator(".toasts").textContent());
  }
  await close(page);
}

/** A machine without axes, as a project has that only computes: all of its views open. */
export async function a_machine_without_axes_has_a_page({ browser, url }) {
  const page = await open(browser, url, "machine");
  for (const view of ["path", "trends", "drive", "program", "tags", "events", "machine"]) await go(page, view);
  await close(page);
}

/** An error is one message, although it comes as an answer and as an event; the view that shows it itself needs none. */
export async function an_error_is_one_message({ browser, url }) {
  const page = await open(browser, url, "drive");
  const other = await open(browser, url, "machine");
  await page.getByLabel("What to drive").selectOption("Conveyor");
  await page.getByRole("button", { name: "Take control" }).click();
  await page.getByText("You have control of").first().waitFor();
  await page.getByRole("button", { name: "Any instruction" }).click();
  await page.getByLabel("Instruction", { exact: true }).selectOption("MASD");
  await ready(page, "MASD(Conveyor");
  await page.locator(".form .run").click();
  await page.getByText("MASD accepted").waitFor();
  const errors = () => page.locator(".toast.bad").allTextContents();
  for (const ask of [() => page.getByRole("button", { name: "Servo on Conveyor" }).click(), () => page.getByRole("button", { name: "Home Conveyor" }).click()]) {
    await ask();
    await toast(page, "ERR 7").waitFor();
    await page.waitForTimeout(800); // an event comes with the answer or soon after it
    assert.equal((await errors()).length, 1, (await errors()).join("\n"));
  }
  // The form shows its own error; another page has it as a message.
  await page.locator(".toast.bad").getByLabel("Close this message").click();
  await page.getByLabel("Instruction", { exact: true }).selectOption("MAM");
  await ready(page, "MAM(Conveyor");
  await page.locator(".form .run").click();
  await page.locator(".form .problem").getByText("ERR 7").waitFor();
  await toast(other, "MAM").waitFor();
  await page.waitForTimeout(800);
  assert.deepEqual(await errors(), []);
  await close(other);
  await close(page);
}

/** If control is missing, the message names the object and offers its control. */
export async function control_is_offered_where_it_is_missing({ browser, url }) {
  const page = await open(browser, url, "tags");
  await page.getByLabel("Name of a tag or member to watch").fill("MoveGantry.EnableIn");
  await page.getByRole("button", { name: "Watch", exact: true }).click();
  const write = async (name, value) => {
    await page.getByLabel(`New value of ${name}`).fill(value);
    await page.locator(".watch-list tbody tr", { hasText: name }).getByRole("button", { name: "Write" }).click();
  };
  await write("MoveGantry.EnableIn", "1");
  const message = toast(page, "You do not have control of Gantry.");
  await message.getByRole("button", { name: "Take control" }).click();
  await message.getByText("You have control of Gantry").waitFor();
  await write("MoveGantry.EnableIn", "1");
  await page.locator(".toast.good", { hasText: "MoveGantry.EnableIn was written" }).waitFor();
  await close(page);
}

/** A value that a tag cannot hold is refused with its reason. */
export async function a_value_that_does_not_fit_is_refused({ browser, url }) {
  const page = await open(browser, url, "tags");
  const cases = [
    ["Parts", "3.5", "Parts is DINT, 3.5 is not a whole number"],
    ["Recipe", "[1, 2]", "Recipe is an array: write one element, such as Recipe[0]"],
    ["Recipe", "5", "Recipe is an array: write one element, such as Recipe[0]"],
  ];
  for (const [name, value, why] of cases) {
    await page.getByLabel("Name of a tag or member to watch").fill(name);
    await page.getByRole("button", { name: "Watch", exact: true }).click();
    await page.getByLabel(`New value of ${name}`).fill(value);
    await page.locator(".watch-list tbody tr", { hasText: name }).getByRole("button", { name: "Write" }).click();
    await toast(page, why).waitFor();
    await toast(page, why).getByLabel("Close this message").click();
  }
  assert.equal(await page.locator(".watch-list tbody tr", { hasText: "Parts" }).locator(".value").textContent(), "0");
  await close(page);
}

/** A program runs with control of all that it moves; an error goes with the next run, and with the control that it asked for. */
export async function an_error_of_a_program_goes({ browser, url }) {
  const page = await open(browser, url, "program");
  const editor = page.getByLabel("Program in Structured Text");
  const run = page.getByRole("button", { name: "Run", exact: true });
  const problem = page.locator(".view.program .problem");
  const move = (place, speed) => `MCLM(Gantry, P1, Absolute, [${place}, 0, 0], ${speed}, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2);\nWAIT(P1.PC);\n`;
  const type = async (text) => {
    await editor.fill(text);
    await page.locator(".editor-errors:empty").waitFor({ state: "attached" });
  };
  await type(`IF TRUE THEN ${move(20, 10)}END_IF;\nMAM(Conveyor, P2, Absolute, 5, 10, Unitspersec, 100, Unitspersec2, 100, Unitspersec2);\n`);
  await page.getByText("Take control of Gantry, Conveyor first.").waitFor();
  assert.ok(await run.isDisabled() && await page.getByRole("button", { name: "Step" }).isDisabled(), "nothing runs without control");
  await page.getByRole("button", { name: "Take control" }).click();
  await page.getByText("You have control of Gantry, Conveyor").waitFor();
  await type(move(20, -5));
  await run.click();
  await problem.getByText("ERR 13").waitFor();
  await page.locator(".editor-gutter .wrong").waitFor();
  const since = await page.evaluate(() => performance.now());
  await until(page, "the check behind the run", (before) => performance.now() > before + 800, since);
  assert.ok(await page.locator(".editor-gutter .wrong").isVisible(), "the mark stays when the text has been checked again");
  await type("WAIT(FALSE);\n");
  await run.click();
  await page.locator(".view.program .toolbar .pill", { hasText: "Running" }).waitFor();
  assert.ok(await problem.isHidden(), "the error of the earlier run is gone");
  await page.getByRole("button", { name: "Stop", exact: true }).click();
  await page.locator(".view.program .toolbar .pill", { hasText: "Running" }).waitFor({ state: "detached" });
  // A run that fails, then a step of the same text to be run again.
  await type(move(20, -5));
  await run.click();
  await problem.getByText("ERR 13").waitFor();
  await page.getByRole("button", { name: "Step" }).click();
  await page.locator(".view.program .toolbar .pill", { hasText: "Paused" }).waitFor();
  assert.ok(await problem.isHidden(), "a step begins a run of its own");
  assert.equal(await page.locator(".editor-gutter .wrong").count(), 0);
  await close(page);
}

/** While the pictures show an earlier moment, every view that goes on says that it is live. */
export async function a_live_view_says_so({ browser, url }) {
  const page = await open(browser, url, "path");
  const live = page.getByText("Path and Trends are paused");
  await until(page, "samples", () => document.querySelector(".timebar-time")?.textContent.startsWith("live"));
  await page.getByRole("button", { name: "Pause" }).click();
  await page.getByText("An earlier moment is shown").waitFor();
  for (const [view, named] of [["machine", true], ["trends", false], ["drive", true], ["program", true], ["tags", true], ["events", true], ["path", false]]) {
    await go(page, view);
    assert.equal(await live.isVisible(), named, view);
  }
  await go(page, "drive");
  await page.getByRole("button", { name: "Return to live" }).click();
  await live.waitFor({ state: "hidden" });
  await go(page, "path");
  assert.ok(await page.getByText("An earlier moment is shown").isHidden());
  await close(page);
}

/** The form, the jog and the stop act on the chosen object: an axis has forms of its own. */
export async function an_axis_has_its_own_form({ browser, url }) {
  const page = await open(browser, url, "drive");
  await page.getByLabel("What to drive").selectOption("Conveyor");
  assert.equal(await page.getByRole("button", { name: "Arc" }).count(), 0, "an axis has no arc");
  assert.ok(await page.getByRole("button", { name: "Stop Conveyor" }).isEnabled(), "a stop needs no control");
  await page.getByRole("button", { name: "Take control" }).click();
  await page.getByText("You have control of").first().waitFor();
  await operand(page, "Position", 5);
  await ready(page, "Absolute,5,");
  assert.match(await page.locator(".form .line code").textContent(), /^MAM\(Conveyor,/);
  await page.locator(".form .run").click();
  await arrived(page, "Conveyor", 5);
  await page.getByLabel("What to drive").selectOption("Gantry");
  await page.locator(".form .line code", { hasText: "MCLM(Gantry" }).waitFor();
  await close(page);
}

/** A target that no user has typed is the present position, also after another client has moved the machine. */
export async function targets_follow_the_machine({ browser, url }) {
  const page = await open(browser, url, "drive");
  const other = await open(browser, url, "drive");
  const targets = () => page.locator('.target-table [data-member="Position"]').evaluateAll((inputs) => inputs.map(({ value }) => Number(value)));
  await positions(page, "Position", [7]);
  await take(other, "Gantry");
  await positions(other, "Position", [30, -20, 10]);
  await ready(other, "[30,-20,10]");
  await other.locator(".form .run").click();
  await arrived(page, "Y", -20);
  await until(page, "targets at the machine", () => [...document.querySelectorAll('.target-table [data-member="Position"]')].every(({ value }, k) => Math.abs(Number(value) - [7, -20, 10][k]) < 0.01));
  await page.locator(".form .line code", { hasText: "-20" }).waitFor();
  assert.equal((await targets())[0], 7, "what was typed stays");
  await close(other);
  await close(page);
}

/** The choices stored in the browser may be damaged or old: the page ignores such a choice. */
export async function a_damaged_choice_is_left_out({ browser, url }) {
  const page = await open(browser, url, "trends");
  await page.evaluate(() => {
    for (const key of ["watch", "trends", "theme", "program"]) localStorage.setItem(`arcline.${key}`, '{"axes": 5, "kinds": [null');
  });
  await page.reload();
  await page.locator("html[data-connection=open]").waitFor({ state: "attached" });
  await page.locator(".view.trends canvas").first().waitFor();
  await close(page);
}

/** A move beyond the travel limits of an axis runs only after a second press. */
export async function a_move_beyond_the_travel_asks({ browser, url }) {
  const page = await open(browser, url, "drive");
  await page.getByLabel("What to drive").selectOption("X");
  await take(page, "X");
  await page.getByRole("button", { name: "Home X" }).click();
  await page.locator('[data-member="Position"]').first().fill("2000");
  const run = page.locator(".form .run");
  const why = page.locator(".form .why");
  // Travel limits are in force when the axis is homed.
  for (const deadline = Date.now() + PATIENCE; !/travel/.test(await page.locator(".preview-facts").textContent()); ) {
    assert.ok(Date.now() < deadline, "the preview has the travel limit");
    await page.getByRole("button", { name: "Preview", exact: true }).click();
    await new Promise((done) => setTimeout(done, 200));
  }
  await run.click();
  await why.getByText("The move leaves the travel limits").waitFor();
  assert.equal(await run.innerText(), "Run anyway");
  assert.equal(await page.locator(".toast.good").count(), 0, "nothing was executed");
  await run.click();
  await page.getByText("MAM accepted").waitFor();
  await close(page);
}
