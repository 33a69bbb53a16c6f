type Properties = Record<string, string | number | boolean | ((event: Event) => void)>;

/**
 * An element with attributes, listeners (functions) and children; text is put in as text, never as markup.
 */
export function element<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  properties: Properties = {},
  ...children: (Node | string)[]
): HTMLElementTagNameMap[K] {
  const made = document.createElement(tag);
  for (const [key, value] of Object.entries(properties)) {
    if (typeof value === "function") made.addEventListener(key, value);
    else if (typeof value === "boolean") made.toggleAttribute(key, value);
    else made.setAttribute(key, String(value));
  }
  made.append(...children);
  return made;
}

/** The element of the page with this id. */
export function byId<T extends HTMLElement>(id: string): T {
  return document.getElementById(id) as T;
}

let last = 0;
/** An id that no other element of the page has. */
export function freshId(): string {
  return `e${++last}`;
}

/**
 * A number as text: four significant digits, a true minus sign, and 0 for numbers that are rounding errors.
 */
export function format(x: number): string {
  if (!Number.isFinite(x)) return "∞";
  const magnitude = Math.abs(x);
  if (magnitude < 1e-12) return "0";
  const text = magnitude < 1e-3 || magnitude >= 1e5 ? x.toExponential(3) : String(Number(x.toPrecision(4)));
  return text.replaceAll("-", "−");
}

/** A number of things in words. */
export function count(n: number, what: string, many = `${what}s`): string {
  return `${n} ${n === 1 ? what : many}`;
}
