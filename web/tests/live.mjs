// node --test live.mjs: ./impedraw draw --live, watched by browsers.
//
// IMPEDRAW   the program           IMPEDRAW_WEB     the folder with node_modules
// CHROMIUM   the browser (default: chromium on PATH)
//
// Pictures stand in IMPEDRAW_WEB/shots.
import assert from "node:assert/strict";
import { execFileSync, spawn, spawnSync } from "node:child_process";
import { existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync } from "node:fs";
import { get } from "node:http";
import { connect, createServer } from "node:net";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { after, before, test } from "node:test";

const web = resolve(process.env.IMPEDRAW_WEB ?? "build/web");
const program = resolve(process.env.IMPEDRAW ?? "build/release/src/app/impedraw");
const { chromium } = createRequire(join(web, "package.json"))("playwright-core");
const executablePath = process.env.CHROMIUM ?? execFileSync("sh", ["-c", "command -v chromium"]).toString().trim();
const shots = join(web, "shots");
const scratch = mkdtempSync(join(tmpdir(), "impedraw-live-"));
mkdirSync(shots, { recursive: true });
let browser;
const begun = [];

before(async () => {
  browser = await chromium.launch({ executablePath, args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"] });
});

after(async () => {
  for (const run of begun) run.process.kill("SIGKILL");
  await browser?.close();
  rmSync(scratch, { recursive: true, force: true });
});

// A run that goes on, once it tells its address.
async function draw(name, ...args) {
  const folder = join(scratch, name);
  const run = { folder, process: spawn(program, ["draw", "--live", "--out", folder, ...args]), out: "", err: "" };
  begun.push(run);
  run.process.stdout.on("data", (data) => (run.out += data));
  run.process.stderr.on("data", (data) => (run.err += data));
  run.ended = new Promise((done) => run.process.on("exit", (code) => done(code)));
  for (let i = 0; i < 600 && !/^live +\S+\n/m.test(run.out); ++i) await new Promise((done) => setTimeout(done, 50));
  run.address = /^live +(\S+)\n/m.exec(run.out)?.[1];
  assert.match(run.address ?? run.err, /^http:\/\/127\.0\.0\.1:\d+\/\?token=[0-9a-f]{32}$/);
  return run;
}

async function watch(run) {
  const page = await browser.newPage({ viewport: { width: 1280, height: 800 } });
  const errors = [];
  page.on("pageerror", (error) => errors.push(error.stack));
  page.on("console", (message) => message.type() === "error" && errors.push(message.text()));
  await page.goto(run.address);
  await page.waitForFunction(() => document.querySelector(".stage canvas"), null, { timeout: 60_000 });
  const ask = () => page.evaluate(async () => {
    const hook = await window.impedraw;
    return { ...hook.live(), ...hook.state() };
  });
  return { page, errors, ask, press: (name) => page.getByRole("button", { name }).click() };
}

async function until(condition, what) {
  for (let i = 0; i < 600; ++i) {
    if (await condition()) return;
    await new Promise((done) => setTimeout(done, 100));
  }
  assert.fail(`never: ${what}`);
}

test("a run is paused, resumed and watched to its end; the page then is the report", { timeout: 240_000 }, async () => {
  const run = await draw("watched", "--pace", "0.5");
  const { page, errors, ask, press } = await watch(run);
  await press("pause the run"); // opening a second browser may take longer than the drawing
  const other = await watch(run);
  await press("resume the run");
  await until(async () => (await ask()).ink > 100, "ink on the page");
  await press("pause the run");
  await until(async () => (await ask()).state === "paused" && (await other.ask()).state === "paused", "paused, for both");
  let paused;
  await until(async () => {
    paused = await ask();
    await page.waitForTimeout(1000);
    return (await ask()).rows === paused.rows;
  }, "no new rows of a paused run");
  await page.screenshot({ path: join(shots, "live-paused.png") });
  assert.equal(paused.t, paused.end, "the page follows the run");
  assert.equal(paused.segments, paused.ink, "all ink that came is drawn");
  assert.ok(await page.evaluate(async () => (await window.impedraw).extremes("force")[1]) > 4, "plots have the force");
  await page.getByRole("tab", { name: "Numbers" }).click();
  assert.match(await page.locator(".tiles").textContent(), /N.*normal force so far/);

  // The connection breaks: no row comes twice, none is lost.
  await page.evaluate(async () => (await window.impedraw).drop());
  await page.waitForTimeout(1000);
  await until(async () => (await ask()).state === "paused", "connected again");
  await press("resume the run");
  await until(async () => (await ask()).rows > paused.rows + 20, "rows after the break");
  const times = await page.evaluate(async () => (await window.impedraw).times());
  const gaps = times.slice(1).map((t, i) => t - times[i]);
  assert.ok(Math.min(...gaps) > 0.005 && Math.max(...gaps) < 0.025, `rows each 10 ms: ${Math.min(...gaps)} to ${Math.max(...gaps)} s`);

  // Who looks back is not dragged to the end.
  await page.evaluate(() => (location.hash = "#t=2"));
  await page.waitForTimeout(500);
  assert.equal((await ask()).t, 2);
  await press("follow the run");
  await other.page.close(); // changes nothing

  assert.equal(await run.ended, 0, run.err);
  await page.getByText("The run has ended: this is its report.").waitFor({ timeout: 30_000 });
  await page.screenshot({ path: join(shots, "live-ended.png") });
  assert.deepEqual(errors, []);
  const facts = await page.locator(".tiles").textContent();
  const metrics = JSON.parse(readFileSync(join(run.folder, "metrics.json")));
  assert.ok(facts.includes(String(Number(metrics.ink_error_rms.toPrecision(3)))), facts);

  // Watching has changed nothing.
  const alone = join(scratch, "alone");
  assert.equal(spawnSync(program, ["draw", "--out", alone]).status, 0);
  const unwatched = JSON.parse(readFileSync(join(alone, "metrics.json")));
  for (const name of ["ink_error_rms", "ink_error_max", "force_mean", "force_sd", "tilt_max", "draw_time"])
    assert.equal(metrics[name], unwatched[name], name);
});

test("an emergency stop from the page damps where the pen is and leaves an incident", { timeout: 120_000 }, async () => {
  const run = await draw("emergency", "--pace", "1");
  const { page, ask, press } = await watch(run);
  await until(async () => (await ask()).ink > 50, "ink on the page");
  await press("emergency stop");
  assert.equal(await run.ended, 3, run.err);
  assert.match(run.err, /emergency stop at t = [\d.]+ s/);
  assert.ok(existsSync(join(run.folder, "incident.html")));
  await page.close();
});

test("a run is stopped from the page: the pen is lifted, and the exit code is ctrl-C's", { timeout: 120_000 }, async () => {
  const run = await draw("stopped", "--pace", "1");
  const { page, ask, press } = await watch(run);
  await until(async () => (await ask()).ink > 50, "ink on the page");
  await press("stop with a lift");
  assert.equal(await run.ended, 130, run.err);
  assert.match(run.err, /interrupted at t = [\d.]+ s; the pen was lifted; .*--resume continues/);
  await page.getByText("The run has ended: this is its report.").waitFor({ timeout: 30_000 });
  assert.ok(existsSync(join(run.folder, "report.html")));
});

test("ctrl-C ends a paused run", { timeout: 120_000 }, async () => {
  const run = await draw("interrupted", "--pace", "1");
  const { ask, press } = await watch(run);
  await press("pause the run");
  await until(async () => (await ask()).state === "paused", "paused");
  run.process.kill("SIGINT");
  assert.equal(await run.ended, 130, run.err);
});

test("a viewer that stops reading, a wrong token and a foreign origin change nothing", { timeout: 120_000 }, async () => {
  const run = await draw("hostile", "--pace", "4");
  const { port, host, searchParams } = new URL(run.address);
  const token = searchParams.get("token");
  const status = (target, headers) => new Promise((done, fail) => {
    const asked = get({ port, host: "127.0.0.1", path: target, headers }, (answer) => done(answer.resume().statusCode));
    asked.on("upgrade", (answer, socket) => {
      done(answer.statusCode);
      socket.destroy();
    });
    asked.on("error", fail);
  });
  const upgrade = (origin) => ({ Host: host, Connection: "Upgrade", Upgrade: "websocket", "Sec-WebSocket-Version": "13", "Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ==", ...(origin ? { Origin: origin } : {}) });
  const wrong = token.replace(/.$/, (last) => (last === "0" ? "1" : "0"));
  assert.equal(await status(`/?token=${wrong}`), 403);
  assert.equal(await status(`/live?token=${wrong}`, upgrade(`http://${host}`)), 403);
  assert.equal(await status(`/live?token=${token}`, upgrade("http://evil.example")), 403);
  assert.equal(await status(`/live?token=${token}`, upgrade()), 403);
  assert.equal(await status(`/live?token=${token}`, upgrade(`http://${host}`)), 101);
  // One that is let in and never reads.
  const stuck = connect(Number(port), "127.0.0.1");
  stuck.pause();
  stuck.on("error", () => {});
  stuck.write([`GET /live?token=${token} HTTP/1.1`, ...Object.entries(upgrade(`http://${host}`)).map(([key, value]) => `${key}: ${value}`), "", ""].join("\r\n"));
  assert.equal(await run.ended, 0, run.err);
  stuck.destroy();
  assert.equal(JSON.parse(readFileSync(join(run.folder, "metrics.json"))).strokes_missed, 0);
});

test("a port that is in use, and a port without --live, are bad input", { timeout: 60_000 }, async () => {
  const server = createServer().listen(0, "127.0.0.1");
  await new Promise((done) => server.on("listening", done));
  const folder = join(scratch, "none");
  const used = spawnSync(program, ["draw", "--live", "--port", String(server.address().port), "--out", folder], { encoding: "utf8" });
  server.close();
  assert.equal(used.status, 2);
  assert.match(used.stderr, /^impedraw: --port \d+: cannot be listened to on 127\.0\.0\.1: /);
  assert.ok(!existsSync(folder), "no folder is made");
  const alone = spawnSync(program, ["draw", "--port", "8080", "--out", folder], { encoding: "utf8" });
  assert.equal(alone.status, 2);
  assert.match(alone.stderr, /--live/);
});
