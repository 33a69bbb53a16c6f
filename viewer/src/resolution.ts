/** Parts of the full resolution, in each direction. */
const SCALES = [1, 0.75, 0.5];
const COARSEST = SCALES.length - 1;
/** A frame may take so many milliseconds. */
const BUDGET = 28;
/** Of so many frames the median counts, so that one which is late for reasons of its own changes nothing. */
const FRAMES = 5;
/** The coarsest resolution is kept where frames take at most this part of their time at the full one. */
const WORTHWHILE = 0.9;
/** Where they did not, as on a screen of 30 frames a second, it is tried again where frames take so many times as long. */
const LONGER = 1.5;

/** At which part of the full resolution something is drawn while it moves: at less, step by step, where frames take too long, and
 * at all of it again where that did not help. From one rest to the next it goes down and back once at most, so that nothing
 * flickers. */
export class Resolution {
  private step = 0;
  private times: number[] = [];
  private timeAtFull = 0;
  private timeInVain = 0;
  private settled = false;

  get scale(): number {
    return SCALES[this.step];
  }

  /** Takes how long a frame took, in milliseconds; says whether the scale is another one now. */
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

  /** Full resolution, since nothing moves; says whether it was another one. */
  rest(): boolean {
    const coarse = this.step > 0;
    this.step = 0;
    this.times = [];
    this.settled = false;
    return coarse;
  }
}
