import { Color, ConeGeometry, DoubleSide, Group, InstancedMesh, Matrix4, MeshStandardMaterial, Quaternion, SphereGeometry, Vector3 } from "three";
import { Arrows } from "./arrows";
import { format } from "./element";
import type { Layer, View } from "./layers";
import type { Moment } from "./motion";
import { colors } from "./palette";
import { scaleOf, toArrow } from "./scale";

/** What holds at a point of contact: it has no force, sticks, or slides. */
type Status = "open" | "stick" | "slide";
const STATUS: readonly Status[] = ["open", "stick", "slide"];

/** A point of contact; the force acts on the second shape, to which the normal points. */
interface Contact {
  shapes: [number, number];
  point: Vector3;
  normal: Vector3;
  force: Vector3;
  friction: number;
  status: Status;
}

/** Reads the 17 numbers of a point of contact in a scene. */
export function contactOf(x: readonly number[]): Contact {
  const vector = (from: number) => new Vector3(x[from], x[from + 1], x[from + 2]);
  return { shapes: [x[0], x[1]], point: vector(2), normal: vector(5), force: vector(9), friction: x[15], status: STATUS[x[16]] };
}

/** The sample of the step in which a moment lies: forces are means over the step that ends at a sample. */
export function stepOf({ index, fraction }: Moment, samples: number): number {
  return Math.min(fraction > 0 ? index + 1 : index, samples - 1);
}

const NO_MOTION = "play or scrub: this pose is not of the motion";
const Z = new Vector3(0, 0, 1);
const NAMES = `${colors.contacts.stick.name} sticks, ${colors.contacts.slide.name} slides, ${colors.contacts.open.name} is open`;
/** The lengths of a normal and of a friction cone, and of the longest force, in units of symbols. */
const [NORMAL, CONE, LONGEST] = [2, 1.6, 4.5];

/** The layers of contact: points with their normals, forces to scale, and friction cones. */
export function contactLayers(view: View): Layer[] {
  const { motion } = view.scene;
  if (!motion?.contacts?.some((list) => list.length > 0)) return [];
  const samples = motion.contacts.map((list) => list.map(contactOf));
  const most = Math.max(...samples.map((list) => list.length));
  const now = (): Contact[] => {
    const { moment } = view.state;
    return moment ? samples[stepOf(moment, samples.length)] : [];
  };
  return [points(view, most, now), forces(view, samples, most, now), cones(view, most, now)];
}

function points({ state, stage }: View, most: number, now: () => Contact[]): Layer {
  const root = new Group();
  const balls = new InstancedMesh(new SphereGeometry(0.22, 16, 12), new MeshStandardMaterial({ roughness: 0.5 }), most);
  balls.frustumCulled = false;
  const normals = STATUS.map((status) => new Arrows(most, colors.contacts[status].color, false));
  root.add(balls, ...normals);
  let hint = "";
  const update = () => {
    const unit = stage.unit * state.symbolScale;
    const contacts = now();
    contacts.forEach(({ point, status }, k) => {
      balls.setMatrixAt(k, new Matrix4().makeScale(unit, unit, unit).setPosition(point));
      balls.setColorAt(k, new Color(colors.contacts[status].color));
    });
    balls.count = contacts.length;
    balls.instanceMatrix.needsUpdate = true;
    if (balls.instanceColor) balls.instanceColor.needsUpdate = true;
    STATUS.forEach((status, k) => {
      const of = contacts.filter((contact) => contact.status === status);
      normals[k].show(of.map(({ point, normal }) => ({ from: point, vector: normal.clone().multiplyScalar(NORMAL * unit) })), 0.5 * unit);
    });
    hint = state.moment ? `${contacts.length} now, with normals; ${NAMES}` : NO_MOTION;
  };
  return { id: "contacts", title: "Points of contact", hint: () => hint, swatch: colors.contacts.stick.color, on: true, over: true, root, update };
}

function forces({ state, stage }: View, samples: Contact[][], most: number, now: () => Contact[]): Layer {
  const root = new Group();
  const arrows = STATUS.map((status) => new Arrows(most, colors.contacts[status].color, false));
  root.add(...arrows);
  // An impact is a force of one step that would make all others invisible.
  const scale = scaleOf(samples.map((list) => list.reduce((most, { force }) => Math.max(most, force.length()), 0)));
  let hint = "";
  const update = () => {
    const unit = stage.unit * state.symbolScale;
    const long = LONGEST * stage.unit * state.arrowScale;
    STATUS.forEach((status, k) => {
      const of = now().filter((contact) => contact.status === status && scale.most > 0);
      arrows[k].show(of.map(({ point, force }) => ({ from: point, vector: toArrow(force.clone(), scale, long) })), unit);
    });
    hint = state.moment ? `on the second shape; longest ${format(scale.most)} N${scale.clips ? " and more" : ""}, ${NAMES}` : NO_MOTION;
  };
  const scales = () =>
    scale.most > 0 ? [{ color: colors.contacts.stick.color, heads: 1, unit: "N", each: scale.most / (LONGEST * stage.unit * state.arrowScale), clips: scale.clips }] : [];
  return { id: "contact-forces", title: "Contact forces", hint: () => hint, swatch: colors.contacts.slide.color, on: true, over: true, root, update, scales };
}

function cones({ state, stage }: View, most: number, now: () => Contact[]): Layer {
  const root = new Group();
  const geometry = new ConeGeometry(1, 1, 32, 1, true).translate(0, -0.5, 0).rotateX(-Math.PI / 2);
  const material = new MeshStandardMaterial({ transparent: true, opacity: 0.35, side: DoubleSide, depthWrite: false });
  const mesh = new InstancedMesh(geometry, material, most);
  mesh.frustumCulled = false;
  root.add(mesh);
  let hint = "";
  const update = () => {
    const height = CONE * stage.unit * state.symbolScale;
    const contacts = now().filter(({ friction }) => friction > 0);
    contacts.forEach(({ point, normal, friction, status }, k) => {
      const turn = new Quaternion().setFromUnitVectors(Z, normal);
      const width = friction * height;
      mesh.setMatrixAt(k, new Matrix4().compose(point, turn, new Vector3(width, width, height)));
      mesh.setColorAt(k, new Color(colors.contacts[status].color));
    });
    mesh.count = contacts.length;
    mesh.instanceMatrix.needsUpdate = true;
    if (mesh.instanceColor) mesh.instanceColor.needsUpdate = true;
    hint = state.moment ? "forces lie within them, and on them where shapes slide" : NO_MOTION;
  };
  return { id: "friction-cones", title: "Friction cones", hint: () => hint, swatch: colors.contacts.open.color, on: false, over: true, root, update };
}
