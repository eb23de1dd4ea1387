// node --test place.mjs: ./impedraw place, asked directly and used in a browser.
//
// IMPEDRAW   the program           IMPEDRAW_WEB     the folder with node_modules
// CHROMIUM   the browser (default: chromium on PATH)
//
// Pictures stand in IMPEDRAW_WEB/shots.
import assert from "node:assert/strict";
import { execFileSync, spawn, spawnSync } from "node:child_process";
import { existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync } from "node:fs";
import { request } from "node:http";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { after, before, test } from "node:test";

const web = resolve(process.env.IMPEDRAW_WEB ?? "build/web");
const program = resolve(process.env.IMPEDRAW ?? "build/release/src/app/impedraw");
const { chromium } = createRequire(join(web, "package.json"))("playwright-core");
const executablePath = process.env.CHROMIUM ?? execFileSync("sh", ["-c", "command -v chromium"]).toString().trim();
const shots = join(web, "shots");
const scratch = mkdtempSync(join(tmpdir(), "impedraw-place-"));
const saved = join(scratch, "placed.yaml"), region = join(scratch, "placed.areas.svg");
mkdirSync(shots, { recursive: true });
let run, address;

before(async () => {
  run = spawn(program, ["place", "--headless", "--text", "Hello", "--set", "drawing.placement.fit_radius=0.05", "--save", saved]);
  let out = "", err = "";
  run.stdout.on("data", (data) => (out += data));
  run.stderr.on("data", (data) => (err += data));
  run.ended = new Promise((done) => run.on("exit", (code) => done(code)));
  for (let i = 0; i < 600 && !/^page +\S+\n/m.test(out); ++i) await new Promise((done) => setTimeout(done, 50));
  address = new URL(/^page +(\S+)\n/m.exec(out)?.[1] ?? assert.fail(err));
});

after(() => {
  run.kill("SIGKILL");
  rmSync(scratch, { recursive: true, force: true });
});

// Status and body. fetch() would set Host and Origin itself.
const ask = (path, { body, token = address.search, headers = {} } = {}) => new Promise((done, fail) => {
  const asked = request({ host: "127.0.0.1", port: address.port, path: path + token, method: body === undefined ? "GET" : "POST", headers }, (answer) => {
    let text = "";
    answer.on("data", (data) => (text += data));
    answer.on("end", () => done({ status: answer.statusCode, text, json: () => JSON.parse(text) }));
  });
  asked.on("error", fail);
  asked.end(body);
});
const question = (name, body) => ask(`/${name}`, { body: JSON.stringify(body) });

test("strangers are refused", async () => {
  assert.equal((await ask("/data", { token: "" })).status, 403);
  assert.equal((await ask("/data", { token: "?token=" + "0".repeat(32) })).status, 403);
  assert.equal((await ask("/data", { headers: { Host: "example.com" } })).status, 403);
  assert.equal((await ask("/save", { body: "{}", headers: { Origin: "http://example.com" } })).status, 403);
  assert.equal((await ask("/nothing")).status, 404);
});

test("questions that mean nothing are answered in one line", async () => {
  for (const [name, body, words] of [["check", "no JSON", /JSON object/], ["check", "{}", /'x' must be a number/],
    ["check", '{"x": 1e9, "y": 0, "turn": 0, "size": 1}', /'x'/], ["check", '{"x": 0, "y": 0, "turn": 0, "size": 0}', /'size'/],
    ["save", '{"areas": [[0.6, 0, 0.6]]}', /x and y by turns/], ["save", '{"areas": [[0.6, 0, 0.6, 9]]}', /x and y by turns/],
    ["save", '{"areas": []}', /no area is marked/], ["save", '{"areas": [[0.6, 0, 0.7, 0]]}', /has 2 points/],
    ["dance", "{}", /valid are check, plan, save, end/]]) {
    const answer = await ask(`/${name}`, { body });
    assert.equal(answer.status, 400);
    assert.match(answer.json().error, words);
  }
  assert.equal((await ask("/check", { body: "x".repeat(100_000) })).status, 413);
});

test("a place is checked, quickly and fully, and what lies off the canvas is told", async () => {
  const { given } = (await ask("/data")).json();
  const here = (await question("check", given)).json();
  assert.equal(here.share, 1);
  assert.ok(Math.abs(here.width_mm - 100) < 12 && here.time_s > 5);
  assert.equal((await question("plan", given)).json().share, 1);
  const off = (await question("check", { ...given, y: given.y + 0.17 })).json();
  assert.ok(off.share < 0.9 && off.lost_mm.missing > 0);
  assert.ok(Math.abs(off.share - (await question("plan", { ...given, y: given.y + 0.17 })).json().share) < 0.12);
  const twice = (await question("check", { ...given, size: 2 })).json();
  assert.ok(Math.abs(twice.width_mm / here.width_mm - 2) < 1e-9);
});

