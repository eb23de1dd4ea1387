// node page.mjs: the page of a run in a browser, from the disk, with the network cut off.
//
// IMPEDRAW   the program           IMPEDRAW_WEB     the folder with node_modules
// PYTHON     with h5py             CHROMIUM         the browser (default: chromium on PATH)
// RUN        a finished run's folder; where it is not given, a short drawing is made
//
// What is shown is compared with run.h5, read by h5py, and with frames computed here from the URDF.
// Pictures of all views stand in IMPEDRAW_WEB/shots.
import assert from "node:assert/strict";
import { execFileSync, spawn, spawnSync } from "node:child_process";
import { cpSync, mkdirSync, mkdtempSync, readdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { after, before, test } from "node:test";
import { pathToFileURL } from "node:url";

const web = resolve(process.env.IMPEDRAW_WEB ?? "build/web");
const program = resolve(process.env.IMPEDRAW ?? "build/release/src/app/impedraw");
const python = process.env.PYTHON ?? ".venv/bin/python";
const { chromium } = createRequire(join(web, "package.json"))("playwright-core");
const executablePath = process.env.CHROMIUM ?? execFileSync("sh", ["-c", "command -v chromium"]).toString().trim();
const shots = join(web, "shots");
const scratch = mkdtempSync(join(tmpdir(), "impedraw-page-"));
mkdirSync(shots, { recursive: true });

const name = "<img src=x onerror=window.hacked=1> & <b>bold";
const folder = process.env.RUN ? resolve(process.env.RUN) : join(scratch, "run");
let browser;
let log;

const logReader = `
import h5py, json, sys
f = h5py.File(sys.argv[1])
rows = lambda name: f[name][:].tolist()
clean = lambda a: [None if x != x else x for x in a]
print(json.dumps({
  "time": rows("time"), "q": rows("joint/position"), "tip": rows("tip/position"), "stroke": rows("stroke"),
  "point": [clean(p) for p in rows("contact/point")], "force": rows("contact/force"),
  "names": [n.decode() if isinstance(n, bytes) else n for n in f["joint/position"].attrs["names"]],
}))`;

// A log as a killed run leaves it: half of its rows, and no wall times.
const cutter = `
import h5py, sys
f = h5py.File(sys.argv[1], "r+")
n = f["time"].shape[0]
def cut(name, o):
    if hasattr(o, "shape") and o.maxshape and o.maxshape[0] is None: o.resize(o.shape[0] // 2, axis=0)
f.visititems(cut)
for key in [k for k in f.attrs if k.startswith("wall_")]: f.attrs[key] = float("nan")
`;

// Frames of the links, by the URDF's own convention: fixed-axis roll, pitch, yaw.
function urdfFrames(text, names, q) {
  const multiply = (a, b) => a.map((_, i) => b[0].map((_, k) => a[i].reduce((sum, x, j) => sum + x * b[j][k], 0)));
  const about = (axis, angle) => {
    const [c, s] = [Math.cos(angle), Math.sin(angle)];
    const m = { x: [[1, 0, 0], [0, c, -s], [0, s, c]], y: [[c, 0, s], [0, 1, 0], [-s, 0, c]], z: [[c, -s, 0], [s, c, 0], [0, 0, 1]] }[axis];
    return [...m.map((row) => [...row, 0]), [0, 0, 0, 1]];
  };
  const numbers = (word) => word.trim().split(/\s+/).map(Number);
  const frames = { link_0: about("x", 0) };
  for (const [, joint, type, body] of text.matchAll(/<joint name="([^"]+)" type="([^"]+)">([\s\S]*?)<\/joint>/g)) {
    const parent = /<parent link="([^"]+)"/.exec(body)[1];
    const child = /<child link="([^"]+)"/.exec(body)[1];
    const [x, y, z] = numbers(/xyz="([^"]+)" rpy/.exec(body)[1]);
    const [roll, pitch, yaw] = numbers(/rpy="([^"]+)"/.exec(body)[1]);
    let X = multiply(about("z", yaw), multiply(about("y", pitch), about("x", roll)));
    [x, y, z].forEach((p, i) => (X[i][3] = p));
    if (type === "revolute") {
      assert.match(body, /<axis xyz="0 0 1"\/>/);
      X = multiply(X, about("z", q[names.indexOf(joint)]));
    }
    frames[child] = multiply(frames[parent], X);
  }
  return frames;
}

