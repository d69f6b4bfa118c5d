// The soft bodies of a run: a cloth as its triangles, a block as those of its surface, a rope as a cylinder for each link.
import {
  BufferAttribute, BufferGeometry, CylinderGeometry, DoubleSide, DynamicDrawUsage, Group, InstancedMesh, Matrix4, Mesh,
  MeshLambertMaterial, Quaternion, Vector3,
} from 'three';

const kPicked = [1, 0, 0.6];
const kUp = new Vector3(0, 1, 0);

function makeCloth(body) {
  const geometry = new BufferGeometry();
  const position = new BufferAttribute(new Float32Array(3 * body.count), 3);
  position.setUsage(DynamicDrawUsage);
  geometry.setAttribute('position', position);
  geometry.setIndex(new BufferAttribute(new Uint32Array(body.triangles), 1));
  return new Mesh(geometry, new MeshLambertMaterial({ side: DoubleSide }));
}

function makeRope(body) {
  const mesh = new InstancedMesh(new CylinderGeometry(1, 1, 1, 10), new MeshLambertMaterial(), body.links.length / 2);
  mesh.instanceMatrix.setUsage(DynamicDrawUsage);
  return mesh;
}

export class SoftBodies {
  constructor(recording) {
    this.recording = recording;
    this.object = new Group();
    this.meshes = recording.soft.bodies.map((body) => {
      const mesh = body.triangles.length > 0 ? makeCloth(body) : makeRope(body);
      mesh.frustumCulled = false;
      mesh.castShadow = mesh.receiveShadow = true;
      mesh.userData.body = body.body;
      this.object.add(mesh);
      return mesh;
    });
  }

  show(frame, colour, picked) {
    const { soft, sides } = this.recording;
    this.meshes.forEach((mesh, i) => {
      const body = soft.bodies[i];
      const first = 3 * (frame * soft.nodes + body.first);
      const nodes = soft.position.subarray(first, first + 3 * body.count);
      mesh.visible = nodes.every(Number.isFinite);
      mesh.material.color.setRGB(...(body.body === picked ? kPicked : colour(body.body)));
      if (!mesh.visible) return;
      if (body.triangles.length > 0) {
        mesh.geometry.attributes.position.array.set(nodes);
        mesh.geometry.attributes.position.needsUpdate = true;
        mesh.geometry.computeVertexNormals();
        mesh.geometry.boundingSphere = null; // recomputed for ray casts
        return;
      }
      const radius = sides[3 * body.body + 1] / 2;
      const from = new Vector3(), to = new Vector3(), turn = new Quaternion(), matrix = new Matrix4();
      for (let link = 0; link < mesh.count; ++link) {
        from.fromArray(nodes, 3 * body.links[2 * link]);
        to.fromArray(nodes, 3 * body.links[2 * link + 1]);
        const along = to.clone().sub(from), length = along.length();
        turn.setFromUnitVectors(kUp, length > 0 ? along.divideScalar(length) : kUp);
        matrix.compose(from.add(to).multiplyScalar(0.5), turn, new Vector3(radius, length, radius));
        mesh.setMatrixAt(link, matrix);
      }
      mesh.instanceMatrix.needsUpdate = true;
      mesh.boundingSphere = null;
    });
  }

  // As Bodies.pick.
  pick(ray) {
    const hit = ray.intersectObjects(this.meshes.filter((mesh) => mesh.visible), false)[0];
    return hit ? { body: hit.object.userData.body, distance: hit.distance } : { body: -1, distance: Infinity };
  }
}
