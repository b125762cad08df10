// How many renders there are in each state.

import { count, STATES } from "../format.js";
import { html } from "../html.js";

const ABOUT = {
  queued: "wait for a device",
  running: "are being rendered",
  cancelling: "are to stop",
  succeeded: "have their picture",
  failed: "say why, below",
  cancelled: "were stopped as asked",
};

// counts: as usePoll has them
export const Queue = ({ counts: { value, problem } }) => html`
  <section aria-labelledby="queue">
    <h2 id="queue">Renders</h2>
    <dl class="states">
      ${Object.entries(ABOUT).map(([state, about]) => {
        const number = value?.states[state];
        return html`
          <div key=${state} class=${`${state} ${number ? "" : "none"}`}>
            <dt><a href=${`/?state=${state}`} data-route>${STATES[state]}</a></dt>
            <dd>${number === undefined ? "–" : count(number)} <span class="fact">${about}</span></dd>
          </div>
        `;
      })}
    </dl>
    ${problem && !value && html`<p class="fact" role="status">How many there are cannot be told: ${problem.message}</p>`}
  </section>
`;