async function open(file, options = {}) {
  const context = await browser.newContext({ viewport: { width: 1280, height: 720 }, offline: true, ...options });
  const page = await context.newPage();
  const wrong = [];
  page.on("console", (message) => {
    if (["error", "warning"].includes(message.type()) && !/GL Driver Message|GPU stall|swiftshader/i.test(message.text())) wrong.push(message.text());
  });
  page.on("pageerror", (error) => wrong.push(String(error)));
  page.on("request", (request) => {
    if (!/^(file|blob|data):/.test(request.url())) wrong.push(`asked for ${request.url()}`);
  });
  await page.goto(pathToFileURL(file).href + (options.hash ?? ""));
  await page.evaluate(() => window.impedraw.then(() => 0));
  return { page, wrong, close: () => context.close() };
}

const ask = (page, what, ...values) =>
  page.evaluate(async ([call, list]) => (await window.impedraw)[call](...list), [what, values]);

before(async () => {
  if (!process.env.RUN) {
    writeFileSync(join(scratch, "line.svg"),
      '<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="40mm" viewBox="0 0 40 40">' +
      '<path d="M5 5H25V15" fill="none" stroke="black"/><path d="M5 20H20" fill="none" stroke="black"/></svg>');
    execFileSync(program, ["draw", "--svg", join(scratch, "line.svg"), "--set", `name=${name}`, "--set", "log.rate=full", "--out", folder], { stdio: "pipe" });
  }
  log = JSON.parse(execFileSync(python, ["-c", logReader, join(folder, "run.h5")], { maxBuffer: 1 << 30 }));
  browser = await chromium.launch({
    executablePath, args: ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox"],
  });
});
after(async () => {
  await browser?.close();
  rmSync(scratch, { recursive: true, force: true });
});

