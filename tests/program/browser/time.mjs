// Prints how long a report takes to load and to redraw in a headless Chromium, in milliseconds: the least and the greatest of five.
//
// node time.mjs MODULES PAGE
//
// MODULES is a folder in which `npm install` was run with this folder's package.json.
import { pathToFileURL } from "node:url";
import { launch } from "./chromium.mjs";

const [modules, file] = process.argv.slice(2);
const browser = await launch(modules);
const times = { ready: [], redraw: [], seek: [] };
for (let run = 0; run < 5; run++) {
  const page = await browser.newPage();
  await page.setViewport({ width: 1200, height: 900 });
  await page.goto(pathToFileURL(file).href, { waitUntil: "load" });
  await page.waitForSelector("html[data-ready]");
  const measured = await page.evaluate(() => {
    const ready = performance.now();
    const timed = (act) => {
      const start = performance.now();
      act();
      return performance.now() - start;
    };
    const redraw = ["zoom-in", "zoom-out", "zoom-all"].map((id) => timed(() => document.getElementById(id).click()));
    const slider = document.getElementById("time");
    const seek = [999, 1, 500].map((value) => timed(() => { slider.value = value; slider.dispatchEvent(new Event("input")); }));
    return { ready, redraw: Math.max(...redraw), seek: Math.max(...seek) };
  });
  for (const [name, values] of Object.entries(times)) values.push(measured[name]);
  await page.close();
}
await browser.close();
for (const [name, values] of Object.entries(times)) {
  console.log(`${name} ${Math.min(...values).toFixed(0)} to ${Math.max(...values).toFixed(0)} ms`);
}
