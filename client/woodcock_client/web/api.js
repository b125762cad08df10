// The service's HTTP API. A call resolves to the answer, or throws a Problem with a sentence to show.

const ROOT = "/api/v1";

export class Problem extends Error {
  // status 0: no answer at all; errors: of single fields, {field, message}
  constructor(status, detail, errors = []) {
    super(detail);
    this.status = status;
    this.errors = errors;
  }
}

const NO_ANSWER = "The service does not answer.";

// Said to the window when the service asks who is there: the gallery shows where to sign in.
export const SIGNED_OUT = "woodcock-signed-out";

async function ask(path, options) {
  const response = await answer(path, { cache: "no-store", ...options, headers: { Accept: "application/json", ...options.headers } });
  if (response.status === 204) return null;
  const body = await response.json().catch(() => null);
  if (body === null) throw new Problem(response.status, `The service answered ${response.status}.`);
  return body;
}

async function answer(path, options) {
  let response;
  try {
    response = await fetch(path, options);
  } catch (error) {
    if (error.name === "AbortError") throw error;
    throw new Problem(0, NO_ANSWER);
  }
  if (!response.ok) throw refusal(response.status, await response.json().catch(() => null));
  return response;
}

function refusal(status, body) {
  if (status === 401) dispatchEvent(new Event(SIGNED_OUT));
  return new Problem(status, body?.detail || `The service answered ${status}.`, body?.errors);
}

const get = (path, signal) => ask(path, { signal });

// key: what comes twice under it is done once
const send = (method, path, body, { key, ...options } = {}) =>
  ask(path, {
    ...options,
    method,
    headers: { ...(body && { "Content-Type": "application/json" }), ...(key && { "Idempotency-Key": key }) },
    body: body && JSON.stringify(body),
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

export const getLayers = (link, signal) => get(link, signal);

// {body: ArrayBuffer, headers}; the browser keeps what the service says that it may.
export async function getLayer(link, signal) {
  const response = await answer(link, { signal });
  try {
    return { body: await response.arrayBuffer(), headers: response.headers };
  } catch (error) {
    if (error.name === "AbortError") throw error;
    throw new Problem(0, NO_ANSWER);
  }
}

export const getPixels = (job, { x, y, width = 1, height = 1 }, signal) =>
  get(`${job.links.self}/pixels?${new URLSearchParams({ x, y, width, height })}`, signal);

// Comparing

// Jobs that have succeeded, newest first. wanted: {text} in their name, {batch} that they are of.
export const findFinished = (wanted, signal) =>
  get(`${ROOT}/jobs?${new URLSearchParams({ state: "succeeded", limit: 100, ...wanted })}`, signal);

// How far a job's picture is from another's, the reference; flip: with FLIP, which takes seconds.
export const getDifference = (id, reference, { flip }, signal) =>
  get(`${ROOT}/jobs/${encodeURIComponent(id)}/differences/${encodeURIComponent(reference)}?flip=${flip}`, signal);

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

// Submitting

// The schemas of everything that the API takes, by name.
export const getSchemas = (signal) => get("/openapi.json", signal).then((api) => api.components.schemas);

export const listExamples = (signal) => get(`${ROOT}/examples`, signal);

export const validateJob = (job, signal) => send("POST", `${ROOT}/jobs/validate`, job, { signal });

export const checkJob = (job, signal) => send("POST", `${ROOT}/jobs/check`, job, { signal });

export const submitBatch = (batch, key) => send("POST", `${ROOT}/batches`, batch, { key });

// Files that scenes name

export const listVolumes = (cursor, signal) => {
  const query = new URLSearchParams({ limit: 20 });
  if (cursor) query.set("cursor", cursor);
  return get(`${ROOT}/volumes?${query}`, signal);
};

export const getRange = (id, grid, signal) =>
  get(`${ROOT}/volumes/${encodeURIComponent(id)}/range?${new URLSearchParams({ grid })}`, signal);

export const sliceAddress = (id, { grid, axis, position }) =>
  `${ROOT}/volumes/${encodeURIComponent(id)}/slice.png?${new URLSearchParams({ grid, axis, position })}`;

// Sends a File, calls onProgress with the share that is sent, and resolves to what it is. fetch() tells no progress.
export function uploadVolume(file, onProgress, signal) {
  return new Promise((resolve, reject) => {
    const request = new XMLHttpRequest();
    request.open("POST", `${ROOT}/volumes?${new URLSearchParams({ name: file.name })}`);
    request.responseType = "json";
    request.upload.onprogress = (event) => event.lengthComputable && onProgress(event.loaded / event.total);
    request.onload = () =>
      request.status < 300 ? resolve(request.response) : reject(refusal(request.status, request.response));
    request.onerror = () => reject(new Problem(0, NO_ANSWER));
    request.onabort = () => reject(new DOMException("", "AbortError"));
    signal.addEventListener("abort", () => request.abort());
    request.send(file);
  });
}