test("the page shows what the log says", { timeout: 600_000 }, async (t) => {
  const { page, wrong, close } = await open(join(folder, "report.html"), { hash: "#t=1.5&view=front&colour=tilt" });

  await t.test("a link leads to its moment", async () => {
    const state = await ask(page, "state");
    assert.equal(state.view, "front");
    assert.equal(state.colour, "tilt");
    assert.ok(Math.abs(state.t - 1.5) < 1e-9);
    assert.equal(await ask(page, "hash"), "#t=1.5&view=front&colour=tilt");
  });

  await t.test("a time shows the posture of its row", async () => {
    const urdf = readFileSync("models/iiwa14_pen.urdf", "utf8");
    let worst = 0;
    for (let k = 0; k < 12; ++k) {
      const row = Math.min(log.time.length - 1, Math.round((k / 11) * (log.time.length - 1)));
      await ask(page, "seek", log.time[row]);
      const shown = await ask(page, "frames");
      const wanted = urdfFrames(urdf, log.names, log.q[row]);
      const away = (a, p) => Math.hypot(a[3] - p[0], a[7] - p[1], a[11] - p[2]);
      worst = Math.max(worst, away(shown.tip, log.tip[row]));
      assert.ok(Object.keys(wanted).length >= 9);
      for (const [link, X] of Object.entries(wanted)) worst = Math.max(worst, away(shown[link], X.map((r) => r[3])));
    }
    t.diagnostic(`frames off by at most ${(1000 * worst).toFixed(4)} mm`);
    assert.ok(worst < 1e-4, `frames are off by ${1000 * worst} mm`);
  });

  await t.test("ink stands where the pen touched, and only once it has", async () => {
    const rows = log.force.map((f, i) => i).filter((i) => log.stroke[i] >= 0 && Math.hypot(...log.force[i]) > 1);
    assert.ok(rows.length > 200);
    const some = Array.from({ length: 40 }, (_, k) => rows[Math.round(((k + 0.5) / 40) * (rows.length - 1))]);
    const points = some.map((i) => log.point[i]);
    for (const part of ["arm", "target", "normal", "force", "cameras", "grid", "cloud"]) await ask(page, "hide", part);
    await ask(page, "setColour", "nothing");
    await ask(page, "setView", "top");
    const inked = async (time) => {
      await ask(page, "seek", time);
      const around = await ask(page, "coloursAround", points, 2);
      return around.map((colours) => colours.some(([r, g, b]) => b > r + 60 && r < 90));
    };
    const last = await inked(log.time.at(-1));
    assert.equal(last.filter(Boolean).length, points.length, "every contact point shows ink at the end");
    assert.equal((await inked(log.time[0])).filter(Boolean).length, 0, "none at the beginning");
    const half = some[20];
    const then = await inked(log.time[half]);
    some.forEach((row, k) => {
      if (Math.abs(log.time[row] - log.time[half]) > 0.15) assert.equal(then[k], row < half, `ink of row ${row} at row ${half}`);
    });
  });

  await t.test("plots show the log's extremes", async () => {
    const [, high] = await ask(page, "extremes", "force");
    const normalForce = log.force.map((f) => Math.hypot(...f));
    assert.ok(high <= Math.max(...normalForce) + 1e-3 && high > 0.8 * Math.max(...normalForce));
    const [low0, high0] = await ask(page, "extremes", "position_0");
    const q0 = log.q.map((q) => q[0]);
    assert.ok(Math.abs(low0 - Math.min(...q0)) < 1e-4 && Math.abs(high0 - Math.max(...q0)) < 1e-4);
  });

  await t.test("plots are not painted by an emulated graphics card", async () => {
    const plain = await page.evaluate(() => [...document.querySelectorAll(".plot canvas, canvas.strip")].map((c) => c.getContext("2d").getContextAttributes().willReadFrequently));
    assert.ok(plain.length >= 3 && plain.every((x) => x === true), String(plain));
  });

  await t.test("keys and controls", async () => {
    for (const [key, view] of [["1", "top"], ["2", "front"], ["3", "side"], ["4", "pen"], ["5", "tip"], ["0", "free"]]) {
      await page.keyboard.press(key);
      assert.equal((await ask(page, "state")).view, view);
    }
    await page.keyboard.press("Home");
    assert.equal((await ask(page, "state")).t, log.time[0]);
    await page.keyboard.press("ArrowRight");
    assert.ok(Math.abs((await ask(page, "state")).t - log.time[0] - 0.1) < 1e-9);
    await page.keyboard.press("c");
    assert.equal((await ask(page, "state")).colour, "force");
    await page.keyboard.press("+");
    assert.equal((await ask(page, "state")).speed, 2);
    await page.keyboard.press(" ");
    assert.equal((await ask(page, "state")).playing, true);
    await page.waitForTimeout(300);
    await page.getByRole("button", { name: "pause" }).click();
    const paused = await ask(page, "state");
    assert.ok(paused.t > log.time[0] + 0.1);
    // While it plays, numbers follow the scene a few times a second; where it stops, they agree.
    assert.equal(await page.locator(".clock").textContent(), `${paused.t.toFixed(2)} / ${paused.end.toFixed(2)} s`);
    await page.getByRole("tab", { name: "Strokes" }).click();
    const last = Math.max(...log.stroke);
    await page.getByRole("button", { name: `go to stroke ${last}, pass 1` }).click();
    const begin = log.time[log.stroke.indexOf(last)];
    assert.ok(Math.abs((await ask(page, "state")).t - begin) < 2e-3);
    const row = await page.locator("tr.now").boundingBox();
    const table = await page.locator("table.strokes").boundingBox();
    assert.ok(row.x >= table.x && row.y > table.y && row.width > 0.9 * table.width, "the stroke's row stands in its table");
    await page.getByRole("tab", { name: "Settings" }).click();
    await page.getByRole("searchbox").fill("normal_force");
    assert.ok((await page.locator("table.settings tr:not([hidden])").count()) >= 1);
    const nameless = await page.evaluate(() =>
      [...document.querySelectorAll("button, input, select, [role=img]")].filter((e) =>
        !(e.getAttribute("aria-label") || e.textContent.trim() || e.closest("label"))).map((e) => e.outerHTML));
    assert.deepEqual(nameless, []);
  });

  await t.test("text of files stays text", { skip: Boolean(process.env.RUN) }, async () => {
    assert.equal(await page.locator("h1").textContent(), name);
    assert.equal(await page.title(), name);
    assert.equal(await page.evaluate(() => window.hacked), undefined);
    assert.equal(await page.locator("#page b b, #page h1 *").count(), 0);
  });

  await t.test("nothing went wrong", () => assert.deepEqual(wrong, []));
  await close();
});

