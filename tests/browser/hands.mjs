// Hands of every sort on the page: fingers, keys, stray clicks; and a form for every instruction. A case throws when it
// does not hold.

import assert from "node:assert/strict";
import { VIEWS, actual, arrived, close, go, open, operand, ready, release, take, until } from "./browser.mjs";

const held = (page, axis, is) => page.locator(`.jog-row[aria-label="Axis ${axis}"][data-held=${is}]`).waitFor();
const still = (page) => page.getByText("Standing still").waitFor({ state: "attached" });
const beyond = (page, axis, place) =>
  until(page, `${axis} beyond ${place}`, ([name, least]) =>
    Number(document.querySelector(`.jog-row[aria-label="Axis ${name}"] output`).textContent.replace("\u2212", "-")) > least, [axis, place]);

/** A finger jogs as long as it is down, wherever it slips; an interruption of the touch ends the jog, and so does a second finger on STOP. */
export async function a_finger_jogs_while_it_is_down({ browser, url }) {
  const page = await open(browser, url, "drive", { phone: true });
  await take(page, "CS1");
  const button = page.getByRole("button", { name: "Jog X forwards" });
  await button.scrollIntoViewIfNeeded();
  const middle = async (locator) => {
    const { x, y, width, height } = await locator.boundingBox();
    return { x: x + width / 2, y: y + height / 2 };
  };
  const [finger, stop] = [{ ...await middle(button), id: 0 }, { ...await middle(page.locator(".stop")), id: 1 }];
  const session = await page.context().newCDPSession(page);
  const touch = (type, ...touchPoints) => session.send("Input.dispatchTouchEvent", { type, touchPoints });
  const ends = {
    lifted: () => touch("touchEnd"),
    "taken by the system": () => touch("touchCancel"),
    stopped: async () => {
      await touch("touchStart", finger, stop);
      await held(page, "X", false);
      await touch("touchEnd");
      await release(page);
    },
  };
  for (const [how, end] of Object.entries(ends)) {
    const began = await actual(page, "X");
    await touch("touchStart", finger);
    await beyond(page, "X", began + 0.5);
    if (how === "lifted") await touch("touchMove", { ...finger, y: finger.y - 120 });
    await end();
    await held(page, "X", false);
    await still(page);
  }
  await close(page);
}

/** Everything that moves the machine can be done without a pointer. */
export async function the_keyboard_drives({ browser, url }) {
  const page = await open(browser, url, "machine");
  /** Presses Tab until the element with this name has the focus. */
  const reach = async (name) => {
    for (let presses = 0; presses < 150; presses++) {
      await page.keyboard.press("Tab");
      const called = await page.evaluate(() => {
        const element = document.activeElement;
        return (element.getAttribute("aria-label") ?? element.labels?.[0]?.textContent ?? element.textContent).trim();
      });
      if (called === name) return;
    }
    throw new Error(`Tab does not lead to ${name}`);
  };
  await reach("Drive");
  await page.keyboard.press("Enter");
  await page.locator("main .view.drive").waitFor();
  await reach("Take control");
  await page.keyboard.press("Enter");
  await page.getByText("You have control of").first().waitFor();
  await reach("Jog X forwards");
  await page.keyboard.down("Space");
  await beyond(page, "X", 0.5);
  await page.keyboard.up("Space");
  await still(page);
  await reach("Target Position X");
  await page.keyboard.press("Control+A");
  await page.keyboard.type("12");
  await ready(page, "[12,");
  await reach("Run");
  await page.keyboard.press("Enter");
  await arrived(page, "X", 12);
  await close(page);
}

/** Clicks without control move no axis and execute no instruction. */
export async function a_stray_click_moves_nothing({ browser, url }) {
  const page = await open(browser, url, "machine");
  // The elements that request control, that open a file, and that hold the machine on purpose.
  const meant = /^(Take control|Open|Feed hold|Stop.*)$/;
  let clicks = 0;
  for (const view of VIEWS) {
    await go(page, view);
    for (const element of (await page.locator("main button:enabled, main canvas").all()).slice(0, 40)) {
      if (!(await element.isVisible()) || meant.test((await element.textContent()).trim())) continue;
      await element.click({ timeout: 3000 });
      clicks += 1;
    }
  }
  assert.ok(clicks > 60, `${clicks} clicks`);
  await still(page);
  await go(page, "events");
  assert.equal(await page.locator(".event").count(), 0, "no instruction has been executed");
  await close(page);
}

/** Every instruction of the catalogue has a form with all of its operands; the execution agrees with the form. */
export async function every_instruction_has_a_form({ browser, url }) {
  const page = await open(browser, url, "drive");
  await page.context().grantPermissions(["clipboard-read", "clipboard-write"], { origin: url });
  const { instructions } = await page.evaluate(() => fetch("/api/instructions").then((answer) => answer.json()));
  await page.getByRole("button", { name: "Any instruction" }).click();
  const choice = page.getByLabel("Instruction", { exact: true });
  const without = [];
  for (const { mnemonic, operands } of instructions) {
    await choice.selectOption(mnemonic);
    const members = await page.locator(".form [data-member]").evaluateAll((fields) => fields.map(({ dataset }) => dataset.member));
    for (const { member, name } of operands) if (!members.includes(member)) without.push(`${mnemonic}: ${name}`);
  }
  assert.deepEqual(without, [], "operands without a field");

  await take(page, "X");
  const row = page.locator('.jog-row[aria-label="Axis X"]');
  await row.getByRole("button", { name: "Servo off" }).click();
  await row.getByRole("button", { name: "Servo on" }).click();
  await row.getByRole("button", { name: "Servo off" }).waitFor();
  await choice.selectOption("MAM");
  await operand(page, "Position", 7);
  await ready(page, "Absolute,7,");
  await page.getByRole("button", { name: "Copy" }).click();
  const line = await page.locator(".form .line code").textContent();
  await until(page, "the line in the clipboard", (wanted) => navigator.clipboard.readText().then((text) => text === wanted), line);
  await page.locator(".form .run").click();
  await arrived(page, "X", 7);
  await close(page);
}
