// Opens pages in a headless Chromium, as a reader does, and prints what is wrong with them, one line each; nothing if all is well.
//
// node open.mjs MODULES PAGE...
//
// MODULES is a folder in which `npm install` was run with this folder's package.json.
import { readFileSync } from "node:fs";
import { pathToFileURL } from "node:url";
import { find, launch } from "./chromium.mjs";

const [modules, ...pages] = process.argv.slice(2);
const axe = readFileSync(find(modules, "axe-core/axe.min.js"), "utf8");
const browser = await launch(modules);
for (const file of pages) {
  const problem = (what) => console.log(`${file}: ${what}`);
  for (const scheme of ["light", "dark"]) {
    const page = await browser.newPage();
    await page.setViewport({ width: 1200, height: 900 });
    await page.emulateMediaFeatures([{ name: "prefers-color-scheme", value: scheme }]);
    page.on("console", (message) => problem(`console ${message.type()}: ${message.text()}`));
    page.on("pageerror", (error) => problem(`error: ${error.message}`));
    page.on("request", (request) => {
      if (!/^(file|data|blob):/.test(request.url())) problem(`request: ${request.url()}`);
    });
    await page.goto(pathToFileURL(file).href, { waitUntil: "load" });
    // Only pages in which something moves have data and a script.
    if (await page.$("#data")) {
      try {
        await page.waitForSelector("html[data-ready]", { timeout: 20000 });
      } catch {
        problem("the script does not get ready");
        continue;
      }
    }
    if (scheme === "light" && (await page.$("#play"))) await use(page, problem);
    await page.evaluate(() => document.querySelectorAll("details").forEach((d) => (d.open = true)));
    await page.evaluate(axe);
    const found = await page.evaluate(() => globalThis.axe.run());
    for (const violation of found.violations) {
      problem(`axe, ${scheme}: ${violation.id}: ${violation.nodes.map((node) => node.target.join(" ")).slice(0, 3).join(", ")}`);
    }
    await page.emulateMediaType("print");
    const printed = await page.$$eval(".controls", (all) => all.some((controls) => getComputedStyle(controls).display !== "none"));
    if (printed) problem("controls are printed");
    await page.close();
  }
}
await browser.close();

