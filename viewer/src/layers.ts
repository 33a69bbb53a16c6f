import type { Group, Object3D } from "three";
import type { History } from "./history";
import type { Part } from "./meshes";
import { bodyLayers } from "./body_layers";
import { motionLayers } from "./motion_layers";
import type { Palette } from "./palette";
import type { Scene } from "./scene";
import type { Stage } from "./stage";
import type { State } from "./state";

/** Something that can be switched on and off. */
export interface Layer {
  id: string;
  title: string;
  /** One line about what is seen; asked for anew whenever the state changes. */
  hint: () => string;
  /** Colour of its box in the list. */
  swatch: string;
  on: boolean;
  root: Object3D;
  /** Whether bodies do not hide it. */
  over?: boolean;
  /** Brings it to the state; called only while it is on. */
  update: () => void;
  /** Draws in other colours, where it has some that depend on the background. */
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

/** All layers that a scene has something for. */
export function makeLayers(view: View): Layer[] {
  return [...bodyLayers(view), ...motionLayers(view)];
}

/** Takes the place of what a group has shown. */
export function replace(group: Group, ...children: Object3D[]): void {
  group.clear();
  if (children.length > 0) group.add(...children);
}
