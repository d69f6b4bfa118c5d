// Lines and points beside the bodies: walls, floor, boxes, pairs, contacts.
import {
  BufferAttribute, BufferGeometry, Color, DynamicDrawUsage, Group, LineBasicMaterial, LineSegments, Mesh,
  PlaneGeometry, Points, PointsMaterial, ShadowMaterial, Sphere, Vector3,
} from 'three';

const kBoxEdges = [[0, 1], [1, 3], [3, 2], [2, 0], [4, 5], [5, 7], [7, 6], [6, 4], [0, 4], [1, 5], [2, 6], [3, 7]];

// Corner `index` of a box: bit 0 is x, bit 1 y, bit 2 z.
const corner = (low, high, index) => [0, 1, 2].map((i) => (index >> i & 1 ? high[i] : low[i]));

// Lines whose vertices change with the frame.
class Lines {
  constructor(Kind, material) {
    this.object = new Kind(new BufferGeometry(), material);
    this.object.geometry.boundingSphere = new Sphere(new Vector3(), Infinity); // avoids computing it from the vertices
    this.object.frustumCulled = false;
    this.object.renderOrder = 2;
    this.object.visible = false;
  }
  set(vertices, colours) {
    const { geometry } = this.object;
    const put = (name, values) => {
      const kept = geometry.getAttribute(name);
      if (kept && kept.array.length >= values.length) {
        kept.array.set(values);
        kept.needsUpdate = true;
        return;
      }
      geometry.dispose(); // the buffer is too small
      const room = new Float32Array(Math.ceil(values.length * 1.5) + 3);
      room.set(values);
      geometry.setAttribute(name, new BufferAttribute(room, 3).setUsage(DynamicDrawUsage));
    };
    put('position', vertices);
    if (colours) put('color', colours);
    geometry.setDrawRange(0, vertices.length / 3);
  }
}

// 1, 2 or 5 times a power of ten, at most `size`.
export function roundStep(size) {
  const power = 10 ** Math.floor(Math.log10(size));
  return power * [5, 2, 1].find((factor) => factor * power <= size * (1 + 1e-9));
}

const over = { depthTest: false, depthWrite: false, transparent: true };

export class Overlays {
  constructor(recording, bounds) {
    this.recording = recording;
    this.object = new Group();
    this.boxes = new Lines(LineSegments, new LineBasicMaterial({ transparent: true, opacity: 0.7 }));
    this.pairs = new Lines(LineSegments, new LineBasicMaterial({ ...over, opacity: 0.6 }));
    this.normals = new Lines(LineSegments, new LineBasicMaterial({ ...over, vertexColors: true }));
    this.points = new Lines(Points, new PointsMaterial({ ...over, vertexColors: true, size: 4, sizeAttenuation: false }));
    for (const each of [this.boxes, this.pairs, this.normals, this.points]) this.object.add(each.object);
    this.reach = 0.6 * recording.radius.reduce((sum, value) => sum + value, 0) / (recording.count || 1);
    this.maxDepth = this.deepest();
    this.addWalls(bounds);
  }

  deepest() {
    let depth = 0;
    for (const distance of this.recording.contacts?.distance ?? []) depth = Math.max(depth, -distance);
    return depth;
  }

  addWalls({ low, high }) {
    const { side, walls } = this.recording.run;
    const half = side / 2;
    this.walls = new Lines(LineSegments, new LineBasicMaterial({ transparent: true, opacity: 0.8 }));
    this.grid = new Lines(LineSegments, new LineBasicMaterial({ transparent: true, opacity: 0.35 }));
    this.object.add(this.walls.object, this.grid.object);
    if (walls === 'none') return;
    const edges = kBoxEdges.filter(([a, b]) => walls === 'all' || !((a | b) & 2));
    this.walls.set(edges.flat().flatMap((index) => corner([-half, -half, -half], [half, half, half], index)));
    this.walls.object.renderOrder = this.grid.object.renderOrder = 0;
    this.addFloor(low, high, half);
  }

