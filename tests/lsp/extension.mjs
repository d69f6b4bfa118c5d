// The extension for VS Code can be packed, and contains the files that its manifest names.  extension.mjs CDB SOURCE CMAKE
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

const [cdb, source, cmake] = process.argv.slice(2);
const folder = mkdtempSync(join(tmpdir(), "cdb-vscode-"));
const stage = join(folder, "stage");
execFileSync(process.execPath, ["pack.mjs", cdb, source, stage], { stdio: "inherit" });
const file = join(folder, "cdb.vsix");
execFileSync(cmake, ["-E", "tar", "cf", file, "--format=zip", "."], { cwd: stage });
assert.equal(readFileSync(file).subarray(0, 2).toString(), "PK");
const names = execFileSync(cmake, ["-E", "tar", "tf", file], { encoding: "utf8" });
const manifest = JSON.parse(readFileSync(join(stage, "extension", "package.json"), "utf8"));
const { languages, grammars } = manifest.contributes;
for (const path of [manifest.main, languages[0].configuration, grammars[0].path]) {
  assert.ok(names.includes(`extension/${path.replace("./", "")}`), path);
  assert.ok(readFileSync(join(stage, "extension", path)).length > 100, path);
}
for (const name of ["[Content_Types].xml", "extension.vsixmanifest"]) assert.ok(names.includes(name), name);
assert.deepEqual(languages[0].extensions, [".cdb"]);
assert.equal(JSON.parse(readFileSync(join(stage, "extension", grammars[0].path), "utf8")).scopeName, grammars[0].scopeName);
execFileSync(process.execPath, ["--check", join(stage, "extension", "extension.js")]);
rmSync(folder, { recursive: true });
console.log("the extension: good");
