// What the program of a scene holds, and what of the renderer it does without.

import { count, number, percent } from "../format.js";
import { html } from "../html.js";

// All kinds that there are, by concept. A test holds them against the renderer's.
const CONCEPTS = {
  camera: ["Cameras", { perspective: "perspective", thin_lens: "thin lens", orthographic: "orthographic", spherical: "spherical" }],
  filter: ["Pixel filters", { box: "box", tent: "tent", gaussian: "Gaussian" }],
  volume: ["Media", { constant: "even ones", grid: "grids" }],
  shape: ["Shapes of media", { box: "box", sphere: "ball", mesh: "mesh" }],
  phase: [
    "Phase functions",
    {
      isotropic: "isotropic",
      henyey_greenstein: "Henyey–Greenstein",
      two_lobe: "two lobes",
      rayleigh: "Rayleigh",
      draine: "Draine",
      mie_approx: "Mie droplets",
      tabulated: "tabulated",
      mixture: "mixtures",
    },
  ],
  emission: ["Glow of media", { constant: "even", grid: "by a grid", blackbody: "black bodies" }],
  light: [
    "Lights",
    { constant: "even surroundings", image: "pictures of surroundings", directional: "directional", sun: "sun", point: "point", spot: "spot" },
  ],
  surface: ["Surfaces", { sphere: "sphere", rectangle: "rectangle", disk: "disk", mesh: "mesh" }],
  material: [
    "Materials",
    { diffuse: "diffuse", mirror: "mirror", dielectric: "glass", rough_dielectric: "rough glass", emissive: "emissive", null: "index-matched" },
  ],
  majorant: ["Majorants", { global: "one for all", grid: "by cells" }],
};

const lines = (files) => Object.values(files ?? {}).reduce((sum, each) => sum + each, 0);

export function Lean({ kinds, program, gain }) {
  const without = lines(program?.left_out);
  const held = program?.source_lines ?? 0;
  return html`
    <section>
      <h2>What the scene did not need</h2>
      <p class="explain">
        The program was written for this scene.
        ${without > 0 && ` It is ${count(held)} lines long; ${count(without)} lines of the renderer, ${percent(without / (without + held))}, were not compiled in.`}
        ${" What is not in it costs nothing: no branch, no register, no memory."}
        ${gain && ` With everything in it, a sample would take ${number(gain.ratio)} times as long (${number(gain.low)} to ${number(gain.high)} with 95 %).`}
      </p>
      ${without > 0 && html`
        <div class="split two" aria-hidden="true"><i style=${{ flexGrow: held }}></i><i style=${{ flexGrow: without }}></i></div>
      `}
      <dl class="table lean">
        ${Object.entries(CONCEPTS).map(([concept, [name, words]]) => {
          const used = kinds[concept] ?? [];
          const left = Object.keys(words).filter((kind) => !used.includes(kind));
          return html`
            <div key=${concept}>
              <dt>${name}</dt>
              <dd>
                ${used.length > 0 && html`<span>${used.map((kind) => words[kind] ?? kind).join(", ")}</span>`}
                ${left.length > 0 && html` <span class="without">${used.length > 0 ? "· " : ""}without ${left.map((kind) => words[kind]).join(", ")}</span>`}
              </dd>
            </div>
          `;
        })}
      </dl>
      ${program && html`<${Sizes} program=${program} />`}
    </section>
  `;
}

// By file, for who wants to know it exactly.
const Sizes = ({ program: { remained, left_out: left, bytes: size, binary_bytes: built, registers } }) => html`
  <details class="as-text">
    <summary>File by file</summary>
    <p class="fact">
      ${[`${count(size)} bytes of text`, built !== null && `${count(built)} bytes as built`, registers !== null && `${registers} registers of a work item`].filter(Boolean).join(", ")}
    </p>
    <div class="scroll" tabindex="0" role="region" aria-label="Files of device code">
      <table>
        <thead><tr><th scope="col">File</th><th scope="col">Lines</th><th scope="col">Compiled in</th></tr></thead>
        <tbody>
          ${[...Object.entries(remained).map((each) => [...each, "yes"]), ...Object.entries(left).map((each) => [...each, "no"])].map(([file, n, held]) => html`
            <tr key=${file} class=${held === "no" ? "without" : ""}><td>${file}</td><td>${count(n)}</td><td>${held}</td></tr>
          `)}
        </tbody>
      </table>
    </div>
  </details>
`;
