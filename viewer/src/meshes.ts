import { LoadingManager, Matrix4, Mesh, type BufferGeometry, type Material, type Object3D } from "three";
import { ColladaLoader } from "three/addons/loaders/ColladaLoader.js";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
import { OBJLoader } from "three/addons/loaders/OBJLoader.js";
import { STLLoader } from "three/addons/loaders/STLLoader.js";
import type { MeshFile } from "./scene";

/** A part of a mesh file. Its own material is used where the shape has no colour. */
export interface Part {
  geometry: BufferGeometry;
  material: Material | null;
  pose: Matrix4;
}

const EMPTY_PICTURE = "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mP8/5+hHgAHggJ/PchI7wAAAABJRU5ErkJggg==";

function bytesOf(base64: string): ArrayBuffer {
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let k = 0; k < text.length; ++k) bytes[k] = text.charCodeAt(k);
  return bytes.buffer;
}

/**
 * A manager that opens only what is in the page. Other files to which a mesh refers are left out, with a
 * warning.
 */
function manager(file: string, warn: (text: string) => void): LoadingManager {
  const made = new LoadingManager();
  made.setURLModifier((url) => {
    if (/^(data|blob):/.test(url)) return url;
    warn(`Mesh "${file}" refers to "${url}", which is not in the page.`);
    return EMPTY_PICTURE;
  });
  return made;
}

/** The geometry with the normals of its triangles. */
function faceted(geometry: BufferGeometry): BufferGeometry {
  const separate = geometry.index ? geometry.toNonIndexed() : geometry;
  separate.computeVertexNormals();
  return separate;
}

function partsOf(object: Object3D, withMaterials: boolean): Part[] {
  const parts: Part[] = [];
  object.updateMatrixWorld(true);
  object.traverse((node) => {
    if (!(node instanceof Mesh)) return;
    const given = node.geometry as BufferGeometry;
    const geometry = given.getAttribute("normal") ? given : faceted(given);
    const material = Array.isArray(node.material) ? (node.material[0] as Material) : (node.material as Material);
    parts.push({ geometry, material: withMaterials ? material : null, pose: node.matrixWorld.clone() });
  });
  return parts;
}

async function parse({ file, format, data }: MeshFile, warn: (text: string) => void): Promise<Part[]> {
  const bytes = bytesOf(data);
  const text = () => new TextDecoder().decode(bytes);
  switch (format) {
    case "stl": {
      // Many files have zeros for normals.
      return [{ geometry: faceted(new STLLoader().parse(bytes)), material: null, pose: new Matrix4() }];
    }
    case "obj":
      return partsOf(new OBJLoader().parse(text()), false);
    case "dae": {
      // Coordinates are those of the file, as ROS has it, whatever axis the file calls up.
      const asWritten = text().replace(/<up_axis>[^<]*<\/up_axis>/, "");
      const read = new ColladaLoader(manager(file, warn)).parse(asWritten, "");
      if (!read) throw new Error("it is no COLLADA");
      return partsOf(read.scene, true);
    }
    case "glb":
    case "gltf":
      return partsOf((await new GLTFLoader(manager(file, warn)).parseAsync(format === "glb" ? bytes : text(), "")).scene, true);
  }
}

function drawable(geometry: BufferGeometry): boolean {
  const position = geometry.getAttribute("position");
  if (!position || position.count < 3) return false;
  for (let k = 0; k < position.array.length; ++k) if (!Number.isFinite(position.array[k])) return false;
  return true;
}

/** The parts of every mesh file. A file that cannot be read has no parts, and causes a warning. */
export async function readMeshes(files: readonly MeshFile[], warn: (text: string) => void): Promise<Part[][]> {
  return Promise.all(
    files.map(async (file) => {
      try {
        const parts = (await parse(file, warn)).filter(({ geometry }) => drawable(geometry));
        if (parts.length === 0) throw new Error("there is no surface in it");
        return parts;
      } catch (error) {
        warn(`Mesh "${file.file}" cannot be shown: ${(error as Error).message}.`);
        return [];
      }
    }),
  );
}
