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
