// Validates the binary glTF of a real run:  node gltf.mjs CDB SCENARIO FOLDER
import { execFileSync } from 'node:child_process';
import { deepStrictEqual as equal } from 'node:assert';
import { readFileSync } from 'node:fs';
import validator from 'gltf-validator';

const [cdb, scenario, folder] = process.argv.slice(2);
process.chdir(folder);
execFileSync(cdb, ['run', '-q', '--fresh', scenario, '-o', 'gltf.h5']);
execFileSync(cdb, ['view', 'gltf.h5', '--gltf', 'run.glb'], { stdio: 'pipe' });
execFileSync(cdb, ['view', scenario, '--gltf', 'start.glb'], { stdio: 'pipe' });
for (const [name, animations] of [['run.glb', 1], ['start.glb', 0]]) {
  const report = await validator.validateBytes(new Uint8Array(readFileSync(name)));
  equal(report.issues.messages, []);
  equal(report.info.animationCount, animations);
}
