// Error against rendering time, both logarithmic: a sound render falls along the dashed slope of −1/2. Beside the estimate
// the true error, where there is a reference.

import { duration, number, samples } from "../format.js";
import { html } from "../html.js";

const WIDTH = 340;
const HEIGHT = 190;
const EDGE = { left: 46, right: 12, top: 10, bottom: 30 };

// A logarithmic scale over the values, widened a little where they hardly differ, and its ticks.
function scale(values, from, to) {
  let low = Math.log10(Math.min(...values));
  let high = Math.log10(Math.max(...values));
  const widen = Math.max(0, 0.6 - (high - low)) / 2 + 0.04;
  low -= widen;
  high += widen;
  const at = (value) => from + ((Math.log10(value) - low) / (high - low)) * (to - from);
  const steps = high - low > 1.6 ? [1] : [1, 2, 5];
  const every = Math.ceil((high - low) / 5);
  const ticks = [];
  for (let decade = Math.floor(low); decade <= high; decade++) {
    for (const step of steps) {
      const value = step * 10 ** decade;
      const inside = Math.log10(value) >= low && Math.log10(value) <= high;
      if (inside && decade % every === 0) ticks.push(value);
    }
  }
  return { at, ticks };
}

export function ErrorChart({ series }) {
  const points = series.filter(({ seconds, rmse }) => seconds > 0 && rmse > 0);
  if (points.length < 2) return null;
  const x = scale(points.map((p) => p.seconds), EDGE.left, WIDTH - EDGE.right);
  const truth = points.filter(({ against }) => against?.mse > 0).map((p) => ({ ...p, rmse: Math.sqrt(p.against.mse) }));
  const y = scale([...points, ...truth].map((p) => p.rmse), HEIGHT - EDGE.bottom, EDGE.top);
  const first = points[0];
  const last = points[points.length - 1];
  const ideal = last.rmse * Math.sqrt(last.seconds / first.seconds);
  const path = (line) => line.map((p, i) => `${i ? "L" : "M"}${x.at(p.seconds).toFixed(1)} ${y.at(p.rmse).toFixed(1)}`).join("");
  const said = `The error fell from ${number(first.rmse)} after ${duration(first.seconds)} to ${number(last.rmse)} after ${duration(last.seconds)}.`;
  return html`
    <section>
      <h2>Error over time</h2>
      <svg class="chart" viewBox=${`0 0 ${WIDTH} ${HEIGHT}`} role="img" aria-label=${said}>
        <clipPath id="plot">
          <rect x=${EDGE.left} y=${EDGE.top} width=${WIDTH - EDGE.left - EDGE.right} height=${HEIGHT - EDGE.top - EDGE.bottom} />
        </clipPath>
        ${y.ticks.map((value) => html`
          <g key=${`y${value}`}>
            <line class="grid" x1=${EDGE.left} x2=${WIDTH - EDGE.right} y1=${y.at(value)} y2=${y.at(value)} />
            <text x=${EDGE.left - 6} y=${y.at(value)} dy="0.35em" text-anchor="end">${number(value)}</text>
          </g>
        `)}
        ${x.ticks.map((value) => html`
          <g key=${`x${value}`}>
            <line class="grid" x1=${x.at(value)} x2=${x.at(value)} y1=${EDGE.top} y2=${HEIGHT - EDGE.bottom} />
            <text x=${x.at(value)} y=${HEIGHT - EDGE.bottom + 15} text-anchor="middle">${`${number(value)} s`}</text>
          </g>
        `)}
        <g clip-path="url(#plot)">
          <line class="ideal" x1=${x.at(first.seconds)} y1=${y.at(ideal)} x2=${x.at(last.seconds)} y2=${y.at(last.rmse)} />
          <path class="curve" d=${path(points)} />
          ${truth.length > 0 && html`<path class="curve truth" d=${path(truth)} />`}
          ${points.map((p) => html`
            <circle key=${p.seconds} cx=${x.at(p.seconds)} cy=${y.at(p.rmse)} r="2.5">
              <title>${`${number(p.rmse)} after ${duration(p.seconds)}, ${samples(p.samples)}`}</title>
            </circle>
          `)}
          ${truth.map((p) => html`
            <rect class="truth" key=${p.seconds} x=${x.at(p.seconds) - 2} y=${y.at(p.rmse) - 2} width="4" height="4">
              <title>${`${number(p.rmse)} off the reference after ${duration(p.seconds)}, ${samples(p.samples)}`}</title>
            </rect>
          `)}
        </g>
      </svg>
      <p class="explain">
        Estimated error of a pixel, in the scene’s unit of radiance. Dashed: the 1/√t that independent samples promise.
        ${truth.length > 0 && html` <span class="truth">■</span> How far it is off the reference.`}
      </p>
    </section>
  `;
}
