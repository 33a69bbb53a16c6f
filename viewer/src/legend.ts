import { element } from "./element";
import type { Layer } from "./layers";
import type { Stage } from "./stage";

/** The longest bar of the legend, in pixels. */
const LONGEST = 110;

/** The largest number of the form 1, 2 or 5 times a power of ten that is not larger than x. */
export function round125(x: number): number {
  const power = 10 ** Math.floor(Math.log10(x) + 1e-12);
  return power * (x >= 5 * power ? 5 : x >= 2 * power ? 2 : 1);
}

/**
 * Fills the legend of the arrows that are drawn: for each colour a bar as long as an arrow of a round number
 * at the point at which the camera looks, with the name of the layer if there are several. Returns the function that
 * updates it.
 */
export function fillLegend(place: HTMLElement, layers: readonly Layer[], stage: Stage): () => void {
  let written = "";
  return () => {
    const pixel = stage.pixel * stage.distance;
    const entries = layers.flatMap((layer) => (layer.on && layer.scales ? layer.scales().map((scale) => ({ ...scale, title: layer.title })) : []));
    const several = new Set(entries.map(({ title }) => title)).size > 1;
    const bars = entries.map(({ color, heads, unit, each, clips, title }) => {
      const value = round125(LONGEST * pixel * each);
      return { color, heads, title, text: `${value < 1e-3 || value >= 1e5 ? value.toExponential(0) : value} ${unit}${clips ? ", longer arrows clipped" : ""}${several ? ` (${title.toLowerCase()})` : ""}`, length: value / (each * pixel) };
    });
    const now = JSON.stringify(bars);
    if (now === written) return;
    written = now;
    place.hidden = bars.length === 0;
    place.replaceChildren(
      ...bars.map(({ color, heads, title, text, length }) => {
        const bar = element("i", { class: heads === 2 ? "arrow two" : "arrow", "aria-hidden": "true" });
        bar.style.width = `${length.toFixed(0)}px`;
        bar.style.color = color;
        return element("li", { title }, bar, element("span", {}, text));
      }),
    );
  };
}
