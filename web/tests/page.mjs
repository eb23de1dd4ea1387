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
import { cpSync, mkdirSync, mkdtempSync, readdirSync, readFileSync, rmSync, statSync, truncateSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { after, before, test } from "node:test";
import { fileURLToPath, pathToFileURL } from "node:url";

const web = resolve(process.env.IMPEDRAW_WEB ?? "build/web");
const program = resolve(process.env.IMPEDRAW ?? "build/release/src/app/impedraw");
const python = process.env.PYTHON ?? ".venv/bin/python";
const { chromium } = createRequire(join(web, "package.json"))("playwright-core");
const executablePath = process.env.CHROMIUM ?? execFileSync("sh", ["-c", "command -v chromium"]).toString().trim();
const shots = join(web, "shots");
const scratch = mkdtempSync(join(tmpdir(), "impedraw-page-"));
mkdirSync(shots, { recursive: true });

const name = "<img src=x onerror=window.hacked=1> & <b>bold";
// The drawing's file and its layer, too.
const artwork = join(scratch, "<img src=x onerror=hacked=1>.svg");
const layered = (paths) =>
  '<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" width="40mm" height="40mm" viewBox="0 0 40 40">' +
  `<g inkscape:groupmode="layer" inkscape:label="&lt;img src=x onerror=hacked=2&gt;" id="a">${paths}</g></svg>`;
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
  "point": [clean(p) for p in rows("contact/point")], "force": rows("contact/force"), "normal": [clean(p) for p in rows("contact/normal")],
  "v": rows("joint/velocity"), "torque": rows("joint/torque"), "push": rows("push"), "gravity": rows("torque/gravity"),
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
    writeFileSync(artwork, layered('<path d="M5 5H25V15" fill="none" stroke="black"/><path d="M5 20H20" fill="none" stroke="black"/>'));
    execFileSync(program, ["draw", "--svg", artwork, "--set", `name=${name}`, "--set", "log.rate=full", "--out", folder], { stdio: "pipe" });
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

  await t.test("the scene is not blank: the arm stands where its links are", async () => {
    await ask(page, "setView", "side");
    const around = async () => (await ask(page, "coloursAround", Object.values(await ask(page, "frames")).map((X) => [X[3], X[7], X[11]]), 0)).map(([c]) => c.join());
    const [arm, links] = [await around(), Object.keys(await ask(page, "frames")).length];
    await ask(page, "hide", "arm");
    const bare = await around();
    assert.ok(links >= 9 && arm.filter((c, i) => c !== bare[i]).length >= links - 1, `${arm} without the arm ${bare}`);
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
    const off = async (name, values, quantum) => {
      const shown = await ask(page, "extremes", name);
      const wanted = [values.reduce((a, b) => Math.min(a, b)), values.reduce((a, b) => Math.max(a, b))];
      assert.ok(shown.every((x, i) => Math.abs(x - wanted[i]) <= 0.51 * quantum), `${name}: ${shown}, in the log ${wanted}`);
    };
    await off("force", log.force.map((f, i) => f.reduce((sum, x, axis) => sum + x * (log.normal[i][axis] ?? 0), 0)), 1e-3);
    await off("push", log.push, 1e-3);
    for (const j of log.names.keys()) {
      await off(`position_${j}`, log.q.map((q) => q[j]), 1e-4);
      await off(`velocity_${j}`, log.v.map((v) => v[j]), 2e-4);
      await off(`torque_${j}`, log.torque.map((v) => v[j]), 1e-2);
      await off(`gravity_${j}`, log.gravity.map((v) => v[j]), 1e-2);
    }
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
    const goesTo = async (key, t) => {
      await page.keyboard.press(key);
      assert.ok(Math.abs((await ask(page, "state")).t - t) < 1e-9, key);
    };
    await goesTo("Shift+ArrowRight", log.time[0] + 1.1);
    await goesTo("ArrowLeft", log.time[0] + 1);
    await goesTo("Shift+ArrowLeft", log.time[0]);
    await goesTo("End", (await ask(page, "state")).end);
    await goesTo("Home", log.time[0]);
    await page.keyboard.press("c");
    assert.equal((await ask(page, "state")).colour, "force");
    await page.keyboard.press("-");
    assert.equal((await ask(page, "state")).speed, 0.5);
    await page.keyboard.press("+");
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

  await t.test("each button and choice", async () => {
    for (const [label, view] of [["top", "top"], ["front", "front"], ["side", "side"], ["along the pen", "pen"], ["follow the tip", "tip"], ["all", "free"]]) {
      await page.getByRole("button", { name: label, exact: true }).click();
      assert.equal((await ask(page, "state")).view, view);
    }
    for (const colour of ["nothing", "force", "error", "tilt", "speed", "pass"]) {
      await page.getByRole("combobox", { name: "colour of the ink" }).selectOption(colour);
      assert.equal((await ask(page, "state")).colour, colour);
      const unit = { force: "[N]", error: "[mm]", tilt: "[deg]", speed: "[mm/s]", pass: "pass 1", nothing: "" }[colour];
      assert.ok((await page.locator(".legend:not(.of-map)").textContent()).includes(unit), colour);
    }
    await page.getByRole("combobox", { name: "speed of the replay" }).selectOption("0.1");
    assert.equal((await ask(page, "state")).speed, 0.1);
    await page.getByRole("slider", { name: "time of the replay" }).fill("1.25");
    assert.equal((await ask(page, "state")).t, 1.25);

    await page.getByText("Show", { exact: true }).click();
    for (const part of ["arm", "cloud", "target", "ink", "normal", "force", "cameras", "grid"]) {
      const box = page.getByRole("checkbox", { name: part, exact: true });
      await ask(page, "hide", part);
      await box.setChecked(false);
      await box.check();
      await ask(page, "seek", log.time[50 + log.force.findIndex((f) => Math.hypot(...f) > 1)]); // arrows are shown where there is something
      assert.ok((await ask(page, "shown")).includes(part), part);
      await box.uncheck();
      assert.ok(!(await ask(page, "shown")).includes(part), part);
      await box.setChecked(part !== "cloud");
    }
    const opacity = page.getByRole("slider", { name: "opacity of the canvas" });
    await opacity.fill("0");
    assert.ok(!(await ask(page, "shown")).includes("canvas"));
    await opacity.fill("0.5");
    assert.ok((await ask(page, "shown")).includes("canvas"));
    const saved = async (button) => {
      const [download] = await Promise.all([page.waitForEvent("download"), button.click()]);
      return { name: download.suggestedFilename(), content: readFileSync(await download.path()) };
    };
    const isPng = ({ content }) => content.length > 1500 && content.subarray(1, 4).toString() === "PNG";
    assert.ok(isPng(await saved(page.getByRole("button", { name: "save picture" }))));
    await ask(page, "seek", 1.25);
    await page.getByRole("button", { name: "link to this moment" }).click();
    assert.equal(await page.evaluate(() => location.hash), "#t=1.25&view=free&colour=pass");
    await page.getByText("Show", { exact: true }).click();
    const back = () => page.evaluate(() => getComputedStyle(document.body).backgroundColor);
    const light = await back();
    await page.getByRole("button", { name: "light or dark" }).click();
    assert.notEqual(await back(), light);
    await page.getByRole("button", { name: "light or dark" }).click();
    assert.equal(await back(), light);

    // Tabs by the keyboard.
    await page.getByRole("tab", { name: "Settings" }).focus();
    await page.keyboard.press("ArrowRight");
    assert.equal(await page.getByRole("tab", { name: "Pictures" }).getAttribute("aria-selected"), "true");
    await page.keyboard.press("ArrowRight");
    assert.equal(await page.getByRole("tab", { name: "Plots" }).getAttribute("aria-selected"), "true");

    // A plot is made when it comes into sight, and as high as its place: nothing moves under the mouse.
    const heights = () => page.evaluate(() => [...document.querySelectorAll("section.panel")].map((e) => e.offsetHeight));
    const before = await heights();
    for (const panel of await page.locator("section.panel:has(.plot)").all()) {
      await panel.scrollIntoViewIfNeeded();
      await panel.locator(".u-over").waitFor();
    }
    assert.deepEqual(await heights(), before);
    await page.getByRole("region", { name: "normal force" }).scrollIntoViewIfNeeded();

    // Plots: drag to zoom, click to go there, in step with each other.
    const plot = page.getByRole("region", { name: "normal force" }).locator(".u-over");
    await page.waitForFunction(() => document.querySelector(".u-over").clientWidth > 300); // plots in a tab that was hidden get their width when it is shown
    const box = await plot.boundingBox();
    const drag = async (from, to) => {
      await page.mouse.move(box.x + from * box.width, box.y + 40);
      await page.mouse.down();
      await page.mouse.move(box.x + to * box.width, box.y + 42, { steps: 4 });
      await page.mouse.up();
    };
    const [begin, end] = await ask(page, "range");
    await drag(0.25, 0.75);
    const zoomed = await ask(page, "range");
    zoomed.forEach((t, i) => assert.ok(Math.abs(t - (begin + [0.25, 0.75][i] * (end - begin))) < 0.02 * (end - begin), `${zoomed} of ${begin} to ${end}`));
    const csv = await saved(page.getByRole("button", { name: "joint position: save as CSV" }));
    const rows = csv.content.toString().trim().split("\n").slice(1).map((line) => line.split(",").map(Number));
    assert.ok(rows.length > 100 && rows[0][0] >= zoomed[0] - 1e-3 && rows.at(-1)[0] <= zoomed[1] + 1e-3, "the CSV has what is shown");
    await plot.click({ position: { x: 0.5 * box.width, y: 30 } });
    assert.ok(Math.abs((await ask(page, "state")).t - (zoomed[0] + zoomed[1]) / 2) < 0.02 * (end - begin));
    await page.getByRole("button", { name: "whole run" }).click();
    assert.deepEqual(await ask(page, "range"), [begin, end]);
    assert.ok(isPng(await saved(page.getByRole("button", { name: "normal force: save as PNG" }))));
    await page.getByRole("combobox", { name: "joint", exact: true }).selectOption("2");
    await page.getByRole("region", { name: "torque terms" }).scrollIntoViewIfNeeded(); // plots are made when they come into sight
    await page.getByRole("heading", { name: `torque terms of ${log.names[2]}` }).waitFor({ state: "attached" });
    // Of one joint, in its own unit: the row of a time is the log's.
    const position = (await saved(page.getByRole("button", { name: "joint position: save as CSV" }))).content.toString().trim().split("\n").map((line) => line.split(","));
    assert.equal(position[1].length, 3);
    const [t, least, largest] = position[1 + Math.floor(position.length / 2)].map(Number);
    const q = log.q[log.time.findIndex((x) => x >= t - 1e-6)][2];
    assert.ok(least - 1e-4 <= q && q <= largest + 1e-4, `${least} to ${largest} at ${t} s, in the log ${q}`);
    await page.getByRole("button", { name: "pause" }).count().then((n) => assert.equal(n, 0, "nothing plays"));

    // A click on the ink goes to when it was drawn.
    await ask(page, "setView", "top");
    await ask(page, "seek", log.time.at(-1));
    const row = log.stroke.indexOf(0) + 600;
    const [u, v] = await ask(page, "project", log.point[row]);
    const canvas = await page.locator(".pane canvas").boundingBox();
    await page.mouse.click(canvas.x + u, canvas.y + v);
    const gone = await ask(page, "state");
    const there = log.point[log.time.findIndex((x) => x >= gone.t - 1e-6)];
    assert.ok(Math.hypot(...there.map((x, i) => x - log.point[row][i])) < 1e-3, `to ${gone.t} s, drawn at ${log.time[row]} s`);
    // Faint or not, the canvas is as it was for what follows.
    await page.getByText("Show", { exact: true }).click();
    await opacity.fill("1");
    await page.getByText("Show", { exact: true }).click();
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
  // Of a small screen, no table is wider than its box, in any tab.
  await shoot("narrow", { viewport: { width: 360, height: 740 }, hash: "#colour=error&view=top" }, async (page) => {
    for (const tab of await page.getByRole("tab").all()) {
      await tab.click();
      const beyond = await page.locator(".scroll:visible").evaluateAll((list) => list.map((box) => box.scrollWidth - box.clientWidth));
      assert.ok(beyond.every((x) => x <= 0), `${await tab.textContent()}: ${beyond} px wider than 360 px allow`);
    }
    await page.getByRole("tab", { name: "Plots" }).click();
  });
  for (const view of ["top", "front", "side", "pen", "tip"]) await shoot(`view-${view}`, { hash: `#t=${middle}&view=${view}&colour=error` });
  await shoot("4k", { viewport: { width: 3840, height: 2160 }, hash: `#t=${middle}` });
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

test("a file that lost its end is shown up to there, and says so", { timeout: 600_000, skip: Boolean(process.env.RUN) }, async () => {
  const cut = join(scratch, "lost");
  cpSync(folder, cut, { recursive: true });
  truncateSync(join(cut, "run.h5"), Math.floor(0.6 * statSync(join(cut, "run.h5")).size));
  const told = spawnSync(program, ["report", cut], { encoding: "utf8" });
  assert.equal(told.status, 0, told.stderr);
  assert.match(told.stderr, /run\.h5: is cut short; results are of the run up to [\d.]+ s/);
  const { page, wrong, close } = await open(join(cut, "report.html"));
  const { end } = await ask(page, "state");
  assert.ok(end > 0.2 * log.time.at(-1) && end < 0.95 * log.time.at(-1), `${end} s of ${log.time.at(-1)}`);
  assert.match(await page.getByRole("alert").textContent(), /cannot be read to its end: the run is shown up to/);
  const shown = (await ask(page, "frames")).tip;
  const tip = log.tip[log.time.findIndex((t) => t >= end - 1e-6)];
  assert.ok(Math.hypot(shown[3] - tip[0], shown[7] - tip[1], shown[11] - tip[2]) < 1e-4, "its last posture is the log's of then");
  assert.deepEqual(wrong, []);
  await close();
});

test("what a run left out stands in the scene in a colour of its own", { timeout: 600_000, skip: Boolean(process.env.RUN) }, async () => {
  writeFileSync(join(scratch, "part.svg"),
    '<svg xmlns="http://www.w3.org/2000/svg" width="500mm" height="100mm" viewBox="0 0 500 100"><path d="M150 50H400" fill="none" stroke="black"/></svg>');
  const out = join(scratch, "part");
  execFileSync(program, ["draw", "--svg", join(scratch, "part.svg"), "--skip-unreachable", "--set", "drawing.placement.fit_radius=0.3", "--set", "path.draw_speed=0.2", "--out", out], { stdio: "pipe" });
  const { not_drawable } = JSON.parse(readFileSync(join(out, "strokes.json"), "utf8"));
  assert.ok(not_drawable.length >= 1);
  const { page, wrong, close } = await open(join(out, "report.html"));
  assert.equal((await ask(page, "findings")).length, not_drawable.length);
  for (const part of ["arm", "normal", "force", "cameras", "grid"]) await ask(page, "hide", part);
  await ask(page, "setView", "top");
  const line = await ask(page, "findingLine", 0);
  const middle = line[Math.floor(line.length / 2)];
  const [colours] = await ask(page, "coloursAround", [middle], 2);
  assert.ok(colours.some(([r, g, b]) => Math.abs(r - 0x8a) + Math.abs(g - 0x6d) + Math.abs(b - 0x3b) < 60), JSON.stringify(colours));
  const [u, v] = await ask(page, "project", middle);
  const canvas = await page.locator(".pane canvas").boundingBox();
  await page.mouse.click(canvas.x + u, canvas.y + v);
  assert.ok((await page.locator(".state").textContent()).includes(not_drawable[0].text), "a click tells why");
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

test("a canvas that moves takes its ink along", { timeout: 600_000, skip: Boolean(process.env.RUN) }, async () => {
  const out = join(scratch, "moving");
  const scenario = fileURLToPath(new URL("../../scenarios/moving-turntable.yaml", import.meta.url));
  execFileSync(program, ["draw", scenario, "--set", "log.rate=full", "--out", out], { stdio: "pipe" });
  const rows = JSON.parse(execFileSync(python, ["-c", `
import h5py, json, sys
f = h5py.File(sys.argv[1])
on = [i for i in range(len(f["time"])) if f["contact/point"][i, 0] == f["contact/point"][i, 0]][::1500]
print(json.dumps([{k: f[k][i].tolist() for k in ("time", "canvas/pose", "contact/point", "tip/position")} for i in on]))`, join(out, "run.h5")]));
  assert.ok(rows.length > 4);
  const { page, wrong, close } = await open(join(out, "report.html"));
  for (const row of rows) {
    const [x, y, z, w, a, b, c] = row["canvas/pose"];
    const p = row["contact/point"];
    const turn = [[1 - 2 * (b * b + c * c), 2 * (a * b - w * c), 2 * (a * c + w * b)], [2 * (a * b + w * c), 1 - 2 * (a * a + c * c), 2 * (b * c - w * a)],
      [2 * (a * c - w * b), 2 * (b * c + w * a), 1 - 2 * (a * a + b * b)]];
    const expected = [x, y, z].map((o, i) => o + turn[i][0] * p[0] + turn[i][1] * p[1] + turn[i][2] * p[2]);
    await ask(page, "seek", row.time);
    const shown = await ask(page, "placed", p);
    assert.ok(Math.hypot(...shown.map((u, i) => u - expected[i])) < 1e-4, `at ${row.time} s`);
    assert.ok(Math.hypot(...shown.map((u, i) => u - row["tip/position"][i])) < 2e-3, "the ink is under the pen");
  }
  for (const plot of ["canvas: motion of its centre", "canvas: turn", "canvas: error of its estimated place"])
    assert.equal(await page.locator(`section[aria-label^='${plot}']`).count(), 1, plot);
  await page.screenshot({ path: join(shots, "moving.png") });
  await page.locator("section[aria-label^='canvas: motion of its centre']").scrollIntoViewIfNeeded();
  await page.waitForTimeout(1000); // plots follow what is seen
  await page.screenshot({ path: join(shots, "moving-plots.png") });
  assert.deepEqual(wrong, []);
  await close();
});

test("runs compared share one camera and one time line", { timeout: 600_000, skip: Boolean(process.env.RUN) }, async () => {
  const other = join(scratch, "other");
  execFileSync(program, ["draw", "--svg", artwork, "--set", "name=slower", "--set", "path.draw_speed=0.03", "--set", "log.rate=full", "--out", other], { stdio: "pipe" });
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
  const painted = await page.locator(".plot canvas").evaluateAll((list) => list.map((c) => new Set(new Uint32Array(c.getContext("2d").getImageData(0, 0, c.width, c.height).data.buffer)).size));
  assert.ok(painted.length >= 3 && painted.slice(0, 3).every((colours) => colours > 4), `plots are painted: ${painted}`);
  await page.screenshot({ path: join(shots, "flat.png") });
  await flat.close();
});
