import { byId, element } from "./element";

export interface Shortcut {
  /** The key as KeyboardEvent.key names it. */
  key: string;
  /** The key as it is shown to people. */
  shown: string;
  does: string;
  run: () => void;
}

/**
 * Handles the keys of the whole page, and makes the panel that lists them. An element that takes text or
 * arrow keys keeps these keys for itself.
 */
export function listen(shortcuts: readonly Shortcut[]): void {
  const list = byId("keys");
  for (const { shown, does } of shortcuts) {
    list.append(element("dt", {}, element("kbd", {}, shown)), element("dd", {}, does));
  }
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || byId<HTMLDialogElement>("help").open) return;
    const target = event.target as HTMLElement;
    const takesText = target instanceof HTMLInputElement && target.type === "number";
    const takesArrows = target instanceof HTMLInputElement || target instanceof HTMLSelectElement || target.getAttribute("role") === "tab";
    const pressed = target instanceof HTMLButtonElement || (target instanceof HTMLInputElement && target.type === "checkbox");
    if (takesText || target instanceof HTMLSelectElement) return;
    if (takesArrows && /^(Arrow|Home|End|Page)/.test(event.key)) return;
    if (pressed && event.key === " ") return;
    const key = event.shiftKey && event.key.startsWith("Arrow") ? `Shift+${event.key}` : event.key;
    const found = shortcuts.find((shortcut) => shortcut.key === key);
    if (!found) return;
    event.preventDefault();
    found.run();
  });
}
