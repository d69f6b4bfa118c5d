// `cdb lsp` with a real client that sends an editor's sequence of messages over pipes.  session.mjs CDB
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import rpc from "vscode-jsonrpc/node.js";

const folder = mkdtempSync(join(tmpdir(), "cdb-lsp-"));
const file = join(folder, "é 1.cdb"); // an address with escapes
const uri = pathToFileURL(file).href;
writeFileSync(join(folder, "base.cdb"), "let m = 3\nbenchmark base { objects { size m; quantity 20 } }\n");

const server = spawn(process.argv[2], ["lsp"], { stdio: ["pipe", "pipe", "inherit"] });
const ended = new Promise((resolve) => server.on("exit", resolve));
const connection = rpc.createMessageConnection(
  new rpc.StreamMessageReader(server.stdout), new rpc.StreamMessageWriter(server.stdin));

const waiting = [];
const published = [];
connection.onNotification("textDocument/publishDiagnostics", (params) => {
  const next = waiting.shift();
  if (next) next(params);
  else published.push(params);
});
const diagnostics = () => new Promise((resolve) => {
  if (published.length) resolve(published.shift());
  else waiting.push(resolve);
});
const document = { uri };
const at = (line, character) => ({ textDocument: document, position: { line, character } });
const range = (line, begin, end) => ({ start: { line, character: begin }, end: { line, character: end } });

connection.listen();
const { capabilities, serverInfo } = await connection.sendRequest("initialize", {
  processId: process.pid, rootUri: pathToFileURL(folder).href, capabilities: {},
});
assert.equal(serverInfo.name, "cdb");
assert.equal(capabilities.positionEncoding, "utf-16");
assert.equal(capabilities.textDocumentSync.change, 2);
await connection.sendNotification("initialized", {});

// Opened with an error after a character of two UTF-16 units.
await connection.sendNotification("textDocument/didOpen", { textDocument: { uri, languageId: "cdb", version: 1,
  text: "use \"base\"\nlet n = sweep(10, 100)\nbenchmark b \"😀\" { colour red }\n" } });
let found = await diagnostics();
assert.equal(found.uri, uri);
assert.equal(found.diagnostics.length, 2, JSON.stringify(found));
const fault = found.diagnostics.find((one) => one.code === "E0201");
assert.deepEqual(fault.range, range(2, 19, 25));
assert.equal(found.diagnostics.find((one) => one.code === "W0203").severity, 2);

// Typed one character at a time: the diagnostics come once, after a pause.
let column = 19;
await connection.sendNotification("textDocument/didChange", { textDocument: { uri, version: 2 },
  contentChanges: [{ range: range(2, 19, 29), text: "" }] });
for (const letter of "cycles n") {
  await connection.sendNotification("textDocument/didChange", { textDocument: { uri, version: column },
    contentChanges: [{ range: range(2, column, column), text: letter }] });
  ++column;
}
found = await diagnostics();
assert.deepEqual(found.diagnostics, []);
assert.equal(found.version, 26);

const labels = (items) => items.map((item) => item.label);
assert.ok(labels(await connection.sendRequest("textDocument/completion", at(2, 26))).includes("n"));
assert.ok(labels(await connection.sendRequest("textDocument/completion", at(2, 20))).includes("cycles"));
const hover = await connection.sendRequest("textDocument/hover", at(2, 20));
assert.match(hover.contents.value, /collision-detection cycles/);
assert.deepEqual(hover.range, range(2, 19, 25));
const definition = await connection.sendRequest("textDocument/definition", at(2, 26));
assert.deepEqual(definition, { uri, range: range(1, 4, 5) });
const used = await connection.sendRequest("textDocument/definition", at(0, 6));
assert.equal(used.uri, pathToFileURL(join(folder, "base.cdb")).href);
const hints = await connection.sendRequest("textDocument/inlayHint", { textDocument: document, range: range(0, 0, 0) });
assert.deepEqual(hints.map((hint) => [hint.label, hint.position]), [["2 runs", { line: 2, character: 11 }]]);
const rename = await connection.sendRequest("textDocument/rename", { ...at(2, 26), newName: "count_of" });
assert.deepEqual(rename.changes[uri].map((edit) => edit.range), [range(1, 4, 5), range(2, 26, 27)]);
await assert.rejects(connection.sendRequest("textDocument/rename", { ...at(2, 26), newName: "3d" }), /cannot be a name/);
const options = { tabSize: 2, insertSpaces: true };
assert.deepEqual(await connection.sendRequest("textDocument/formatting", { textDocument: document, options }), []);
await connection.sendNotification("textDocument/didChange", { textDocument: { uri, version: 99 },
  contentChanges: [{ text: "benchmark b   \"😀\"{cycles   5}" }] });
const edits = await connection.sendRequest("textDocument/formatting", { textDocument: document, options });
assert.deepEqual(edits, [{ range: range(0, 0, 30), newText: "benchmark b \"😀\" { cycles 5 }\n" }]);
await assert.rejects(connection.sendRequest("textDocument/frobnicate", { textDocument: document }),
  (error) => error.code === -32601);

await diagnostics();
await connection.sendNotification("textDocument/didClose", { textDocument: document });
assert.deepEqual((await diagnostics()).diagnostics, []);
assert.equal(await connection.sendRequest("shutdown"), null);
await connection.sendNotification("exit");
assert.equal(await ended, 0);
rmSync(folder, { recursive: true });
console.log("an editor's session: good");
