import { BackSide, BufferGeometry, Color, InstancedMesh, ShaderMaterial, Vector2 } from "three";
import { mergeVertices } from "three/addons/utils/BufferGeometryUtils.js";
import type { Instances } from "./instances";

/** The layer of the camera in which edges are. Nothing is chosen by a click on them, and they throw no shadow. */
export const EDGES = 1;
/** The width of an edge, in pixels. */
const WIDTH = 1.5;
/** Geometries with more corners than this have no edges. */
const MOST_CORNERS = 50_000;

/** An edge is the far side of a thing, moved outwards on the screen, so that it shows around the thing only. */
const material = new ShaderMaterial({
  side: BackSide,
  uniforms: { color: { value: new Color() }, shift: { value: new Vector2() } },
  vertexShader: `
    uniform vec2 shift;
    void main() {
      mat4 place = modelViewMatrix * instanceMatrix;
      vec3 square = vec3(dot(place[0], place[0]), dot(place[1], place[1]), dot(place[2], place[2]));
      vec3 outwards = mat3(place) * (normal / max(square, vec3(1e-20)));
      vec2 onScreen = outwards.xy / max(length(outwards), 1e-20);
      float part = length(onScreen);
      gl_Position = projectionMatrix * place * vec4(position, 1.0);
      gl_Position.xy += onScreen / max(part, 1e-6) * min(1.0, 4.0 * part) * shift * gl_Position.w;
    }`,
  fragmentShader: `
    uniform vec3 color;
    void main() {
      gl_FragColor = vec4(color, 1.0);
      #include <colorspace_fragment>
    }`,
  polygonOffset: true, // a surface that is seen from both sides hides its own edge
  polygonOffsetFactor: 2,
  polygonOffsetUnits: 2,
});

/** Chooses the colour of all edges. */
export function paintEdges(color: string): void {
  material.uniforms.color.value.set(color);
}

/** Sets the size of the canvas, in pixels. */
export function sizeEdges(width: number, height: number): void {
  material.uniforms.shift.value.set((2 * WIDTH) / width, (2 * WIDTH) / height);
}

const closed = new WeakMap<BufferGeometry, BufferGeometry>();

/** The geometry with one normal at each corner, so that the sides of a moved edge stay together. */
function withCommonNormals(geometry: BufferGeometry): BufferGeometry {
  const known = closed.get(geometry);
  if (known) return known;
  const bare = new BufferGeometry().setAttribute("position", geometry.getAttribute("position")).setIndex(geometry.index);
  bare.computeBoundingSphere();
  const joined = mergeVertices(bare, 1e-5 * bare.boundingSphere!.radius);
  joined.computeVertexNormals();
  closed.set(geometry, joined);
  return joined;
}

/** The edges of things, which are placed with them; null if there would be too many. */
export function edgesOf(things: Instances): InstancedMesh | null {
  if (things.geometry.getAttribute("position").count > MOST_CORNERS) return null;
  const edges = new InstancedMesh(withCommonNormals(things.geometry), material, things.items.length);
  edges.instanceMatrix = things.instanceMatrix;
  edges.frustumCulled = false;
  edges.renderOrder = 1; // where things hide them they need not be drawn
  edges.layers.set(EDGES);
  return edges;
}
