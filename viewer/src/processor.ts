let known: boolean | undefined;

/**
 * Whether there is no graphics card, so that the processor draws. Shadows would then take three quarters of
 * the time for a frame, and smooth edges half of the rest.
 */
export function drawsOnProcessor(): boolean {
  return (known ??= asked());
}

function asked(): boolean {
  const context = document.createElement("canvas").getContext("webgl2");
  const names = context?.getExtension("WEBGL_debug_renderer_info");
  return !!context && !!names && /swiftshader|llvmpipe|softpipe/i.test(String(context.getParameter(names.UNMASKED_RENDERER_WEBGL)));
}

/**
 * Layers of the camera for things of which a processor draws a simpler form while the scene moves: the simpler forms, and the
 * things themselves.
 */
export const MOVING = 2;
export const RESTING = 3;

/** If there are more things of a kind than this, each of them is small on the screen. */
export const MANY = 60;

/**
 * The number of sides of round parts in a symbol that occurs `count` times. If the processor draws, the
 * number of triangles decides how long a frame takes.
 */
export function sidesOfSymbols(count: number): number {
  return count > MANY && drawsOnProcessor() ? 12 : 40;
}
