// The scenes, one for each run, with a common camera.
import {
  DirectionalLight, Fog, HemisphereLight, PCFShadowMap, PerspectiveCamera, Raycaster, Scene, Vector2, Vector3,
  WebGLRenderer,
} from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { Bodies } from './bodies.js';
import { Overlays, roundStep } from './overlays.js';

const kFieldOfView = 40;
const kLightFrom = new Vector3(0.5, 1, 0.35).normalize();

function union(all) {
  return {
    low: [0, 1, 2].map((i) => Math.min(...all.map(({ low }) => low[i]))),
    high: [0, 1, 2].map((i) => Math.max(...all.map(({ high }) => high[i]))),
  };
}

class Panel {
  constructor(recording, bounds, centre, radius) {
    this.recording = recording;
    this.scene = new Scene();
    this.bodies = new Bodies(recording);
    this.overlays = new Overlays(recording, bounds);
    this.scene.add(this.bodies.object, this.overlays.object);
    this.sky = new HemisphereLight(0xffffff, 0xa09a94, 2.3);
    this.sun = new DirectionalLight(0xfff6e8, 2.6);
    this.sun.position.copy(centre).addScaledVector(kLightFrom, 3 * radius);
    this.sun.target.position.copy(centre);
    this.sun.castShadow = true;
    this.sun.shadow.mapSize.set(2048, 2048);
    this.sun.shadow.normalBias = radius / 400;
    this.sun.shadow.intensity = 0.8;
    const reach = 1.3 * radius;
    Object.assign(this.sun.shadow.camera, {
      left: -reach, right: reach, top: reach, bottom: -reach, near: 0.2 * radius, far: 7 * radius });
    this.scene.add(this.sky, this.sun, this.sun.target);
    this.scene.fog = new Fog(0, 1, 2);
  }
}

export class Stage {
  // Throws if there is no WebGL.
  constructor(recordings, canvas, onChange) {
    this.renderer = new WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = PCFShadowMap;
    this.renderer.shadowMap.autoUpdate = false;
    this.bounds = union(recordings.map((recording) => recording.bounds()));
    const { low, high } = this.bounds;
    this.centre = new Vector3(...low.map((value, i) => (value + high[i]) / 2));
    this.radius = 0.5 * Math.hypot(...low.map((value, i) => high[i] - value)) || 1;
    this.panels = recordings.map((each) => new Panel(each, this.bounds, this.centre, this.radius));
    this.camera = new PerspectiveCamera(kFieldOfView, 1, this.radius / 100, this.radius * 100);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.zoomToCursor = true;
    this.controls.addEventListener('change', onChange);
    this.magnify = this.suitableMagnification(recordings);
    this.drawn = 0;
  }

  // 1, or more if bodies would be smaller than a few pixels.
  suitableMagnification(recordings) {
    const radii = recordings.flatMap(({ radius }) => [...radius]).sort((a, b) => a - b);
    const middle = radii[radii.length >> 1] || 1;
    return middle > this.radius / 250 ? 1 : Math.max(1, roundStep(this.radius / 160 / middle));
  }

  frameAll() {
    const narrow = Math.min(1, this.camera.aspect);
    const distance = 0.98 * this.radius / Math.sin(kFieldOfView / 2 * Math.PI / 180) / narrow;
    this.camera.position.copy(this.centre).addScaledVector(new Vector3(0.75, 0.42, 1).normalize(), distance);
    this.controls.target.copy(this.centre);
    this.controls.update();
  }

  resize(width, height) {
    this.width = Math.max(width, 1);
    this.height = Math.max(height, 1);
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.setSize(this.width, this.height, false);
    this.camera.aspect = this.width / this.panels.length / this.height;
    this.camera.updateProjectionMatrix();
  }

  setTheme(theme) {
    this.renderer.setClearColor(theme.stage);
    for (const panel of this.panels) {
      panel.scene.fog.color.set(theme.stage);
      panel.overlays.setTheme(theme);
      panel.sky.intensity = theme.isDark ? 1.9 : 2.3;
    }
  }

  setShadows(on) {
    for (const panel of this.panels) panel.sun.castShadow = on;
  }

  setMagnify(factor) {
    this.magnify = factor;
    for (const panel of this.panels) panel.bodies.magnify = factor;
  }

  show(frames, colours, switches) {
    this.panels.forEach((panel, i) => {
      panel.bodies.show(frames[i], colours);
      panel.overlays.show(frames[i], switches);
    });
    this.isNew = true;
  }

  draw() {
    const distance = this.camera.position.distanceTo(this.controls.target);
    this.camera.near = Math.max(distance - 8 * this.radius, distance / 200, this.radius / 1e4);
    this.camera.far = distance + 20 * this.radius;
    this.camera.updateProjectionMatrix();
    const width = this.width / this.panels.length;
    this.renderer.setScissorTest(true);
    this.panels.forEach((panel, i) => {
      panel.scene.fog.near = distance;
      panel.scene.fog.far = distance + 7 * this.radius;
      this.renderer.setViewport(i * width, 0, width, this.height);
      this.renderer.setScissor(i * width, 0, width, this.height);
      this.renderer.shadowMap.needsUpdate = this.isNew || this.panels.length > 1;
      this.renderer.render(panel.scene, this.camera);
    });
    this.isNew = false;
    ++this.drawn;
  }

  // The run and the body at a pixel, or null. `x`, `y`: pixels from the upper left corner.
  pick(x, y) {
    const width = this.width / this.panels.length;
    const panel = Math.min(Math.floor(x / width), this.panels.length - 1);
    const ray = new Raycaster();
    ray.setFromCamera(new Vector2((x - panel * width) / width * 2 - 1, 1 - y / this.height * 2), this.camera);
    const { body } = this.panels[panel].bodies.pick(ray);
    return body < 0 ? null : { run: panel, body };
  }
}
