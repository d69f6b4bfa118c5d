// A run of the document (runtime/pages/view/scene_document.h), unpacked: the pose of each body in each frame.

function bytesOf(text) {
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; ++i) bytes[i] = binary.charCodeAt(i);
  return bytes.buffer;
}
const floats = (text) => new Float32Array(bytesOf(text));
const ints = (text) => new Int32Array(bytesOf(text));
const shorts = (text) => new Uint16Array(bytesOf(text));

// The sets of bodies that touch each other, directly or through others.
function connectedSets(count, contacts) {
  const parent = Int32Array.from({ length: count }, (_, i) => i);
  const find = (i) => {
    while (parent[i] !== i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (const [a, b] of contacts) {
    const [low, high] = [find(a), find(b)].sort((x, y) => x - y);
    parent[high] = low;
  }
  return parent.map((_, i) => find(i));
}

export class Recording {
  constructor(run) {
    this.run = run;
    this.count = run.bodies.count;
    this.group = ints(run.bodies.group);
    this.mass = floats(run.bodies.mass);
    this.sides = floats(run.bodies.sides);
    this.radius = floats(run.bodies.radius);
    this.meshes = run.meshes.map(({ name, positions, normals, indices }) => (
      { name, positions: floats(positions), normals: floats(normals), indices: ints(indices) }));
    this.parts = { body: ints(run.parts.body), mesh: ints(run.parts.mesh), place: floats(run.parts.place) };
    this.frames = run.frames.count;
    this.isStart = run.frames.is_start;
    this.position = floats(run.frames.position);
    this.orientation = shorts(run.frames.orientation);
    this.boxes = run.boxes && floats(run.boxes);
    this.series = run.series.map((each) => ({ ...each, values: floats(each.values) }));
    this.durations = run.durations.map((each) => ({ ...each, values: floats(each.values) }));
    this.meshOfBody = new Int32Array(this.count).fill(-1);
    this.parts.body.forEach((body, part) => {
      if (this.meshOfBody[body] < 0) this.meshOfBody[body] = this.parts.mesh[part];
    });
    this.soft = run.soft && {
      nodes: run.soft.nodes,
      position: floats(run.soft.position),
      bodies: run.soft.bodies.map((each) => ({ ...each, triangles: ints(each.triangles), links: ints(each.links) })),
    };
    this.readContacts(run.contacts);
    this.cache = new Map();
  }

  readContacts(contacts) {
    this.contacts = null;
    if (!contacts) return;
    const counts = ints(contacts.count);
    const first = [0];
    for (const count of counts) first.push(first.at(-1) + count);
    this.contacts = {
      first,
      body: ints(contacts.body),
      point: floats(contacts.point),
      normal: floats(contacts.normal),
      distance: floats(contacts.distance),
    };
  }

  cycleOf(frame) { return this.run.frames.first + frame * this.run.frames.every; }
  // Simulated seconds at the end of a cycle, warm-up included.
  timeOfCycle(cycle) { return (this.run.warmup + cycle + 1) * this.run.timestep; }
  timeOf(frame) { return this.isStart ? 0 : this.timeOfCycle(this.cycleOf(frame)); }
  // The last frame at or before `time`, or the first one.
  frameAt(time) {
    if (this.isStart) return 0;
    const cycle = time / this.run.timestep - this.run.warmup - 1 + 1e-6;
    const frame = Math.floor((cycle - this.run.frames.first) / this.run.frames.every + 1e-9);
    return Math.min(Math.max(frame, 0), this.frames - 1);
  }
  get begin() { return this.timeOf(0); }
  get end() { return this.timeOf(this.frames - 1); }

  // Writes x y z.
  positionOf(frame, body, out) {
    const at = 3 * (frame * this.count + body);
    for (let i = 0; i < 3; ++i) out[i] = this.position[at + i];
    return out;
  }
  // Writes x y z w (runtime/pages/view/scene_document.h).
  orientationOf(frame, body, out) {
    const at = 3 * (frame * this.count + body);
    const words = this.orientation;
    const largest = (words[at] >> 15) * 2 + (words[at + 1] >> 15);
    let rest = 1;
    for (let i = 0, word = at; i < 4; ++i) {
      if (i === largest) continue;
      const value = ((words[word++] & 0x7fff) / 32767 * 2 - 1) * Math.SQRT1_2;
      out[i] = value;
      rest -= value * value;
    }
    out[largest] = Math.sqrt(Math.max(rest, 0));
    return out;
  }
  // True if the pose equals that of the previous cycle, bit for bit.
  isUnmoved(frame, body) {
    return this.orientation[3 * (frame * this.count + body) + 2] >> 15 === 1;
  }

  // Caches the latest value of each kind.
  cached(kind, frame, make) {
    const kept = this.cache.get(kind);
    if (kept && kept.frame === frame) return kept.value;
    const value = make();
    this.cache.set(kind, { frame, value });
    return value;
  }

  // Speeds in m/s, from the previous frame to this one; for the first frame, from it to the next.
  speeds(frame) {
    return this.cached('speeds', frame, () => {
      const speeds = new Float32Array(this.count);
      if (this.frames < 2) return speeds;
      const to = Math.max(frame, 1) * this.count * 3;
      const from = to - this.count * 3;
      const seconds = this.run.frames.every * this.run.timestep;
      for (let body = 0; body < this.count; ++body) {
        let sum = 0;
        for (let i = 3 * body; i < 3 * body + 3; ++i) {
          const step = this.position[to + i] - this.position[from + i];
          sum += step * step;
        }
        speeds[body] = Math.sqrt(sum) / seconds;
      }
      return speeds;
    });
  }

  // The contacts of a frame as rows of the arrays.
  contactRange(frame) { return [this.contacts.first[frame], this.contacts.first[frame + 1]]; }

  contactCounts(frame) {
    return this.cached('contactCounts', frame, () => {
      const counts = new Float32Array(this.count);
      const [from, to] = this.contactRange(frame);
      for (let row = 2 * from; row < 2 * to; ++row) {
        const body = this.contacts.body[row];
        if (body < this.count) ++counts[body];
      }
      return counts;
    });
  }

  // For each body, the lowest index in its island; -1 for fixed bodies and bodies without contact.
  // Walls and fixed bodies do not connect islands.
  islands(frame) {
    return this.cached('islands', frame, () => {
      const counts = this.contactCounts(frame);
      const joins = (body) => body < this.count && this.mass[body] > 0;
      const pairs = [];
      const [from, to] = this.contactRange(frame);
      for (let row = from; row < to; ++row) {
        const a = this.contacts.body[2 * row], b = this.contacts.body[2 * row + 1];
        if (joins(a) && joins(b)) pairs.push([a, b]);
      }
      const sets = connectedSets(this.count, pairs);
      return sets.map((set, body) => (counts[body] > 0 && joins(body) ? set : -1));
    });
  }

  // Pairs of bodies whose boxes overlap and that are not both fixed, by sweep and prune along x.
  pairs(frame) {
    return this.cached('pairs', frame, () => {
      const at = (body) => 6 * (frame * this.count + body);
      const boxes = this.boxes;
      const order = [...Array(this.count).keys()].filter((body) => boxes[at(body)] <= boxes[at(body) + 3])
        .sort((a, b) => boxes[at(a)] - boxes[at(b)]);
      const pairs = [];
      for (let i = 0; i < order.length; ++i) {
        const a = at(order[i]);
        for (let k = i + 1; k < order.length; ++k) {
          const b = at(order[k]);
          if (boxes[b] > boxes[a + 3]) break;
          if (this.mass[order[i]] === 0 && this.mass[order[k]] === 0) continue;
          if (boxes[b + 1] <= boxes[a + 4] && boxes[a + 1] <= boxes[b + 4] &&
              boxes[b + 2] <= boxes[a + 5] && boxes[a + 2] <= boxes[b + 5])
            pairs.push([order[i], order[k]]);
        }
      }
      return pairs;
    });
  }

  // For each axis, the usual range of positions: the 10th to 90th percentile of the first frame, extended
  // by its width on both sides.
  usualRange() {
    return [0, 1, 2].map((axis) => {
      const values = Array.from({ length: this.count }, (_, body) => this.position[3 * body + axis])
        .filter(Number.isFinite).sort((a, b) => a - b);
      const at = (part) => values[Math.round(part * (values.length - 1))] ?? 0;
      const span = at(0.9) - at(0.1);
      return [at(0.1) - span, at(0.9) + span];
    });
  }

  // The box that the camera should show: the bodies in the cube, and those near most others, so that a
  // body that flew away does not shrink the rest to a dot.
  bounds() {
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    const usual = this.usualRange();
    const grow = (frame, isNear) => {
      for (let body = 0; body < this.count; ++body) {
        const at = this.positionOf(frame, body, [0, 0, 0]);
        if (!at.every(isNear)) continue;
        at.forEach((value, axis) => {
          low[axis] = Math.min(low[axis], value - this.radius[body]);
          high[axis] = Math.max(high[axis], value + this.radius[body]);
        });
      }
    };
    const isUsual = (value, axis) =>
      Math.abs(value) <= 0.51 * this.run.side || (value >= usual[axis][0] && value <= usual[axis][1]);
    grow(0, isUsual);
    const centre = low.map((value, axis) => (value + high[axis]) / 2);
    const reach = 1.5 * Math.max(...low.map((value, axis) => high[axis] - value));
    for (let k = 1; k <= 24; ++k)
      grow(Math.floor((this.frames - 1) * k / 24),
        (value, axis) => isUsual(value, axis) && Math.abs(value - centre[axis]) <= reach);
    return low[0] < Infinity ? { low, high } : { low: [-1, -1, -1], high: [1, 1, 1] };
  }
}
