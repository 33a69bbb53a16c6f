import { Group, Matrix4, MeshStandardMaterial, SphereGeometry, TorusGeometry, Vector3 } from "three";
import { along } from "./axode";
import { edgesOf } from "./edges";
import { count } from "./element";
import { rod } from "./glyphs";
import { Instances, type Item } from "./instances";
import { matrixOf } from "./kinematics";
import type { Layer, View } from "./layers";
import { colors } from "./palette";

/**
 * The ends of a loop joint count as apart if their distance is more than this part of the size of the scene.
 */
const OPEN = 1e-4;
/** Radii of a rod and of the balls at its ends, in units of symbols. */
const [ROD, BALL] = [0.09, 0.16];

/** Whether the two ends of a loop joint of this kind must be at the same point. */
function apartIsOpen(kind: string): boolean {
  return ["fixed", "revolute", "spherical", "universal"].includes(kind);
}

/** The rods as bars between balls, and a red line between the ends of other loop joints that stand open. */
function rodsAndGaps({ scene, state, stage }: View): Layer {
  const links = scene.loops.filter(({ kind }) => kind === "rod");
  const pins = scene.loops.filter(({ kind }) => apartIsOpen(kind));
  const material = () => new MeshStandardMaterial({ roughness: 0.5 });
  const between = (color: string) => (): Item => ({ body: 0, pose: new Matrix4(), color });
  const rods = new Instances(rod(1, 0, 1), material(), links.map(between(colors.rod)));
  const balls = new Instances(
    new SphereGeometry(BALL, 20, 14),
    material(),
    links.flatMap(({ ends }) => ends).map(({ body, pose }) => ({ body, pose: matrixOf(pose), color: colors.rod, symbol: true })),
  );
  const gaps = new Instances(rod(1, 0, 1), material(), pins.map(between(colors.open)));
  const root = new Group();
  for (const part of [rods, balls]) part.castShadow = true;
  for (const part of [rods, balls, gaps]) if (part.items.length > 0) root.add(part);
  if (links.length > 0) root.add(...[rods, balls].map(edgesOf).filter((edges) => edges !== null));

  /** Lets things reach from one end of their loops to the other. Returns the distances of these ends. */
  const stretch = (things: Instances, of: typeof links, radius: number): number[] =>
    of.map(({ ends }, k) => {
      const [a, b] = ends.map(({ body, pose }) => new Vector3(...pose.slice(0, 3)).applyMatrix4(state.tree.poses[body]));
      const e = b.sub(a);
      const length = e.length();
      things.items[k].pose =
        length > OPEN * stage.radius
          ? along({ centre: a, e: e.divideScalar(length) }).scale(new Vector3(radius, radius, length))
          : new Matrix4().makeScale(0, 0, 0); // a disc as thin as paper would still be seen
      return length;
    });
  let open = 0;
  const update = () => {
    stretch(rods, links, ROD * stage.unit);
    open = stretch(gaps, pins, 0.05 * stage.unit).filter((length) => length > OPEN * stage.radius).length;
    balls.place(state.tree.poses, stage.unit);
    for (const part of [rods, gaps]) part.place(state.tree.poses, 1);
  };
  return {
    id: "loops",
    title: "Loops",
    hint: () =>
      open > 0 ? `${count(open, "loop")} stand${open === 1 ? "s" : ""} open, red` : count(scene.loops.length, "loop"),
    swatch: colors.loop,
    on: true,
    root,
    update,
  };
}

/** Rings about loop joints, since these look like other joints. */
function rings({ scene, state, stage }: View): Layer | null {
  // The frames of a plane and of what rolls on it are not where they touch.
  const ringed = scene.loops.filter(({ kind }) => kind !== "rod" && kind !== "rolling").flatMap(({ ends }) => ends);
  if (ringed.length === 0) return null;
  const root = new Instances(
    new TorusGeometry(0.4, 0.07, 10, 32),
    new MeshStandardMaterial({ roughness: 0.5 }),
    ringed.map(({ body, pose }) => ({ body, pose: matrixOf(pose), color: colors.loop, symbol: true })),
  );
  return {
    id: "loop-joints",
    title: "Loop joints",
    hint: () => "rings at the ends of loop joints",
    swatch: colors.loop,
    on: false,
    over: true,
    root,
    update: () => root.place(state.tree.poses, stage.unit * state.symbolScale),
  };
}

/** The layers of loops. */
export function loopLayers(view: View): (Layer | null)[] {
  return view.scene.loops.length > 0 ? [rodsAndGaps(view), rings(view)] : [];
}
