// Logarithmic axes: limits with some air, ticks at round numbers, and the minor lines between decades.

const LEAST = 0.6; // decades that an axis shows at least
const MINOR = 4; // decades up to which every digit has its line
// Multiples within a decade that ticks may stand at, from few to many
const STEPS = [
  [1, 3],
  [1, 2, 5],
  [1, 2, 3, 5, 7],
];

// Maps positive values to [start, stop]; at(value) is where one lies, low and high are the limits.
export function axisOver(values, start, stop) {
  const logs = values.map(Math.log10);
  const [least, most] = [Math.min(...logs), Math.max(...logs)];
  const air = Math.max(LEAST - (most - least), 0) / 2 + 0.04 * Math.max(most - least, LEAST);
  const [low, high] = [10 ** (least - air), 10 ** (most + air)];
  const at = (value) => start + (Math.log(value / low) / Math.log(high / low)) * (stop - start);

  const first = Math.floor(least - air);
  const decades = Array.from({ length: Math.ceil(most + air) - first + 1 }, (_, index) => first + index);
  const round = (chosen, steps) =>
    chosen.flatMap((decade) => steps.map((step) => step * 10 ** decade)).filter((value) => low <= value && value <= high);

  // As many round numbers as there is room for, each taking so many units of the axis.
  function ticks(room) {
    const limit = Math.max(2, Math.floor(Math.abs(stop - start) / room));
    const every = Math.ceil(decades.length / (limit + 1));
    let found = round(decades.filter((decade) => decade % every === 0), [1]);
    if (every > 1) return found;
    for (const steps of STEPS) {
      const more = round(decades, steps);
      const gaps = more.slice(1).map((value, index) => Math.abs(at(value) - at(more[index])));
      if (more.length <= limit && Math.min(...gaps) >= 0.7 * room) found = more;
    }
    return found;
  }

  const minor = () => (high / low > 10 ** MINOR ? round(decades, [1]) : round(decades, [1, 2, 3, 4, 5, 6, 7, 8, 9]));

  return { low, high, start, stop, at, ticks, minor };
}
