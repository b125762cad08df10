// What half the error takes.

const MOST = { samples: 2 ** 31, seconds: 30 * 86400 };
const LEAST_ERROR = 1e-6;

// {stop, seconds} of the contract that halves a finished render's error, of the kind that it had, and how much longer it
// renders for that, s; null where there is none. reached: the error that a contract of one looked at, if it is known.
export function halved({ target, seconds }, reached) {
  const { kind } = target;
  if (kind === "relative_error") {
    const error = Math.min(reached ?? target.relative_error, target.relative_error);
    const asked = Number((error / 2).toPrecision(3));
    if (!(asked >= LEAST_ERROR)) return null;
    return { stop: { ...target, relative_error: asked }, seconds: ((error / asked) ** 2 - 1) * seconds };
  }
  const more = 4 * target[kind];
  return more <= MOST[kind] ? { stop: { kind, [kind]: more }, seconds: 3 * seconds } : null;
}
