/** The colours of what is drawn. The colours of the page around it are in page.css. */
export interface Palette {
  back: string;
  grid: string;
  text: string;
  halo: string;
}

export const palettes: Record<"light" | "dark", Palette> = {
  light: { back: "#f4f6f8", grid: "#8b98a6", text: "#1d2630", halo: "#f4f6f8" },
  dark: { back: "#14181d", grid: "#66737f", text: "#e4e9ee", halo: "#14181d" },
};

export const colors = {
  x: "#d8434f",
  y: "#2f9e58",
  z: "#3672d9",
  bodies: ["#6d97bd", "#d3c08a", "#86b59a", "#c79686", "#9c93c4", "#77b3b8", "#c4a5bd", "#a8b27c"],
  ground: "#7b858f",
  collision: "#d98b2b",
  chosen: "#ffb454",
  driven: "#e08a1e",
  passive: "#8b95a0",
  coupled: "#8d63c9",
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
