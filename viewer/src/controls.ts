import { byId, element } from "./element";
import type { Player } from "./player";
import { listen, type Shortcut } from "./shortcuts";
import type { Stage } from "./stage";
import type { State } from "./state";

/** Keys and buttons of the page, and clicks into the view. */
export function control(state: State, stage: Stage, player: Player | null, showTab: (id: string, focus: boolean) => void, changeTheme: () => void): void {
  const { scene } = state;
  const savePng = async () => {
    const link = element("a", { href: URL.createObjectURL(await stage.png()), download: `${scene.name}.png` });
    link.click();
    window.setTimeout(() => URL.revokeObjectURL(link.href), 10000);
  };
  const help = byId<HTMLDialogElement>("help");
  const turn = Math.PI / 24;
  const shortcuts: (Shortcut | false)[] = [
    player !== null && { key: " ", shown: "space", does: "play or pause", run: () => player.toggle() },
    player !== null && { key: "ArrowLeft", shown: "←", does: "one sample back", run: () => player.step(-1) },
    player !== null && { key: "ArrowRight", shown: "→", does: "one sample on", run: () => player.step(1) },
    player !== null && { key: "Home", shown: "Home", does: "to the start", run: () => player.toEnd(false) },
    player !== null && { key: "End", shown: "End", does: "to the end", run: () => player.toEnd(true) },
    { key: "f", shown: "f", does: "fit everything into the view", run: () => stage.fit() },
    { key: "1", shown: "1", does: "look along -x", run: () => stage.fit([1, 0, 0]) },
    { key: "2", shown: "2", does: "look along y", run: () => stage.fit([0, -1, 0]) },
    { key: "3", shown: "3", does: "look along -z", run: () => stage.fit([0, 0, 1]) },
    { key: "Shift+ArrowLeft", shown: "shift ←", does: "turn the view to the left", run: () => stage.orbit(-turn, 0) },
    { key: "Shift+ArrowRight", shown: "shift →", does: "turn the view to the right", run: () => stage.orbit(turn, 0) },
    { key: "Shift+ArrowUp", shown: "shift ↑", does: "look from higher", run: () => stage.orbit(0, turn) },
    { key: "Shift+ArrowDown", shown: "shift ↓", does: "look from lower", run: () => stage.orbit(0, -turn) },
    { key: "+", shown: "+", does: "nearer", run: () => stage.orbit(0, 0, 1.15) },
    { key: "-", shown: "−", does: "farther", run: () => stage.orbit(0, 0, 1 / 1.15) },
    { key: "j", shown: "j", does: "joints", run: () => showTab("joints", true) },
    { key: "l", shown: "l", does: "layers", run: () => showTab("layers", true) },
    { key: "b", shown: "b", does: "numbers of the chosen body", run: () => showTab("body", true) },
    { key: "n", shown: "n", does: "choose the next body", run: () => state.select((state.selected + 1) % scene.bodies.length) },
    { key: "d", shown: "d", does: "dark or light", run: () => changeTheme() },
    { key: "s", shown: "s", does: "save a PNG", run: () => void savePng() },
    { key: "?", shown: "?", does: "these keys", run: () => help.showModal() },
  ];
  listen(shortcuts.filter((shortcut) => shortcut !== false));
  byId("png").addEventListener("click", () => void savePng());
  byId("theme").addEventListener("click", () => changeTheme());
  byId("help-button").addEventListener("click", () => help.showModal());
  byId("fit").addEventListener("click", () => stage.fit());
  byId("view-x").addEventListener("click", () => stage.fit([1, 0, 0]));
  byId("view-y").addEventListener("click", () => stage.fit([0, -1, 0]));
  byId("view-z").addEventListener("click", () => stage.fit([0, 0, 1]));

  // A click, not a drag, chooses a body.
  let pressed = { x: 0, y: 0 };
  stage.canvas.addEventListener("pointerdown", (event) => (pressed = { x: event.offsetX, y: event.offsetY }));
  stage.canvas.addEventListener("pointerup", (event) => {
    if (event.button !== 0 || Math.hypot(event.offsetX - pressed.x, event.offsetY - pressed.y) > 4) return;
    const body = stage.pick(event.offsetX, event.offsetY);
    if (body !== null) state.select(body);
  });
}
