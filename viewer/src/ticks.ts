/** How many decimals the multiples of a step need to be written without rounding. */
export function decimalsOf(step: number): number {
  let decimals = 0;
  for (let x = Math.abs(step); decimals < 12 && Math.abs(x - Math.round(x)) > 1e-6 * x; x *= 10) ++decimals;
  return decimals;
}

/** A number beside an axis, with as many digits as the multiples of the step need. */
export function tickText(x: number, step: number): string {
  if (Math.abs(x) < 1e-9 * step) return "0";
  const decimals = decimalsOf(step);
  if (decimals <= 5 && Math.abs(x) < 1e6) return x.toFixed(decimals).replace("-", "−");
  const mantissa = step / 10 ** Math.floor(Math.log10(Math.abs(x)) + 1e-9);
  return x.toExponential(Math.min(8, decimalsOf(mantissa))).replace("-", "−");
}
