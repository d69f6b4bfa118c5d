// Median step time of every cell of a results file: npm install h5wasm; node read.mjs OUT.h5
import h5wasm from "h5wasm/node";

await h5wasm.ready;
const file = new h5wasm.File(process.argv[2], "r");
const axes = (file.attrs.axes?.value ?? "").split(" ").filter(Boolean);
const values = axes.map((axis) => Array.from(file.get(axis).value));
const step = file.get("phase").value.indexOf("step");
// Facts of the runs are called "run/host", errors "accuracy/energy", their axes "accuracy/hz".
const { shape, value } = file.get("duration"); // axes…, rep, phase, cycle; one flat array
const [reps, phases, cycles] = shape.slice(-3);
for (let cell = 0; cell * reps * phases * cycles < value.length; ++cell) {
  const ns = [];
  for (let rep = 0; rep < reps; ++rep) {
    const begin = ((cell * reps + rep) * phases + step) * cycles;
    ns.push(...value.subarray(begin, begin + cycles).filter((x) => !Number.isNaN(x)));
  }
  if (ns.length === 0) continue;
  ns.sort((a, b) => a - b);
  let rest = cell;
  const at = values.map((v) => v).reverse().map((v) => [v[rest % v.length], (rest = Math.floor(rest / v.length))][0]);
  console.log([...at.reverse(), (ns[(ns.length - 1) >> 1] + ns[ns.length >> 1]) / 2].join("\t"));
}