test("pictures of all views", { timeout: 600_000 }, async () => {
  const shoot = async (label, options, prepare = async () => {}) => {
    const { page, wrong, close } = await open(join(folder, "report.html"), options);
    await prepare(page);
    await page.waitForTimeout(200);
    await page.screenshot({ path: join(shots, `${label}.png`) });
    const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
    assert.ok(wide <= 0, `${label}: ${wide} px wider than the window`);
    assert.deepEqual(wrong, []);
    await close();
  };
  const middle = (log.time[0] + log.time.at(-1)) / 2;
  await shoot("light", { hash: `#t=${middle}` });
  await shoot("dark", { colorScheme: "dark", hash: `#t=${middle}&view=tip` });
  await shoot("narrow", { viewport: { width: 360, height: 740 }, hash: "#colour=error&view=top" });
  await shoot("numbers", {}, (page) => page.getByRole("tab", { name: "Numbers" }).click());
});

test("a log that ends early is shown up to there, and says so", { timeout: 600_000, skip: Boolean(process.env.RUN) }, async () => {
  const cut = join(scratch, "cut");
  cpSync(folder, cut, { recursive: true });
  execFileSync(python, ["-c", cutter, join(cut, "run.h5")]);
  rmSync(join(cut, "strokes.json")); // written when a run ends
  execFileSync(program, ["report", cut], { stdio: "pipe" });
  const { page, wrong, close } = await open(join(cut, "report.html"));
  const { end } = await ask(page, "state");
  assert.ok(Math.abs(end - log.time[Math.floor(log.time.length / 2) - 1]) < 2e-3);
  assert.match(await page.getByRole("alert").textContent(), /ends before the run was closed: the run is shown up to/);
  assert.deepEqual(wrong, []);
  await close();
});

test("a plan shows what fails, and the arm where it does", { timeout: 600_000, skip: Boolean(process.env.RUN) }, async (t) => {
  writeFileSync(join(scratch, "wide.svg"),
    '<svg xmlns="http://www.w3.org/2000/svg" width="100mm" height="100mm" viewBox="0 0 100 100">' +
    '<path d="M0 50H500" fill="none" stroke="black"/><path d="M10 60H40" fill="none" stroke="black"/></svg>');
  const out = join(scratch, "plan");
  const words = ["plan", "--svg", join(scratch, "wide.svg"), "--set", `name=${name}`, "--set", "drawing.placement.fit_radius=0.3",
    "--out", out];
  let code = 0;
  try {
    execFileSync(program, words, { stdio: "pipe" });
  } catch (error) {
    code = error.status;
    t.diagnostic(String(error.stderr).slice(-300));
  }
  assert.equal(code, 1, "some of it cannot be drawn");
  const plan = JSON.parse(readFileSync(join(out, "plan.json"), "utf8"));
  const { page, wrong, close } = await open(join(out, "plan.html"));
  const state = await ask(page, "state");
  assert.equal(state.t, 0);
  assert.ok(Math.abs(state.end - plan.time_s) < 1e-3);
  const found = await ask(page, "findings");
  assert.equal(found.length, plan.not_drawable.length);
  found.forEach((f, i) => {
    assert.equal(f.problem, plan.not_drawable[i].problem);
    f.world_m.forEach((x, axis) => assert.ok(Math.abs(x - plan.not_drawable[i].world_m[axis]) < 1e-9));
  });
  // The arm's tip goes to what was clicked: reached or not, its posture is the one the plan tells.
  const urdf = readFileSync("models/iiwa14_pen.urdf", "utf8");
  await page.getByRole("button", { name: /^show what fails on stroke/ }).first().click();
  const names = [...urdf.matchAll(/<joint name="([^"]+)" type="revolute"/g)].map((m) => m[1]);
  const tip = urdfFrames(urdf, names, found[0].q).tip.map((row) => row[3]).slice(0, 3);
  const shown = (await ask(page, "frames")).tip;
  assert.ok(Math.hypot(shown[3] - tip[0], shown[7] - tip[1], shown[11] - tip[2]) < 1e-4);
  // A click on it in the scene does the same.
  await ask(page, "seek", 0);
  await ask(page, "setView", "top");
  const line = await ask(page, "findingLine", 0);
  const [u, v] = await ask(page, "project", line[Math.floor(line.length / 2)]);
  const canvas = await page.locator(".pane canvas").boundingBox();
  await page.mouse.click(canvas.x + u, canvas.y + v);
  const clicked = (await ask(page, "frames")).tip;
  assert.ok(Math.hypot(clicked[3] - shown[3], clicked[7] - shown[7], clicked[11] - shown[11]) < 1e-6);
  // Along the path, the tip of the arm is the tip of the plan: the posture reaches it.
  for (const share of [0.3, 0.5, 0.7]) {
    await ask(page, "seek", share * state.end);
    const frame = (await ask(page, "frames")).tip;
    const wanted = await ask(page, "tipOfPath");
    assert.ok(Math.hypot(frame[3] - wanted[0], frame[7] - wanted[1], frame[11] - wanted[2]) < 5e-4);
  }
  for (const map of await ask(page, "maps")) await ask(page, "setMap", map);
  assert.equal(await page.evaluate(() => window.hacked), undefined);
  assert.equal(await page.locator("h1").textContent(), name);
  await page.screenshot({ path: join(shots, "plan.png") });
  assert.deepEqual(wrong, []);
  await close();
});

