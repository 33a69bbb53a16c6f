import { element, format, freshId } from "./element";
import type { State } from "./state";

/** While a motion plays, its time is written once in this many milliseconds: each writing takes a layout of the page. */
const WRITING = 50;
const SPEEDS = [0.05, 0.1, 0.25, 0.5, 1, 2, 5, 10];

/** Plays a motion. It has the time cursor and the controls that move it. */
export class Player {
  playing = false;
  private loop = true;
  private speed = 1;
  private last = 0;
  /** When the time was last written. */
  private written = 0;
  private readonly start: number;
  private readonly end: number;
  private readonly button: HTMLButtonElement;
  private readonly scrub: HTMLInputElement;
  private readonly clock: HTMLOutputElement;
  private readonly spoken: HTMLElement;

  constructor(
    bar: HTMLElement,
    private readonly state: State,
  ) {
    const { t } = state.scene.motion!;
    [this.start, this.end] = [t[0], t[t.length - 1]];
    this.button = element("button", { type: "button", id: "play", click: () => this.toggle() }, "Play");
    const step = (sign: number, text: string, label: string) =>
      element("button", { type: "button", class: "square", "aria-label": label, title: label, click: () => this.step(sign) }, text);
    this.scrub = element("input", {
      type: "range",
      id: "scrub",
      min: this.start,
      max: this.end,
      step: "any",
      "aria-label": "Time",
      input: () => {
        this.pause();
        state.setTime(Number(this.scrub.value));
        this.say();
      },
      keydown: (event) => this.scrubKey(event as KeyboardEvent),
    });
    this.clock = element("output", { "aria-hidden": "true" });
    this.spoken = element("p", { class: "unseen", "aria-live": "polite", id: "spoken-time" });
    const speedId = freshId();
    const speed = element("select", { id: speedId, "aria-label": "Speed", change: () => (this.speed = Number(speed.value)) });
    speed.append(...SPEEDS.map((x) => element("option", { value: x, selected: x === 1 }, `${x} ×`)));
    const loopId = freshId();
    const loop = element("input", { type: "checkbox", id: loopId, checked: true, change: () => (this.loop = loop.checked) });
    const loopLabel = element("span", { class: "loop-switch" }, loop, element("label", { for: loopId }, "repeat"));
    bar.append(this.button, step(-1, "‹", "One sample back (left)"), step(1, "›", "One sample on (right)"), this.scrub, this.clock, speed, loopLabel, this.spoken);
    state.onChange(() => this.show());
    this.show();
  }

  toggle(): void {
    if (this.playing) this.pause();
    else this.play();
  }

  play(): void {
    if (this.state.t >= this.end || this.state.moment === null) this.state.setTime(this.state.t >= this.end ? this.start : this.state.t);
    this.playing = true;
    this.last = performance.now();
    this.show();
    requestAnimationFrame((now) => this.frame(now));
  }

  pause(): void {
    if (!this.playing) return;
    this.playing = false;
    this.show();
    this.say();
  }

  /** Goes to the next or to the previous sample. */
  step(sign: number): void {
    this.pause();
    const times = this.state.scene.motion!.t;
    const { t } = this.state;
    const to = sign > 0 ? times.find((x) => x > t) : [...times].reverse().find((x) => x < t);
    this.state.setTime(to ?? (sign > 0 ? this.end : this.start));
    this.say();
  }

  seek(t: number): void {
    this.pause();
    this.state.setTime(t);
    this.say();
  }

  toEnd(end: boolean): void {
    this.seek(end ? this.end : this.start);
  }

  private scrubKey(event: KeyboardEvent): void {
    const sign = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1 }[event.key];
    if (sign === undefined) return;
    event.preventDefault();
    event.stopPropagation();
    this.step(sign);
  }

  private frame(now: number): void {
    if (!this.playing) return;
    let t = this.state.t + (this.speed * Math.max(0, now - this.last)) / 1000;
    this.last = now;
    if (t >= this.end) {
      const span = this.end - this.start;
      if (this.loop && span > 0) t = this.start + ((t - this.start) % span);
      else {
        this.state.setTime(this.end);
        this.pause();
        return;
      }
    }
    this.state.setTime(t);
    requestAnimationFrame((next) => this.frame(next));
  }

  private show(): void {
    if (this.state.moment === null && this.playing) {
      this.playing = false; // somebody took the bodies out of the motion
    }
    const text = this.playing ? "Pause" : "Play";
    if (this.button.textContent !== text) this.button.textContent = text;
    const now = performance.now();
    if (this.playing && now - this.written < WRITING) return;
    this.written = now;
    this.scrub.value = String(this.state.t);
    this.scrub.setAttribute("aria-valuetext", `${format(this.state.t)} s`);
    this.clock.textContent = `${this.state.t.toFixed(3)} / ${this.end.toFixed(3)} s`;
  }

  private say(): void {
    this.spoken.textContent = `Time ${format(this.state.t)} seconds`;
  }
}
