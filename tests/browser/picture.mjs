// Takes the picture of the page for the README; docs/images/page.sh runs it: node picture.mjs URL OUT.png
//
// The page shows a server that runs docs/images/page.st. The picture is taken on the fifth move of that program, so that the active and the
// pending move, the trail and the tolerances are all in it.

import { launch, open, until } from "./browser.mjs";

/** Z within the fifth move, in mm. */
const HEIGHT = 56;

const [, , url, out] = process.argv;
const browser = await launch();
try {
  const page = await open(browser, url, "path");
  await page.setViewportSize({ width: 1200, height: 640 });
  await until(page, "the fifth move", (height) => Number(/\bZ\s+(\d+\.\d+)/.exec(document.querySelector("main").innerText)?.[1]) > height, HEIGHT);
  await page.getByRole("button", { name: "Fit" }).click();
  await page.screenshot({ path: out });
} finally {
  await browser.close();
}
