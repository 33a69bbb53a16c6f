import { byId, element } from "./element";

/** Lists warnings in a tab that exists only if there are some. Returns the function that adds a warning. */
export function fillWarnings(panel: HTMLElement, given: readonly string[]): (text: string) => void {
  const known = new Set<string>();
  const list = element("ul");
  panel.append(list);
  const tab = byId("tab-warnings");
  tab.hidden = true;
  const add = (text: string) => {
    if (known.has(text)) return;
    known.add(text);
    list.append(element("li", {}, text));
    tab.textContent = `Warnings (${known.size})`;
    tab.hidden = false;
  };
  given.forEach(add);
  return add;
}
