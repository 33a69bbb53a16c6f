import type { Group, Object3D } from "three";
import type { History } from "./history";
import type { Part } from "./meshes";
import { bodyLayers } from "./body_layers";
import { contactLayers } from "./contact_layers";
import { motionLayers } from "./motion_layers";
import type { Palette } from "./palette";
import type { Scene } from "./scene";
import type { Stage } from "./stage";
import type { State } from "./state";

/** Something in the view that can be switched on and off. */
export interface Layer {
  id: string;
  title: string;
  /** One line about what the layer shows. It is called again whenever the state changes. */
  hint: () => string;
  /** Colour of its box in the list. */
  swatch: string;
  on: boolean;
  root: Object3D;
  /** Whether the layer is drawn over the bodies, so that these do not hide it. */
  over?: boolean;
  /** Arrows of the layer, each with what a metre of an arrow is, and whether longer ones are clipped. */
  scales?: () => { color: string; heads: number; unit: string; each: number; clips: boolean }[];
  /** Updates the layer after a change of the state. It is called only while the layer is on. */
  update: () => void;
  /** Draws the layer in other colours, if some of its colours depend on the background. */
  paint?: (palette: Palette) => void;
}

/** What layers are made from. */
export interface View {
  scene: Scene;
  state: State;
  stage: Stage;
  history: History;
  meshes: Part[][];
}

/** All layers for which the scene has data. */
export function makeLayers(view: View): Layer[] {
  return [...bodyLayers(view), ...motionLayers(view), ...contactLayers(view)];
}

/** Replaces the children of a group. */
export function replace(group: Group, ...children: Object3D[]): void {
  group.clear();
  if (children.length > 0) group.add(...children);
}
