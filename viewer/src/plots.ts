import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import { element } from "./element";
import { ANGLE, type JointKind, KINDS } from "./joint_kinds";
import { colors, strokeOfBody } from "./palette";
import type { Scene } from "./scene";
import type { State } from "./state";
import { tickText } from "./ticks";

/** A curve over time; `body` is the body whose joint it belongs to, 0 if it belongs to none. */
interface Curve {
  label: string;
  body: number;
  values: number[];
}

/** Curves of one unit. */
interface Quantity {
  name: string;
  unit: string;
  curves: Curve[];
}

const HEIGHT = 150;

const UNITS = {
  q: { angle: "rad", length: "m", quaternion: "quaternion" },
  v: { angle: "rad/s", length: "m/s", quaternion: "" },
  tau: { angle: "N m", length: "N", quaternion: "" },
};
type Kind = keyof (typeof UNITS)["q"];

/**
 * The directions of the numbers of a joint, each with what
 * it measures. A joint of one number has no direction.
 */
function directions(kind: JointKind, which: "q" | "v"): [string, Kind][] {
  const { units, coordinates, velocities, hasQuaternion } = KINDS[kind];
  const measures = units.map((unit): Kind => (unit === ANGLE ? "angle" : "length"));
  if (which === "v") return velocities.map((name, k) => [name, measures[k]]);
  const [turn, rest] = hasQuaternion ? [4, measures.slice(3)] : [0, measures];
  return coordinates.map((name, k) => [name, k < turn ? "quaternion" : rest[k - turn]]);
}

/** Panels of q, v or tau: one for each unit. */
function ofJoints(scene: Scene, symbol: keyof typeof UNITS, rows: readonly number[][]): Quantity[] {
  const curves = scene.bodies.flatMap(({ joint }, body) => {
    if (body === 0 || joint.nv === 0) return [];
    const first = symbol === "q" ? joint.iq : joint.iv;
    return directions(joint.kind, symbol === "q" ? "q" : "v").map(([direction, kind], k) => ({
      kind,
      curve: { label: direction ? `${joint.name} ${direction}` : joint.name, body, values: rows.map((row) => row[first + k]) },
    }));
  });
  const kinds = (["angle", "quaternion", "length"] as const).filter((kind) => curves.some((c) => c.kind === kind));
  return kinds.map((kind) => ({
    name: kinds.length > 1 ? `${symbol}, ${UNITS[symbol][kind]}` : symbol,
    unit: UNITS[symbol][kind],
    curves: curves.filter((c) => c.kind === kind).map((c) => c.curve),
  }));
}

function quantities(scene: Scene): Quantity[] {
  const { q, v, tau, series } = scene.motion!;
  return [
    ...ofJoints(scene, "q", q),
    ...ofJoints(scene, "v", v),
    ...(tau ? ofJoints(scene, "tau", tau) : []),
    ...series.map(({ name, unit, labels, values }) => ({ name, unit, curves: labels.map((label, k) => ({ label, body: 0, values: values.map((row) => row[k]) })) })),
  ];
}

/** The curves of a quantity that are drawn: at most as many as there are colours, those that change most. */
function drawnCurves({ curves }: Quantity, body: number | null): Curve[] {
  const asked = curves.filter((curve) => body === null || curve.body === 0 || curve.body === body);
  const range = ({ values }: Curve) => values.reduce((a, b) => Math.max(a, b), -Infinity) - values.reduce((a, b) => Math.min(a, b), Infinity);
  const most = new Set([...asked].sort((a, b) => range(b) - range(a)).slice(0, colors.curves.length));
  return asked.filter((curve) => most.has(curve));
}

/** The colours of curves: those of their bodies if that tells them apart. */
function strokes(curves: readonly Curve[]): string[] {
  const ofBodies = curves.filter(({ body }) => body > 0).map(({ body }) => strokeOfBody(body));
  const apart = new Set(ofBodies).size === curves.length;
  return apart ? ofBodies : curves.map((_, k) => colors.curves[k]);
}

/** Plots over time, each of which can be switched off. A click or drag in a plot moves the time cursor. */
export class Plots {
  private readonly drawn = new Map<string, { plot: uPlot; cursor: HTMLElement; box: HTMLElement }>();
  private readonly drawings = element("div", { class: "drawings" });
  private readonly buttons = new Map<string, HTMLButtonElement>();
  /** The body whose curves are drawn; null for every body. */
  private body: number | null = null;
  private ofChosen = false;

