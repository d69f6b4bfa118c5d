// The TextMate grammar, tokenised as VS Code does it.  grammar.mjs CDB EXAMPLES
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readdirSync, readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";
import oniguruma from "vscode-oniguruma";
import textmate from "vscode-textmate";

const [cdb, examples] = process.argv.slice(2);
const generate = (kind) => execFileSync(cdb, ["generate", kind], { encoding: "utf8" });
const wasm = readFileSync(createRequire(import.meta.url).resolve("vscode-oniguruma/release/onig.wasm"));
await oniguruma.loadWASM(wasm);
const registry = new textmate.Registry({
  onigLib: Promise.resolve({
    createOnigScanner: (patterns) => new oniguruma.OnigScanner(patterns),
    createOnigString: (text) => new oniguruma.OnigString(text),
  }),
  loadGrammar: async () => textmate.parseRawGrammar(generate("textmate"), "cdb.json"),
});
const grammar = await registry.loadGrammar("source.cdb");

// [text, innermost scope] of each token that has a scope.
const tokens = (text) => {
  let state = textmate.INITIAL;
  const all = [];
  for (const line of text.split("\n")) {
    const result = grammar.tokenizeLine(line, state);
    state = result.ruleStack;
    for (const token of result.tokens)
      all.push([line.slice(token.startIndex, token.endIndex), token.scopes.at(-1)]);
  }
  return all.filter(([, scope]) => scope !== "source.cdb");
};
const scopeOf = (text, word) => tokens(text).find(([token]) => token === word)?.[1];

const vocabulary = JSON.parse(generate("vocabulary"));
for (const [kind, scope] of [["statements", "keyword.control.cdb"], ["modifiers", "keyword.other.cdb"],
  ["functions", "support.function.cdb"], ["constants", "constant.language.cdb"]])
  for (const word of vocabulary[kind])
    assert.equal(scopeOf(`  x ${word} 1`, word), scope, word);
assert.ok(vocabulary.parameters.length > 60);
for (const name of vocabulary.parameters)
  assert.equal(scopeOf(`  ${name} 5`, name), "variable.parameter.cdb", name);
for (const block of vocabulary.blocks)
  assert.equal(scopeOf(`  ${block} {`, block), "entity.name.section.cdb", block);
for (const word of vocabulary.words)
  assert.equal(scopeOf(`  x any(5, ${word})`, word), "support.constant.cdb", word);

assert.deepEqual(tokens('benchmark b "t \\n" { cycles 1_000 } # c'), [
  ["benchmark", "keyword.control.cdb"], ["b", "entity.name.type.cdb"], ['"', "punctuation.definition.string.begin.cdb"],
  ["t ", "string.quoted.double.cdb"], ["\\n", "constant.character.escape.cdb"],
  ['"', "punctuation.definition.string.end.cdb"], ["cycles", "variable.parameter.cdb"],
  ["1_000", "constant.numeric.cdb"], ["#", "punctuation.definition.comment.cdb"], [" c", "comment.line.number-sign.cdb"]]);
assert.equal(scopeOf("let n = sweep(1 .. 5) as z", "n"), "variable.other.constant.cdb");
assert.equal(scopeOf("seed 0xAA_BB", "0xAA_BB"), "constant.numeric.cdb");
assert.equal(scopeOf("timestep 1.5e-3", "1.5e-3"), "constant.numeric.cdb");
assert.equal(scopeOf("any(bottomless 3)", "bottomless"), undefined, "part of a word");

// In the examples, every parameter and statement has a scope.
for (const name of readdirSync(examples).filter((one) => one.endsWith(".cdb"))) {
  const seen = new Set(tokens(readFileSync(join(examples, name), "utf8")).map(([token]) => token));
  for (const word of ["benchmark"]) assert.ok(seen.has(word), name);
}
console.log("the grammar: good");