  // Adds a grid under the bodies, with their shadows.
  addFloor(low, high, half) {
    const size = Math.max(...low.map((value, i) => high[i] - value));
    if (low[1] + half > size) return; // the floor is far below the bodies
    const clip = (value) => Math.min(half, Math.max(-half, value));
    const from = [clip(low[0] - size / 2), clip(low[2] - size / 2)];
    const to = [clip(high[0] + size / 2), clip(high[2] + size / 2)];
    this.gridStep = roundStep(size / 8);
    const lines = [];
    const steps = (a, b) => {
      const all = [];
      for (let k = Math.ceil(a / this.gridStep); k * this.gridStep <= b; ++k) all.push(k * this.gridStep);
      return all;
    };
    for (const x of steps(from[0], to[0])) lines.push(x, -half, from[1], x, -half, to[1]);
    for (const z of steps(from[1], to[1])) lines.push(from[0], -half, z, to[0], -half, z);
    this.grid.set(lines);
    this.floor = new Mesh(new PlaneGeometry(to[0] - from[0], to[1] - from[1]), new ShadowMaterial({ opacity: 0.3, depthWrite: false }));
    this.floor.rotation.x = -Math.PI / 2;
    this.floor.position.set((from[0] + to[0]) / 2, -half - size * 1e-4, (from[1] + to[1]) / 2);
    this.floor.receiveShadow = true;
    this.object.add(this.floor);
  }

  setTheme({ line, ink, accent }) {
    this.walls.object.material.color.set(line);
    this.grid.object.material.color.set(line);
    this.boxes.object.material.color.set(ink);
    this.pairs.object.material.color.set(accent);
  }

  show(frame, { walls, boxes, pairs, contacts }) {
    const { recording } = this;
    this.walls.object.visible = this.grid.object.visible = walls;
    this.boxes.object.visible = boxes && Boolean(recording.boxes);
    this.pairs.object.visible = pairs && Boolean(recording.boxes);
    this.normals.object.visible = this.points.object.visible = contacts && Boolean(recording.contacts);
    if (this.boxes.object.visible) this.boxes.set(this.boxLines(frame));
    if (this.pairs.object.visible) {
      const centre = (body) => recording.positionOf(frame, body, [0, 0, 0]);
      this.pairs.set(recording.pairs(frame).flatMap(([a, b]) => [...centre(a), ...centre(b)]));
    }
    if (this.points.object.visible) this.showContacts(frame);
  }

  boxLines(frame) {
    const { boxes, count } = this.recording;
    const lines = [];
    for (let at = 6 * frame * count; at < 6 * (frame + 1) * count; at += 6) {
      const low = boxes.subarray(at, at + 3), high = boxes.subarray(at + 3, at + 6);
      if (!(low[0] <= high[0])) continue;
      for (const edge of kBoxEdges) for (const index of edge) lines.push(...corner(low, high, index));
    }
    return lines;
  }

  // Shows points and normals: blue for gaps, yellow to red with increasing depth of overlap.
  showContacts(frame) {
    const { point, normal, distance } = this.recording.contacts;
    const [from, to] = this.recording.contactRange(frame);
    const points = [], lines = [], colours = [], lineColours = [];
    const gap = new Color('#2a8fff'), shallow = new Color('#ffc400'), deep = new Color('#e0002b'), mixed = new Color();
    for (let row = from; row < to; ++row) {
      const depth = -distance[row] / (this.maxDepth || 1);
      const colour = (depth < 0 ? gap : mixed.lerpColors(shallow, deep, Math.sqrt(Math.min(depth, 1)))).toArray();
      for (let i = 0; i < 3; ++i) points.push(point[3 * row + i]);
      for (const length of [0, this.reach])
        for (let i = 0; i < 3; ++i) lines.push(point[3 * row + i] + length * normal[3 * row + i]);
      colours.push(...colour);
      lineColours.push(...colour, ...colour);
    }
    this.points.set(points, colours);
    this.normals.set(lines, lineColours);
  }
}
