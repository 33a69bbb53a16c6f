import {
  BufferAttribute,
  BufferGeometry,
  Color,
  DirectionalLight,
  Group,
  HemisphereLight,
  Light,
  LineBasicMaterial,
  LineSegments,
  Matrix4,
  Mesh,
  PCFShadowMap,
  PerspectiveCamera,
  PlaneGeometry,
  Quaternion,
  Raycaster,
  Scene as Space,
  ShadowMaterial,
  Sphere,
  Vector2,
  Vector3,
  WebGLRenderer,
  type Object3D,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { EDGES, sizeEdges } from "./edges";
import { heightOfGround } from "./ground";
import { Instances } from "./instances";
import { palettes } from "./palette";
import { drawsOnProcessor, MOVING, RESTING } from "./processor";
import { Resolution } from "./resolution";

/** The scene counts as resting if nothing was drawn for this many milliseconds. */
const REST = 150;

/** The largest number of the form 1, 2 or 5 times a power of ten that is not larger than x. */
function round(x: number): number {
  const power = 10 ** Math.floor(Math.log10(x));
  return power * (x >= 5 * power ? 5 : x >= 2 * power ? 2 : 1);
}

/** Camera, lights and ground. It draws when something has changed. */
export class Stage {
  readonly space = new Space();
  /** Objects that are drawn over the bodies, so that these do not hide them. */
  readonly over = new Space();
  readonly bodies = new Group();
  readonly ground = new Group();
  readonly camera = new PerspectiveCamera(32, 1, 0.01, 100);
  /** Metres between the lines of the grid. */
  gridStep = 1;
  /** The size of a symbol, before the factor that the user chose. */
  unit = 0.1;
  radius = 1;
  /** Called before a frame is drawn. */
  beforeFrame: () => void = () => {};
  private readonly renderer: WebGLRenderer;
  private readonly controls: OrbitControls;
  private readonly key = new DirectionalLight("#ffffff", 2.1);
  private readonly centre = new Vector3();
  private points: readonly Vector3[] = [];
  private readonly up: Vector3;
  private pending = 0;
  /** When the frame that is pending was requested. */
  private asked = 0;
  private readonly resolution = new Resolution();
  private untilRest = 0;
  private frames = 0;
  private dark = false;
  private groundHeight = 0;
  private followed: (() => Vector3) | null = null;
  private lastSeen: Vector3 | null = null;

  constructor(
    readonly canvas: HTMLCanvasElement,
    gravity: readonly number[],
  ) {
    // What is behind an opaque canvas need not be drawn by the
    // browser; three.js itself asks for none that is opaque.
    const context = canvas.getContext("webgl2", { alpha: false, antialias: !drawsOnProcessor() }) ?? undefined;
    try {
      this.renderer = new WebGLRenderer({ canvas, context });
    } catch {
      throw new Error("This browser draws nothing in three dimensions: it has no WebGL, or it is switched off.");
    }
    this.renderer.shadowMap.enabled = !drawsOnProcessor();
    this.renderer.shadowMap.type = PCFShadowMap;
    this.renderer.shadowMap.autoUpdate = false;
    this.up = upward(gravity);
    this.camera.up.copy(this.up);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", () => this.invalidate());
    const sky = new HemisphereLight("#ffffff", "#8d96a0", 1.7);
    sky.position.copy(this.up);
    this.key.castShadow = true;
    this.key.shadow.mapSize.set(1024, 1024);
    this.key.shadow.radius = 4;
    const fill = new DirectionalLight("#dfe9f5", 0.6);
    fill.position.copy(this.basis(-1.5, 1, 0.6));
    this.space.add(this.bodies, this.ground, sky, this.key, this.key.target, fill);
    const head = new DirectionalLight("#ffffff", 1.8);
    head.position.copy(this.basis(1, -0.7, 2.2));
    this.over.add(sky.clone(), head);
    this.renderer.autoClear = false;
    new ResizeObserver(() => this.resize()).observe(canvas);
  }

  /** A vector of components to the front, to the side and up. */
  private basis(front: number, side: number, up: number): Vector3 {
    const turn = new Quaternion().setFromUnitVectors(new Vector3(0, 0, 1), this.up);
    return new Vector3(front, side, up).applyQuaternion(turn);
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (width === 0 || height === 0) return;
    this.setPixelRatio();
    this.renderer.setSize(width, height, false);
    sizeEdges(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.invalidate();
  }

  /** Sets the resolution. This empties the canvas, so that it must be drawn again in the same task. */
  private setPixelRatio(): void {
    this.renderer.setPixelRatio(this.resolution.scale * Math.min(window.devicePixelRatio, 2));
  }

  /**
   * The length that covers one pixel at a distance of one metre. Sprites of constant size are scaled by it.
   */
  get pixel(): number {
    return (2 * Math.tan((this.camera.fov * Math.PI) / 360)) / Math.max(1, this.canvas.clientHeight);
  }

  /** Moves the camera along with a point from now on, or with none. */
  follow(point: (() => Vector3) | null): void {
    this.followed = point;
    this.lastSeen = point?.() ?? null;
  }

  /** Looks at the followed point as before, after it has moved. */
  private keepInView(): void {
    const point = this.followed?.();
    if (!point || !this.lastSeen) return;
    const step = point.clone().sub(this.lastSeen);
    this.lastSeen = point;
    if (step.lengthSq() === 0) return;
    this.camera.position.add(step);
    this.controls.target.add(step);
    this.camera.lookAt(this.controls.target);
  }

  /** Moves the camera so that a ball about a point is seen, from its present direction. */
  fitBall(centre: Vector3, radius: number): void {
    const from = this.camera.position.clone().sub(this.controls.target).setLength((2.2 * radius) / Math.tan((this.camera.fov * Math.PI) / 360));
    this.controls.target.copy(centre);
    this.camera.position.copy(centre).add(from);
    this.controls.update();
    this.invalidate();
  }

  /** The distance from the camera to the point at which it looks, m. */
  get distance(): number {
    return this.camera.position.distanceTo(this.controls.target);
  }

  /** Draws at the next frame of the browser, once however often it is called. */
  invalidate(moved = false): void {
    if (moved) this.renderer.shadowMap.needsUpdate = true;
    if (this.pending) return;
    this.asked = performance.now();
    this.pending = requestAnimationFrame(() => {
      // A browser that is not done with the frames before calls late.
      if (this.resolution.took(performance.now() - this.asked)) this.setPixelRatio();
      this.draw(false);
      window.clearTimeout(this.untilRest);
      this.untilRest = window.setTimeout(() => this.rest(), REST);
    });
  }

  /** Draws in full resolution and with edges when the scene comes to rest. */
  private rest(): void {
    if (this.pending) return;
    const isCoarse = this.resolution.rest();
    if (!isCoarse && !drawsOnProcessor()) return;
    this.setPixelRatio();
    this.draw(true);
  }

  /** Draws a frame. A processor draws no edges and simpler forms while the scene moves, since frames would take too long. */
  private draw(rests: boolean): void {
    this.pending = 0;
    ++this.frames;
    this.keepInView();
    this.beforeFrame();
    const simply = drawsOnProcessor() && !rests;
    const { layers } = this.camera;
    for (const layer of simply ? [EDGES, RESTING] : [MOVING]) layers.disable(layer);
    for (const layer of simply ? [MOVING] : [EDGES, RESTING]) layers.enable(layer);
    this.renderer.render(this.space, this.camera); // its background clears the canvas
    if (!this.over.children.some((child) => child.visible && !(child instanceof Light))) return;
    this.renderer.clearDepth();
    this.renderer.render(this.over, this.camera);
  }

  /** Frames drawn since the page was opened. */
  get frameCount(): number {
    return this.frames;
  }

  /** Chooses the sizes of symbols, camera and ground from points of the scene now, and of all its motion. */
  measure(now: readonly Vector3[], ever: readonly Vector3[]): void {
    const still = new Sphere().setFromPoints(now.length > 0 ? [...now] : [new Vector3()]);
    const whole = new Sphere().setFromPoints(ever.length > 0 ? [...ever] : [new Vector3()]);
    const size = still.radius > 0 ? still.radius : 0.5;
    this.unit = 0.11 * size;
    this.radius = Math.max(whole.radius, size);
    this.centre.copy(whole.center);
    this.points = ever;
    this.layGround(heightOfGround(ever, this.up, size));
    this.camera.near = 0.01 * size;
    this.camera.far = 60 * this.radius;
    this.controls.maxDistance = 40 * this.radius; // so that nothing lies behind the far plane
    this.key.position.copy(this.centre).add(this.basis(1, -0.7, 2.2).multiplyScalar(1.5 * this.radius));
    this.key.target.position.copy(this.centre);
    const view = this.key.shadow.camera;
    view.left = view.bottom = -1.6 * this.radius;
    view.right = view.top = 1.6 * this.radius;
    view.far = 9 * this.radius;
    view.updateProjectionMatrix();
    this.invalidate(true);
  }

  private layGround(height: number): void {
    this.gridStep = round(this.radius / 3);
    const half = Math.ceil((4 * this.radius) / this.gridStep);
    const points: number[] = [];
    const alphas: number[] = [];
    const { r, g, b } = new Color(palettes[this.dark ? "dark" : "light"].grid);
    const step = this.gridStep;
    const foot = this.centre.clone().addScaledVector(this.up, -this.centre.dot(this.up));
    const turn = new Quaternion().setFromUnitVectors(this.up, new Vector3(0, 0, 1));
    const { x: cx, y: cy } = foot.applyQuaternion(turn);
    const [ox, oy] = [Math.round(cx / step), Math.round(cy / step)];
    const put = (x: number, y: number) => {
      const point = this.basis(x * step, y * step, 0).addScaledVector(this.up, height);
      points.push(point.x, point.y, point.z);
      const away = Math.hypot(x - ox, y - oy) / half;
      alphas.push(r, g, b, 0.5 * Math.max(0, 1 - away) ** 1.5);
    };
    for (let i = -half; i <= half; ++i) {
      for (let j = -half; j < half; ++j) {
        put(ox + i, oy + j), put(ox + i, oy + j + 1);
        put(ox + j, oy + i), put(ox + j + 1, oy + i);
      }
    }
    const geometry = new BufferGeometry()
      .setAttribute("position", new BufferAttribute(new Float32Array(points), 3))
      .setAttribute("color", new BufferAttribute(new Float32Array(alphas), 4));
    const lines = new LineSegments(geometry, new LineBasicMaterial({ vertexColors: true, transparent: true, depthWrite: false }));
    const plane = new Mesh(new PlaneGeometry(1, 1), new ShadowMaterial({ opacity: this.dark ? 0.35 : 0.16 }));
    plane.applyMatrix4(
      new Matrix4().compose(
        this.basis(cx, cy, height - 1e-3 * this.radius),
        new Quaternion().setFromUnitVectors(new Vector3(0, 0, 1), this.up),
        new Vector3(1, 1, 1).multiplyScalar(10 * this.radius),
      ),
    );
    plane.receiveShadow = true;
    this.ground.clear();
    this.ground.add(lines);
    if (this.renderer.shadowMap.enabled) this.ground.add(plane);
    this.groundHeight = height;
  }

  /** The direction from which a mechanism is seen whose bodies all move in planes with this normal. */
  before(normal: Vector3): Vector3 {
    const front = normal.clone().addScaledVector(this.up, -normal.dot(this.up));
    if (front.lengthSq() < 0.5) return normal.clone().addScaledVector(this.basis(0.25, -0.5, 0), 1);
    if (front.dot(this.basis(1.25, -1.6, 0)) < 0) front.negate();
    const side = new Vector3().crossVectors(this.up, front);
    return front.addScaledVector(side, 0.42).addScaledVector(this.up, 0.32);
  }

  /** The point of the ground below (or above) another. */
  below(point: Vector3): Vector3 {
    return point.clone().addScaledVector(this.up, this.groundHeight - point.dot(this.up));
  }

  /**
   * Moves the camera so that all of the scene is seen, from its present direction or from a direction in the
   * inertial frame.
   */
  fit(direction?: readonly number[]): void {
    this.resize();
    const from = direction ? new Vector3().fromArray(direction) : this.camera.position.clone().sub(this.controls.target);
    if (from.lengthSq() === 0) from.copy(this.basis(1.25, -1.6, 0.75));
    if (from.clone().cross(this.up).lengthSq() === 0) from.add(this.basis(0, -1e-3, 0)); // straight from above: what is up?
    this.controls.target.copy(this.centre);
    this.camera.position.copy(this.centre).addScaledVector(from.normalize(), this.farEnough(from));
    this.camera.updateProjectionMatrix();
    this.controls.update();
    this.invalidate();
  }

  /** The distance from the centre, in a direction, from which every point is seen. */
  private farEnough(direction: Vector3): number {
    const looking = new Matrix4().lookAt(direction, new Vector3(), this.up).invert();
    const high = Math.tan((this.camera.fov * Math.PI) / 360) / 1.12;
    const wide = high * this.camera.aspect;
    return this.points.reduce((distance, point) => {
      const { x, y, z } = point.clone().sub(this.centre).applyMatrix4(looking);
      return Math.max(distance, z + Math.abs(x) / wide, z + Math.abs(y) / high);
    }, 0.8 * this.radius);
  }

  /** Turns the camera about the point that it looks at, by angles in rad, and zooms by a factor. */
  orbit(around: number, above: number, zoom = 1): void {
    const from = this.camera.position.clone().sub(this.controls.target);
    const side = new Vector3().crossVectors(this.up, from).normalize();
    const tilt = Math.acos(Math.min(1, Math.max(-1, from.clone().normalize().dot(this.up))));
    const lift = Math.min(Math.max(above, tilt - Math.PI + 0.02), tilt - 0.02);
    from.applyAxisAngle(side, -lift).applyAxisAngle(this.up, around).divideScalar(zoom);
    this.camera.position.copy(this.controls.target).add(from);
    this.controls.update();
    this.invalidate();
  }

  setTheme(dark: boolean): void {
    this.dark = dark;
    this.space.background = new Color(palettes[dark ? "dark" : "light"].back);
    if (this.ground.children.length > 0) this.layGround(this.groundHeight);
    this.invalidate();
  }

  /** The body under a point of the canvas (pixels from its corner), or null. */
  pick(x: number, y: number): number | null {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const ray = new Raycaster();
    ray.layers.enable(RESTING);
    ray.setFromCamera(new Vector2((2 * x) / width - 1, 1 - (2 * y) / height), this.camera);
    const visible: Object3D[] = this.bodies.children.filter((layer) => layer.visible);
    const hit = ray.intersectObjects(visible, true).find(({ object }) => object instanceof Instances);
    return hit ? (hit.object as Instances).items[hit.instanceId!].body : null;
  }

  /** The view as a PNG. */
  png(): Promise<Blob> {
    if (this.pending) cancelAnimationFrame(this.pending);
    if (this.resolution.rest()) this.setPixelRatio();
    this.draw(true); // what is drawn is kept until this task ends
    return new Promise((resolve, reject) => {
      this.canvas.toBlob((blob) => (blob ? resolve(blob) : reject(new Error("No picture could be made."))), "image/png");
    });
  }
}

/** The coordinate axis that is most nearly opposite to gravity, or z without gravity. */
function upward([x, y, z]: readonly number[]): Vector3 {
  const sizes = [Math.abs(x), Math.abs(y), Math.abs(z)];
  const most = Math.max(...sizes);
  if (most === 0) return new Vector3(0, 0, 1);
  const k = sizes[2] === most ? 2 : sizes.indexOf(most);
  return new Vector3().setComponent(k, -Math.sign([x, y, z][k]));
}
