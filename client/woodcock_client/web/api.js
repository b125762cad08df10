// The service's HTTP API. A call resolves to the answer, or throws a Problem with a sentence to show.

const ROOT = "/api/v1";

export class Problem extends Error {
  // status 0: no answer at all
  constructor(status, detail) {
    super(detail);
    this.status = status;
  }
}

// Said to the window when the service asks who is there: the gallery shows where to sign in.
export const SIGNED_OUT = "woodcock-signed-out";

async function ask(path, options) {
  let response;
  try {
    response = await fetch(path, { cache: "no-store", ...options, headers: { Accept: "application/json", ...options.headers } });
  } catch (error) {
    if (error.name === "AbortError") throw error;
    throw new Problem(0, "The service does not answer.");
  }
  if (response.status === 204) return null;
  const body = await response.json().catch(() => null);
  if (!response.ok || body === null) {
    if (response.status === 401) dispatchEvent(new Event(SIGNED_OUT));
    throw new Problem(response.status, body?.detail || `The service answered ${response.status}.`);
  }
  return body;
}

const get = (path, signal) => ask(path, { signal });

// key: what comes twice under it is done once; the other options are fetch's
const send = (method, path, body, { key, ...options } = {}) =>
  ask(path, {
    method,
    headers: { ...(body && { "Content-Type": "application/json" }), ...(key && { "Idempotency-Key": key }) },
    body: body && JSON.stringify(body),
    ...options,
  });


export const signIn = (token) => send("POST", `${ROOT}/session`, { token });

// The wall

// filter: the query of a listing, as text
export const listJobs = ({ limit, cursor, filter }, signal) => {
  const query = new URLSearchParams(filter);
  query.set("limit", limit);
  if (cursor) query.set("cursor", cursor);
  return get(`${ROOT}/jobs?${query}`, signal);
};

export const countJobs = (signal) => get(`${ROOT}/jobs/counts`, signal);

export const MOST_DELETED = 1000; // jobs at a time

// leaving: the request goes on when its page is no more
export const deleteJobs = (ids, leaving) => send("POST", `${ROOT}/jobs/delete`, { ids }, { keepalive: leaving });

// Batches

const batchAt = (id) => `${ROOT}/batches/${encodeURIComponent(id)}`;

// What has not changed does not come again: a batch may have a thousand jobs.
export const getBatch = (id, signal) => ask(batchAt(id), { signal, cache: "no-cache" });

export const cancelBatch = (id) => ask(`${batchAt(id)}/cancel`, { method: "POST" });

export const deleteBatch = (id, leaving) => ask(batchAt(id), { method: "DELETE", keepalive: leaving });

// Renders

export const getJob = (id, signal) => get(`${ROOT}/jobs/${encodeURIComponent(id)}`, signal);

export const getReport = (job, signal) => get(job.links.report, signal);

// A render's life. job: as it was asked for; change: some of its name, tags and pinned; stop: a stricter contract.

export const submitJob = (job, key) => send("POST", `${ROOT}/jobs`, job, { key });

export const changeJob = (id, change) => send("PATCH", `${ROOT}/jobs/${encodeURIComponent(id)}`, change);

export const cancelJob = (job) => send("POST", `${job.links.self}/cancel`);

export const retryJob = (job, key) => send("POST", `${job.links.self}/retry`, null, { key });

export const extendJob = (job, stop, key) => send("POST", `${job.links.self}/extend`, { stop }, { key });

// The fleet

export const listDevices = (signal) => get(`${ROOT}/devices`, signal);

const stabilityOf = (device) => `${ROOT}/devices/${encodeURIComponent(device.id)}/stability`;

export const getStability = (device, signal) => get(stabilityOf(device), signal);

export const checkStability = (device) => send("POST", stabilityOf(device));

export const jobsThatAre = (state, limit, signal) => get(`${ROOT}/jobs?${new URLSearchParams({ state, limit })}`, signal);

export const getRetention = (signal) => get(`${ROOT}/retention`, signal);

export const getHealth = (signal) => get("/healthz", signal);

export const isActive = (job) => ["queued", "running", "cancelling"].includes(job.state);

// Calls onJob with the job now and at each change, onEnd after the last, and onLost(true/false) as the stream breaks
// and comes back. A hidden tab lets go of its stream: browsers allow six connections to one address over HTTP/1.1,
// shared by all tabs. Returns a function that stops it.
export function followJob(job, { onJob, onEnd, onLost }) {
  const RETRY = 3000; // ms; EventSource itself gives up when an answer is not 200, as while a service restarts
  let source;
  let timer;

  function open() {
    close();
    if (document.hidden) return;
    source = new EventSource(job.links.events);
    source.onopen = () => onLost(false);
    source.addEventListener("progress", (event) => onJob(JSON.parse(event.data)));
    source.addEventListener("end", (event) => {
      stop();
      onJob(JSON.parse(event.data));
      onEnd();
    });
    source.onerror = () => {
      onLost(true);
      if (source.readyState === EventSource.CLOSED) timer = setTimeout(open, RETRY);
    };
  }

  function close() {
    clearTimeout(timer);
    source?.close();
  }

  function stop() {
    close();
    document.removeEventListener("visibilitychange", open);
  }

  document.addEventListener("visibilitychange", open);
  open();
  return stop;
}
