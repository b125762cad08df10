// Error against rendering time, both logarithmic, of one render or several: the pointer and the arrow keys read it, and
// its values are a table too.

import { useLayoutEffect, useRef, useState } from "preact/hooks";
import { axisOver } from "./axis.js";
import { curvesOf, says, sized, stopsOf } from "./curves.js";
import { duration, number } from "../format.js";
import { html } from "../html.js";
import { Marker, Plot } from "./plot.js";

const EDGE = { left: 58, right: 16, top: 24, bottom: 42 };

// series: as seriesOf makes them of reports, and each curve has the colour of its place. Nothing where no two points
// are known.
export function ErrorChart({ series }) {
  const { relative, curves, goals } = curvesOf(series);
  if (!curves.some(({ dots }) => dots.length > 1)) return null;
  return html`
    <section class="error-chart">
      <h2>Error over time</h2>
      <${Board} curves=${curves} goals=${goals} relative=${relative} />
      <${Legend} curves=${curves} relative=${relative} banded=${curves.some(({ fit }) => fit)} />
      <${Values} curves=${curves} relative=${relative} />
    </section>
  `;
}

// What the whole chart says, for those who do not see it.
function summary([{ dots }, ...others], relative) {
  const [first, last] = [dots[0], dots[dots.length - 1]];
  const fell = `The error fell from ${sized(first.error, relative)} after ${duration(first.seconds)} to ${sized(last.error, relative)} after ${duration(last.seconds)}.`;
  return others.length ? `${fell} ${others.length + 1} curves; their values are in the table below.` : fell;
}

// The drawing, as large as the room that the stylesheet gives it, and what goes through its dots.
function Board({ curves, goals, relative }) {
  const board = useRef();
  const [{ width, height }, setSize] = useState({ width: 0, height: 0 });
  const [at, setAt] = useState(null);
  useLayoutEffect(() => {
    const measure = () => setSize({ width: board.current.clientWidth, height: board.current.clientHeight });
    measure();
    const observer = new ResizeObserver(measure);
    observer.observe(board.current);
    return () => observer.disconnect();
  }, []);

  const dots = curves.flatMap((curve) => curve.dots);
  const x = axisOver(dots.map(({ seconds }) => seconds), EDGE.left, width - EDGE.right);
  const y = axisOver([...dots.map(({ error }) => error), ...goals], height - EDGE.bottom, EDGE.top);
  const stops = stopsOf(curves);
  const shown = stops[at] ?? null;

  function point(event) {
    const box = board.current.getBoundingClientRect();
    const away = ({ dot }) =>
      Math.abs(x.at(dot.seconds) - (event.clientX - box.left)) + 0.3 * Math.abs(y.at(dot.error) - (event.clientY - box.top));
    setAt(stops.reduce((best, stop, index) => (away(stop) < away(stops[best]) ? index : best), 0));
  }

  function key(event) {
    const to = { ArrowLeft: at - 1, ArrowDown: at - 1, ArrowRight: at + 1, ArrowUp: at + 1, Home: 0, End: stops.length - 1 }[event.key];
    if (to === undefined) return;
    event.preventDefault();
    setAt(Math.min(Math.max(to, 0), stops.length - 1));
  }

  return html`
    <div class="board" ref=${board}>
      ${width > 0 && html`<${Plot} ...${{ curves, goals, relative, x, y, width, height, shown }} says=${summary(curves, relative)} />`}
      <div
        class="reader"
        role="slider"
        tabindex="0"
        aria-label="Points of the chart"
        aria-valuemin="1"
        aria-valuemax=${stops.length}
        aria-valuenow=${(at ?? stops.length - 1) + 1}
        aria-valuetext=${spoken(stops[at ?? stops.length - 1], relative)}
        onKeyDown=${key}
        onFocus=${() => setAt(at ?? stops.length - 1)}
        onBlur=${() => setAt(null)}
        onPointerMove=${point}
        onPointerDown=${point}
        onPointerLeave=${() => setAt(null)}
      ></div>
      ${shown && html`<${Tip} stop=${shown} relative=${relative} x=${x.at(shown.dot.seconds)} y=${y.at(shown.dot.error)} width=${width} />`}
    </div>
  `;
}

const spoken = ({ curve, dot }, relative) => `${curve.name}: ${says(dot, relative)}`;

// Beside the dot, on the side that has more room.
function Tip({ stop, relative, x, y, width }) {
  const side = x > width / 2 ? { right: `${width - x + 12}px` } : { left: `${x + 12}px` };
  return html`
    <p class="tip" aria-hidden="true" style=${{ ...side, top: `${y}px` }}>
      <b>${sized(stop.dot.error, relative)}</b> <span>${stop.curve.name}</span>
      <span>${says(stop.dot, relative).replace(/^.*? after /, "after ")}</span>
    </p>
  `;
}

const Legend = ({ curves, relative, banded }) => html`
  <ul class="key">
    ${curves.map((curve) => html`
      <li key=${curve.name}>
        <svg width="14" height="14" aria-hidden="true"><${Marker} curve=${curve} x=${7} y=${7} size=${4} /></svg>
        <span>${curve.name}</span> <span class="fact">${sized(curve.dots[curve.dots.length - 1].error, relative)}</span>
      </li>
    `)}
    <li>
      <svg width="22" height="14" aria-hidden="true"><path class="ideal" d="M1 3L21 11" /></svg>
      <span>slope −½ <span class="fact">half the error in four times the time</span></span>
    </li>
    ${banded && html`
      <li>
        <svg width="22" height="14" aria-hidden="true"><path class="band look-0" d="M1 1L21 8L1 13Z" /><path class="fit look-0" d="M1 6L21 8" /></svg>
        <span>fitted slope <span class="fact">in its 95 % band</span></span>
      </li>
    `}
  </ul>
`;

// The same as numbers.
const Values = ({ curves, relative }) => html`
  <details class="as-text">
    <summary>Values</summary>
    <div class="scroll" tabindex="0" role="region" aria-label="Values of the chart">
      <table>
        <thead><tr><th scope="col">Error</th><th scope="col">Time</th><th scope="col">Samples per pixel</th><th scope="col">What</th></tr></thead>
        <tbody>
          ${stopsOf(curves).map(({ curve, dot }) => html`
            <tr key=${`${curve.name}${dot.seconds}`}>
              <td>${sized(dot.error, relative)}</td><td>${duration(dot.seconds)}</td><td>${number(dot.samples)}</td><td>${curve.name}</td>
            </tr>
          `)}
        </tbody>
      </table>
    </div>
  </details>
`;
