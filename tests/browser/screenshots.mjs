// Pictures of every view, light and dark, for a desk and for a phone, and checks of each: no element is wider
// than the screen, every control has a name, every text can be read on its ground.

import assert from "node:assert/strict";
import { mkdir } from "node:fs/promises";
import { VIEWS, go, open, operand, positions, ready, take, until } from "./browser.mjs";

/** Text on its ground (WCAG 2.1, 1.4.3), and text that is large. */
const CONTRAST = 4.5;
const LARGE = 3;

export async function screenshots({ browser, url, folder }) {
  await mkdir(folder, { recursive: true });
  await something(browser, url);
  const found = {};
  for (const scheme of ["light", "dark"]) {
    for (const phone of [false, true]) {
      const page = await open(browser, url, "machine", { scheme, phone });
      await until(page, "a little history", () => performance.now() > 1500);
      for (const view of VIEWS) {
        await go(page, view);
        if (view === "events") await page.locator(".event.bad summary").first().click();
        if (view === "program") {
          await page.getByRole("button", { name: "Dry run" }).click();
          await page.locator(".view.program .preview-facts, .view.program .problem").filter({ visible: true }).first().waitFor();
        }
        // The elements that control adds to the bar leave room for STOP.
        if (view === "drive" && phone) await take(page, "CS1");
        if (view === "drive") await until(page, "the line", () => document.querySelector(".form .line code")?.textContent.includes("MCLM"));
        await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
        const name = `${view}-${scheme}-${phone ? "phone" : "desktop"}`;
        await page.screenshot({ path: `${folder}/${name}.png` });
        const list = await page.evaluate(faults, { enough: CONTRAST, large: LARGE });
        if (list.length) found[name] = list;
      }
      assert.deepEqual(page.faults, [], "the page reports no error");
      await page.context().close();
    }
  }
  assert.deepEqual(found, {}, "no picture has a fault");
}

/** Something to see: a move done, one under way, an error. */
async function something(browser, url) {
  const page = await open(browser, url, "drive");
  await take(page, "CS1");
  await operand(page, "Speed", 40);
  await positions(page, "Position", [120, 80, 30]);
  await ready(page, "[120,80,30]");
  await page.locator(".form .run").click();
  await page.getByText("Standing still").waitFor();
  await page.getByRole("button", { name: "Arc" }).click();
  await operand(page, "CircleType", 0);
  await positions(page, "Position", [220, 80, 30]);
  await positions(page, "ViaCenterRadius", [170, 80, 30]);
  await ready(page, "[220,80,30],Via,[170,80,30]");
  await page.locator(".form .run").click();
  await page.locator(".form .problem").getByText("Cause").waitFor();
  await page.getByRole("button", { name: "Move", exact: true }).click();
  await operand(page, "Speed", 0.2);
  await operand(page, "TerminationType", 2);
  await positions(page, "Position", [0, 100, 0]);
  await ready(page, "[0,100,0]");
  await page.locator(".form .run").click();
  await page.getByText("axes moving").waitFor();
  await positions(page, "Position", [0, 0, 40]);
  await ready(page, "[0,0,40]");
  await page.locator(".form .run").click();
  await page.context().close();
}

/** In the page: the elements that are wider than the screen, have no name, or cannot be read. */
function faults({ enough, large }) {
  const found = [];
  const main = document.querySelector("main");
  if (main.scrollWidth > main.clientWidth + 1) found.push(`the view is ${main.scrollWidth} pixels wide, the screen ${main.clientWidth}`);
  for (const element of document.querySelectorAll("header.bar button")) {
    const { left, right } = element.getBoundingClientRect();
    if (left < 0 || right > innerWidth + 0.5) found.push(`out of the screen: ${element.textContent}, ${left} to ${right} of ${innerWidth}`);
  }
  const seen = (element) => element.checkVisibility({ opacityProperty: true, visibilityProperty: true });
  for (const element of document.querySelectorAll("button, a, input, select, textarea, canvas")) {
    const name = element.getAttribute("aria-label") ?? element.labels?.[0]?.textContent ?? element.textContent;
    if (seen(element) && !name?.trim()) found.push(`without a name: ${element.outerHTML.slice(0, 120)}`);
  }
  const canvas = document.createElement("canvas").getContext("2d", { willReadFrequently: true });
  const rgba = (colour) => {
    canvas.clearRect(0, 0, 1, 1);
    canvas.fillStyle = colour;
    canvas.fillRect(0, 0, 1, 1);
    return [...canvas.getImageData(0, 0, 1, 1).data].map((value) => value / 255);
  };
  const over = ([r, g, b, a], ground) => [r, g, b].map((value, k) => value * a + ground[k] * (1 - a));
  const ground = (element) => {
    const layers = [];
    for (let at = element; at; at = at.parentElement) {
      const colour = rgba(getComputedStyle(at).backgroundColor);
      if (colour[3] > 0) layers.unshift(colour);
      if (colour[3] === 1) break;
    }
    return layers.reduce((below, layer) => over(layer, below), [1, 1, 1]);
  };
  const light = (colour) => {
    const [r, g, b] = colour.map((value) => (value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4));
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const texts = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (texts.nextNode()) {
    const element = texts.currentNode.parentElement;
    if (!texts.currentNode.textContent.trim() || !seen(element) || element.closest(":disabled, noscript, .editor-area, option, .starting")) continue;
    const style = getComputedStyle(element);
    const below = ground(element);
    const [a, b] = [light(over(rgba(style.color), below)), light(below)];
    const contrast = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    const big = parseFloat(style.fontSize) >= 24 || (parseFloat(style.fontSize) >= 18.6 && Number(style.fontWeight) >= 700);
    if (contrast < (big ? large : enough)) found.push(`contrast ${contrast.toFixed(2)}: "${texts.currentNode.textContent.trim().slice(0, 40)}" in ${element.outerHTML.slice(0, 80)}`);
  }
  return [...new Set(found)];
}
