// What an uploaded file holds; of a volume its grids, and slices through them.

import { useEffect, useState } from "preact/hooks";
import { getRange, sliceAddress } from "../api.js";
import { bytes, count, number } from "../format.js";
import { html } from "../html.js";

const AXES = ["x", "y", "z"];

// "volume, 3 grids, 12 MB"
export function inBrief({ type, size, grids, triangles, width, height }) {
  const what = {
    volume: () => (grids.length === 1 ? grids[0].shape.join(" × ") : `${grids.length} grids`),
    mesh: () => `${count(triangles)} triangles`,
    picture: () => `${width} × ${height}`,
  };
  return `${type}, ${what[type]()}, ${bytes(size)}`;
}

// onUse: is given what a scene says beside the file
export function Contents({ volume, onUse }) {
  if (volume.type !== "volume") {
    return html`<button type="button" onClick=${() => onUse({})}>Use in the scene</button>`;
  }
  return html`<${Grids} volume=${volume} onUse=${onUse} />`;
}

function Grids({ volume: { id, grids }, onUse }) {
  const usual = grids.find(({ name }) => name === "density") ?? grids[0];
  const [name, setName] = useState(usual.name);
  const [found, setFound] = useState({ name: null });
  useEffect(() => {
    const abort = new AbortController();
    getRange(id, name, abort.signal).then(
      (range) => setFound({ name, range }),
      (problem) => problem.name !== "AbortError" && setFound({ name, problem }),
    );
    return () => abort.abort();
  }, [id, name]);

  const { range, problem } = found.name === name ? found : {};
  const grid = grids.find((one) => one.name === name);
  const scale = range?.high > 0 ? { scale: Number((10 / range.high).toPrecision(2)) } : {};
  return html`
    ${grids.length > 1 &&
    html`
      <label class="field">
        Grid
        <select value=${name} onChange=${(event) => setName(event.target.value)}>
          ${grids.map((one) => html`<option key=${one.name} value=${one.name}>${one.name}</option>`)}
        </select>
      </label>
    `}
    <p class="fact">
      ${grid.type}, ${grid.shape.join(" × ")} voxels, ${count(grid.voxels)} of them set
      <br />${problem ? "" : range ? values(range) : "Reading…"}
    </p>
    ${problem
      ? html`<p class="fault" role="alert">${problem.message}</p>`
      : html`<${Slice} key=${name} id=${id} grid=${name} range=${range} />`}
    <button type="button" onClick=${() => onUse({ grid: name, ...scale })}>Use in the scene</button>
  `;
}

const values = ({ low, high }) => (low === null ? "no finite value" : `values from ${number(low)} to ${number(high)}`);

// range: undefined until it is known
function Slice({ id, grid, range }) {
  const [axis, setAxis] = useState("z");
  const [position, setPosition] = useState(null);
  const end = range ? range.shape[AXES.indexOf(axis)] : 1;
  const at = Math.min(position ?? Math.floor(end / 2), end - 1);
  const across = range?.shape.filter((_, index) => AXES[index] !== axis) ?? [1, 1];
  const turn = (next) => {
    setAxis(next);
    setPosition(null);
  };
  return html`
    <div class="stage slice">
      ${range &&
      html`<img
        src=${sliceAddress(id, { grid, axis, position: at })}
        alt=${`${grid} across ${axis}, voxel ${at} of ${end}`}
        width=${across[0]}
        height=${across[1]}
      />`}
    </div>
    <div class="cut">
      <fieldset class="axes">
        <legend>Across</legend>
        ${AXES.map((one) => html`<label key=${one}><input type="radio" name=${`axis of ${id}`} checked=${axis === one} onChange=${() => turn(one)} />${one}</label>`)}
      </fieldset>
      <label class="field">
        <span>Position ${at}, of 0 to ${end - 1}</span>
        <input type="range" min="0" max=${end - 1} value=${at} disabled=${!range} onInput=${(event) => setPosition(Number(event.target.value))} />
      </label>
    </div>
  `;
}
