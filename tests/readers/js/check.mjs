// Holds a results file against what is known of it: node check.mjs FOLDER
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import h5wasm from "h5wasm/node";

await h5wasm.ready;
const folder = process.argv[2];
const file = new h5wasm.File(`${folder}/out.h5`, "r");
assert.equal(file.attrs.title.value, "A plan for tests – µ");
assert.equal(file.get("duration").attrs.units.value, "ns");

const expected = (name) =>
  readFileSync(`${folder}/${name}`, "utf8").trimEnd().split("\n").map((line) => line.split("\t"));
let arrays = 0;
for (const [name, shape, ...values] of expected("numbers.tsv")) {
  const dataset = file.get(name);
  assert.deepEqual(dataset.shape, shape.split(" ").map(Number), name);
  assert.deepEqual(Array.from(dataset.value), values.map((v) => (v === "nan" ? NaN : Number(v))), name);
  ++arrays;
}
for (const [name, shape, ...values] of expected("texts.tsv")) {
  const dataset = file.get(name);
  assert.deepEqual(dataset.shape, shape.split(" ").map(Number), name);
  assert.deepEqual(Array.from(dataset.value, (text) => text ?? ""), values, name);
  ++arrays;
}
assert.ok(arrays >= 54, `${arrays}`);
console.log("h5wasm read", arrays, "arrays");