test("runs compared share one camera and one time line", { timeout: 600_000, skip: Boolean(process.env.RUN) }, async () => {
  const other = join(scratch, "other");
  execFileSync(program, ["draw", "--svg", join(scratch, "line.svg"), "--set", "name=slower", "--set", "path.draw_speed=0.03", "--set", "log.rate=full", "--out", other], { stdio: "pipe" });
  const out = join(scratch, "compared");
  execFileSync(program, ["compare", folder, other, "--out", out], { stdio: "pipe" });
  for (const [words, told] of [
    [[folder], /one run alone/], [[folder, scratch], /contains no run\.h5/], [[folder, other, "--set", "seed=2"], /--set does not go with finished runs/],
    [[folder, other, "--out", folder], /contains files but no comparison/]]) {
    const ended = spawnSync(program, ["compare", ...words], { cwd: scratch });
    assert.equal(ended.status, 2, words.join(" "));
    assert.match(ended.stderr.toString(), told);
  }
  const { page, wrong, close } = await open(join(out, "compare.html"));
  const late = JSON.parse(execFileSync(python, ["-c", logReader, join(other, "run.h5")], { maxBuffer: 1 << 30 }));
  const { end } = await ask(page, "state");
  assert.ok(Math.abs(end - late.time.at(-1)) < 2e-3, "the time line lasts as long as the slower run");
  const row = Math.floor(0.4 * log.time.length);
  await ask(page, "seek", log.time[row]);
  const at = (list, t) => list.time.findIndex((x) => x >= t - 1e-6);
  for (const [which, run] of [[0, log], [1, late]]) {
    const shown = (await ask(page, "frames", which)).tip;
    const tip = run.tip[at(run, log.time[row])];
    assert.ok(Math.hypot(shown[3] - tip[0], shown[7] - tip[1], shown[11] - tip[2]) < 1.5e-4, `tip of run ${which}`);
  }
  const same = async () => {
    const [a, b] = await ask(page, "eyes");
    [...a.from, ...a.at].forEach((x, i) => assert.ok(Math.abs(x - [...b.from, ...b.at][i]) < 1e-6));
    return a;
  };
  const before = await same();
  const box = await page.locator(".pane canvas").nth(1).boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width / 2 + 60, box.y + box.height / 2 + 20, { steps: 4 });
  await page.mouse.up();
  const turned = await same();
  assert.ok(Math.hypot(...turned.from.map((x, i) => x - before.from[i])) > 0.05, "dragging one turns both");
  await page.getByRole("checkbox", { name: "ink over ink" }).check();
  await ask(page, "setView", "top");
  for (const part of ["arm", "target", "normal", "force", "cameras", "grid", "cloud"]) await ask(page, "hide", part);
  await ask(page, "seek", end);
  const inked = log.force.map((f, i) => i).filter((i) => log.stroke[i] >= 0 && Math.hypot(...log.force[i]) > 1);
  const some = Array.from({ length: 12 }, (_, k) => log.point[inked[Math.round(((k + 0.5) / 12) * (inked.length - 1))]]);
  const around = await ask(page, "coloursAround", some, 4);
  const blue = around.filter((colours) => colours.some(([r, g, b]) => b > r + 60)).length;
  const orange = around.filter((colours) => colours.some(([r, g, b]) => r > b + 60)).length;
  assert.ok(blue >= 10 && orange >= 10, `both inks are seen: ${blue} and ${orange} of 12 places`);
  const beyond = await page.locator(".scroll:has(> table.comparison)").evaluate((box) => box.scrollWidth - box.clientWidth);
  assert.ok(beyond <= 1, `the table of two runs is ${beyond} px wider than its panel`);
  const table = await page.locator("table.comparison").textContent();
  assert.match(table, /ink_error_rms/);
  await page.screenshot({ path: join(shots, "compare.png") });

  // Strokes side by side, each with two runs' ink; the button goes there.
  await page.getByRole("tab", { name: "Strokes" }).click();
  const rows = page.locator("table.strokes tbody tr");
  assert.equal(await rows.count(), new Set(log.stroke.filter((s) => s >= 0)).size);
  const cells = await rows.first().locator("td.n").allTextContents();
  assert.equal(cells.length, 6);
  assert.ok(cells.every((text) => Number(text) > 0), cells.join(" "));
  await rows.first().getByRole("button").click();
  assert.ok(Math.abs((await ask(page, "state")).t - log.time[log.stroke.findIndex((s) => s >= 0)]) < 0.02);
  assert.ok((await page.locator("section[aria-label^='torque term: ']").count()) >= 3, "a plot for each torque term");
  assert.equal(await page.evaluate(() => window.hacked), undefined);
  assert.deepEqual(wrong, []);
  await close();
});