test("in a browser the drawing is dragged, turned, undone and saved", async () => {
  const browser = await chromium.launch({ executablePath, args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"] });
  try {
    const page = await browser.newPage({ viewport: { width: 1100, height: 720 } });
    const errors = [];
    page.on("pageerror", (error) => errors.push(error.stack));
    // The browser tells that a file was not replaced as an error of its own.
    page.on("console", (message) => message.type() === "error" && !message.text().includes("400") && errors.push(message.text()));
    await page.goto(address.href);
    const share = page.locator(".share");
    const shown = async (text) => page.waitForFunction((t) => document.querySelector(".share")?.textContent === t, text, { timeout: 60_000 });
    await shown("100.0 %");
    await page.screenshot({ path: join(shots, "place.png") });
    const value = async (label) => Number(await page.getByLabel(label).inputValue());
    const before = [await value("x [mm]"), await value("y [mm]")];
    // Along the canvas, to the right of the page: y falls.
    const [x, y] = await page.evaluate(() => window.impedraw.screen());
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.mouse.move(x + 60, y, { steps: 4 });
    await page.mouse.move(x + 200, y + 60, { steps: 8 });
    await page.mouse.up();
    assert.ok(Math.hypot((await value("x [mm]")) - before[0], (await value("y [mm]")) - before[1]) > 50);
    await page.waitForFunction(() => document.querySelector(".share")?.textContent !== "100.0 %", null, { timeout: 60_000 });
    assert.match(await page.locator(".lost").innerText(), /mm/);
    await page.screenshot({ path: join(shots, "place-off.png") });
    await page.getByRole("button", { name: "Undo" }).click();
    await shown("100.0 %");
    assert.deepEqual([await value("x [mm]"), await value("y [mm]")], before);
    await page.getByLabel("width [mm]").fill("60");
    await page.getByLabel("width [mm]").press("Enter");
    await page.locator("canvas").focus().catch(() => {});
    await page.evaluate(() => document.activeElement.blur());
    await page.keyboard.press("[");
    await page.keyboard.press("Shift+ArrowUp");
    assert.equal(await value("turn [°]"), 5);
    assert.ok(Math.abs((await value("x [mm]")) - before[0] - 10) < 0.11);
    await page.getByRole("button", { name: "Save" }).click();
    await page.waitForFunction(() => document.querySelector(".said")?.textContent?.startsWith("saved"), null, { timeout: 20_000 });
    await page.getByRole("button", { name: "Save" }).click();
    await page.getByRole("button", { name: "Overwrite" }).click();
    await page.waitForFunction(() => document.querySelector(".said")?.textContent?.startsWith("saved"), null, { timeout: 20_000 });
    assert.match(await share.innerText(), /100.0/);
    await page.emulateMedia({ colorScheme: "dark" });
    await page.setViewportSize({ width: 390, height: 780 });
    await page.screenshot({ path: join(shots, "place-narrow-dark.png"), fullPage: true });
    assert.deepEqual(errors, []);
  } finally {
    await browser.close();
  }
});

test("what was saved is drawn there", () => {
  assert.ok(existsSync(saved));
  const plan = spawnSync(program, ["plan", saved, "--json", "--out", join(scratch, "plan")], { encoding: "utf8" });
  assert.equal(plan.status, 0, plan.stderr);
  assert.match(readFileSync(saved, "utf8"), /rotate: 5/);
});

test("in a browser an area is marked, undone and saved", async () => {
  rmSync(saved);
  const browser = await chromium.launch({ executablePath, args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"] });
  try {
    const page = await browser.newPage({ viewport: { width: 1100, height: 720 } });
    const errors = [];
    page.on("pageerror", (error) => errors.push(error.stack));
    await page.goto(address.href);
    await page.getByRole("button", { name: "Mark an area" }).click();
    const [x, y] = await page.evaluate(() => window.impedraw.screen());
    const round = async (radius, turn) => {
      await page.mouse.move(x + radius, y);
      await page.mouse.down();
      for (let k = 1; k < 24; ++k) await page.mouse.move(x + radius * Math.cos((turn * k) / 24), y - 0.8 * radius * Math.sin((turn * k) / 24), { steps: 4 });
      await page.mouse.up();
    };
    const size = async () => Number(/of ([\d.]+) cm²/.exec(await page.locator(".side").innerText())?.[1] ?? 0);
    await round(90, 2 * Math.PI);
    const one = await size();
    assert.ok(one > 20, `${one} cm²`);
    await round(140, Math.PI);
    assert.ok((await size()) > 1.2 * one);
    await page.screenshot({ path: join(shots, "place-area.png") });
    await page.getByRole("button", { name: "Undo" }).click();
    assert.equal(await size(), one);
    await page.getByRole("button", { name: "Save" }).click();
    await page.waitForFunction(() => document.querySelector(".said")?.textContent?.includes("impedraw cover"), null, { timeout: 20_000 });
    await page.keyboard.press("Escape");
    await page.waitForFunction(() => document.querySelector(".share")?.textContent === "100.0 %", null, { timeout: 60_000 });
    assert.deepEqual(errors, []);
    // Its middle is the drawing's, about which it was marked.
    const { given } = (await ask("/data")).json();
    const centre = /centre: \[([^,]+), ([^\]]+)\]/.exec(readFileSync(saved, "utf8")).slice(1).map(Number);
    const half = /viewBox="0 0 (\S+) (\S+)"/.exec(readFileSync(region, "utf8")).slice(1).map((mm) => Number(mm) / 2e3);
    assert.ok(Math.hypot(centre[0] - half[1] - given.x, centre[1] - half[0] - given.y) < 5e-3);
  } finally {
    await browser.close();
  }
});

test("what was marked is covered", { timeout: 300_000 }, () => {
  const cover = spawnSync(program, ["cover", saved, "--out", join(scratch, "cover")], { encoding: "utf8" });
  assert.equal(cover.status, 0, cover.stderr);
  const { treated_share, promised_share } = JSON.parse(readFileSync(join(scratch, "cover/cover.json"), "utf8")).metrics;
  assert.ok(treated_share > 0.99 && promised_share > 0.9, cover.stdout);
});

test("the command ends when asked", async () => {
  await ask("/end", { body: "{}" });
  assert.equal(await run.ended, 0);
});
