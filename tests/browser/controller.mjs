// The controller's own program in the browser: ladder with power flow and values, text, uses, forced inputs, mode, a fault at its rung.
// A case throws when it does not hold.

import assert from "node:assert/strict";
import path from "node:path";
import { close, go, metrics_of, open, slowness, until } from "./browser.mjs";

const picture = (page, folder, name) => page.screenshot({ path: path.join(folder, `${name}.png`) });

/** Writes a tag over a connection of the test's own. */
function write(page, tag, value) {
  return page.evaluate(([name, wanted]) => new Promise((done) => {
    const socket = new WebSocket(`ws://${location.host}/ws`);
    socket.onopen = () => socket.send(JSON.stringify({ id: 1, do: "write", tag: name, value: wanted }));
    socket.onmessage = ({ data }) => {
      if (typeof data !== "string" || JSON.parse(data).id !== 1) return;
      socket.close();
      done(data);
    };
  }), [tag, value]);
}

const rung = (page, number) => page.locator(`.rung:has(.rung-picture[aria-label="Rung ${number}"])`);
const on = (page, number, selector) => rung(page, number).locator(`${selector}[data-on=true]`);

/** Contacts, coils and wires show the last scan; values stand beside the operands; a tag leads to its uses. */
export async function a_program_is_seen({ browser, url, folder }) {
  const page = await open(browser, url, "controller");
  await page.getByText("Run mode").waitFor();
  await rung(page, 0).waitFor();
  assert.match(await rung(page, 0).innerText(), /The cell runs while Start is pressed/, "a rung has its comment");
  await page.locator(`[data-name="Main/Go"][aria-current=true]`).waitFor();
  assert.equal(await on(page, 0, ".coil").count(), 0, "Running is off");
  await write(page, "Start", true);
  await write(page, "Override", true);
  await on(page, 0, ".coil").waitFor();
  assert.equal(await on(page, 0, ".contact").count(), 4, "Start, not Stop, Override, not Guard");
  await rung(page, 1).getByText("EN TT").waitFor();
  await until(page, "Count counts", () => Number([...document.querySelectorAll(".rung-picture[aria-label='Rung 2'] .operand-value")][0]?.textContent) > 0);
  await picture(page, folder, "controller-ladder");
  await rung(page, 2).locator("[data-tag=Count]").first().click();
  await page.locator(".tag-full-name", { hasText: /^Count$/ }).waitFor();
  const writing = page.locator(".uses li", { hasText: "writes" });
  assert.equal(await writing.count(), 1, "ADD alone writes Count");
  await page.locator(`[data-name="Main/Logic"]`).click();
  await page.locator(".text-line", { hasText: "Average := Sum" }).locator("b", { hasText: /\d/ }).first().waitFor();
  await picture(page, folder, "controller-text");
  await page.locator(".uses button", { hasText: "rung 5" }).click();
  await page.locator(".rung.marked", { hasText: "MOV" }).waitFor();
  // The logic of an add-on instruction shows the values of an instance.
  await page.getByText("Add-on instructions").click();
  await page.locator(`[data-name="Scale/Logic"]`).click();
  await rung(page, 0).locator(".operand-value", { hasText: /^\d/ }).first().waitFor();
  await close(page);
}

/** A fault is shown with its operand and value and leads to its rung; Program mode clears it; inputs are forced. */
export async function a_fault_leads_to_its_rung({ browser, url, folder }) {
  const page = await open(browser, url, "controller");
  await rung(page, 0).waitFor();
  await write(page, "Fail", true);
  const fault = page.locator(".controller .problem", { hasText: "Main/Go rung 5, MOV: Bad is 12" });
  await fault.waitFor();
  await fault.getByRole("button", { name: "Show the rung" }).click();
  await page.locator(".rung.marked", { hasText: "Recipe[Bad]" }).waitFor();
  await picture(page, folder, "controller-fault");
  await write(page, "Fail", false);
  const mode = page.getByRole("group", { name: "Mode of the controller" });
  await mode.getByRole("button", { name: "Program" }).click();
  await page.locator(".pill", { hasText: "Program mode" }).waitFor();
  await fault.waitFor({ state: "hidden" });
  await mode.getByRole("button", { name: "Run" }).click();
  await page.locator(".pill", { hasText: "Run mode" }).waitFor();
  await page.getByLabel("Tag whose uses are shown").fill("PartPresent");
  await page.getByRole("button", { name: "Find" }).click();
  await page.locator(".tag-full-name", { hasText: "Local:1:I.Data.0" }).waitFor();
  await page.getByRole("button", { name: "Force 1" }).click();
  await page.getByText("1 forced input").waitFor();
  await page.locator(".tag-value", { hasText: /true|1/ }).waitFor();
  await picture(page, folder, "controller-force");
  await page.getByRole("button", { name: "Remove all forces" }).click();
  await page.getByText("1 forced input").waitFor({ state: "hidden" });
  await close(page);
}

