import { BufferGeometry, CatmullRomCurve3, Group, Mesh, MeshStandardMaterial, TubeGeometry, Vector3, type Curve } from "three";
import type { Layer, View } from "./layers";
import { colors } from "./palette";

/** The most frames whose traces are drawn. */
const MOST = 12;

/** The paths of named frames, and of the centre of mass of the chosen body, in the whole motion. */
export function traces({ scene, state, stage, history }: View): Layer | null {
  if (!scene.motion || scene.motion.t.length < 2) return null;
  const material = (color: string) => new MeshStandardMaterial({ color, roughness: 0.6, emissive: color, emissiveIntensity: 0.25 });
  const [ofFrames, ofCentre] = [material(colors.trace), material(colors.whole)];
  const path = (body: number, point: Vector3): BufferGeometry | null => {
    const points = history.poses.map((poses) => point.clone().applyMatrix4(poses[body]));
    const radius = 0.06 * stage.unit;
    const apart = points.filter((x, k) => k === 0 || x.distanceTo(points[k - 1]) > 0.1 * radius);
    if (apart.length < 2) return null;
    const curve: Curve<Vector3> = new CatmullRomCurve3(apart);
    curve.arcLengthDivisions = apart.length;
    return new TubeGeometry(curve, 2 * apart.length, radius, 6);
  };
  const frames = scene.frames.filter(({ body }) => body !== 0).slice(0, MOST);
  const root = new Group();
  const centre = new Mesh(new BufferGeometry(), ofCentre);
  let drawn = -1;
  const update = () => {
    if (root.children.length === 0) {
      for (const { body, pose } of frames) {
        const geometry = path(body, new Vector3(pose[0], pose[1], pose[2]));
        if (geometry) root.add(new Mesh(geometry, ofFrames));
      }
      root.add(centre);
    }
    if (drawn === state.selected) return;
    drawn = state.selected;
    centre.geometry.dispose();
    centre.geometry = (drawn > 0 && path(drawn, new Vector3(...scene.bodies[drawn].com))) || new BufferGeometry();
  };
  return {
    id: "traces",
    title: "Traces",
    hint: () => `of ${frames.length === 1 ? `frame ${frames[0].name}` : "frames"}, and of the centre of mass of the chosen body (green)`,
    swatch: colors.trace,
    on: false,
    root,
    update,
  };
}
