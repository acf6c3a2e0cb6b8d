// Takes the picture of the page for the README; docs/images/page.sh runs it: node picture.mjs URL OUT.png
//
// The page shows a server that runs docs/images/page.st. The picture is taken on the fifth move of that program, so that the active and the
// pending move, the trail and the tolerances are all in it; and in a run in which no tick was missed within the last ten seconds, since the page
// shows one that was. The program runs again and again until then.

import { launch, open } from "./browser.mjs";

/** Z within the fifth move, in mm. */
const HEIGHT = 56;
const PATIENCE_MS = 900_000;

const [, , url, out] = process.argv;
const browser = await launch();
try {
  const page = await open(browser, url, "path");
  await page.setViewportSize({ width: 1200, height: 640 });
  const ready = (height) => {
    const z = Number(/\bZ\s+(\d+\.\d+)/.exec(document.querySelector("main").innerText)?.[1]);
    return z > height && z < height + 3 && !document.querySelector("header.bar").innerText.includes("missed");
  };
  await page.waitForFunction(ready, HEIGHT, { timeout: PATIENCE_MS, polling: 50 });
  await page.getByRole("button", { name: "Fit" }).click();
  await page.screenshot({ path: out });
} finally {
  await browser.close();
}
