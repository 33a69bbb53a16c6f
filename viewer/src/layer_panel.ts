import { element, freshId } from "./element";
import type { Layer } from "./layers";
import { representations, type Representation } from "./screws";
import type { State } from "./state";

/** Fills the panel with switches of all layers, and settings of how their symbols are drawn. */
export function fillLayerPanel(panel: HTMLElement, layers: readonly Layer[], state: State, setLayer: (id: string, on: boolean) => void): () => void {
  const rows = layers.map((layer) => {
    const id = freshId();
    const box = element("input", { type: "checkbox", id, change: () => setLayer(layer.id, box.checked) });
    const swatch = element("span", { class: "swatch", "aria-hidden": "true" });
    swatch.style.background = layer.swatch;
    const hint = element("span", { class: "hint", id: freshId() });
    box.setAttribute("aria-describedby", hint.id);
    panel.append(element("div", { class: "layer" }, box, swatch, element("label", { for: id }, layer.title), hint));
    return { layer, box, hint };
  });
  panel.append(element("h3", {}, "Symbols"), size("size of symbols", (x) => (state.symbolScale = x), state));
  if (state.scene.motion) {
    panel.append(size("length of arrows", (x) => (state.arrowScale = x), state), ...arrowChoices(state));
  }
  return () => {
    for (const { layer, box, hint } of rows) {
      box.checked = layer.on;
      const text = layer.on || !layer.id.match(/axode|axis|traces|twists|wrenches|loads|forces|momenta/) ? layer.hint() : "";
      if (hint.textContent !== text) hint.textContent = text;
    }
  };
}

function size(title: string, set: (factor: number) => void, state: State): HTMLElement {
  const id = freshId();
  const slider = element("input", {
    type: "range",
    id,
    min: -2,
    max: 2,
    step: 0.1,
    value: 0,
    input: () => {
      set(2 ** Number(slider.value));
      state.changed();
    },
  });
  return element("div", { class: "row" }, element("label", { for: id }, title), slider);
}

function arrowChoices(state: State): HTMLElement[] {
  const [ofId, asId] = [freshId(), freshId()];
  const of = element(
    "select",
    {
      id: ofId,
      change: () => {
        state.everyBody = of.value === "every";
        state.changed();
      },
    },
    element("option", { value: "chosen" }, "the chosen body"),
    element("option", { value: "every" }, "every body"),
  );
  const as = representationChoice(state, asId);
  return [
    element("div", { class: "row" }, element("label", { for: ofId }, "arrows of"), of),
    element("div", { class: "row" }, element("label", { for: asId }, "representation"), as),
  ];
}

/**
 * A choice of the representation of twists, wrenches and momenta. There may be several such elements; all
 * show the same choice.
 */
export function representationChoice(state: State, id: string): HTMLSelectElement {
  const options = Object.entries(representations).map(([key, { title }]) => element("option", { value: key }, title));
  const choice = element(
    "select",
    {
      id,
      change: () => {
        state.representation = choice.value as Representation;
        state.changed();
      },
    },
    ...options,
  );
  const show = () => {
    choice.value = state.representation;
  };
  show();
  state.onChange(show);
  return choice;
}
