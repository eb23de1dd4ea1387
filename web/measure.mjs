// node measure.mjs FOLDER PAGE...: what a page costs in headless Chromium without a graphics card.
// FOLDER has node_modules. Window such that the drawing buffer is 1280×720; CHROMIUM names another browser.
// node measure.mjs --long FILE.svg: a drawing of 300 strokes, 25 minutes with --set path.draw_speed=0.019.
//
// Prints per page: its size; the time to the first frame; frames a second while it plays; processor time a frame;
// memory of the page's process, of the one that renders, and of all of the browser's (shared pages counted once); and the
// machine's share of stolen and idle time meanwhile: the frames a second tell of the page only where little is stolen.
import { execFileSync } from "node:child_process";
import { readFileSync, readdirSync, statSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { basename, join, resolve } from "node:path";
import { pathToFileURL } from "node:url";

const [first, ...files] = process.argv.slice(2);
if (first === "--long") {
  const strokes = [];
  for (let row = 0; row < 15; ++row) {
    for (let column = 0; column < 20; ++column) {
      const points = Array.from({ length: 41 }, (_, k) => [4 + 9.6 * column + (7.5 * k) / 40, 6 + 12.8 * row + 3 * Math.sin((6 * Math.PI * k) / 40 + row + column)]);
      strokes.push(`<path d="M${points.map((p) => p.map((x) => x.toFixed(2)).join(",")).join("L")}" fill="none" stroke="black"/>`);
    }
  }
  writeFileSync(files[0], `<svg xmlns="http://www.w3.org/2000/svg" width="200mm" height="200mm" viewBox="0 0 200 200">${strokes.join("")}</svg>\n`);
  process.exit();
}

const seconds = 5;
const { chromium } = createRequire(join(resolve(first), "package.json"))("playwright-core");
const executablePath = process.env.CHROMIUM ?? execFileSync("sh", ["-c", "command -v chromium"]).toString().trim();

// Processes that this one started: kind, processor time [s], memory [MB].
function processes() {
  const all = new Map();
  for (const id of readdirSync("/proc").filter((name) => /^\d+$/.test(name))) {
    try {
      const stat = readFileSync(`/proc/${id}/stat`, "utf8");
      const [, parent, ...fields] = stat.slice(stat.lastIndexOf(")") + 2).split(" ");
      const kind = /--type=([a-z-]+)/.exec(readFileSync(`/proc/${id}/cmdline`, "utf8"))?.[1] ?? "main";
      const pss = /^Pss:\s+(\d+)/m.exec(readFileSync(`/proc/${id}/smaps_rollup`, "utf8"))?.[1] ?? 0;
      all.set(id, { parent, kind, cpu: (Number(fields[9]) + Number(fields[10])) / 100, memory: Number(pss) / 1024 });
    } catch {
      // It has ended meanwhile, or is another user's.
    }
  }
  const own = (id) => id !== "0" && all.has(id) && (all.get(id).parent === String(process.pid) || own(all.get(id).parent));
  return [...all.entries()].filter(([id]) => own(id)).map(([, one]) => one);
}
const sum = (list) => list.reduce((total, x) => total + x, 0);
const machine = () => readFileSync("/proc/stat", "utf8").split("\n")[0].trim().split(/\s+/).slice(1, 9).map(Number);

for (const file of files) {
  const browser = await chromium.launch({ executablePath, args: ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox"] });
  const page = await (await browser.newContext({ viewport: { width: 2163, height: 844 }, offline: true })).newPage();
  const begin = performance.now();
  await page.goto(pathToFileURL(resolve(file)).href);
  await page.evaluate(() => window.impedraw.then(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))));
  const shown = performance.now() - begin;
  await page.waitForTimeout(1000);
  const [before, at] = [processes(), machine()];
  const rate = await page.evaluate(async (s) => (await window.impedraw).framesPerSecond(s), seconds);
  const [now, after] = [processes(), machine()];
  const passed = after.map((x, i) => x - at[i]);
  const cpu = (list) => sum(list.map((p) => p.cpu));
  const memory = (kind) => Math.round(sum(now.filter((p) => !kind || p.kind === kind).map((p) => p.memory)));
  const buffer = await page.evaluate(() => { const c = document.querySelector(".pane canvas"); return `${c.width}×${c.height}`; });
  console.log(`${basename(file)}: ${(statSync(file).size / 1e6).toFixed(2)} MB, first frame ${(shown / 1000).toFixed(2)} s, ${rate.toFixed(1)} frames/s of ${buffer}, ` +
    `${((1000 * (cpu(now) - cpu(before))) / (rate * seconds)).toFixed(0)} ms of processor a frame, memory ${memory("renderer")} + ${memory("gpu-process")} MB (all ${memory()}); ` +
    `stolen ${Math.round((100 * passed[7]) / sum(passed))} %, idle ${Math.round((100 * passed[3]) / sum(passed))} %`);
  await browser.close();
}
