// What is known of a picture's error, line by line, and on which evidence.

import { html } from "../html.js";
import { MEANINGS } from "./meanings.js";

const SIGNS = { passed: "✓", failed: "✗", stated: "·", "not checked": "?" };

// What would make a reader doubt the picture is said before anything else.
export function Cautions({ certificate }) {
  const failed = certificate.lines.filter(({ status }) => status === "failed");
  if (!failed.length) return null;
  return html`
    <section class="caution">
      <h2>Take care with this picture</h2>
      ${failed.map(({ name, says }) => html`<p key=${name}>${says} <span class="fact">${MEANINGS[name]?.failed}</span></p>`)}
    </section>
  `;
}

export const Certificate = ({ certificate }) => html`
  <section>
    <h2>Certificate</h2>
    <p class="explain">What was checked of this picture and of the program that made it, on the device that ran it. Open a line for what it means.</p>
    <ul class="certificate">
      ${certificate.lines.map(({ name, status, says }) => html`
        <li key=${name} class=${status.replace(" ", "-")}>
          <span class="sign" aria-hidden="true">${SIGNS[status]}</span>
          <div>
            ${MEANINGS[name]
              ? html`<details><summary><${Heading} name=${name} status=${status} /></summary><${Meaning} ...${MEANINGS[name]} status=${status} /></details>`
              : html`<${Heading} name=${name} status=${status} />`}
            <p>${says}</p>
          </div>
        </li>
      `)}
    </ul>
  </section>
`;

const Heading = ({ name, status }) =>
  html`<h3><span class="name">${name}</span> ${status !== "stated" && html`<span class="fact">${status}</span>`}</h3>`;

const Meaning = ({ what, how, failed, status }) => html`
  <p class="meaning">${what} ${how}</p>
  <p class="meaning">${status === "failed" ? "It failed: " : "Had it failed: "}${failed[0].toLowerCase() + failed.slice(1)}</p>
`;
