// node film.mjs JSON: renders a page as a film or a picture. src/report/report.cc has read the command line.
//
// page ─ headless Chromium, frame by frame ─ PNG ─ pipe ─> ffmpeg ─> OUT
// Frames never touch the disk; OUT appears when it is whole.
import { spawn, spawnSync } from "node:child_process";
import { renameSync, rmSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { basename, dirname, extname, join } from "node:path";
import { pathToFileURL } from "node:url";

const job = JSON.parse(process.argv[2]);
const kind = extname(job.out);
const part = join(dirname(job.out), `.${basename(job.out, kind)}.${process.pid}${kind}`);
let browser;
let encoder;
let leaving = false;

async function leave(code, message) {
  if (leaving) return;
  leaving = true;
  encoder?.kill("SIGKILL");
  if (process.stderr.isTTY) process.stderr.write("\r\x1b[K");
  if (message) process.stderr.write(`impedraw: ${message}\n`);
  await browser?.close().catch(() => {});
  rmSync(part, { force: true });
  process.exit(code);
}
for (const [signal, code] of [["SIGINT", 130], ["SIGTERM", 143], ["SIGHUP", 129]])
  process.on(signal, () => leave(code, "film: interrupted; nothing was written"));

// Redrawn on a terminal; elsewhere a line every half minute.
let told = 0;
function progress(done, begun) {
  const passed = (Date.now() - begun) / 1000;
  const left = Math.round((passed / done) * (1 - done));
  const text = `film: ${Math.floor(100 * done)} %, ${Math.floor(left / 60)}:${String(left % 60).padStart(2, "0")} left`;
  if (process.stderr.isTTY) process.stderr.write(`\r\x1b[K${text}`);
  else if (Date.now() - told > 30_000) {
    told = Date.now();
    process.stderr.write(`${text}\n`);
  }
}

function needed(program) {
  const found = spawnSync("sh", ["-c", `command -v ${program}`]).stdout.toString().trim();
  if (!found) throw new Error(`film needs ${program}: call it as ./impedraw film, which installs it, or apt-get install ${program}`);
  return found;
}

function encode() {
  const how = {
    // Loops for ever; lossy, as a photograph.
    ".webp": ["-c:v", "libwebp_anim", "-loop", "0", "-quality", "85", "-compression_level", "4", "-pix_fmt", "yuva420p"],
    ".mp4": ["-c:v", "libx264", "-preset", "medium", "-crf", "20", "-pix_fmt", "yuv420p", "-movflags", "+faststart"],
  }[kind];
  // A group of its own: ctrl-C is ours to handle.
  const child = spawn(needed("ffmpeg"),
    ["-v", "error", "-nostdin", "-y", "-f", "image2pipe", "-framerate", String(job.fps), "-c:v", "png", "-i", "pipe:0", ...how, part],
    { stdio: ["pipe", "ignore", "pipe"], detached: true });
  let words = "";
  child.stderr.on("data", (data) => (words += data));
  child.stdin.on("error", () => {}); // told by its exit code
  child.ended = new Promise((done, fail) => {
    child.on("error", fail);
    child.on("close", (code) => (code === 0 ? done() : fail(new Error(`ffmpeg: ${words.trim().split("\n").pop() || `exit code ${code}`}`))));
  });
  child.ended.catch(() => {});
  return child;
}

async function render() {
  const executablePath = process.env.CHROMIUM || needed("chromium");
  const { chromium } = createRequire(join(job.web, "package.json"))("playwright-core");
  browser = await chromium.launch({
    executablePath, handleSIGINT: false, handleSIGTERM: false, handleSIGHUP: false,
    args: ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox", "--hide-scrollbars"],
  });
  const context = await browser.newContext({
    viewport: { width: job.width, height: job.height }, colorScheme: job.theme, offline: true,
  });
  const page = await context.newPage();
  await page.addInitScript(() => (window.impedrawFine = true)); // the fine shapes, whatever a frame costs
  await page.goto(pathToFileURL(job.page).href);
  const ready = await page.evaluate(() => window.impedraw?.then((hook) => typeof hook.film === "function"));
  if (!ready) throw new Error(`${job.page}: made by an older version; write it anew with ./impedraw report`);
  const { begin, end } = await page.evaluate(async (wanted) => (await window.impedraw).film(wanted), job);
  const from = Math.max(begin, job.from ?? begin);
  const to = Math.min(end, job.to ?? end);
  const show = (t) => page.evaluate(async (time) => {
    (await window.impedraw).seek(time);
    await new Promise(requestAnimationFrame);
  }, t);
  if (kind === ".png") {
    await show(to);
    writeFileSync(part, await page.screenshot({ type: "png" }));
    return;
  }
  if (!(from < to)) throw new Error(`the film would be empty: the run lasts from ${begin} to ${end} s`);
  encoder = encode();
  const step = job.speed / job.fps;
  const frames = Math.floor((to - from) / step + 1e-9) + 1;
  const begun = Date.now();
  for (let k = 0; k < frames; ++k) {
    await show(Math.min(to, from + k * step));
    const frame = await page.screenshot({ type: "png" });
    if (encoder.exitCode !== null) break;
    if (!encoder.stdin.write(frame))
      await Promise.race([new Promise((go) => encoder.stdin.once("drain", go)), encoder.ended.catch(() => {})]);
    progress((k + 1) / frames, begun);
  }
  encoder.stdin.end();
  await encoder.ended;
}

try {
  await render();
  renameSync(part, job.out);
  if (process.stderr.isTTY) process.stderr.write("\r\x1b[K");
  process.stdout.write(`film  ${job.out}\n`);
  await leave(0);
} catch (error) {
  const words = error.message.split("\n")[0].replace(/^page\.evaluate: (Error: )?/, "");
  await leave(words.startsWith("--") ? 2 : 3, words.startsWith("--") || words.startsWith("film") ? words : `film: ${words}`);
}
