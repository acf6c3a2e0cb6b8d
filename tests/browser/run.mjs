// Runs one case against a server: node run.mjs CASE URL FOLDER-FOR-PICTURES SERVER-PROCESS

import { launch } from "./browser.mjs";
import * as cases from "./cases.mjs";

const [, , name, url, folder, process_id] = process.argv;
const browser = await launch();
try {
  await cases[name]({ browser, url, folder, server: Number(process_id) });
  console.log(`ok  ${name}`);
} finally {
  await browser.close();
}
