// The common functions of the cases: a browser with an empty profile, pages, pixels, a probe of the samples. The browser is
// Debian's Chromium; playwright-core comes from the working directory, where npm has put it.

import assert from "node:assert/strict";
import path from "node:path";
import { createRequire } from "node:module";

const { chromium } = createRequire(path.join(process.cwd(), "x.js"))("playwright-core");

const CHROMIUM = process.env.CHROMIUM ?? "/usr/bin/chromium";
const FLAGS = ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"];
const DESKTOP = { width: 1360, height: 850 };
const PHONE = { width: 390, height: 844 };

/** The views of the page, in the order of their list. */
export const VIEWS = ["machine", "path", "trends", "drive", "program", "tags", "events"];

/** The longest time for a condition; far more than it needs, for busy machines. */
export const PATIENCE = 20_000;

/** Starts the browser with a profile of its own, which is removed with it. */
export function launch() {
  return chromium.launch({ executablePath: CHROMIUM, headless: true, args: FLAGS, timeout: 60_000 });
}

/** Opens a new viewer on a view, connected. An error that the page logs fails the case. */
export async function open(browser, url, view, { scheme = "light", phone = false, agent = undefined } = {}) {
  const context = await browser.newContext({ colorScheme: scheme, viewport: phone ? PHONE : DESKTOP, hasTouch: phone, isMobile: phone, reducedMotion: "reduce", userAgent: agent, acceptDownloads: true, ignoreHTTPSErrors: true });
  const page = await context.newPage();
  page.setDefaultTimeout(PATIENCE);
  page.faults = [];
  page.on("pageerror", (error) => page.faults.push(error.stack ?? error.message));
  // The page makes requests to its own server only.
  page.on("request", (request) => /^(https?|wss?):/.test(request.url()) && new URL(request.url()).host !== new URL(url).host && page.faults.push(`asked ${request.url()}`));
  page.on("console", (message) => message.type() === "error" && page.faults.push(`${message.text()} ${message.location().url}`));
  await page.goto(`${url}/#/${view}`);
  await page.locator("html[data-connection=open]").waitFor({ state: "attached" });
  await page.getByText("No page has control").or(page.locator("main section")).first().waitFor();
  return page;
}

/** Goes to another view. */
export async function go(page, view) {
  await page.locator(`nav a[href="#/${view}"]`).click();
  await page.locator(`main .view.${view}`).waitFor();
}

/** Holds that the page reported no fault, and closes it with its context. */
export async function close(page) {
  assert.deepEqual(page.faults, [], "the page reports no error");
  await page.context().close();
}

/** Releases STOP, so that motion may begin again. */
export async function release(page) {
  const button = page.getByRole("button", { name: "Release STOP" });
  await button.click();
  await button.waitFor({ state: "hidden" });
}

/** Takes the right to drive an object in the view "Drive". */
export async function take(page, object) {
  await page.getByLabel("What to drive").selectOption(object);
  await page.getByRole("button", { name: "Take control" }).click();
  await page.getByText("You have control of").first().waitFor();
}

/** Waits until a function of the page gives something true. */
export function until(page, what, check, argument) {
  return page.waitForFunction(check, argument, { timeout: PATIENCE, polling: 50 }).catch((error) => {
    throw new Error(`${what}: ${error.message}`);
  });
}

/** Fills an operand of the form that is shown. */
export async function operand(page, member, value) {
  const input = page.locator(`.form [data-member="${member}"]`).first();
  if (!(await input.isVisible())) await page.locator(".form summary").click();
  if (await input.evaluate((element) => element.tagName === "SELECT")) await input.selectOption(String(value));
  else await input.fill(String(value));
}

/** Fills the column of the targets, and that of the vias. */
export async function positions(page, member, values) {
  for (const [k, value] of values.entries()) await page.locator(`.target-table [data-member="${member}"]`).nth(k).fill(String(value));
}

/** Waits for the line of Structured Text that matches, and for the button that runs it. */
export async function ready(page, line) {
  await until(page, `the line ${line}`, (text) => document.querySelector(".form .line code")?.textContent.replaceAll(" ", "").includes(text), line.replaceAll(" ", ""));
  await page.locator(".form[data-ready=true]").waitFor();
}

/** A number as the page shows it. */
export const shown = (text) => Number(text.replace("\u2212", "-"));

/** The actual position of an axis in the view "Drive". */
export const actual = (page, axis) => page.locator(`.jog-row[aria-label="Axis ${axis}"] output`).textContent().then(shown);

/** Waits until an axis is at a place, in the view "Drive". */
export const arrived = (page, axis, place) =>
  until(page, `${axis} at ${place}`, ([name, wanted]) =>
    Math.abs(Number(document.querySelector(`.jog-row[aria-label="Axis ${name}"] output`)?.textContent.replace("\u2212", "-")) - wanted) < 0.02, [axis, place]);

/**
 * Waits until a canvas has at least `least` pixels of a colour of the style sheet; gives how many, and the box around
 * them in pixels of the canvas. A pixel counts when it is the ground with `share` of the colour over it or more: what
 * is drawn is drawn finely, and a trail fades.
 */
