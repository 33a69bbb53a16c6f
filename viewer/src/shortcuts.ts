import { byId, element } from "./element";

export interface Shortcut {
  /** As KeyboardEvent.key has it. */
  key: string;
  /** As people read it. */
  shown: string;
  does: string;
  run: () => void;
}

/** Keys of the whole page, and the panel that lists them. Where something takes text or arrows, they stay its own. */
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
