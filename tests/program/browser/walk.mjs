// Walks through controllers in a headless Chromium, and prints where a page differs from the steps of `linewright step`, one line each; nothing
// if all is well.
//
// node walk.mjs MODULES (PAGE STEPS)...
//
// STEPS is what `linewright step --format json` printed.
import { readFileSync } from "node:fs";
import { pathToFileURL } from "node:url";
import { launch } from "./chromium.mjs";

const [modules, ...files] = process.argv.slice(2);
const browser = await launch(modules);
for (let index = 0; index < files.length; index += 2) {
  const [file, steps] = [files[index], files[index + 1]];
  const problem = (what) => console.log(`${file}: ${what}`);
  const page = await browser.newPage();
  page.on("console", (message) => problem(`console ${message.type()}: ${message.text()}`));
  page.on("pageerror", (error) => problem(`error: ${error.message}`));
  await page.goto(pathToFileURL(file).href, { waitUntil: "load" });
  await page.waitForSelector("html[data-ready]", { timeout: 20000 });
  // Numbers that would be rounded are read as text.
  const read = (line) => JSON.parse(line.replace(/:\s*(-?\d{16,})/g, ':"$1"'));
  const made = readFileSync(steps, "utf8").split("\n").filter((line) => line).map(read).filter((line) => "step" in line);
  for (const problem of await page.evaluate(compare, made)) console.log(`${file}: ${problem}`);
  if (made.length > 1) await use(page, problem);
  if (await page.$("#diagram")) await zoom(page, problem);
  await page.close();
}
await browser.close();

// In the page: makes the steps, and returns where the answers differ.
function compare(steps) {
  const byId = (id) => document.getElementById(id);
  const { variables, own, others, reader } = JSON.parse(byId("data").textContent);
  const problems = [];
  for (const made of steps) {
    const [moved, answered] = reader === "plant" ? [made.plant, made.machine] : [made.machine, made.plant];
    for (const index of own) {
      const field = byId(`own${index}`);
      if (!field) continue;
      const { name, labels } = variables[index];
      const value = moved[name];
      if (field.type === "checkbox") field.checked = value;
      else field.value = labels ? labels.indexOf(value) : value;
      field.dispatchEvent(new Event("input"));
    }
    byId("step").click();
    const rows = byId("history").querySelectorAll("tr");
    if (rows.length !== made.step + 2) {
      problems.push(`step ${made.step} was refused: ${byId("status").textContent}`);
      break;
    }
    const shown = {};
    const [names, values] = [byId("answer").querySelectorAll("dt"), byId("answer").querySelectorAll("dd")];
    names.forEach((name, place) => (shown[name.textContent] = values[place].textContent.split(" ")[0]));
    for (const index of others.filter((index) => !variables[index].hidden)) {
      const { name } = variables[index];
      if (shown[name] !== String(answered[name])) problems.push(`step ${made.step}: ${name} is ${shown[name]}, not ${answered[name]}`);
    }
  }
  return problems;
}

