let known: boolean | undefined;

/** Whether there is no graphics card, so that the processor draws: then shadows would take three quarters of the time of a frame,
 * and of what is left smooth edges half. */
export function drawsOnProcessor(): boolean {
  return (known ??= asked());
}

function asked(): boolean {
  const context = document.createElement("canvas").getContext("webgl2");
  const names = context?.getExtension("WEBGL_debug_renderer_info");
  return !!context && !!names && /swiftshader|llvmpipe|softpipe/i.test(String(context.getParameter(names.UNMASKED_RENDERER_WEBGL)));
}

/** Where there are more things of a kind than this, each is small on the screen. */
export const MANY = 60;

/** Sides of what is round in a symbol of which there are so many. To the processor a frame is above all its triangles. */
export function sidesOfSymbols(count: number): number {
  return count > MANY && drawsOnProcessor() ? 12 : 40;
}
