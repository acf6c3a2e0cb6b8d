// Faults in the browser: the cause that ended a move, the fault itself, a reset that does not help. A case throws when it fails.

import assert from "node:assert/strict";
import { close, go, open, take } from "./browser.mjs";

const MOVE = "MCLM(CS1, Long, 0, [1000, 0, 0], 50, 0, 2000, 0, 2000, 0, 0, 0, 0, 0);\n";

/** Runs a program of the page to its end. */
async function run(page, text) {
  await go(page, "program");
  await page.locator(".view.program textarea").fill(text);
  await page.locator(".editor-errors:empty").waitFor({ state: "attached" });
  await page.getByRole("button", { name: "Run", exact: true }).click();
}

/** The page shows the fault that ended a move, with axis, fault and time; the fault is an event; a reset that does not help is an error. */
export async function a_fault_is_an_event({ browser, url }) {
  const page = await open(browser, url, "drive");
  await take(page, "Motion");
  await run(page, `${MOVE}DELAY(0.3);\nFaultInject[0] := 16;\nWAIT(Long.PC);\n`);
  const problem = page.locator(".view.program", { hasText: "Long (MCLM, line 1) was stopped by a fault: X overcurrent" });
  await problem.waitFor();
  await go(page, "events");
  const moved = page.locator(".event", { hasText: "MCLM" }).first();
  await moved.locator(".pill", { hasText: "Stopped by a fault" }).waitFor();
  await moved.getByText("Stopped by a fault: X overcurrent").first().waitFor();
  const fault = page.locator(".event", { has: page.locator(".pill", { hasText: /^Faulted$/ }) }).first();
  await fault.getByText("overcurrent").first().waitFor();
  await fault.locator("summary").click();
  assert.match(await fault.locator(".event-when").innerText(), /^\d{4}-\d\d-\d\d \d\d:\d\d:\d\d\.\d{3}$/, "the time of the day");
  await page.getByRole("button", { name: "Errors", exact: true }).click();
  for (const event of [moved, fault]) assert.ok(await event.isVisible(), "both are errors");
  // The cause is still there.
  await run(page, "MAFR(X, Again);\nWAIT(Again.DN);\nDELAY(0.1);\n");
  await go(page, "events");
  const reset = page.locator(".event", { hasText: "MAFR" }).first();
  await reset.locator(".pill", { hasText: "Still faulted" }).waitFor();
  await page.locator(".event .pill", { hasText: "Faulted again" }).first().waitFor();
  // Now the cause is gone.
  await run(page, "FaultInject[0] := 0;\nDELAY(0.1);\nMAFR(X, Good);\nWAIT(Good.DN);\nDELAY(0.1);\n");
  await go(page, "events");
  await page.getByRole("button", { name: "All", exact: true }).click();
  await page.locator(".event", { hasText: "Good" }).locator(".pill", { hasText: "Done" }).waitFor();
  // A move that is stopped by hand is no error.
  await run(page, "MSO(X, On);\nWAIT(On.DN);\nMCLM(CS1, Halted, 0, [1000, 0, 0], 50, 0, 2000, 0, 2000, 0, 0, 0, 0, 0);\nDELAY(0.3);\nMCS(CS1, Halt, All);\nWAIT(Halt.PC);\n");
  await go(page, "events");
  await page.locator(".event", { hasText: "Halted" }).getByText("Stopped by MCS Halt").first().waitFor();
  await close(page);
}
