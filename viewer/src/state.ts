import { Closure } from "./closure";
import { centreOfMass, Tree } from "./kinematics";
import { coordinatesAt, interpolate, momentOf, type Moment } from "./motion";
import type { Scene } from "./scene";
import { screwOf, type Representation, type Screw } from "./screws";

/**
 * The state of the page: coordinates, the time in the motion to which they belong, and the choices of the
 * user.
 */
export class State {
  q: number[];
  readonly tree: Tree;
  readonly closure: Closure;
  /** Why the joints are not where the user wanted them; empty if they are. */
  notice = "";
  /** The time of the time cursor. */
  t: number;
  /**
   * The place of `t` in the motion. It is null while the bodies are where the user put them, and not where
   * the motion has them.
   */
  moment: Moment | null = null;
  selected: number;
  /** Whether the user chose the body; then it has another colour. */
  chosen = false;
  representation: Representation = "hybrid";
  /** Whether arrows are drawn for every body, or for the chosen one only. */
  everyBody = false;
  /** The size of symbols and arrows, relative to that which the page chose. */
  symbolScale = 1;
  arrowScale = 1;
  private readonly listeners: (() => void)[] = [];

  constructor(readonly scene: Scene) {
    this.q = scene.q.slice();
    this.tree = new Tree(scene.bodies);
    this.closure = new Closure(scene);
    this.selected = scene.bodies.length - 1;
    this.t = scene.motion ? scene.motion.t[0] : 0;
    if (scene.motion) this.setTime(this.t);
    else this.tree.update(this.q);
  }

  onChange(listener: () => void): void {
    this.listeners.push(listener);
  }

  changed(): void {
    for (const listener of this.listeners) listener();
  }

  /** Shows coordinates that the user chose, and why they are not those that he wanted. */
  setCoordinates(q: readonly number[], notice = ""): void {
    if (q.length !== this.scene.nq || !q.every(Number.isFinite)) {
      throw new Error(`q must be ${this.scene.nq} finite numbers, got ${q.length}.`);
    }
    this.q = q.slice();
    this.notice = notice;
    this.moment = null;
    this.tree.update(this.q);
    this.changed();
  }

  /** Shows the motion at time t. */
  setTime(t: number): void {
    const { motion } = this.scene;
    if (!motion) throw new Error("The scene has no motion.");
    const { t: times } = motion;
    this.t = Math.min(Math.max(t, times[0]), times[times.length - 1]);
    this.notice = "";
    this.moment = momentOf(times, this.t);
    this.q = coordinatesAt(this.scene, motion, this.moment);
    this.tree.update(this.q);
    this.changed();
  }

  select(body: number): void {
    this.selected = body;
    this.chosen = true;
    this.changed();
  }

  /**
   * The twist, wrench or momentum of body i at the shown time, in the spatial representation; null if the
   * scene has none.
   */
  screw(kind: "twists" | "wrenches" | "momenta", i: number): Screw | null {
    return i === 0 ? null : this.numbered(this.scene.motion?.[kind], i - 1);
  }

  /** The spatial wrench of loop joint k on its second body at the shown time; null if the scene has none. */
  loopWrench(k: number): Screw | null {
    return this.numbered(this.scene.motion?.loop_wrenches, k);
  }

  /** The spatial wrench of the loads on loaded frame k at the shown time; null if the scene has none. */
  load(k: number): Screw | null {
    return this.numbered(this.scene.motion?.loads, k);
  }

  private numbered(samples: readonly number[][][] | null | undefined, k: number): Screw | null {
    if (!samples || !this.moment) return null;
    const { index, fraction } = this.moment;
    const of = [index, Math.min(index + 1, samples.length - 1)].map((sample) => samples[sample][k]);
    return screwOf(interpolate(of, { index: 0, fraction }));
  }

  /** The tension of a line at the shown time, N; null if the scene has none. */
  tension(k: number): number | null {
    const samples = this.scene.motion?.tensions;
    return samples && this.moment ? interpolate(samples, this.moment)[k] : null;
  }

  centreOfMass() {
    return centreOfMass(this.scene, this.tree.poses);
  }
}
