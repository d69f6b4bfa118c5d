// Selects values by label in each group of a results file: node labels.mjs FOLDER
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import h5wasm from "h5wasm/node";

await h5wasm.ready;
const folder = process.argv[2];
const file = new h5wasm.File(`${folder}/out.h5`, "r");
const known = new Map();
const read = (name) => {
  if (!known.has(name)) known.set(name, file.get(name).value);
  return known.get(name);
};
let found = 0;
for (const line of readFileSync(`${folder}/labels.tsv`, "utf8").trimEnd().split("\n")) {
  const [name, ...labels] = line.split("\t");
  const wanted = labels.pop();
  const group = name.slice(0, name.lastIndexOf("/") + 1);
  const { shape } = file.get(name);
  let index = 0;
  labels.forEach((label, dimension) => {
    const [axis, value] = label.split("=");
    const coordinate = Array.from(read(group + axis), String);
    const at = coordinate.indexOf(value);
    assert.ok(at >= 0, `${name}: ${label}`);
    index = index * shape[dimension] + at;
  });
  assert.equal(String(read(name)[index]), wanted, line);
  ++found;
}
assert.ok(found > 50, `${found}`);
console.log("h5wasm found", found, "values by label");
