// The layout at every size of a screen: no element leaves its area, covers another one or is cut off; and the findings of
// axe-core, which sees the page as a screen reader does. A case throws when it fails.

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import path from "node:path";
import { createRequire } from "node:module";
import { VIEWS, close, go, open, take, until } from "./browser.mjs";

const AXE = createRequire(path.join(process.cwd(), "x.js")).resolve("axe-core/axe.min.js");
const SIZES = [[1024, 768], [1440, 900], [1920, 1080]];

/** In the page: texts and controls that leave their panel or card, and columns of the cursors that are cut off. */
function overflow() {
  const found = [];
  const say = (element, why) => found.push(`${why}: ${element.textContent.trim().slice(0, 40) || element.outerHTML.slice(0, 60)}`);
  const seen = (element) => element.checkVisibility({ visibilityProperty: true });
  const scrolls = ".scroll, .scroll-x, .toolbar, .chips, .path-canvas, .plot, .heard, .editor, select, .toasts, .preview-facts, .members";
  for (const panel of document.querySelectorAll("main .panel, main .cursor-values, main .jog-row")) {
    const box = panel.getBoundingClientRect();
    if (panel.scrollWidth > panel.clientWidth + 1) say(panel, `${panel.scrollWidth} pixels wide in ${panel.clientWidth}`);
    for (const element of panel.querySelectorAll("*")) {
      if (!seen(element) || element.closest(scrolls)) continue;
      const { left, right } = element.getBoundingClientRect();
      if (right > box.right + 1 || left < box.left - 1) say(element, "leaves its panel");
    }
  }
  for (const head of document.querySelectorAll(".tag-list tbody th, .watch-list tbody th")) {
    const range = document.createRange();
    for (const node of head.childNodes) {
      if (node.nodeType !== Node.TEXT_NODE) continue;
      range.selectNodeContents(node);
      if (range.getClientRects().length > 1) say(head, "a name is broken within a word");
    }
  }
  return [...new Set(found)];
}

/** No panel overflows with many axes and long names, at every size, with a cursor A and a cursor B in the trends. */
export async function nothing_overflows({ browser, url }) {
  const wrong = [];
  for (const [width, height] of SIZES) {
    const page = await open(browser, url, "machine");
    await page.setViewportSize({ width, height });
    for (const view of VIEWS) {
      await go(page, view);
      if (view === "trends") {
        const plot = page.locator(".plot canvas");
        const { width: wide } = await plot.boundingBox();
        await plot.click({ position: { x: 0.4 * wide, y: 60 } });
        await plot.click({ position: { x: 0.7 * wide, y: 60 }, modifiers: ["Shift"] });
        await page.locator('.view.trends[data-cursors="true"]').waitFor();
      }
      if (view === "tags") {
        await page.getByLabel("Name of a tag or member to watch").fill("Conveyor.CommandPosition");
        await page.getByRole("button", { name: "Watch", exact: true }).click();
        await page.locator("tr.tag", { hasText: "MoveGantry" }).waitFor();
      }
      await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
      wrong.push(...(await page.evaluate(overflow)).map((what) => `${view} ${width}: ${what}`));
    }
    await close(page);
  }
  assert.deepEqual(wrong, []);
}

/** While another page has control, the button that takes it over is whole, and nothing in the view is moved by it. */
export async function control_is_taken_over({ browser, url }) {
  const other = await open(browser, url, "drive");
  await take(other, "Gantry");
  const page = await open(browser, url, "drive");
  await page.setViewportSize({ width: 1440, height: 900 });
  const left = () => page.locator(".drive-left").evaluate((element) => element.getBoundingClientRect().width);
  const before = await left();
  await page.getByRole("button", { name: "Take over…" }).click();
  const now = page.getByRole("button", { name: "Take over now" });
  await now.waitFor();
  assert.equal(await left(), before, "the column keeps its width");
  assert.deepEqual(await page.evaluate(overflow), []);
  const covered = await now.evaluate((button) => {
    const { left: x, top: y, width, height } = button.getBoundingClientRect();
    return [[2, 2], [width - 3, height - 3]].some(([dx, dy]) => document.elementFromPoint(x + dx, y + dy)?.closest("button") !== button);
  });
  assert.equal(covered, false, "the button is seen whole");
  await now.click();
  await page.getByText("You have control of").first().waitFor();
  await other.getByText("has control of Gantry").waitFor();
  await close(other);
  await close(page);
}

