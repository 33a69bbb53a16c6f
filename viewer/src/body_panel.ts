import { Quaternion, Vector3, type Matrix4 } from "three";
import { leastTurning } from "./axode";
import { element, format, freshId } from "./element";
import { principalAxes } from "./inertia";
import { KINDS } from "./joint_kinds";
import { representationChoice } from "./layer_panel";
import { axisOf, represent, representations } from "./screws";
import type { State } from "./state";

type Row = [string, (string | number)[], string];

function table(caption: string, rows: Row[]): HTMLTableElement {
  const columns = Math.max(...rows.map(([, values]) => values.length));
  return element(
    "table",
    {},
    element("caption", {}, caption),
    element(
      "tbody",
      {},
      ...rows.map(([name, values, unit]) => {
        const row = element("tr", {}, element("th", { scope: "row" }, name));
        for (const value of values) {
          const last = value === values[values.length - 1] && values.length < columns;
          const attributes = { colspan: last ? columns - values.length + 1 : 1 };
          row.append(
            typeof value === "number" ? element("td", attributes, format(value)) : element("td", { ...attributes, class: "text" }, value),
          );
        }
        row.append(element("td", { class: "unit" }, unit));
        return row;
      }),
    ),
  );
}

function poseRows(C: Matrix4): Row[] {
  const [r, turn, scale] = [new Vector3(), new Quaternion(), new Vector3()];
  C.decompose(r, turn, scale);
  return [
    ["position", r.toArray(), "m"],
    ["quaternion", [turn.x, turn.y, turn.z], "x y z"],
    ["", [turn.w], "w"],
  ];
}

const QUANTITIES = [
  { kind: "twists", title: "Twist", rows: ["ω", "v"], units: ["rad/s", "m/s"] },
  { kind: "wrenches", title: "Wrench through its joint", rows: ["moment", "force"], units: ["N m", "N"] },
  { kind: "momenta", title: "Momentum", rows: ["angular", "linear"], units: ["N m s", "N s"] },
] as const;

/** Fills the panel with numbers of the chosen body. Returns the function that updates them. */
export function fillBodyPanel(panel: HTMLElement, state: State): () => void {
  const { scene } = state;
  const [bodyId, asId] = [freshId(), freshId()];
  const options = scene.bodies.map(({ name }, i) => element("option", { value: i }, name));
  const choice = element("select", { id: bodyId, change: () => state.select(Number(choice.value)) }, ...options);
  panel.append(element("div", { class: "row" }, element("label", { for: bodyId }, "body"), choice));
  if (scene.motion) {
    panel.append(element("div", { class: "row" }, element("label", { for: asId }, "representation"), representationChoice(state, asId)));
  }
  const numbers = element("div");
  panel.append(numbers);
  return () => {
    choice.value = String(state.selected);
    numbers.replaceChildren(...tables(state));
  };
}

function tables(state: State): Node[] {
  const { scene, selected: i } = state;
  const C = state.tree.poses[i];
  const made: Node[] = [element("h3", {}, "Pose"), table("of the body in the inertial frame", poseRows(C))];
  if (i === 0) return made;
  const body = scene.bodies[i];
  const { joint } = body;
  const jointRows: Row[] = [
    ["name", [joint.name], ""],
    ["kind", [joint.kind + (joint.passive ? ", passive" : "")], ""],
    ["from", [scene.bodies[body.predecessor].name], ""],
  ];
  if (KINDS[joint.kind].hasPitch) jointRows.push(["pitch", [joint.pitch], "m/rad"]);
  if (joint.leader) {
    jointRows.push(["follows", [`${format(joint.leader.ratio)} ${scene.bodies[joint.leader.joint].joint.name} + ${format(joint.leader.offset)}`], ""]);
  }
  made.push(element("h3", {}, "Joint"), table("that moves it", jointRows));
  made.push(
    element("h3", {}, "Inertia"),
    table("of the body with all that is fixed to it, in body axes", [
      ["mass", [body.mass], "kg"],
      ["centre", body.com, "m"],
      ["principal", principalAxes(body.inertia).moments.toArray(), "kg m²"],
    ]),
  );
  const { where, axes } = representations[state.representation];
  for (const { kind, title, rows, units } of QUANTITIES) {
    const spatial = state.screw(kind, i);
    if (!spatial) continue;
    const numbers = represent(spatial, kind !== "twists", C, state.representation);
    made.push(
      element("h3", {}, title),
      table(`${where}; ${axes}`, [
        [rows[0], numbers.slice(0, 3), units[0]],
        [rows[1], numbers.slice(3), units[1]],
      ]),
    );
  }
  const twist = state.screw("twists", i);
  const axis = twist && axisOf(twist, leastTurning(scene, i));
  if (twist) {
    const rows: Row[] = axis
      ? [
          ["direction", axis.e.toArray(), ""],
          ["point", axis.p.toArray(), "m"],
          ["pitch", [axis.pitch], "m/rad"],
          ["turning", [twist.w.length()], "rad/s"],
        ]
      : [["", ["none: the body does not turn now"], ""]];
    made.push(element("h3", {}, "Instantaneous screw axis"), table("in the inertial frame; the point nearest to its origin", rows));
  }
  return made;
}
