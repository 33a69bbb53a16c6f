import { CanvasTexture, Group, Matrix4, Sprite, SpriteMaterial, SRGBColorSpace, Vector3 } from "three";
import type { Palette } from "./palette";

const FONT = '600 26px system-ui, "Segoe UI", Roboto, "DejaVu Sans", sans-serif';
const HEIGHT = 44;

interface Label {
  text: string;
  body: number;
  at: Vector3;
}

/** Names beside things, of one size on the screen. */
export class Labels extends Group {
  private sprites: Sprite[] = [];

  constructor(private readonly labels: Label[]) {
    super();
  }

  /** Draws the texts anew, in the colours of a palette. */
  paint(palette: Palette): void {
    for (const sprite of this.sprites) {
      sprite.material.map?.dispose();
      sprite.material.dispose();
    }
    this.sprites = this.labels.map(({ text }) => written(text, palette));
    this.clear();
    if (this.sprites.length > 0) this.add(...this.sprites);
  }

  place(poses: readonly Matrix4[], pixel: number): void {
    const taken = new Map<string, number>();
    this.labels.forEach(({ body, at }, k) => {
      const sprite = this.sprites[k];
      sprite.position.copy(at).applyMatrix4(poses[body]);
      // Names of one and the same place stand below each other.
      const place = sprite.position.toArray().map((x) => x.toFixed(4)).join();
      const above = taken.get(place) ?? 0;
      taken.set(place, above + 1);
      sprite.center.set(-12 / sprite.userData.width, 0.5 + 0.72 * above);
      sprite.scale.set((sprite.userData.width / 2) * pixel, (HEIGHT / 2) * pixel, 1);
    });
  }
}

function written(text: string, palette: Palette): Sprite {
  const canvas = document.createElement("canvas");
  const context = canvas.getContext("2d")!;
  context.font = FONT;
  const shown = text.length > 60 ? `${text.slice(0, 59)}…` : text;
  const width = Math.ceil(context.measureText(shown).width) + 16;
  canvas.width = width;
  canvas.height = HEIGHT;
  context.font = FONT;
  context.textBaseline = "middle";
  context.lineJoin = "round";
  context.lineWidth = 7;
  context.strokeStyle = palette.halo;
  context.globalAlpha = 0.85;
  context.strokeText(shown, 8, HEIGHT / 2);
  context.globalAlpha = 1;
  context.fillStyle = palette.text;
  context.fillText(shown, 8, HEIGHT / 2);
  const map = new CanvasTexture(canvas);
  map.colorSpace = SRGBColorSpace;
  const sprite = new Sprite(new SpriteMaterial({ map, sizeAttenuation: false, depthTest: false, depthWrite: false }));
  sprite.renderOrder = 10;
  sprite.userData.width = width;
  return sprite;
}
