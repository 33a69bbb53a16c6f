import { Color } from "three";

/** The colours of what is drawn. The colours of the page around it are in page.css. */
export interface Palette {
  back: string;
  grid: string;
  text: string;
  halo: string;
  /** Edges around bodies. */
  edge: string;
}

export const palettes: Record<"light" | "dark", Palette> = {
  light: { back: "#f4f6f8", grid: "#8b98a6", text: "#1d2630", halo: "#f4f6f8", edge: "#2b333c" },
  dark: { back: "#14181d", grid: "#66737f", text: "#e4e9ee", halo: "#14181d", edge: "#07090b" },
};

export const colors = {
  x: "#d8434f",
  y: "#2f9e58",
  z: "#3672d9",
  bodies: ["#6d97bd", "#d3c08a", "#86b59a", "#c79686", "#9c93c4", "#77b3b8", "#c4a5bd", "#a8b27c"],
  /** The first ones have the hues of the colours of bodies, in their order. */
  curves: ["#3b82c4", "#d9a21b", "#2f9e58", "#d05a3a", "#7d63c9", "#1795a3", "#d66fb0", "#8a9a22", "#5f6b76", "#8c5a2f"],
  ground: "#7b858f",
  collision: "#d98b2b",
  chosen: "#ffb454",
  driven: "#e08a1e",
  passive: "#8b95a0",
  coupled: "#8d63c9",
  rod: "#9aa3ad",
  belt: "#3a424b",
  loop: "#b8479e",
  open: "#e02f2f",
  spring: "#4f7d3c",
  trace: "#2a62c9",
  whole: "#0b8f8a",
  ellipsoid: "#6c8cd5",
  screw: "#e0457b",
  fixedAxode: ["#1f6fb5", "#37b8b0"],
  movingAxode: ["#e8a02c", "#d8476a"],
  twists: ["#3c7ae0", "#19a7c4"],
  wrenches: ["#c93f86", "#e0632f"],
  momenta: ["#5a9a2c", "#9bb01f"],
  contacts: {
    open: { color: "#9aa3ad", name: "grey" },
    stick: { color: "#2f9e58", name: "green" },
    slide: { color: "#e0632f", name: "orange" },
  },
} as const;

/** Changes of hue and lightness for the first bodies that share a colour, for the second ones, and so on. */
const SHADES = [[0, 0], [0.03, -0.11], [-0.04, 0.09], [0.06, -0.17], [-0.06, -0.05]] as const;

/** A colour for body i > 0, made from one of as many colours as there are for bodies. */
function shade(of: readonly string[], body: number): string {
  const count = colors.bodies.length;
  const [hue, light] = SHADES[Math.floor((body - 1) / count) % SHADES.length];
  return hue === 0 ? of[(body - 1) % count] : `#${new Color(of[(body - 1) % count]).offsetHSL(hue, 0, light).getHexString()}`;
}

/** The colour of a body whose shapes have no colour of their own. */
export function colorOfBody(body: number): string {
  return body === 0 ? colors.ground : shade(colors.bodies, body);
}

/** The colour of the curves of body i > 0. */
export function strokeOfBody(body: number): string {
  return shade(colors.curves, body);
}