// Goes back and on, by the keyboard and the table of moves; finds a refused move and a forbidden answer, which name a rule.
async function use(page, problem) {
  const expect = (holds, what) => { if (!holds) problem(what); };
  const length = () => page.$$eval("#history tr", (rows) => rows.length - 1);
  const made = await length();
  await page.click("#undo");
  expect((await length()) === made - 1, "a step is not taken back");
  await page.focus("#step");
  await page.keyboard.press("Enter");
  expect((await length()) === made, "the enter key makes no step");
  await page.click("#reset");
  expect((await length()) === 0, "the play does not begin again");
  if (await page.$("#choices button")) {
    await page.$eval("#choices button", (button) => button.click());
    expect((await length()) === 1, "a move of the table is not made");
    const boxes = await page.$$eval("#diagram .state", (all) => all.length);
    const marked = await page.$$eval("#diagram .state.current", (all) => all.length);
    expect(marked === 1 || boxes === 0 || (await page.$eval("#diagram", (d) => d.textContent.includes("groups"))), "the state is not marked in the drawing");
  }
  await page.evaluate(() => document.querySelectorAll("details").forEach((d) => (d.open = true)));
  const named = (prefix, target) => page.evaluate((prefix, target) => {
    for (const field of document.querySelectorAll(`[id^=${prefix}]`)) {
      const options = field.type === "checkbox" ? [true, false] : field.options ? [...field.options].map((option) => option.value) : [field.min, field.max];
      for (const option of options) {
        if (field.type === "checkbox") field.checked = option;
        else field.value = option;
        field.dispatchEvent(new Event("input"));
        if (document.querySelector(`#${target} li code`)) return true;
      }
    }
    return false;
  }, prefix, target);
  const { rules } = await page.evaluate(() => JSON.parse(document.getElementById("data").textContent));
  const found = { other: false, own: false };
  for (let round = 0; round < 40 && !(found.other && found.own); round++) {
    await page.click("#random");
    found.other ||= await named("other", "why");
    found.own ||= await named("own", "status");
  }
  const { definitions } = await page.evaluate(() => JSON.parse(document.getElementById("data").textContent));
  const isNamed = (rule) => definitions.some((defined) => defined.value !== undefined && rule.text.includes(defined.name));
  const inner = await page.$$eval("#status li .definitions li", (all) => all.map((entry) => entry.textContent));
  if (found.own && rules.filter((rule) => rule.own).every(isNamed)) {
    expect(inner.some((text) => /, defined as .* (would be|was) (true|false)/.test(text)), "a refused move does not show the values of definitions");
  }
  if (rules.some((rule) => !rule.own)) expect(found.other, "no other answer breaks a rule");
  if (rules.some((rule) => rule.own)) expect(found.own, "no move is refused with a rule");
}

// Changes the size of the state diagram by buttons and keys, and sees that it follows the walk without moving the page.
async function zoom(page, problem) {
  const expect = (holds, what) => { if (!holds) problem(what); };
  const width = () => page.$eval("#diagram svg", (svg) => svg.getBoundingClientRect().width);
  const drawn = await page.$eval("#diagram svg", (svg) => +svg.getAttribute("width"));
  const isAbout = (a, b) => Math.abs(a - b) < 1;
  expect(isAbout(await width(), drawn), "the diagram does not begin as it was drawn");
  await page.click("#larger");
  expect(isAbout(await width(), 1.25 * drawn), "a button does not make the diagram larger");
  await page.focus("#diagram");
  await page.keyboard.press("-");
  await page.keyboard.press("-");
  expect(isAbout(await width(), 0.8 * drawn), "a key does not make the diagram smaller");
  await page.keyboard.press("0");
  expect(await page.$eval("#diagram", (diagram) => diagram.scrollWidth <= diagram.clientWidth + 1 && diagram.scrollHeight <= diagram.clientHeight + 1), "the diagram does not fit the page");
  await page.keyboard.press("w");
  expect(await page.$eval("#diagram", (diagram) => diagram.scrollWidth <= diagram.clientWidth + 1), "the diagram does not fit the width");
  await page.keyboard.press("1");
  expect(isAbout(await width(), drawn), "a key does not show the diagram as drawn");
  for (let times = 0; times < 12; times++) await page.click("#larger");
  for (let move = 0; move < 6; move++) {
    await page.evaluate(() => globalThis.scrollTo({ top: 0, behavior: "instant" }));
    const before = await page.evaluate(() => globalThis.scrollY);
    await page.$eval("#random", (button) => button.click());
    expect((await page.evaluate(() => globalThis.scrollY)) === before, "the walk moves the page");
    const isShown = await page.evaluate(() => {
      const [diagram, state] = [document.querySelector("#diagram"), document.querySelector("#diagram .state.current")];
      if (!state) return true;
      const [inside, outside] = [state.getBoundingClientRect(), diagram.getBoundingClientRect()];
      const [x, y] = [inside.left + inside.width / 2, inside.top + inside.height / 2];
      return outside.left <= x && x <= outside.right && outside.top <= y && y <= outside.bottom;
    });
    expect(isShown, "the diagram does not follow the walk");
  }
  const meaning = await page.$eval(".notation", (list) => list.textContent);
  expect(["before the slash", "!x", "from the dot"].every((words) => meaning.includes(words)), "the notation is not explained");
}
