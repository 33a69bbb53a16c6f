import { CanvasTexture, Group, Matrix4, Sprite, SpriteMaterial, SRGBColorSpace, Vector3 } from "three";
import type { Palette } from "./palette";
import type { Stage } from "./stage";

const FONT = '600 26px system-ui, "Segoe UI", Roboto, "DejaVu Sans", sans-serif';
const HEIGHT = 44;
/** The distance of two lines of text on the screen, in pixels. */
const ROW = 0.36 * HEIGHT;

interface Label {
  text: string;
  body: number;
  at: Vector3;
}

/** Names beside things, in a constant size on the screen. */
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

  /**
   * Places each name beside its thing, or below it, or hides it if other names are in the way. Earlier names
   * have precedence.
   */
  place(poses: readonly Matrix4[], { camera, canvas, pixel }: Stage): void {
    camera.updateMatrixWorld();
    const seen = new Vector3();
    const places = this.labels.map(({ body, at }, k) => {
      const sprite = this.sprites[k];
      sprite.position.copy(at).applyMatrix4(poses[body]);
      const { x, y, z } = seen.copy(sprite.position).project(camera);
      return {
        x: (0.5 + 0.5 * x) * canvas.clientWidth,
        y: (0.5 - 0.5 * y) * canvas.clientHeight,
        width: Math.abs(z) <= 1 ? sprite.userData.width / 2 : 0,
      };
    });
    rowsOf(places, ROW).forEach((row, k) => {
      const sprite = this.sprites[k];
      sprite.visible = row !== null;
      sprite.center.set(-12 / sprite.userData.width, 0.5 + ((row ?? 0) * ROW) / (HEIGHT / 2));
      sprite.scale.set((sprite.userData.width / 2) * pixel, (HEIGHT / 2) * pixel, 1);
    });
  }
}

/** The left end and the width of a text on the screen, in pixels. The width is 0 if the text is not seen. */
interface Place {
  x: number;
  y: number;
  width: number;
}

/**
 * For each text, by how many rows it is moved down, so that it covers none of the texts before it. Texts may
 * move only below texts at the same place. If others are in the way the entry is null, because farther away
 * the text would seem to name something else.
 */
export function rowsOf(places: readonly Place[], height: number): (number | null)[] {
  const taken = new Map<number, (Place & { row: number })[]>(); // by height
  return places.map(({ x, y, width }) => {
    if (!(width > 0)) return 0;
    for (let row = 0; ; ++row) {
      const here = y + row * height;
      const cell = Math.floor(here / height);
      const near = [cell - 1, cell, cell + 1].flatMap((k) => taken.get(k) ?? []);
      const hit = near.filter((it) => Math.abs(it.y - here) < 0.999 * height && it.x < x + width && x < it.x + it.width);
      if (hit.length === 0) {
        taken.set(cell, [...(taken.get(cell) ?? []), { x, y: here, width, row }]);
        return row;
      }
      if (!hit.every((it) => Math.hypot(it.x - x, it.y - it.row * height - y) < 1)) return null;
    }
  });
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
