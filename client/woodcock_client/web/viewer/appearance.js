// How a view turns a picture's numbers into colours, as the shader wants it.

import { CURVE_NAMES } from "./curves.js";
import { MAPPED, SPREAD, TONED } from "./shaders.js";
import { rangeOf, weightsOf, whiteOf } from "./statistics.js";

// Light is shown in tones, directions and positions by their parts, other quantities in false colour; and so is a
// single channel, which has no colour of its own.
export const mapOf = (view, data) => view.map ?? (data.kind === "quantity" || view.channel ? "viridis" : "none");

export const isLogarithmic = (view, data) => view.log ?? data.unit === "radiance²";

// [low, high] of the false colours. Logarithms begin above 0.
export function rangeShown(view, data) {
  const logarithmic = isLogarithmic(view, data);
  const fits = view.range && !(logarithmic && view.range[0] <= 0);
  return fits ? view.range : rangeOf(data, view.channel, logarithmic);
}

// In stops; the first one is that of the preview.
export function exposureShown(view, data) {
  if (view.exposure !== null) return view.exposure;
  const white = whiteOf(data);
  return white > 0 ? -Math.log2(white) : 0;
}

export function looks(view, data) {
  const map = mapOf(view, data);
  const curve = CURVE_NAMES.indexOf(view.curve);
  const same = { gain: 1, curve, weights: [0, 0, 0], line: [1, 0], logarithmic: false, map: null, flagged: view.flag };
  if (map !== "none") {
    const logarithmic = isLogarithmic(view, data);
    const weights = [...weightsOf(data, view.channel), 0, 0].slice(0, 3);
    return { ...same, how: MAPPED, map, weights, logarithmic, line: line(rangeShown(view, data), data.scale, logarithmic) };
  }
  if (data.kind === "vector") {
    return { ...same, how: SPREAD, line: line(view.range ?? spread(data), data.scale, false) };
  }
  return { ...same, how: TONED, gain: data.scale * 2 ** exposureShown(view, data) };
}

// Factor and summand that take a number in units of the scale, or its binary logarithm, from the range to 0 to 1.
function line([low, high], scale, logarithmic) {
  if (!logarithmic) return [scale / (high - low), -low / (high - low)];
  const width = Math.log2(high) - Math.log2(low);
  return [1 / width, (Math.log2(scale) - Math.log2(low)) / width];
}

// The same range for all parts, around 0 where there are negative ones.
function spread(data) {
  const ranges = data.channels.map((channel) => rangeOf(data, channel, false));
  const low = Math.min(...ranges.map(([each]) => each));
  const high = Math.max(...ranges.map(([, each]) => each));
  const most = Math.max(-low, high);
  return low < 0 ? [-most, most] : [low, high];
}
