// Users in the browser: a log-in, a lock, STOP without any right, names that look like markup. A case throws when it does not hold.

import assert from "node:assert/strict";
import { close, go, open, release, take, VIEWS } from "./browser.mjs";

const PASSWORD = "a long password";
/** The user whose name is markup. */
const MARKUP = "<img src=x onerror=alert(1)>";

/** Fills and sends the form of a log-in. */
async function logIn(page, user, password) {
  if (user) await page.getByLabel("User").fill(user);
  await page.getByLabel("Password").fill(password);
  await page.locator(".session-note button[type=submit]").click();
}

/** The button with the name of the user. */
const session = (page, text) => page.locator("button.session", { hasText: text });

/** Stops by the key, and waits until the page says so. */
async function stop(page) {
  await page.keyboard.press("Escape");
  await page.getByText("Motion is inhibited by STOP").waitFor();
}

/** A viewer without a log-in looks and stops; a user has the rights of the role; a locked page stops. */
export async function a_login_gives_the_role({ browser, url, folder }) {
  const scheme = new URL(url).protocol.replace(":", "");
  const page = await open(browser, url, "drive");
  await page.getByText("As viewer you may look and stop").first().waitFor();
  assert.equal(await page.getByRole("button", { name: "Take control" }).count(), 0, "a viewer is not offered control");
  await page.screenshot({ path: `${folder}/login-viewer-${scheme}.png` });
  await stop(page);
  assert.ok(await page.getByRole("button", { name: "Release STOP" }).isDisabled(), "a viewer does not release STOP");
  await session(page, "Log in").click();
  await page.locator(".login-notice", { hasText: MARKUP }).waitFor();
  await logIn(page, "anna", "a wrong password");
  await page.getByText("The user or the password is wrong.").waitFor();
  await page.screenshot({ path: `${folder}/login-wrong-${scheme}.png` });
  await logIn(page, null, PASSWORD);
  await session(page, "anna, operator").waitFor();
  const cookies = await page.context().cookies();
  assert.deepEqual(cookies.map(({ httpOnly, sameSite, secure }) => [httpOnly, sameSite, secure]), [[true, "Strict", scheme === "https"]]);
  await release(page);
  await take(page, "Gantry");
  await go(page, "program");
  await page.getByText("As operator you may not run programs.").waitFor();
  // The user is still there behind a reload.
  await page.reload();
  await session(page, "anna, operator").click();
  await page.getByRole("button", { name: "Lock" }).click();
  await page.getByText("This page is locked. You may look and stop.").waitFor();
  await session(page, "anna, locked").waitFor();
  await go(page, "machine");
  await page.screenshot({ path: `${folder}/login-locked-${scheme}.png` });
  await stop(page);
  assert.ok(await page.getByRole("button", { name: "Release STOP" }).isDisabled(), "a locked page does not release STOP");
  await logIn(page, null, PASSWORD);
  await session(page, "anna, operator").click();
  await release(page);
  await page.getByRole("button", { name: "Log out" }).click();
  await session(page, "Log in").waitFor();
  assert.deepEqual(await page.context().cookies(), [], "the cookie has gone");
  // The browser logs the refusal, too.
  page.faults = page.faults.filter((fault) => !fault.includes("401"));
  await close(page);
}

/** An administrator sees the sessions of all users beside the own one, and ends one; its page says so and looks on as a viewer. */
export async function an_administrator_ends_a_session({ browser, url, folder }) {
  const [page, other] = [await open(browser, url, "machine"), await open(browser, url, "machine")];
  await session(other, "Log in").click();
  await logIn(other, MARKUP, PASSWORD);
  await session(other, MARKUP).click();
  await other.getByText("is logged in as engineer.").waitFor();
  assert.equal(await other.locator(".sessions").count(), 0, "an engineer is not shown the sessions of others");
  await session(page, "Log in").click();
  await logIn(page, "bert", PASSWORD);
  await session(page, "bert, administrator").click();
  const rows = page.locator(".sessions tbody tr");
  await rows.nth(1).waitFor();
  const texts = await rows.evaluateAll((all) => all.map((row) => [...row.cells].map((cell) => cell.textContent)));
  assert.deepEqual(texts, [[MARKUP, "engineer", "127.0.0.1", "1 page", "below 1 min", "End"], ["bert", "administrator", "127.0.0.1", "1 page", "below 1 min", "this page"]]);
  await page.screenshot({ path: `${folder}/sessions.png` });
  await page.setViewportSize({ width: 390, height: 844 });
  const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
  assert.ok(wide <= 0, `the page is ${wide} px wider than a phone`);
  await page.screenshot({ path: `${folder}/sessions-phone.png` });
  await page.getByRole("button", { name: /End session \d+ of/ }).click();
  await other.getByText("an administrator ended it").waitFor();
  await other.screenshot({ path: `${folder}/session-ended.png` });
  await session(other, "Log in").waitFor();
  await rows.nth(1).waitFor({ state: "detached" });
  for (const one of [page, other]) assert.equal(await one.locator("img").count(), 0, "no element is made of a name");
  await stop(other);
  await close(page);
  await close(other);
}

/** A name is text wherever it is shown, here and on the pages of others. */
export async function a_users_name_is_text({ browser, url, folder }) {
  const [page, other] = [await open(browser, url, "machine", { phone: true }), await open(browser, url, "machine")];
  await session(page, "Log in").click();
  await logIn(page, MARKUP, PASSWORD);
  await session(page, MARKUP).click();
  await page.getByText("is logged in as engineer.").waitFor();
  await page.screenshot({ path: `${folder}/login-phone.png` });
  await session(page, MARKUP).click();
  await go(page, "drive");
  await take(page, "Gantry");
  await other.getByText(`user:${MARKUP}`).first().waitFor();
  for (const one of [page, other]) assert.equal(await one.locator("img").count(), 0, "no element is made of a name");
  await close(page);
  await close(other);
}