/** axe-core has nothing to say against any view, light or dark. */
export async function axe_finds_nothing({ browser, url }) {
  const wrong = [];
  for (const scheme of ["light", "dark"]) {
    const page = await open(browser, url, "machine", { scheme });
    await page.setViewportSize({ width: 1024, height: 768 });
    await page.evaluate(await readFile(AXE, "utf8"));
    for (const view of VIEWS) {
      await go(page, view);
      if (view === "tags") await page.locator("tr.tag").first().waitFor();
      if (view === "drive") await until(page, "the line", () => document.querySelector(".form .line code")?.textContent);
      const found = await page.evaluate(async () => {
        const { violations } = await window.axe.run(document, { resultTypes: ["violations"] });
        return violations.flatMap(({ id, nodes }) => nodes.map(({ html }) => `${id}: ${html.slice(0, 120)}`));
      });
      wrong.push(...found.map((what) => `${view} ${scheme}: ${what}`));
    }
    // Buttons with the same look have different names.
    await go(page, "drive");
    const names = await page.locator(".jog-actions button").evaluateAll((buttons) => buttons.map((button) => button.getAttribute("aria-label") ?? button.textContent));
    assert.equal(new Set(names).size, names.length, names.join(", "));
    await close(page);
  }
  assert.deepEqual(wrong, []);
}

/** No axis and no coordinate system has the colour of another one. */
export async function colours_are_told_apart({ browser, url }) {
  for (const scheme of ["light", "dark"]) {
    const page = await open(browser, url, "trends", { scheme });
    await page.locator('.series .choice[aria-pressed="false"]').evaluateAll((choices) => choices.forEach((choice) => choice.click()));
    const colours = await page.locator(".cursor-values tbody tr:not(.times)").evaluateAll((rows) => rows.map((row) => {
      const [name] = row.querySelector("th").textContent.split(" ");
      return [name, row.querySelector(".swatch").style.backgroundColor];
    }));
    const owners = new Map();
    for (const [name, colour] of colours) owners.set(colour, (owners.get(colour) ?? new Set()).add(name));
    const shared = [...owners.values()].filter((names) => names.size > 1).map((names) => [...names].join(" and "));
    assert.deepEqual(shared, [], scheme);
    const { axes, coordinate_systems: systems } = await page.evaluate(() => fetch("/api/machine").then((answer) => answer.json()));
    assert.equal(owners.size, axes.length + systems.length);
    await close(page);
  }
}

/** The numbers at a grid do not lie over each other, however small or flat the picture is. */
export async function the_numbers_of_a_grid_are_apart({ browser, url }) {
  const page = await open(browser, url, "machine");
  const wrong = await page.evaluate(async () => {
    const { groundGrid, flatGrid } = await import("/assets/js/grid.js");
    const { Camera, LOOKS } = await import("/assets/js/camera.js");
    const { palette } = await import("/assets/js/theme.js");
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [420, 300];
    const context = canvas.getContext("2d");
    const boxes = [];
    const write = context.fillText.bind(context);
    context.fillText = (text, x, y) => {
      const { actualBoundingBoxLeft: left, actualBoundingBoxRight: right, actualBoundingBoxAscent: up, actualBoundingBoxDescent: down } = context.measureText(text);
      boxes.push({ text, box: [x - left, y - up, x + right, y + down] });
      write(text, x, y);
    };
    const found = [];
    for (const look of Object.keys(LOOKS)) {
      for (const size of [0.5, 50, 44_804]) {
        for (const flat of [1, 0.05]) {
          const camera = new Camera();
          Object.assign(camera, { width: 420, tall: 300 });
          camera.look(LOOKS[look]);
          const box = [[-size, -size * flat, 0], [size, size * flat, size / 10]];
          camera.fit(box);
          boxes.length = 0;
          if (camera.plane) flatGrid(context, camera, camera.plane, palette(), ["", "", ""]);
          else groundGrid(context, camera.projection(), box, palette());
          if (!boxes.some(({ text }) => text)) found.push(`${look} ${size}: no number`);
          boxes.forEach((one, k) => boxes.slice(k + 1).forEach((other) => {
            if (!one.text || !other.text) return;
            const [a, b] = [one.box, other.box];
            if (a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]) found.push(`${look} ${size} ${flat}: ${one.text} over ${other.text}`);
          }));
        }
      }
    }
    return found;
  });
  assert.deepEqual(wrong, []);
  await close(page);
}
