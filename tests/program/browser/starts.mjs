// Succeeds if the headless Chromium of a folder of Node packages starts: node starts.mjs MODULES
import { launch } from "./chromium.mjs";

const browser = await launch(process.argv[2]);
await browser.close();
