import { Group, Mesh, MeshStandardMaterial, Vector3 } from "three";
import { along, axodes, dispose, leastTurning, ruledSurface, type Axodes } from "./axode";
import { format } from "./element";
import { cone, helix, rod } from "./glyphs";
import { replace, type Layer, type View } from "./layers";
import { colors } from "./palette";
import { axisOf, nearest } from "./screws";
import { traces } from "./traces";
import { vectorLayers } from "./vectors";

/**
 * The layers of a motion: instantaneous screw axis and axodes of the chosen body, traces, twists, wrenches
 * and momenta.
 */
export function motionLayers(view: View): Layer[] {
  const { motion } = view.scene;
  if (!motion) return [];
  const layers: Layer[] = [];
  if (motion.twists) layers.push(screwAxis(view), ...axodeLayers(view));
  const paths = traces(view);
  if (paths) layers.push(paths);
  return [...layers, ...vectorLayers(view)];
}

const NO_MOTION = "play or scrub: this pose is not of the motion";
const GROUND = "choose a body that moves";

/**
 * Half of the length with which an axis is drawn: a number of units of symbols, or more if it takes more to
 * reach the joint of the body.
 */
function halfAxis({ scene, state, stage }: View): number {
  const { S_self, com } = scene.bodies[state.selected];
  const toJoint = new Vector3(...com).distanceTo(new Vector3(S_self[0], S_self[1], S_self[2]));
  return Math.max(5 * stage.unit * state.symbolScale, Math.min(1.15 * toJoint, stage.radius));
}

/** Axes are not drawn if their distance from the centre of mass is more than this many sizes of the scene. */
const FAR = 2;

function screwAxis(view: View): Layer {
  const { scene, state, stage } = view;
  const root = new Group();
  const material = new MeshStandardMaterial({ color: colors.screw, roughness: 0.4, emissive: colors.screw, emissiveIntensity: 0.25 });
  let hint = "";
  const draw = (): string => {
    for (const child of root.children) (child as Mesh).geometry.dispose();
    root.clear();
    if (state.selected === 0) return GROUND;
    const twist = state.screw("twists", state.selected);
    if (!twist) return NO_MOTION;
    const axis = axisOf(twist, leastTurning(scene, state.selected));
    if (!axis) return "the body does not turn now";
    const com = new Vector3(...scene.bodies[state.selected].com).applyMatrix4(state.tree.poses[state.selected]);
    const centre = nearest(axis, com);
    if (centre.distanceTo(com) > FAR * stage.radius) return "the axis is too far away to be drawn";
    const unit = stage.unit * state.symbolScale;
    const lead = (2 * Math.PI * axis.pitch) / unit;
    const half = halfAxis(view) / unit;
    const parts = [rod(0.055, -half, half), cone(0.17, 0.5, half + 0.4)];
    if (Math.abs(lead) > 0.02) {
      const drawn = Math.sign(lead) * Math.min(8, Math.max(0.18, Math.abs(lead)));
      parts.push(helix(0.45, drawn, Math.min(12, 6 / Math.abs(drawn)), 0.045));
    }
    const pose = along({ centre, e: axis.e });
    pose.scale(new Vector3(unit, unit, unit));
    for (const part of parts) {
      const mesh = new Mesh(part, material);
      mesh.matrixAutoUpdate = false;
      mesh.matrix.copy(pose);
      root.add(mesh);
    }
    return `of ${scene.bodies[state.selected].name}; pitch ${format(axis.pitch)} m/rad`;
  };
  return {
    id: "screw-axis",
    title: "Instantaneous screw axis",
    hint: () => hint,
    swatch: colors.screw,
    on: false,
    over: true,
    root,
    update: () => {
      hint = draw();
    },
  };
}

function axodeLayers(view: View): Layer[] {
  const { scene, state, stage, history } = view;
  let of = -1;
  let both: Axodes = { fixed: [], moving: [] };
  const known = () => {
    if (of !== state.selected) {
      of = state.selected;
      both = of === 0 ? { fixed: [], moving: [] } : axodes(scene, history, of, FAR * stage.radius);
    }
    return both;
  };
  const layer = (which: "fixed" | "moving", title: string, where: string, palette: readonly string[]): Layer => {
    const root = new Group();
    let drawn: Axodes | null = null;
    let size = 0;
    let surface = new Group();
    return {
      id: `${which}-axode`,
      title,
      hint: () => {
        if (state.selected === 0) return GROUND;
        const n = known()[which].filter((g) => g !== null).length;
        return n === 0 ? "the body has no screw axis near it" : `of ${scene.bodies[state.selected].name}, ${where}`;
      },
      swatch: palette[0],
      on: false,
      root,
      update: () => {
        const half = state.selected === 0 ? 0 : halfAxis(view);
        if (drawn !== known() || size !== half) {
          dispose(surface);
          drawn = known();
          size = half;
          surface = ruledSurface(drawn[which], half, palette);
          replace(root, surface);
        }
        if (which === "fixed") return;
        surface.matrix.copy(state.tree.poses[state.selected]);
        surface.matrixWorldNeedsUpdate = true;
      },
    };
  };
  return [
    layer("fixed", "Fixed axode", "in the inertial frame", colors.fixedAxode),
    layer("moving", "Moving axode", "in the frame of the body, touches the fixed one", colors.movingAxode),
  ];
}
