import { byId, element } from "./element";

/**
 * Makes the tabs of the panel. `shown` is called after another tab was shown. Returns the function that shows
 * a tab.
 */
export function makeTabs(titles: Record<string, string>, shown: () => void): (id: string, focus?: boolean) => void {
  const list = byId("tabs");
  const ids = Object.keys(titles);
  const show = (id: string, focus = false) => {
    for (const other of ids) {
      const tab = byId(`tab-${other}`);
      tab.setAttribute("aria-selected", String(other === id));
      tab.tabIndex = other === id ? 0 : -1;
      byId(other).hidden = other !== id;
    }
    if (focus) byId(`tab-${id}`).focus();
    shown();
  };
  list.append(
    ...ids.map((id, k) =>
      element(
        "button",
        {
          type: "button",
          role: "tab",
          id: `tab-${id}`,
          "aria-controls": id,
          click: () => show(id),
          keydown: (event) => {
            const step = { ArrowLeft: -1, ArrowRight: 1 }[(event as KeyboardEvent).key];
            if (step === undefined) return;
            event.preventDefault();
            show(ids[(k + step + ids.length) % ids.length], true);
          },
        },
        titles[id],
      ),
    ),
  );
  show(ids[0]);
  return show;
}
