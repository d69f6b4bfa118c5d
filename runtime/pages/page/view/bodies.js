// The bodies of a run: an instanced mesh for each shape.
import {
  BufferAttribute, BufferGeometry, DynamicDrawUsage, Group, InstancedBufferAttribute, InstancedMesh, Matrix4,
  MeshLambertMaterial, Quaternion, Vector3,
} from 'three';
import { SoftBodies } from './soft.js';

const kPlace = 8; // numbers for each part: scale, rotation, offset along y
const kPicked = [1, 0, 0.6];

// Darkens surfaces that face away, so that bodies of the same colour are distinguishable.
const kFacing = `
  float facing = abs(dot(normalize(vViewPosition), normal));
  outgoingLight *= mix(0.5, 1.0, smoothstep(0.0, 0.5, facing));`;

// Darkens the edges of a unit cube, so that adjacent boxes are distinguishable, unless a box covers few pixels.
const kEdges = `
  vec3 inward = 1.0 - 2.0 * abs(vLocal);
  float toEdge = dot(inward, vec3(1.0)) - max(inward.x, max(inward.y, inward.z)) - min(inward.x, min(inward.y, inward.z));
  float pixel = fwidth(toEdge);
  float edge = (1.0 - smoothstep(0.5 * pixel, 1.6 * pixel, toEdge)) * (1.0 - smoothstep(0.05, 0.25, pixel));
  outgoingLight *= 1.0 - 0.55 * edge;`;

function makeMaterial(hasEdges) {
  const material = new MeshLambertMaterial({ color: 0xffffff });
  material.customProgramCacheKey = () => `body${hasEdges}`;
  material.onBeforeCompile = (shader) => {
    if (hasEdges) {
      shader.vertexShader = `varying vec3 vLocal;\n${shader.vertexShader}`.replace('#include <begin_vertex>',
        '#include <begin_vertex>\nvLocal = position;');
      shader.fragmentShader = `varying vec3 vLocal;\n${shader.fragmentShader}`;
    }
    shader.fragmentShader = shader.fragmentShader.replace('#include <opaque_fragment>',
      `${kFacing}${hasEdges ? kEdges : ''}\n#include <opaque_fragment>`);
  };
  return material;
}

function makeGeometry({ positions, normals, indices }) {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(positions, 3));
  geometry.setAttribute('normal', new BufferAttribute(normals, 3));
  geometry.setIndex(new BufferAttribute(new Uint32Array(indices), 1));
  return geometry;
}

export class Bodies {
  constructor(recording) {
    this.recording = recording;
    this.object = new Group();
    this.magnify = 1;
    this.picked = -1;
    const plain = makeMaterial(false), edged = makeMaterial(true);
    const partsOfMesh = recording.meshes.map(() => []);
    recording.parts.mesh.forEach((mesh, part) => partsOfMesh[mesh].push(part));
    this.meshes = recording.meshes.map((mesh, index) => {
      const instances = new InstancedMesh(makeGeometry(mesh), mesh.name === 'cuboid' ? edged : plain,
        partsOfMesh[index].length);
      instances.instanceMatrix.setUsage(DynamicDrawUsage);
      instances.instanceColor = new InstancedBufferAttribute(new Float32Array(3 * instances.count), 3);
      instances.frustumCulled = false;
      instances.castShadow = instances.receiveShadow = true;
      instances.userData.parts = partsOfMesh[index];
      this.object.add(instances);
      return instances;
    });
    this.soft = recording.soft && new SoftBodies(recording);
    if (this.soft) this.object.add(this.soft.object);
  }

  show(frame, colours) {
    const { recording } = this;
    const colour = colours.colour(recording, frame);
    this.soft?.show(frame, colour, this.picked);
    const p = [0, 0, 0], q = [0, 0, 0, 1];
    const at = new Vector3(), scale = new Vector3(), offset = new Vector3();
    const turn = new Quaternion(), local = new Quaternion(), matrix = new Matrix4();
    const place = recording.parts.place;
    for (const mesh of this.meshes) {
      mesh.userData.parts.forEach((part, instance) => {
        const body = recording.parts.body[part];
        recording.positionOf(frame, body, p);
        recording.orientationOf(frame, body, q);
        const row = part * kPlace;
        turn.set(...q);
        offset.set(0, place[row + 7] * this.magnify, 0).applyQuaternion(turn);
        at.set(...p).add(offset);
        local.set(place[row + 3], place[row + 4], place[row + 5], place[row + 6]);
        scale.set(place[row], place[row + 1], place[row + 2]).multiplyScalar(this.magnify);
        if (!p.every(Number.isFinite)) scale.set(0, 0, 0), at.set(0, 0, 0);
        matrix.compose(at, turn.multiply(local), scale).toArray(mesh.instanceMatrix.array, 16 * instance);
        mesh.instanceColor.array.set(body === this.picked ? kPicked : colour(body), 3 * instance);
      });
      mesh.instanceMatrix.needsUpdate = true;
      mesh.instanceColor.needsUpdate = true;
      mesh.boundingSphere = null; // recomputed from the instances for ray casts
    }
  }

  // The first body that a ray hits; -1 if it hits none.
  pick(ray) {
    const hit = ray.intersectObjects(this.meshes, false)[0];
    const soft = this.soft?.pick(ray);
    if (soft && soft.distance < (hit?.distance ?? Infinity)) return soft;
    if (!hit) return { body: -1, distance: Infinity };
    return { body: this.recording.parts.body[hit.object.userData.parts[hit.instanceId]], distance: hit.distance };
  }
}
