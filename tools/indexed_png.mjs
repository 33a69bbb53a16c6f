/** Pictures and moving pictures (APNG) of at most 255 colours, from frames of RGBA bytes. */
import { deflateSync } from "node:zlib";

const BITS = 5;
const cell = (r, g, b) => ((r >> (8 - BITS)) << (2 * BITS)) | ((g >> (8 - BITS)) << BITS) | (b >> (8 - BITS));

/** How many pixels of the frames are in each cell of colours, with the sums of their colours. */
function histogram(frames) {
  const cells = new Map();
  for (const frame of frames) {
    for (let k = 0; k < frame.length; k += 4) {
      const key = cell(frame[k], frame[k + 1], frame[k + 2]);
      const found = cells.get(key) ?? [0, 0, 0, 0];
      found[0] += 1;
      for (let c = 0; c < 3; ++c) found[c + 1] += frame[k + c];
      cells.set(key, found);
    }
  }
  return [...cells].map(([key, [count, ...sums]]) => ({ key, weight: Math.sqrt(count), color: sums.map((sum) => sum / count) }));
}

/**
 * Colours by median cut, in which rare colours count more than
 * their pixels, and the index of the colour of each cell.
 */
function palette(frames, most) {
  const boxes = [histogram(frames)];
  const spread = (box) => [0, 1, 2].map((c) => Math.max(...box.map((x) => x.color[c])) - Math.min(...box.map((x) => x.color[c])));
  const worth = (box) => (box.length < 2 ? 0 : Math.max(...spread(box)) * Math.sqrt(box.reduce((sum, x) => sum + x.weight, 0)));
  const worths = boxes.map(worth);
  while (boxes.length < most) {
    const k = worths.indexOf(Math.max(...worths));
    if (worths[k] === 0) break;
    const widths = spread(boxes[k]);
    const c = widths.indexOf(Math.max(...widths));
    const sorted = boxes[k].sort((a, b) => a.color[c] - b.color[c]);
    const half = sorted.reduce((sum, x) => sum + x.weight, 0) / 2;
    let at = 0;
    for (let sum = 0; at < sorted.length - 1 && sum < half; ++at) sum += sorted[at].weight;
    at = Math.max(1, Math.min(at, sorted.length - 1));
    const parts = [sorted.slice(0, at), sorted.slice(at)];
    boxes.splice(k, 1, ...parts);
    worths.splice(k, 1, ...parts.map(worth));
  }
  const indices = new Map();
  const colors = boxes.map((box, k) => {
    for (const { key } of box) indices.set(key, k);
    const weight = box.reduce((sum, x) => sum + x.weight, 0);
    return [0, 1, 2].map((c) => Math.round(box.reduce((sum, x) => sum + x.weight * x.color[c], 0) / weight));
  });
  return { colors, indices };
}

const CRC = Uint32Array.from({ length: 256 }, (_, n) => {
  let c = n;
  for (let k = 0; k < 8; ++k) c = c & 1 ? 0xedb88320 ^ (c >>> 1) : c >>> 1;
  return c;
});

function chunk(type, data) {
  const body = Buffer.concat([Buffer.from(type, "latin1"), data]);
  let crc = 0xffffffff;
  for (const byte of body) crc = CRC[(crc ^ byte) & 255] ^ (crc >>> 8);
  const out = Buffer.alloc(body.length + 8);
  out.writeUInt32BE(data.length, 0);
  body.copy(out, 4);
  out.writeUInt32BE((crc ^ 0xffffffff) >>> 0, body.length + 4);
  return out;
}

function integers(...values) {
  const out = Buffer.alloc(4 * values.length);
  values.forEach((value, k) => out.writeUInt32BE(value, 4 * k));
  return out;
}

/** The smallest rectangle with all pixels that differ from those of the frame before. */
function changed(indices, before, width, height) {
  let [left, top, right, bottom] = [width, height, -1, -1];
  for (let y = 0; y < height; ++y) {
    for (let x = 0; x < width; ++x) {
      if (before && indices[y * width + x] === before[y * width + x]) continue;
      [left, right] = [Math.min(left, x), Math.max(right, x)];
      [top, bottom] = [Math.min(top, y), Math.max(bottom, y)];
    }
  }
  return right < 0 ? { left: 0, top: 0, right: 0, bottom: 0 } : { left, top, right, bottom };
}

/**
 * A PNG of one frame, or an APNG of several that repeats
 * without end and shows each frame for `delay` milliseconds.
 */
export function indexedPng(frames, width, height, delay = 0) {
  const sample = frames.filter((_, k) => k % Math.ceil(frames.length / 8) === 0);
  const { colors, indices } = palette(sample, 255);
  const clear = colors.length;
  const known = (r, g, b) => {
    const key = cell(r, g, b);
    if (!indices.has(key)) {
      const far = ([x, y, z]) => (x - r) ** 2 + (y - g) ** 2 + (z - b) ** 2;
      indices.set(key, colors.reduce((best, color, k) => (far(color) < far(colors[best]) ? k : best), 0));
    }
    return indices.get(key);
  };
  const parts = [Buffer.from("\x89PNG\r\n\x1a\n", "latin1")];
  parts.push(chunk("IHDR", Buffer.concat([integers(width, height), Buffer.from([8, 3, 0, 0, 0])])));
  if (frames.length > 1) parts.push(chunk("acTL", integers(frames.length, 0)));
  parts.push(chunk("PLTE", Buffer.from([...colors.flat(), 255, 255, 255])));
  parts.push(chunk("tRNS", Buffer.from([...colors.map(() => 255), 0])));
  let before = null;
  let sequence = 0;
  for (const frame of frames) {
    const now = Uint8Array.from({ length: width * height }, (_, k) => known(frame[4 * k], frame[4 * k + 1], frame[4 * k + 2]));
    const { left, top, right, bottom } = changed(now, before, width, height);
    const rows = [];
    for (let y = top; y <= bottom; ++y) {
      const row = Buffer.alloc(right - left + 2);
      for (let x = left; x <= right; ++x) {
        const at = y * width + x;
        row[x - left + 1] = before && now[at] === before[at] ? clear : now[at];
      }
      rows.push(row);
    }
    const data = deflateSync(Buffer.concat(rows), { level: 9 });
    if (frames.length > 1) {
      const place = integers(sequence++, right - left + 1, bottom - top + 1, left, top);
      parts.push(chunk("fcTL", Buffer.concat([place, Buffer.from([delay >> 8, delay & 255, 1000 >> 8, 1000 & 255, 0, before ? 1 : 0])])));
    }
    parts.push(before ? chunk("fdAT", Buffer.concat([integers(sequence++), data])) : chunk("IDAT", data));
    before = now;
  }
  parts.push(chunk("IEND", Buffer.alloc(0)));
  return Buffer.concat(parts);
}