export async function pixels(page, canvas, property, least, share = 0.9) {
  const found = await until(page, `${least} pixels of ${property} in ${canvas}`, ([selector, name, enough, part]) => {
    const element = document.querySelector(selector);
    const probe = document.createElement("canvas").getContext("2d");
    const colour = (of) => {
      probe.fillStyle = getComputedStyle(document.documentElement).getPropertyValue(of).trim();
      probe.fillRect(0, 0, 1, 1);
      return [...probe.getImageData(0, 0, 1, 1).data.subarray(0, 3)];
    };
    const ground = colour("--canvas");
    const over = colour(name).map((value, k) => value - ground[k]);
    const square = over.reduce((sum, value) => sum + value * value, 0);
    const { width, height } = element;
    const { data } = element.getContext("2d").getImageData(0, 0, width, height);
    const box = { count: 0, left: width, right: -1, top: height, bottom: -1 };
    for (let at = 0; at < data.length; at += 4) {
      const [red, green, blue] = [data[at] - ground[0], data[at + 1] - ground[1], data[at + 2] - ground[2]];
      const has = (red * over[0] + green * over[1] + blue * over[2]) / square;
      if (has < part || has > 1.1) continue;
      if (Math.abs(red - has * over[0]) + Math.abs(green - has * over[1]) + Math.abs(blue - has * over[2]) > 20) continue;
      const [x, y] = [(at / 4) % width, Math.floor(at / 4 / width)];
      box.count += 1;
      box.left = Math.min(box.left, x);
      box.right = Math.max(box.right, x);
      box.top = Math.min(box.top, y);
      box.bottom = Math.max(box.bottom, y);
    }
    return box.count >= enough && box;
  }, [canvas, property, least, share]);
  return found.jsonValue();
}

/**
 * Collects every sample of an axis's command velocity in a page, over a WebSocket of its own: `samples` of
 * `{tick, speed}`, and `offset`, the clock (ms) at tick 0 as the quickest frame says.
 */
export async function probe(page, axis) {
  await page.evaluate(async (name) => {
    const machine = await (await fetch("/api/machine")).json();
    const column = 4 * machine.axes.findIndex((one) => one.name === name) + 1;
    const socket = new WebSocket(`ws://${location.host}/ws`);
    socket.binaryType = "arraybuffer";
    const { period_s: period } = machine;
    window.samples = [];
    window.offset = Infinity;
    window.clockOf = (tick) => window.offset + tick * period * 1000;
    socket.onopen = () => socket.send(JSON.stringify({ id: 1, do: "trace", on: true }));
    socket.onmessage = ({ data }) => {
      if (typeof data === "string") return;
      const now = Date.now();
      const view = new DataView(data);
      const [count, columns, first] = [view.getUint32(4, true), view.getUint32(8, true), Number(view.getBigUint64(16, true))];
      const bases = new Float64Array(data, 24, columns);
      const rows = new Float32Array(data, 24 + 8 * columns, columns * count);
      for (let row = 0; row < count; row++) window.samples.push({ tick: first + row, speed: bases[column] + rows[row * columns + column] });
      window.offset = Math.min(window.offset, now - (first + count - 1) * period * 1000);
    };
  }, axis);
  await until(page, "samples", () => window.samples.length > 0);
}

/** A function that reads the performance metrics of a page by name; times are those of the main thread's processor, s. */
export async function metrics_of(page) {
  const session = await page.context().newCDPSession(page);
  await session.send("Performance.enable", { timeDomain: "threadTicks" });
  return async () => Object.fromEntries((await session.send("Performance.getMetrics")).metrics.map(({ name, value }) => [name, value]));
}

/** What each frame of `slowness` takes on the computer whose times the limits are, ms of the main thread. */
const REFERENCE_MS = 5;

/**
 * How much longer this computer takes for a frame than the one that limits of time were made on, at least 1. The frame is a drawing that needs
 * nothing of the page: eight lines of 3,000 columns each, as many as Trends may draw.
 */
export async function slowness(browser) {
  const page = await browser.newPage({ viewport: DESKTOP });
  await page.setContent('<canvas width="1200" height="600"></canvas>');
  const metrics = await metrics_of(page);
  let least = Infinity;
  for (let attempt = 0; attempt < 3; attempt += 1) {
    const before = await metrics();
    const frames = await page.evaluate((ms) => new Promise((done) => {
      const pen = document.querySelector("canvas").getContext("2d");
      const began = performance.now();
      let count = 0;
      const frame = () => {
        count += 1;
        pen.clearRect(0, 0, 1200, 600);
        for (let line = 0; line < 8; line += 1) {
          pen.beginPath();
          for (let column = 0; column < 3000; column += 1) {
            pen.lineTo(0.4 * column, 300 + 30 * line + 200 * Math.sin(0.01 * (column + 7 * count) * (1 + line)));
          }
          pen.stroke();
        }
        if (performance.now() - began < ms) requestAnimationFrame(frame);
        else done(count);
      };
      requestAnimationFrame(frame);
    }), 1000);
    least = Math.min(least, (1000 * ((await metrics()).TaskDuration - before.TaskDuration)) / frames);
  }
  await page.close();
  console.log(`reference: ${least.toFixed(2)} ms of the main thread for a frame`);
  return Math.max(1, least / REFERENCE_MS);
}
