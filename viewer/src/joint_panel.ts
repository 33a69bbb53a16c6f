import { Quaternion, Vector3 } from "three";
import { TORN, type Arrival } from "./closure";
import { element, format, freshId } from "./element";
import { KINDS } from "./joint_kinds";
import { expQuaternion, logQuaternion } from "./kinematics";
import { colorOfBody } from "./palette";
import type { Joint } from "./scene";
import type { State } from "./state";

/** One number that a slider sets. */
interface Handle {
  slider: HTMLInputElement;
  box: HTMLInputElement;
  limits: [number | null, number | null];
  range: [number, number];
}

/** The numbers that the sliders of a joint show for its coordinates: for a quaternion its rotation vector. */
function handlesFrom(joint: Joint, x: readonly number[]): number[] {
  if (!KINDS[joint.kind].hasQuaternion) return x.slice();
  return [...logQuaternion(new Quaternion(x[0], x[1], x[2], x[3])).toArray(), ...x.slice(4)];
}

function coordinatesFrom(joint: Joint, handles: readonly number[]): number[] {
  if (!KINDS[joint.kind].hasQuaternion) return handles.slice();
  return [...expQuaternion(new Vector3(handles[0], handles[1], handles[2])).toArray(), ...handles.slice(3)];
}

/**
 * Makes sliders for the coordinates of all joints. Sliders of lengths without limits reach up to `length`.
 * Returns the function that moves the sliders to the coordinates of the state.
 */
export function fillJointPanel(panel: HTMLElement, state: State, length: number): () => void {
  const { scene } = state;
  // Joints that the user moved keep their coordinates while he moves others, if the loops allow it.
  const chosen = new Set<number>();
  const forget = () => {
    chosen.clear();
    state.setCoordinates(scene.q);
  };
  state.onChange(() => state.moment && chosen.clear());
  const rows = scene.bodies.slice(1).map((body, k) => jointRow(state, k + 1, body.joint, length, chosen));
  const reset = element("button", { type: "button", click: forget }, "Reset");
  panel.append(...(rows.length > 0 ? rows.map((row) => row.root) : [element("p", {}, "No body moves.")]));
  panel.append(element("div", { class: "row" }, reset));
  return () => rows.forEach((row) => row.show());
}

