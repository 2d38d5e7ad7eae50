// Opens the pages of the examples in docs/browser.md in headless Chromium, and compares what they
// show with the document.
//
//   node browser.mjs FOLDER PLAYWRIGHT CHROMIUM
//
// FOLDER holds the folders `vite` and `plain`, in which `.ci/examples` has followed the sections.

import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { readFileSync } from "node:fs";
import { createServer } from "node:http";
import { createRequire } from "node:module";
import { extname, join, normalize } from "node:path";

const [folder, playwright, program] = process.argv.slice(2);
const { chromium } = createRequire(import.meta.url)(join(playwright, "index.js"));
const KINDS = { ".html": "text/html", ".js": "text/javascript", ".wasm": "application/wasm" };

/** Serves a folder, as any web server does. */
function serve(root) {
  const server = createServer((request, answer) => {
    const path = normalize(new URL(request.url, "http://localhost").pathname);
    try {
      const name = path.endsWith("/") ? `${path}index.html` : path;
      answer.setHeader("content-type", KINDS[extname(name)] ?? "application/octet-stream").end(readFileSync(join(root, name)));
    } catch {
      answer.writeHead(404).end();
    }
  });
  return new Promise((resolve) => server.listen(0, "127.0.0.1", () => resolve([`http://127.0.0.1:${server.address().port}/`, () => server.close()])));
}

/** Vite's server for development. */
function develop(root) {
  const vite = spawn(process.execPath, ["node_modules/vite/bin/vite.js", "--host", "127.0.0.1", "--port", "0"], { cwd: root, stdio: ["ignore", "pipe", "inherit"] });
  return new Promise((resolve, reject) => {
    let printed = "";
    vite.stdout.on("data", (text) => {
      printed += String(text).replace(/\x1b\[[0-9;]*m/g, "");
      const address = printed.match(/http:\/\/127\.0\.0\.1:\d+\//);
      if (address) resolve([address[0], () => vite.kill()]);
    });
    vite.on("exit", () => reject(new Error(`vite ended: ${printed}`)));
  });
}

const browser = await chromium.launch({ executablePath: program, args: ["--no-sandbox", "--disable-quic", "--no-first-run"] });
try {
  for (const [what, start] of [
    ["a page without a bundler", () => serve(join(folder, "plain/project"))],
    ["Vite, built", () => serve(join(folder, "vite/project/dist"))],
    ["Vite, in development", () => develop(join(folder, "vite/project"))],
  ]) {
    const [address, stop] = await start();
    const page = await browser.newPage(), complaints = [];
    page.on("pageerror", (error) => complaints.push(String(error)));
    page.on("console", (message) => {
      if (["error", "warning"].includes(message.type()) && !/favicon/.test(message.location().url)) complaints.push(message.text());
    });
    await page.goto(address);
    await page.waitForFunction(() => document.body.textContent.includes("depth"), null, { timeout: 30_000 }).catch(() => {});
    assert.equal((await page.textContent("body")).trim(), "depth 0.25", `${what}: ${complaints}`);
    assert.deepEqual(complaints, [], what);
    await page.close();
    stop();
    console.log(`${what}: depth 0.25, as the document says`);
  }
} finally {
  await browser.close();
}
