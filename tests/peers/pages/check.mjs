// SPDX-License-Identifier: Apache-2.0
// check.mjs PAGE...: what axe-core finds in pages, which are files or addresses, in the light and in the dark, on a desk and on a
// phone, with all that can be opened open. Exit status 1: a violation.
import {createRequire} from "node:module";
import {resolve} from "node:path";
import puppeteer from "puppeteer-core";

const axe = createRequire(import.meta.url).resolve("axe-core");
const browser = await puppeteer.launch({executablePath: "/usr/bin/chromium",
  args: ["--no-sandbox", "--disable-gpu", "--enable-unsafe-swiftshader"]});
const page = await browser.newPage();
for (const file of process.argv.slice(2)) {
  for (const scheme of ["light", "dark"]) {
    for (const [width, height] of [[1280, 900], [390, 844]]) {
      await page.setViewport({width, height, isMobile: width < 500, hasTouch: width < 500});
      await page.emulateMediaFeatures([{name: "prefers-color-scheme", value: scheme}]);
      await page.goto(/^http:/.test(file) ? file : `file://${resolve(file)}`, {waitUntil: "load"});
      await page.evaluate(async () => {
        document.querySelectorAll("details").forEach((each) => { each.open = true; });
        document.querySelector("#runs-table .link")?.click();  // of a campaign: what there is of one run
        await new Promise((done) => setTimeout(done, 500));  // media are there, charts drawn
      });
      await page.addScriptTag({path: axe});
      const {violations, passes} = await page.evaluate(() => axe.run(document, {resultTypes: ["violations", "passes"]}));
      console.log(`${file}, ${scheme}, ${width} px: ${violations.length} violations, ${passes.length} rules kept`);
      for (const {id, help, nodes} of violations) {
        console.log(`  ${id}: ${help}`);
        for (const {html, any, all} of nodes.slice(0, 5)) console.log(`    ${html.slice(0, 160)}\n      ${[...any, ...all].map(({message}) => message).join("; ")}`);
        process.exitCode = 1;
      }
    }
  }
}
await browser.close();