function jointRow(state: State, body: number, joint: Joint, length: number, chosen: Set<number>): { root: HTMLElement; show: () => void } {
  const { scene } = state;
  const { units, sliders, hasPitch } = KINDS[joint.kind];
  const kind = joint.leader
    ? `${joint.kind}, follows ${scene.bodies[joint.leader.joint].joint.name}`
    : hasPitch
      ? `${joint.kind}, ${format(joint.pitch)} m/rad`
      : joint.kind;
  const name = element("b", { title: `moves ${scene.bodies[body].name}` }, joint.name);
  const root = element("div", { class: "joint", role: "group", "aria-label": joint.name });
  const swatch = element("i", { class: "swatch", "aria-hidden": "true" });
  swatch.style.background = colorOfBody(body);
  root.append(element("div", { class: "joint-name" }, swatch, name, element("span", {}, kind + (joint.passive ? ", passive" : ""))));
  root.addEventListener("focusin", () => state.selected !== body && state.select(body));

  // What the user holds keeps its own numbers: a rotation
  // vector beyond half a turn is another one by its pose.
  let held: number[] | null = null;
  let editing = false;
  const numbers = () => held ?? handlesFrom(joint, state.tree.coordinates(body, state.q));
  const edit = (k: number, value: number) => {
    const from = numbers().slice();
    const path = (s: number) => from.map((x, j) => (j === k ? x + s * (value - x) : x));
    const way = (value - from[k]) / (units[k].coordinate === "m" ? length : 1);
    const others = [...chosen].filter((other) => other !== body);
    const { q, part } = led(state, body, (s) => coordinatesFrom(joint, path(s)), Math.abs(way), others);
    chosen.add(body);
    held = path(part);
    const what = sliders[k] ? `${joint.name} ${sliders[k]}` : joint.name;
    const said = (x: number) => `${format(x)} ${units[k].coordinate}`;
    editing = true;
    state.setCoordinates(q, part < 1 ? `${what} cannot reach ${said(value)}: the loops end its way at ${said(held[k])}.` : "");
    editing = false;
  };
  state.onChange(() => {
    if (!editing) held = null;
  });
  const handles: Handle[] = units.map(({ coordinate }, k) => {
    const limits = joint.limits[k] ?? [null, null];
    const free = coordinate === "rad" ? Math.PI : length;
    const range: [number, number] = [limits[0] ?? Math.min(-free, limits[1] ?? 0), limits[1] ?? Math.max(free, limits[0] ?? 0)];
    const label = sliders[k] ? `${joint.name} ${sliders[k]}, ${coordinate}` : `${joint.name}, ${coordinate}`;
    const disabled = joint.leader !== null;
    const slider = element("input", {
      type: "range",
      min: range[0],
      max: range[1],
      step: "any",
      "aria-label": label,
      disabled,
      input: () => edit(k, Number(slider.value)),
      // With step "any" browsers move by one, which is much for an angle.
      keydown: (event) => {
        const steps = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1, PageDown: -10, PageUp: 10 };
        const step = steps[(event as KeyboardEvent).key as keyof typeof steps];
        if (step === undefined) return;
        event.preventDefault();
        const moved = Number(slider.value) + (step * (range[1] - range[0])) / 100;
        edit(k, Math.min(Math.max(moved, range[0]), range[1]));
      },
    });
    const box = element("input", {
      type: "number",
      step: "any",
      "aria-label": label,
      disabled,
      change: () => {
        if (!Number.isFinite(box.valueAsNumber)) return;
        edit(k, box.valueAsNumber);
        box.value = asText(numbers()[k]); // where the joint is, which may be less far
      },
      blur: () => show(),
    });
    const labelled = sliders[k] ? [element("span", { class: "unit", "aria-hidden": "true" }, sliders[k])] : [];
    const line = element("div", { class: sliders[k] ? "slider labelled" : "slider" }, ...labelled, slider, box, element("span", { class: "unit" }, coordinate));
    line.id = freshId();
    if (limits[0] !== null || limits[1] !== null) {
      const end = (value: number | null) => element("span", {}, value === null ? "" : format(value));
      line.append(element("div", { class: "ends", "aria-hidden": "true" }, end(limits[0]), end(limits[1])));
    }
    root.append(line);
    return { slider, box, limits, range };
  });

  const show = () => numbers().forEach((x, k) => showHandle(handles[k], x));
  return { root, show };
}

/**
 * The configuration in which the joint of a body has gone along path(s), as
 * far as the loops let it. If the loops are open, the joint moves alone.
 */
function led({ closure, scene, q }: State, body: number, path: (s: number) => number[], way: number, others: readonly number[]): Arrival {
  const closed = closure.none || closure.gap(q) > TORN ? null : closure.close(q, Array<boolean>(scene.nv).fill(false));
  if (closed) return closure.lead(closed, body, path, way, others);
  const alone = q.slice();
  path(1).forEach((x, k) => (alone[scene.bodies[body].joint.iq + k] = x));
  return { q: alone, part: 1 };
}

function asText(x: number): string {
  return String(Number(x.toFixed(5)));
}

function showHandle({ slider, box, limits, range }: Handle, value: number): void {
  slider.min = String(Math.min(range[0], value));
  slider.max = String(Math.max(range[1], value));
  slider.value = String(value);
  if (document.activeElement !== box) box.value = asText(value); // nobody's typing is disturbed
  const beyond = (limits[0] !== null && value < limits[0] - 1e-9) || (limits[1] !== null && value > limits[1] + 1e-9);
  box.classList.toggle("beyond", beyond);
  box.title = beyond ? "beyond its limits" : "";
}
