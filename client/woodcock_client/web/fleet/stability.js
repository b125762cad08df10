// A device's stability check: how to begin one, and its table of cases.

import { useEffect, useState } from "preact/hooks";
import { checkStability, getStability } from "../api.js";
import { duration, number } from "../format.js";
import { html } from "../html.js";
import { useOnce } from "../once.js";

// ask: for the devices anew
export function Check({ device, ask }) {
  const { busy, problem, run } = useOnce(async () => {
    await checkStability(device);
    ask();
  });
  const running = device.stability === "running";
  const ended = device.stability === "passed" || device.stability === "failed";
  return html`
    <div class="check">
      <button type="button" disabled=${busy || running} onClick=${() => run()}>
        ${running ? "Being checked…" : ended ? "Check again" : "Check its stability"}
      </button>
      <span class="fact">${running ? "It takes minutes; the device renders nothing else meanwhile." : "Renders stiff and extreme scenes against exact answers; takes minutes."}</span>
    </div>
    <p class="fault" role="alert">${problem?.message}</p>
    ${ended && html`<${Table} key=${device.checked_at} device=${device} />`}
  `;
}

const VERDICTS = { failed: "failed", passed: "passed", "not expressible": "not expressible" };

function Table({ device }) {
  const [open, setOpen] = useState(false);
  const [check, setCheck] = useState(null);
  const [problem, setProblem] = useState(null);
  useEffect(() => {
    if (!open || check) return undefined;
    const abort = new AbortController();
    setProblem(null);
    getStability(device, abort.signal).then(setCheck, (caught) => abort.signal.aborted || setProblem(caught));
    return () => abort.abort();
  }, [open]);
  return html`
    <details class="cases" onToggle=${(event) => setOpen(event.target.open)}>
      <summary>Its cases</summary>
      ${problem && html`<p class="fact" role="alert">${problem.message}</p>`}
      ${!check && !problem && html`<p class="fact" role="status">Loading…</p>`}
      ${check && html`<${Cases} check=${check} name=${device.name} />`}
    </details>
  `;
}

function Cases({ check: { rows, version, started_at: from, finished_at: to }, name }) {
  const of = (verdict) => rows.filter((row) => row.verdict === verdict);
  const sorted = Object.keys(VERDICTS).flatMap(of); // what failed first
  const counts = Object.keys(VERDICTS).filter((verdict) => of(verdict).length).map((verdict) => `${of(verdict).length} ${verdict}`);
  const took = from && to ? `, in ${duration((Date.parse(to) - Date.parse(from)) / 1000)}` : "";
  return html`
    <p class="fact">${`${counts.join(", ")}, by Woodcock ${version}${took}`}</p>
    <div class="scroll" tabindex="0" role="region" aria-label=${`Cases of ${name}`}>
      <table>
        <thead>
          <tr><th scope="col">Case</th><th scope="col">Verdict</th><th scope="col">Expected</th><th scope="col">Got</th><th scope="col">Off by</th><th scope="col">Limit</th></tr>
        </thead>
        <tbody>
          ${sorted.map((row, index) => html`
            <tr key=${index} class=${row.verdict.replace(" ", "-")}>
              <th scope="row">${row.group}, ${row.case}${row.says && html`<p class="fact">${row.says}</p>`}</th>
              <td>${VERDICTS[row.verdict]}</td>
              <td>${value(row.expected)}</td>
              <td>${value(row.got)}</td>
              <td>${row.deviation === null ? "–" : `${number(row.deviation)} ${row.unit}`}</td>
              <td>${value(row.limit)}</td>
            </tr>
          `)}
        </tbody>
      </table>
    </div>
  `;
}

const value = (x) => (x === null ? "–" : number(x));