  constructor(
    place: HTMLElement,
    private readonly state: State,
    private readonly seek: (t: number) => void,
  ) {
    const all = quantities(state.scene);
    const choices = element("div", { class: "choices", role: "group", "aria-label": "Plots" });
    for (const quantity of all) {
      const button = element("button", { type: "button", "aria-pressed": "false", click: () => this.toggle(quantity) }, quantity.name);
      this.buttons.set(quantity.name, button);
      choices.append(button);
    }
    const of = element(
      "select",
      { "aria-label": "Curves of", change: () => this.choose((this.ofChosen = of.value === "chosen"), all) },
      element("option", { value: "every" }, "every body"),
      element("option", { value: "chosen" }, "the chosen body"),
    );
    choices.append(element("span", { class: "curves-of" }, "curves of", of));
    place.append(choices, this.drawings);
    for (const quantity of all.filter(({ name }) => /^q\b/.test(name) || name === "energy").slice(0, 3)) this.toggle(quantity);
    if (window.innerHeight < 700 || window.innerWidth < 760) all.slice(1).forEach((q) => this.drawn.has(q.name) && this.toggle(q));
    state.onChange(() => {
      if (this.ofChosen) this.choose(true, all);
      this.moveCursors();
    });
    new ResizeObserver(() => this.resize()).observe(this.drawings);
  }

  /** Draws the curves of the chosen body or of every body. */
  private choose(ofChosen: boolean, all: readonly Quantity[]): void {
    const body = ofChosen ? this.state.selected : null;
    if (body === this.body) return;
    this.body = body;
    for (const quantity of all) {
      if (!this.drawn.has(quantity.name)) continue;
      this.toggle(quantity);
      this.toggle(quantity);
    }
  }

  private toggle(quantity: Quantity): void {
    const found = this.drawn.get(quantity.name);
    this.buttons.get(quantity.name)!.setAttribute("aria-pressed", String(!found));
    if (found) {
      found.plot.destroy();
      found.box.remove();
      this.drawn.delete(quantity.name);
    } else {
      this.draw(quantity);
    }
    this.drawings.hidden = this.drawn.size === 0;
    this.resize();
  }

  private draw(quantity: Quantity): void {
    const { name, unit } = quantity;
    const curves = drawnCurves(quantity, this.body);
    const stroke = strokes(curves);
    const all = quantity.curves.length;
    const chosen = curves.length < all && this.body === null ? `; the ${curves.length} of ${all} that change most` : "";
    const box = element("div", { class: "drawing", role: "img", "aria-label": `${name} over time` });
    this.drawings.append(box);
    const text = () => getComputedStyle(document.documentElement).getPropertyValue("--soft");
    const line = () => getComputedStyle(document.documentElement).getPropertyValue("--line");
    const axis = { stroke: text, grid: { stroke: line, width: 1 }, ticks: { stroke: line, width: 1, size: 4 }, font: "11px system-ui, sans-serif" };
    const tick = (_: uPlot, ticks: number[], _axis: number, _space: number, step: number) => ticks.map((x) => tickText(x, step));
    const plot = new uPlot(
      {
        title: (unit && !name.endsWith(unit) ? `${name}, ${unit}` : name) + chosen,
        width: Math.max(200, box.clientWidth),
        height: HEIGHT,
        legend: { live: false },
        cursor: { drag: { x: false, y: false, setScale: false }, points: { show: false }, y: false },
        scales: { x: { time: false } },
        axes: [
          { ...axis, size: 26, values: tick },
          { ...axis, size: (_, texts) => Math.max(40, 16 + 6.6 * Math.max(0, ...(texts ?? []).map((text) => text.length))), values: tick },
        ],
        series: [
          { label: "t" },
          ...curves.map(({ label }, k) => ({
            label,
            stroke: stroke[k],
            width: 1.4,
            pxAlign: 0,
            points: { show: false },
          })),
        ],
      },
      [this.state.scene.motion!.t, ...curves.map(({ values }) => values)],
      box,
    );
    const cursor = element("div", { class: "cursor" });
    plot.over.append(cursor);
    const follow = (event: PointerEvent) => this.seek(plot.posToVal(event.clientX - plot.over.getBoundingClientRect().left, "x"));
    plot.over.addEventListener("pointerdown", (event) => {
      plot.over.setPointerCapture(event.pointerId);
      follow(event);
    });
    plot.over.addEventListener("pointermove", (event) => event.buttons & 1 && follow(event));
    this.drawn.set(name, { plot, cursor, box });
    this.moveCursors();
  }

  /** Draws anew in the colours of the page. */
  repaint(): void {
    for (const { plot } of this.drawn.values()) plot.redraw(false, true);
  }

  private resize(): void {
    for (const { plot, box } of this.drawn.values()) {
      if (box.clientWidth > 0 && box.clientWidth !== plot.width) plot.setSize({ width: box.clientWidth, height: HEIGHT });
    }
    this.moveCursors();
  }

  private moveCursors(): void {
    for (const { plot, cursor } of this.drawn.values()) {
      cursor.style.transform = `translateX(${plot.valToPos(this.state.t, "x")}px)`;
      cursor.style.opacity = this.state.moment ? "1" : "0.3";
    }
  }
}