/** Texts of the configuration, of tags, programs and events are text in every view. */
export async function names_and_values_are_text({ browser, url, folder }) {
  const page = await open(browser, url, "machine");
  const opened = [];
  page.on("dialog", (dialog) => {
    opened.push(dialog.message());
    dialog.dismiss();
  });
  await page.getByText(MARKUP).first().waitFor();
  await go(page, "tags");
  await page.getByLabel("Name of a tag or member to watch").fill("Text");
  await page.getByRole("button", { name: "Watch", exact: true }).click();
  await page.locator(".watch-list tbody tr .value", { hasText: "onerror=alert(4)" }).waitFor();
  await page.getByLabel("Search tags").fill(MARKUP);
  await go(page, "program");
  await page.getByLabel("Program in Structured Text").fill(`// ${MARKUP}\nMCLM(${MARKUP}, M1);\n`);
  await page.locator(".editor-errors:not(:empty)").waitFor({ state: "attached" });
  for (const view of VIEWS) {
    await go(page, view);
    await page.locator("main section, main .view").first().waitFor();
    assert.equal(await page.locator("main img, header img, nav img, main script").count(), 0, `no element is made of a text in ${view}`);
  }
  await page.screenshot({ path: `${folder}/markup.png` });
  assert.deepEqual(opened, [], "no text is executed");
  await close(page);
}

/** The page shows the identifications of clients, the texts of a program, and errors that repeat them as text. */
export async function texts_of_strangers_are_shown_as_text({ browser, url, folder }) {
  const agent = "<u>agent";
  const page = await open(browser, url, "machine");
  const other = await open(browser, url, "machine", { agent });
  const opened = [];
  for (const one of [page, other]) one.on("dialog", (dialog) => {
    opened.push(dialog.message());
    dialog.dismiss();
  });
  // The client of EtherNet/IP: its product, its user and its program.
  for (const number of [7, 8, 9]) await page.getByText(`onerror=alert(${number})`).first().waitFor();
  // A browser with a name of its own jogs the other axis, and the others say so.
  await go(other, "drive");
  await take(other, "CS1");
  await other.getByRole("button", { name: "Jog Y forwards" }).hover();
  // A computer without time for a page stops its jog.
  const isSeen = () => page.getByText(agent).first().waitFor({ timeout: 3000 }).then(() => true, () => false);
  for (let tries = 0, seen = false; !seen; tries += 1) {
    assert.ok(tries < 10, "the jog of another browser is seen");
    await other.mouse.down();
    seen = await isSeen();
    await other.mouse.up();
  }
  // An error that repeats the requested name.
  await go(page, "tags");
  await page.getByLabel("Name of a tag or member to watch").fill(MARKUP);
  await page.getByRole("button", { name: "Watch", exact: true }).click();
  await page.getByText(MARKUP).first().waitFor();
  // The program of the controller: its file, task, program and routine, comments of rungs, a value, a line, a fault with its place.
  await go(page, "controller");
  for (const number of [5, 10, 13, 14, 15]) await page.getByText(`onerror=alert(${number})`).first().waitFor();
  // In a box a value is cut to the room beside its operand.
  const value = page.locator(".operand-value", { hasText: /^<img .*…$/ }).first();
  await value.waitFor();
  const room = await value.evaluate((text) => {
    const operand = text.previousElementSibling.getBBox();
    return text.getBBox().x - operand.x - operand.width;
  });
  assert.ok(room >= 0, `the value is ${-room} px over its operand`);
  await page.locator(`[data-name$="/Logic"]`).first().click();
  await page.getByText("onerror=alert(16)").first().waitFor();
  await page.evaluate(() => new Promise((done) => {
    const socket = new WebSocket(`ws://${location.host}/ws`);
    socket.onopen = () => socket.send(JSON.stringify({ id: 1, do: "write", tag: "Fail", value: true }));
    socket.onmessage = ({ data }) => typeof data === "string" && JSON.parse(data).id === 1 && done(socket.close());
  }));
  await page.locator(".controller .problem", { hasText: /onerror=alert\(14\).*onerror=alert\(15\).*Bad is 12/ }).waitFor();
  await page.getByRole("button", { name: "Show the rung" }).click();
  await page.locator(".rung.marked", { hasText: "Recipe[Bad]" }).waitFor();
  await page.getByLabel("Tag whose uses are shown").fill("Count");
  await page.getByRole("button", { name: "Find" }).click();
  await page.locator(".uses li", { hasText: "onerror=alert(15)" }).first().waitFor();
  await page.getByLabel("Tag whose uses are shown").fill("<img src=x onerror=alert(11)>");
  await page.getByRole("button", { name: "Find" }).click();
  await page.locator(".tag-panel p", { hasText: "onerror=alert(11)" }).or(page.locator(".tag-full-name", { hasText: "onerror=alert(11)" })).first().waitFor();
  await page.screenshot({ path: `${folder}/strangers-program.png` });
  // A fault of a client's making, in the events.
  await go(page, "events");
  for (const view of [...VIEWS, "controller"]) {
    for (const one of [page, other]) {
      await go(one, view);
      await one.locator("main section, main .view").first().waitFor();
      assert.equal(await one.locator("main img, header img, nav img, main script, main u, header u").count(), 0, `no element is made of a text in ${view}`);
    }
  }
  await page.screenshot({ path: `${folder}/strangers.png` });
  assert.deepEqual(opened, [], "no text is executed");
  await close(page);
  await close(other);
}