// Plays, steps, seeks, zooms and jumps, by keyboard and mouse.
async function use(page, problem) {
  const text = (id) => page.$eval(`#${id}`, (element) => element.textContent);
  const expect = (holds, what) => { if (!holds) problem(what); };
  const parts = () => page.$$eval("#units use", (uses) => uses.map((use) => use.getAttribute("transform") + use.getAttribute("display")).join(" "));

  // With a calendar, times have their days.
  const { days } = await page.evaluate(() => JSON.parse(document.getElementById("data").textContent));
  const isDay = days?.date ? /^Mon 30 Nov 0:00:00$/ : days ? /^Mon 0:00:00$/ : /^0:00:00(\.00)?$/;
  expect(isDay.test(await text("clock")), `the clock shows ${await text("clock")} at the start`);

  const press = (id) => page.$eval(`#${id}`, (button) => { for (let i = 0; i < 40; i++) button.click(); });
  await page.focus("#play");
  const [before, placed] = [await text("clock"), await parts()];
  await page.keyboard.press("Space");
  await new Promise((done) => setTimeout(done, 700));
  for (const place of await miscounted(page)) problem(`during playback, ${place}`);
  expect((await text("play")) === "Pause", "the space bar does not start playback");
  expect((await text("clock")) !== before, "time does not pass during playback");
  expect((await parts()) !== placed, "parts do not move during playback");
  await page.keyboard.press("Space");
  expect((await text("play")) === "Play", "the space bar does not stop playback");
  expect((await page.$$("#units .moving:not([display=none])")).length === 0, "parts are drawn on arrows while the run is paused");
  for (let thousandth = 0; thousandth <= 1000; thousandth += 40) {
    await page.$eval("#time", (input, value) => { input.value = value; input.dispatchEvent(new Event("input")); }, thousandth);
    for (const place of await miscounted(page)) problem(`at ${thousandth / 10} % of the run, ${place}`);
  }
  await page.$eval("#time", (input) => { input.value = 100; input.dispatchEvent(new Event("input")); });

  const stopped = await text("clock");
  await press("forward");
  expect((await text("clock")) !== stopped, "stepping forward does not change the time");
  const later = await text("clock");
  await press("back");
  expect((await text("clock")) !== later, "stepping back does not change the time");

  await page.focus("#time");
  await page.keyboard.press("End");
  const end = await text("clock");
  await page.keyboard.press("Home");
  expect((await text("clock")) !== end, "Home and End do not move through the time");
  await page.keyboard.press("End");
  await page.keyboard.press("Home");

  await page.$eval("#line .node", (node) => node.focus());
  const first = await text("status");
  await page.keyboard.press("Tab");
  expect(/ (is|holds|has taken|has delivered) /.test(first) && (await text("status")) !== first, "the focus on a place does not say what it does");

  if (await page.$("#gantt")) {
    const all = await text("window");
    await page.focus("#gantt");
    await page.keyboard.press("+");
    expect((await text("window")) !== all, "+ does not zoom");
    await page.keyboard.press("ArrowRight");
    await page.keyboard.press("0");
    expect((await text("window")) === all, "0 does not show all");
    const [gaps, rows] = await page.evaluate(ground);
    expect(rows > 0 && gaps === 0, `the rows of the timeline show the ground at ${gaps} pixels`);
  }
  if (await page.$(".jump")) {
    await page.focus("#time");
    await page.keyboard.press("End");
    const said = await page.$$eval("#line .node", (nodes) => nodes.map((node) => { node.focus(); return document.getElementById("status").textContent; }));
    expect(said.some((sentence) => /It has refused (once|[\d,]+ times), last at /.test(sentence)), "no place says that it has refused something");
    expect(await page.$(".refusal"), "the legend of the timeline does not explain refusals");
    await page.click("#violation");
    const marked = await page.$eval("#marks path", (path) => path.getAttribute("d").length);
    expect(marked > 0, "violations are not marked");
    await page.click(".jump");
    const at = await page.$eval(".jump", (button) => +button.dataset.time);
    const value = await page.$eval("#time", (input) => +input.value);
    const last = await page.evaluate(() => JSON.parse(document.getElementById("data").textContent).end);
    expect(Math.abs((value / 1000) * last - at) < 1e-3 * last, "a violation's button does not set the time");
  }
}

// The places in which the number of drawn parts is not the number beside them.
function miscounted(page) {
  return page.evaluate(() => [...document.querySelectorAll("#line .node")].flatMap((node, index) => {
    const said = node.querySelector(".count").textContent;
    const number = (text) => Number((text.match(/[\d,]+/) ?? ["0"])[0].replaceAll(",", ""));
    const shown = document.querySelectorAll(`#units use[data-in="${index}"]:not([display=none])`).length + number(node.querySelector(".more").textContent);
    const name = node.querySelector("text").textContent;
    if (/ (in|out)$/.test(said)) return shown === 0 ? [] : [`${name} draws ${shown} parts that have left the line`];
    const isRight = said === "" ? shown <= 1 : shown === number(said);
    return isRight ? [] : [`${name} draws ${shown} parts and says "${said}"`];
  }));
}

// Number of pixels in the rows of the timeline that have the colour of the ground, and number of rows.
function ground() {
  const data = JSON.parse(document.getElementById("data").textContent);
  const canvas = document.getElementById("gantt");
  const ratio = canvas.width / canvas.clientWidth;
  const [left, right] = data.margins.map((share) => Math.ceil(share * canvas.width) + 2);
  const rows = data.states.map((states, node) => [states, data.refusals[node]]).filter(([states, refusals]) => states || refusals);
  const height = (canvas.clientHeight - 24) / rows.length;
  const { data: pixels, width } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  const background = getComputedStyle(document.body).backgroundColor.match(/\d+/g).map(Number);
  let gaps = 0;
  rows.forEach(([states], row) => {
    if (!states) return;
    const start = Math.floor((row + 0.6) * height * ratio) * width;
    for (let x = left; x < width - right; x++) {
      const [red, green, blue] = pixels.subarray(4 * (start + x), 4 * (start + x) + 3);
      if (background.every((value, c) => Math.abs(value - [red, green, blue][c]) < 6)) gaps++;
    }
  });
  return [gaps, rows.length];
}