test("a picture and a film are rendered, and ctrl-C leaves nothing", { timeout: 600_000, skip: Boolean(process.env.RUN) }, async (t) => {
  const films = join(scratch, "films");
  mkdirSync(films);
  execFileSync(program, ["film", folder, "--out", join(films, "still.png"), "--size", "320x200", "--view", "top"], { stdio: "pipe" });
  const png = readFileSync(join(films, "still.png"));
  assert.deepEqual([png.readUInt32BE(16), png.readUInt32BE(20)], [320, 200]);
  assert.ok(png.length > 3000, "not blank");
  for (const [words, told] of [
    [["--out", "x.gif"], /--out x\.gif.*valid are/], [["--out", "x.png", "--size", "321x200"], /--size 321x200/],
    [["--out", "x.png", "--hide", "leg"], /--hide leg: valid are canvas/]]) {
    const ended = spawnSync(program, ["film", folder, ...words], { cwd: films });
    assert.equal(ended.status, 2, ended.stderr.toString());
    assert.match(ended.stderr.toString(), told);
  }
  if (spawnSync("sh", ["-c", "command -v ffmpeg"]).status === 0) {
    execFileSync(program, ["film", folder, "--out", join(films, "a.webp"), "--size", "160x120", "--fps", "5", "--from", "1", "--to", "2"], { stdio: "pipe" });
    const film = readFileSync(join(films, "a.webp"));
    assert.equal(film.subarray(8, 12).toString(), "WEBP");
    let frames = 0;
    for (let i = film.indexOf("ANMF"); i >= 0; i = film.indexOf("ANMF", i + 4)) ++frames;
    assert.ok(frames >= 2 && frames <= 6, `${frames} frames`);
    const child = spawn(program, ["film", folder, "--out", join(films, "b.webp"), "--size", "160x120"], { stdio: "ignore" });
    await new Promise((go) => setTimeout(go, 4000));
    child.kill("SIGINT");
    assert.equal(await new Promise((done) => child.on("exit", done)), 130);
  } else {
    t.diagnostic("no ffmpeg here: films are not tested");
  }
  assert.deepEqual(readdirSync(films).filter((file) => !["still.png", "a.webp"].includes(file)), []);
});

test("without WebGL the page shows its flat pictures", { timeout: 600_000 }, async () => {
  const flat = await chromium.launch({ executablePath, args: ["--disable-3d-apis", "--no-sandbox"] });
  const page = await (await flat.newContext({ offline: true })).newPage();
  await page.goto(pathToFileURL(join(folder, "report.html")).href);
  await page.evaluate(() => window.impedraw.then(() => 0));
  assert.match(await page.getByRole("alert").textContent(), /no WebGL/);
  const widths = await page.locator(".stage img").evaluateAll((list) => Promise.all(list.map((i) => i.decode().then(() => i.naturalWidth))));
  assert.ok(widths.length >= 1 && widths.every((w) => w > 100));
  await page.screenshot({ path: join(shots, "flat.png") });
  await flat.close();
});
