// Numbers and times as text. Digits are grouped by thin spaces, so that 1 024 means the same everywhere.

export function count(n) {
  return String(Math.round(n)).replace(/\B(?=(\d{3})+$)/g, "\u2009");
}

export const samples = (n) => `${count(n)} sample${n === 1 ? "" : "s"}`;

// Three significant digits, without an exponent where the number is of everyday size.
export function number(x) {
  if (x === 0) return "0";
  const size = Math.abs(x);
  if (size >= 1e5 || size < 1e-4) {
    const [mantissa, exponent] = x.toExponential(1).split("e");
    const digits = [...String(Number(exponent))].map((c) => (c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[c])).join("");
    return `${mantissa} × 10${digits}`;
  }
  return size >= 100 ? count(x) : String(Number(x.toPrecision(3)));
}

export const percent = (x) => `${number(100 * x)} %`;

const UNITS = ["bytes", "kB", "MB", "GB", "TB"];

export function bytes(n) {
  const power = Math.min(n < 1000 ? 0 : Math.floor(Math.log10(n) / 3), UNITS.length - 1);
  return `${number(n / 1000 ** power)} ${UNITS[power]}`;
}

export function duration(seconds) {
  if (seconds === 0) return "0 s";
  if (seconds < 0.1) return `${number(1000 * seconds)} ms`;
  if (seconds < 59.5) return `${seconds < 10 ? seconds.toFixed(1) : Math.round(seconds)} s`;
  const whole = Math.round(seconds);
  const minutes = Math.floor(whole / 60);
  if (minutes < 60) return `${minutes} min ${String(whole % 60).padStart(2, "0")} s`;
  return `${Math.floor(minutes / 60)} h ${String(minutes % 60).padStart(2, "0")} min`;
}

export function ago(iso, now) {
  const seconds = Math.max(0, (now - Date.parse(iso)) / 1000);
  if (seconds < 60) return "just now";
  if (seconds < 3600) return `${Math.floor(seconds / 60)} min ago`;
  if (seconds < 86400) return `${Math.floor(seconds / 3600)} h ago`;
  if (seconds < 7 * 86400) return `${Math.floor(seconds / 86400)} d ago`;
  return new Date(iso).toLocaleDateString("en-GB", { day: "numeric", month: "short", year: "numeric" });
}

export const moment = (iso) =>
  new Date(iso).toLocaleString("en-GB", { dateStyle: "medium", timeStyle: "medium" });

export const title = (job) => job.name || "Untitled";

// The seconds that were asked for, as they were: 6 s, not 6.0 s.
const limit = ({ target: { seconds } }) => (seconds < 60 ? `${number(seconds)} s` : duration(seconds));

const TARGETS = {
  samples: (job) => `${samples(job.target.samples)} per pixel`,
  seconds: (job) => `${limit(job)} of rendering`,
  relative_error: ({ target }) => `an error of ${percent(target.relative_error)}${target.per === "tile" ? " in every tile" : ""}`,
};

export const target = (job) => TARGETS[job.target.kind](job);

const PROGRESS = {
  samples: (job) => `${count(job.samples)} of ${target(job)}`,
  seconds: (job) => `${duration(job.seconds)} of ${limit(job)}, ${samples(job.samples)} per pixel`,
  relative_error: (job) => `${samples(job.samples)} per pixel, down to ${target(job)}`,
};

export const progress = (job) => PROGRESS[job.target.kind](job);

// Is it computed without random numbers? Not known before a device has prepared it.
export const isDeterministic = (job) => ["transmittance", "emission_absorption"].includes(job.integrator);

// Ids of uploaded files by their first digits: in one line they would leave no room for what is said of them.
export const brief = (text) => text.replace(/(sha256:[0-9a-f]{8})[0-9a-f]{56}/g, "$1…");

export const STATES = {
  queued: "Queued",
  running: "Rendering",
  cancelling: "Stopping",
  succeeded: "Done",
  failed: "Failed",
  cancelled: "Cancelled",
};
