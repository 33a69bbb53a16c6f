/** The parts of the full resolution, in each direction, that may be used. */
const SCALES = [1, 0.75, 0.5];
const COARSEST = SCALES.length - 1;
/** The longest time that a frame may take, in milliseconds. */
const BUDGET = 28;
/** The median of this many frames counts, so that a single late frame changes nothing. */
const FRAMES = 5;
/** The coarsest resolution is kept if frames then take at most this part of their time at the full one. */
const WORTHWHILE = 0.9;
/**
 * If it was not kept, as on a screen with 30 frames a second, it is tried again when frames take this many
 * times as long.
 */
const LONGER = 1.5;

/**
 * Chooses the resolution at which the scene is drawn while it moves. If frames take too long the resolution
 * is reduced step by step; if that did not help, it is the full one again. Between two rests it goes down and
 * back at most once, so that nothing flickers.
 */
export class Resolution {
  private step = 0;
  private times: number[] = [];
  private timeAtFull = 0;
  private timeInVain = 0;
  private settled = false;

  get scale(): number {
    return SCALES[this.step];
  }

  /** Notes the time that a frame took, in milliseconds. Returns whether the scale has changed. */
  took(time: number): boolean {
    if (this.settled) return false;
    this.times.push(time);
    if (this.times.length < FRAMES) return false;
    const median = this.times.sort((a, b) => a - b)[FRAMES >> 1];
    this.times = [];
    const before = this.step;
    if (before === 0) this.timeAtFull = median;
    if (before === COARSEST) {
      this.settled = true;
      if (median > WORTHWHILE * this.timeAtFull) {
        this.step = 0;
        this.timeInVain = this.timeAtFull;
      }
    } else if (median > BUDGET && (before > 0 || median > LONGER * this.timeInVain)) {
      ++this.step;
    }
    return this.step !== before;
  }

  /** Returns to the full resolution, because nothing moves. Returns whether the scale has changed. */
  rest(): boolean {
    const coarse = this.step > 0;
    this.step = 0;
    this.times = [];
    this.settled = false;
    return coarse;
  }
}