/** What the server passes over is counted above the routine, leads to its rung or line, and stands there with its reason. */
export async function parts_that_do_not_run_are_named_at_their_rungs({ browser, url, folder }) {
  const page = await open(browser, url, "controller");
  await rung(page, 3).locator(".warn", { hasText: "Does not run: XIC(Loop.Auto): Data Bit Loop.Auto: there is no tag Loop" }).waitFor();
  const parts = page.locator(".parts-note");
  await parts.locator("summary", { hasText: "2 parts do not run as the file has them" }).click();
  await picture(page, folder, "controller-parts");
  await parts.getByRole("button", { name: "Main/Logic line 7" }).click();
  await page.locator(".text-line.marked .warn", { hasText: "Does not run: statement: Peak := 1: there is no tag Peak" }).waitFor();
  await parts.getByRole("button", { name: "Main/Go rung 3" }).click();
  await page.locator(".rung.marked", { hasText: "Loop.Auto" }).waitFor();
  await close(page);
}

/** The share of a core that rungs may take of the page's main thread where `slowness` is 1. */
const MOST_SHARE = 0.05;

/** The main thread's share of a core, and the pushes of rungs with their bytes, within a time. */
async function load(page, metrics, ms) {
  const before = await metrics();
  const pushes = await page.evaluate((time) => new Promise((done) => {
    setTimeout(() => done({ ...window.looked }), time);
    window.looked = { pushes: 0, rows: 0, bytes: 0 };
  }), ms);
  const after = await metrics();
  const share = (name) => (after[name] - before[name]) / (after.Timestamp - before.Timestamp);
  return { ...pushes, task: share("TaskDuration"), script: share("ScriptDuration"), layout: share("LayoutDuration") + share("RecalcStyleDuration") };
}

/** A routine of 1,000 rungs that change: the page draws and watches the visible ones only, in any place, and the main thread has time. */
export async function a_thousand_rungs_leave_time({ browser, url, folder }) {
  const page = await open(browser, url, "machine");
  // Counts the pushes of rungs beside the page.
  await page.addInitScript(() => {
    window.looked = { pushes: 0, rows: 0, bytes: 0 };
    const Plain = window.WebSocket;
    window.WebSocket = class extends Plain {
      constructor(...given) {
        super(...given);
        this.addEventListener("message", ({ data }) => {
          if (typeof data !== "string" || !data.startsWith('{"push":"look"')) return;
          window.looked.pushes += 1;
          window.looked.rows += data.split('"index":').length - 1;
          window.looked.bytes += data.length;
        });
      }
    };
  });
  await page.reload();
  await go(page, "controller");
  await rung(page, 0).waitFor();
  await on(page, 0, ".coil").or(page.locator(".operand-value", { hasText: /^\d/ })).first().waitFor();
  const metrics = await metrics_of(page);
  const wrong = [];
  // Other work on the computer only adds, through caches and cores that are shared: the least of a few counts.
  const least = async (enough) => {
    let found = null;
    for (let attempt = 0; attempt < 4 && !(found?.task <= enough); attempt += 1) {
      const now = await load(page, metrics, 3000);
      if (!found || now.task < found.task) found = now;
    }
    return found;
  };
  // The same page in a view that shows nothing of the program.
  await go(page, "events");
  const without = await least(0);
  const most = MOST_SHARE * (await slowness(browser));
  await go(page, "controller");
  for (const [where, width, height] of [["desktop", 1360, 850], ["tall screen", 1360, 2400]]) {
    await page.setViewportSize({ width, height });
    await page.waitForTimeout(500);
    const shown = await least(without.task + most);
    const drawn = await page.locator(".rung").count();
    const percent = (share) => (100 * share).toFixed(1);
    const own = shown.task - without.task;
    console.log(`${where}: ${drawn} of 1,000 rungs drawn, ${percent(own)} % of a core for them, ${percent(shown.task)} % for the page (script ${percent(shown.script)}, layout ${percent(shown.layout)}), ${(shown.bytes / 3000).toFixed(1)} kB/s in ${(shown.pushes / 3).toFixed(1)} pushes a second of ${(shown.rows / shown.pushes).toFixed(1)} rungs`);
    if (own > most) wrong.push(`${where}: ${percent(own)} of ${percent(most)} % of a core`);
    assert.ok(drawn > 4 && drawn < 100, `${drawn} rungs are drawn`);
    assert.ok(shown.pushes > 0 && shown.pushes <= 16, `${shown.pushes} pushes in 3 s`);
  }
  assert.deepEqual(wrong, [], "the main thread has time");
  await picture(page, folder, "controller-thousand");
  await close(page);
}

/** A tablet has room for the ladder; on a phone the view scrolls and nothing is wider than the page. */
export async function a_program_fits_small_screens({ browser, url, folder }) {
  const page = await open(browser, url, "controller");
  for (const [name, width, height] of [["tablet", 820, 1180], ["phone", 390, 844]]) {
    await page.setViewportSize({ width, height });
    await rung(page, 0).waitFor();
    const wide = await page.evaluate(() => [document.documentElement.scrollWidth, document.querySelector("main").scrollWidth]);
    assert.ok(wide.every((one) => one <= width), `${name}: nothing is wider than the page, ${wide}`);
    await picture(page, folder, `controller-${name}`);
  }
  await go(page, "machine");
  await close(page);
}
