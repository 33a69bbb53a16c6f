import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import { element } from "./element";
import { degrees, type Scene } from "./scene";
import type { State } from "./state";

interface Quantity {
  name: string;
  unit: string;
  labels: string[];
  values: number[][];
}

const STROKES = ["#3b82c4", "#e08a1e", "#2f9e58", "#d8434f", "#8d63c9", "#8c6d4f", "#d66fb0", "#7f8a95", "#a7a32b", "#19a7c4"];
const HEIGHT = 150;

/** The units of these numbers, each of them once. */
function unitsOf(scene: Scene, which: "velocity" | "force"): string {
  const units = scene.bodies.slice(1).flatMap(({ joint }) => (joint.nv > 0 ? degrees(joint.kind).map((d) => d[which]) : []));
  return [...new Set(units)].join(", ");
}

function unitsOfCoordinates(scene: Scene): string {
  const units = scene.bodies.slice(1).flatMap(({ joint }) => {
    if (joint.nq === 0) return [];
    const each = degrees(joint.kind).map((d) => d.coordinate);
    return joint.kind === "spherical" ? ["–"] : joint.kind === "free" ? ["–", ...each.slice(3)] : each;
  });
  return [...new Set(units)].join(", ");
}

function quantities(scene: Scene): Quantity[] {
  const motion = scene.motion!;
  const all: Quantity[] = [];
  if (scene.nq > 0) all.push({ name: "q", unit: unitsOfCoordinates(scene), labels: scene.coordinate_names, values: motion.q });
  if (scene.nv > 0) all.push({ name: "v", unit: unitsOf(scene, "velocity"), labels: scene.velocity_names, values: motion.v });
  if (scene.nv > 0 && motion.tau) all.push({ name: "tau", unit: unitsOf(scene, "force"), labels: scene.velocity_names, values: motion.tau });
  return [...all, ...motion.series];
}

/** A number beside an axis, with as many digits as its neighbours need to differ. */
function tickText(x: number, step: number): string {
  if (Math.abs(x) < 1e-9 * step) return "0";
  const decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const text = decimals > 5 || Math.abs(x) >= 1e6 ? x.toExponential(Math.min(8, Math.max(0, Math.round(Math.log10(Math.abs(x) / step))))) : x.toFixed(decimals);
  return text.replace("-", "−");
}

/** Plots over time, each of which can be switched off. A click or drag in a plot moves the time cursor. */
export class Plots {
  private readonly drawn = new Map<string, { plot: uPlot; cursor: HTMLElement; box: HTMLElement }>();
  private readonly drawings = element("div", { class: "drawings" });
  private readonly buttons = new Map<string, HTMLButtonElement>();

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
    place.append(choices, this.drawings);
    for (const quantity of all.filter(({ name }) => name === "q" || name === "energy")) this.toggle(quantity);
    if (window.innerHeight < 700 || window.innerWidth < 760) all.slice(1).forEach((q) => this.drawn.has(q.name) && this.toggle(q));
    state.onChange(() => this.moveCursors());
    new ResizeObserver(() => this.resize()).observe(this.drawings);
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

  private draw({ name, unit, labels, values }: Quantity): void {
    const box = element("div", { class: "drawing", role: "img", "aria-label": `${name} over time` });
    this.drawings.append(box);
    const text = () => getComputedStyle(document.documentElement).getPropertyValue("--soft");
    const line = () => getComputedStyle(document.documentElement).getPropertyValue("--line");
    const axis = { stroke: text, grid: { stroke: line, width: 1 }, ticks: { stroke: line, width: 1, size: 4 }, font: "11px system-ui, sans-serif" };
    const tick = (_: uPlot, ticks: number[], _axis: number, _space: number, step: number) => ticks.map((x) => tickText(x, step));
    const plot = new uPlot(
      {
        title: unit ? `${name}, ${unit}` : name,
        width: Math.max(200, box.clientWidth),
        height: HEIGHT,
        legend: { live: false },
        cursor: { drag: { x: false, y: false, setScale: false }, points: { show: false }, y: false },
        scales: { x: { time: false } },
        axes: [
          { ...axis, size: 26, values: tick },
          { ...axis, size: 56, values: tick },
        ],
        series: [
          { label: "t" },
          ...labels.map((label, k) => ({
            label,
            stroke: STROKES[k % STROKES.length],
            width: 1.4,
            pxAlign: 0,
            points: { show: false },
            dash: k < STROKES.length ? [] : [4 + 2 * Math.floor(k / STROKES.length), 3],
          })),
        ],
      },
      [this.state.scene.motion!.t, ...labels.map((_, k) => values.map((sample) => sample[k]))],
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
