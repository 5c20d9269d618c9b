// The headless Chromium of a folder in which `npm install` was run with this folder's package.json.
import { createRequire } from "node:module";
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";

// Starts the browser.
export async function launch(modules) {
  const puppeteer = await load(modules, "puppeteer-core");
  const chromium = await load(modules, "@sparticuz/chromium");
  return puppeteer.launch({
    executablePath: await chromium.executablePath(),
    args: [...chromium.args, "--no-sandbox"],
    headless: "shell",
  });
}

// The path of a file of a package.
export function find(modules, name) {
  return createRequire(resolve(modules, "package.json")).resolve(name);
}

async function load(modules, name) {
  return (await import(pathToFileURL(find(modules, name)))).default;
}
