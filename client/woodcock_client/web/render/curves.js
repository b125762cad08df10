// What the chart of errors is drawn from. Errors are relative to the mean luminance, and time is the devices' own: the
// slopes in reports are of that.

import { duration, number, percent, samples } from "../format.js";

// A render's series for ErrorChart, from its report.
export const seriesOf = (name, { error, mean_luminance: mean, slope, contract }) => ({
  name,
  points: error,
  mean,
  slope: slope ?? null,
  contract: contract ?? null,
});

const dotsOf = (points, unit, errorOf) =>
  points
    .map((point) => ({
      seconds: point.device_seconds || point.seconds,
      samples: point.samples,
      error: errorOf(point) / unit,
    }))
    .filter(({ seconds, error }) => seconds > 0 && error > 0);

// A slope of which no more is known, for want of points or because pixels have different numbers of samples, is not drawn.
const fitOf = (slope, verdict) => (typeof slope?.slope === "number" && verdict !== "not known" ? slope : null);

// {relative, curves, goals}. relative: are errors shares of the mean luminance, or, where one of the pictures is black,
// radiances? A curve has {name, look, truth, dots, fit}; truth: of the error against a reference. goals: errors that
// were asked for.
export function curvesOf(series) {
  const relative = series.every(({ mean }) => mean > 0);
  const alone = series.length === 1;
  const curves = series.flatMap(({ name, points, mean, slope }, index) => {
    const unit = relative ? mean : 1;
    const own = { look: index, name: alone ? "Estimated by its samples" : name, truth: false, fit: fitOf(slope, slope?.verdict) };
    const true_ = { look: alone ? 1 : index, name: alone ? "True, against the reference" : `${name}, true`, truth: true };
    return [
      { ...own, dots: dotsOf(points, unit, ({ rmse }) => rmse) },
      {
        ...true_,
        fit: fitOf(slope?.against, slope?.verdict),
        dots: dotsOf(points, unit, ({ against }) => Math.sqrt(Math.max(against?.mse ?? 0, 0))),
      },
    ];
  });
  const asked = series.flatMap(({ contract }) => (contract?.kind === "relative_error" ? [contract.asked] : []));
  const goals = relative ? [...new Set(asked)] : [];
  return { relative, curves: curves.filter(({ dots }) => dots.length > 0), goals };
}

export const sized = (error, relative) => (relative ? percent(error) : number(error));

export const says = (dot, relative) =>
  `${sized(dot.error, relative)} after ${duration(dot.seconds)}, ${samples(dot.samples)} per pixel`;

// All dots, by time: what the pointer and the arrow keys go through.
export const stopsOf = (curves) =>
  curves.flatMap((curve) => curve.dots.map((dot) => ({ curve, dot }))).sort((a, b) => a.dot.seconds - b.dot.seconds);
