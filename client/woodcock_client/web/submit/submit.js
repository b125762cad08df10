// A scene is written, tried and sent off: the editor, files, sweeps, and what the service says of them.

import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { checkJob, getJob, getSchemas, listDevices, submitBatch, submitJob } from "../api.js";
import { count } from "../format.js";
import { html } from "../html.js";
import { go } from "../navigation.js";
import { numbersOf, sweepOf } from "./axes.js";
import { requestOf, START, useDraft } from "./draft.js";
import { Editor, jump, replace } from "./editor.js";
import { Estimate } from "./estimate.js";
import { Examples } from "./examples.js";
import { isOfScene, placeOf, syntaxFault } from "./faults.js";
import { controlOf, Fields } from "./fields.js";
import { Files } from "./files.js";
import { use } from "./insert.js";
import { stepsOf } from "./place.js";
import { Problems } from "./problems.js";
import { Schema } from "./schema.js";
import { Sweep } from "./sweep.js";
import { useDrop, useUploads } from "./uploads.js";
import { useValidation } from "./validation.js";
import { written } from "./written.js";

const ignore = () => {}; // the page does without

// What a call resolves to, null before.
function useAnswer(call) {
  const [answer, setAnswer] = useState(null);
  useEffect(() => {
    const abort = new AbortController();
    call(abort.signal).then(setAnswer, ignore);
    return () => abort.abort();
  }, []);
  return answer;
}

export function Submit({ query }) {
  const [draft, change] = useDraft();
  const view = useRef(null);
  const schemas = useAnswer(getSchemas);
  const schema = useMemo(() => schemas && new Schema(schemas), [schemas]);
  const devices = useAnswer(listDevices)?.items ?? [];
  const uploads = useUploads();
  const request = useMemo(() => requestOf(draft), [draft]);
  const found = useValidation(request, uploads.volumes);
  const sweep = sweepOf(draft.axes, (path) => isWhole(schema, path));
  const wrong = request === null && view.current ? syntaxFault(view.current.state) : null;
  const lost = useBeginning(query.get("from"), schema, (job) => {
    replace(view.current, written(schema.lean(job.scene)));
    change({ name: job.name, tags: job.tags.join(", ") });
  });
  const send = (files) => files.forEach(uploads.add);
  const over = useDrop(send);

  useEffect(() => {
    document.title = "New render · Woodcock";
  }, []);

  const onJump = (fault) => {
    if (wrong) jump(view.current, wrong);
    else if (isOfScene(fault)) jump(view.current, placeOf(view.current.state, fault.field));
    else document.getElementById(controlOf(fault.field))?.focus();
  };
  const onExample = (scene, name) => {
    replace(view.current, written(scene));
    change({ name });
  };
  return html`
    <div class="heading">
      <a class="up" href="/" data-route>Renders</a>
      <h1>New render</h1>
      ${lost && html`<span class="fact" role="alert">${lost}</span>`}
    </div>
    <div class="submit">
      <section class="writing" aria-label="Scene">
        <${Examples} open=${draft.text === START.text} uploads=${uploads} onScene=${onExample} />
        <${Editor}
          text=${draft.text}
          view=${view}
          onText=${(text) => change({ text })}
          schema=${schema}
          files=${uploads.volumes ?? []}
          faults=${found.faults}
        />
        <p class="fact keys">Ctrl-Space offers what may stand at the cursor; rest the pointer on a field to read what it is.</p>
        <${Problems} wrong=${wrong} found=${found} onJump=${onJump} />
      </section>
      <div class="beside">
        <section aria-labelledby="render">
          <h2 id="render">Render</h2>
          <${Fields} draft=${draft} devices=${devices} onChange=${change} />
          <${Sending} request=${request} axes=${draft.axes} sweep=${sweep} />
        </section>
        <${Sweep} axes=${draft.axes} paths=${request ? numbersOf(request.scene) : []} sweep=${sweep} onAxes=${(axes) => change({ axes })} />
        <${Files} uploads=${uploads} onFiles=${send} onUse=${(volume, more) => use(view.current, schema, volume, more)} />
      </div>
    </div>
    <div class="dropping" hidden=${!over}><p>Drop files to upload them</p></div>
  `;
}

// Whether only whole numbers may stand at a path.
function isWhole(schema, path) {
  const place = schema?.at(stepsOf(path), []);
  return Boolean(place) && schema.choices(place).every(({ type }) => type === "integer");
}

// Begins with a job that is there, once the schema is; returns a sentence if that is not possible.
function useBeginning(from, schema, onJob) {
  const [lost, setLost] = useState(null);
  useEffect(() => {
    if (!from || !schema) return undefined;
    const abort = new AbortController();
    getJob(from, abort.signal).then(
      (job) => {
        history.replaceState(null, "", "/submit"); // a reload keeps what is written from here on
        onJob(job);
      },
      (problem) => problem.name !== "AbortError" && setLost(`The render to begin with cannot be had: ${problem.message}`),
    );
    return () => abort.abort();
  }, [from, schema]);
  return lost;
}

const newKey = () => [...crypto.getRandomValues(new Uint8Array(16))].map((byte) => byte.toString(16).padStart(2, "0")).join("");

// The buttons, and what the service answered.
function Sending({ request, axes, sweep }) {
  const [busy, setBusy] = useState(null);
  const [refusal, setRefusal] = useState(null);
  const [tried, setTried] = useState(null);
  const sent = useRef({}); // the last body, and the key under which it may come again
  const swept = axes.length > 0;
  const possible = request !== null && busy === null && !(swept && sweep.fault);
  const text = JSON.stringify(request);

  async function doing(name, act) {
    setBusy(name);
    setRefusal(null);
    try {
      await act();
    } catch (problem) {
      setRefusal(problem);
    }
    setBusy(null);
  }

  const estimate = () => doing("estimate", async () => setTried({ text, check: await checkJob(request) }));

  const submit = () =>
    doing("submit", async () => {
      const body = swept ? { ...request, product: sweep.product, zip: sweep.zip } : request;
      const whole = JSON.stringify(body);
      if (sent.current.whole !== whole) sent.current = { whole, key: newKey() };
      const { key } = sent.current;
      if (swept) go(`/batches/${encodeURIComponent((await submitBatch(body, key)).id)}`);
      else go(`/renders/${encodeURIComponent((await submitJob(body, key)).id)}`);
    });

  return html`
    <div class="line actions">
      <button type="button" disabled=${!possible} onClick=${estimate}>${busy === "estimate" ? "Estimating…" : "Estimate"}</button>
      <button type="button" class="primary" disabled=${!possible} onClick=${submit}>
        ${busy === "submit" ? "Sending…" : swept && sweep.count > 1 ? `Render ${count(sweep.count)}` : "Render"}
      </button>
    </div>
    ${refusal &&
    html`
      <div class="refusal" role="alert">
        <p>${refusal.message}</p>
        <ul>${refusal.errors?.map(({ field, message }) => html`<li key=${field}><code>${field}</code> ${message}</li>`)}</ul>
      </div>
    `}
    ${tried && html`<${Estimate} check=${tried.check} renders=${swept ? sweep.count : 1} old=${tried.text !== text} />`}
  `;
}
