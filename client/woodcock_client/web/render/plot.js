// The drawing of the chart of errors: axes, curves with their fits, the ideal slope and what was asked for.

import { useId } from "preact/hooks";
import { percent, tick } from "../format.js";
import { html } from "../html.js";

const LOOKS = 6; // colours, and shapes of markers

// A marker's outline around a point.
function outline(look, x, y, size) {
  const corners = [null, [4, 45], [3, -90], [4, 0], [3, 90], [5, -90]][look % LOOKS];
  if (!corners) return `M${x - size} ${y}a${size} ${size} 0 1 0 ${2 * size} 0a${size} ${size} 0 1 0 ${-2 * size} 0Z`;
  const [count, turn] = corners;
  const at = (k) => {
    const angle = ((turn + (360 * k) / count) * Math.PI) / 180;
    return `${(x + 1.25 * size * Math.cos(angle)).toFixed(1)} ${(y + 1.25 * size * Math.sin(angle)).toFixed(1)}`;
  };
  return `M${Array.from({ length: count }, (_, k) => at(k)).join("L")}Z`;
}

export const Marker = ({ curve: { look, truth }, x, y, size = 3.2 }) =>
  html`<path class=${`marker look-${look % LOOKS} ${truth ? "open" : ""}`} d=${outline(look, x, y, size)} />`;

const path = (points, close = "") => `M${points.map(([x, y]) => `${x.toFixed(1)} ${y.toFixed(1)}`).join("L")}${close}`;

export function Plot({ curves, goals, relative, x, y, width, height, shown, says }) {
  const clip = useId();
  const label = (value) => (relative ? `${tick(100 * value)} %` : tick(value));
  const inner = { x: x.start, y: y.stop, width: x.stop - x.start, height: y.start - y.stop };
  return html`
    <svg width=${width} height=${height} viewBox=${`0 0 ${width} ${height}`} role="img" aria-label=${says}>
      <clipPath id=${clip}><rect ...${inner} /></clipPath>
      <path class="minor" d=${[
        ...x.minor().map((value) => path([[x.at(value), y.stop], [x.at(value), y.start]])),
        ...y.minor().map((value) => path([[x.start, y.at(value)], [x.stop, y.at(value)]])),
      ].join("")} />
      ${y.ticks(30).map((value) => html`
        <g key=${`y${value}`}>
          <line class="grid" x1=${x.start} x2=${x.stop} y1=${y.at(value)} y2=${y.at(value)} />
          <text x=${x.start - 7} y=${y.at(value)} dy="0.35em" text-anchor="end">${label(value)}</text>
        </g>
      `)}
      ${x.ticks(54).map((value) => html`
        <g key=${`x${value}`}>
          <line class="grid" x1=${x.at(value)} x2=${x.at(value)} y1=${y.stop} y2=${y.start} />
          <text x=${x.at(value)} y=${y.start + 16} text-anchor="middle">${`${tick(value)} s`}</text>
        </g>
      `)}
      <text class="axis" x="0" y="12">${relative ? "error of a pixel, of the mean luminance" : "error of a pixel, radiance"}</text>
      <text class="axis" x=${x.stop} y=${y.start + 33} text-anchor="end">rendering time of the devices</text>
      <g clip-path=${`url(#${clip})`}>
        ${curves.map((curve) => html`<${Fan} key=${curve.name} curve=${curve} x=${x} y=${y} />`)}
        <${Guide} dots=${curves[0].dots} x=${x} y=${y} />
        ${goals.map((goal) => html`<line key=${goal} class="goal" x1=${x.start} x2=${x.stop} y1=${y.at(goal)} y2=${y.at(goal)} />`)}
      </g>
      ${goals.map((goal) => html`<text key=${goal} class="goal-name" x=${x.start + 6} y=${y.at(goal) - 5}>${`asked for: ${percent(goal)}`}</text>`)}
      ${curves.map((curve) =>
        curve.dots.map((dot) => html`<${Marker} key=${`${curve.name}${dot.seconds}`} curve=${curve} x=${x.at(dot.seconds)} y=${y.at(dot.error)} />`))}
      ${shown && html`<${Cross} stop=${shown} x=${x} y=${y} />`}
    </svg>
  `;
}

// The fitted slope through the last dot, which is known best, in its band; without a fit, from dot to dot.
function Fan({ curve: { dots, fit, look, truth }, x, y }) {
  const looks = `look-${look % LOOKS} ${truth ? "open" : ""}`;
  const place = ({ seconds, error }) => [x.at(seconds), y.at(error)];
  if (!fit || dots.length < 3) return html`<path class=${`fit ${looks}`} d=${path(dots.map(place))} />`;
  const [first, last] = [dots[0], dots[dots.length - 1]];
  const start = (slope) => place({ seconds: first.seconds, error: last.error * (first.seconds / last.seconds) ** slope });
  return html`
    <path class=${`band ${looks}`} d=${path([start(fit.low), place(last), start(fit.high)], "Z")} />
    <path class=${`fit ${looks}`} d=${path([start(fit.slope), place(last)])} />
  `;
}

// The slope −1/2 through the last dot, as far as the picture goes.
function Guide({ dots, x, y }) {
  const last = dots[dots.length - 1];
  const ends = [x.low, x.high].map((seconds) => [x.at(seconds), y.at(last.error * Math.sqrt(last.seconds / seconds))]);
  return html`<path class="ideal" d=${path(ends)} />`;
}

const Cross = ({ stop: { curve, dot }, x, y }) => html`
  <path class="cross" d=${path([[x.at(dot.seconds), y.stop], [x.at(dot.seconds), y.start]]) + path([[x.start, y.at(dot.error)], [x.stop, y.at(dot.error)]])} />
  <${Marker} curve=${curve} x=${x.at(dot.seconds)} y=${y.at(dot.error)} size=${5} />
`;
