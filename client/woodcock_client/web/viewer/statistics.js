// What is to be known of a picture before it can be shown: its white, the range of its numbers, how they are distributed.

import { largestOf, numbersOf } from "./halves.js";

const LUMINANCE = [0.2126, 0.7152, 0.0722]; // of linear Rec. 709
const DIGITS = 11; // bits of a float32 that do not count here: numbers are told apart to 2^-12, as halves are

// The share of each channel in the number that a pixel stands for: luminance, or one channel by its name.
export function weightsOf({ channels }, channel) {
  if (channels.includes(channel)) return channels.map((each) => (each === channel ? 1 : 0));
  return channels.join("") === "RGB" ? LUMINANCE : channels.map((_, index) => (index === 0 ? 1 : 0));
}

// Numbers by their size, smallest first: `numbers`, and how often each is there or one that is hardly larger, `counts`.
class Distribution {
  constructor(numbers) {
    const bits = new Uint32Array(numbers.buffer);
    const tally = new Uint32Array(2 ** (32 - DIGITS));
    for (let index = 0; index < numbers.length; index++) {
      if (Number.isNaN(numbers[index])) continue;
      const size = bits[index];
      tally[(size >>> 31 ? ~size : size | 0x80000000) >>> DIGITS] += 1; // in the order of the numbers
    }
    this.numbers = [];
    this.counts = [];
    const size = new Int32Array(1);
    const number = new Float32Array(size.buffer);
    for (let key = 0; key < tally.length; key++) {
      if (tally[key] === 0) continue;
      const ordered = key << DIGITS;
      size[0] = (ordered < 0 ? ordered ^ 0x80000000 : ~ordered) & (-1 << DIGITS);
      this.numbers.push(number[0]);
      this.counts.push(tally[key]);
    }
    this.total = this.counts.reduce((sum, each) => sum + each, 0);
  }

  // Numbers that so many of a hundred are not above, linearly between neighbours, as numpy.percentile has them. above:
  // of the numbers above this one alone. Null where there are none.
  percentiles(wanted, above = -Infinity) {
    const first = this.numbers.findIndex((number) => number > above);
    if (first < 0) return null;
    const total = this.counts.slice(first).reduce((sum, each) => sum + each, 0);
    const at = (rank) => {
      let index = first;
      for (let before = this.counts[first]; before <= rank; before += this.counts[index]) index += 1;
      return this.numbers[index];
    };
    return wanted.map((percent) => {
      const rank = ((total - 1) * percent) / 100;
      const low = at(Math.floor(rank));
      return low + (at(Math.ceil(rank)) - low) * (rank % 1);
    });
  }
}

const kept = new WeakMap(); // by data, what was computed of it

function keep(data, key, compute) {
  if (!kept.has(data)) kept.set(data, new Map());
  const known = kept.get(data);
  if (!known.has(key)) known.set(key, compute());
  return known.get(key);
}

// The radiance that an exposure of its own brings to 1: white_of in kernels/woodcock/image.py.
export const whiteOf = (data) =>
  keep(data, "white", () => data.scale * new Distribution(largestOf(data)).percentiles([99])[0]);

const distributionOf = (data, channel) =>
  keep(data, `distribution ${channel}`, () => new Distribution(numbersOf(data, weightsOf(data, channel))));

// How many pixels have a channel that is no finite number.
export const badOf = (data) => data.width * data.height - distributionOf(data, "").total;

// What false colours go from and to: of linear ones the 1st and 99th percentile, or 0 where that is near; of logarithmic
// ones, of numbers above 0, up to four decades.
export function rangeOf(data, channel, logarithmic) {
  return keep(data, `range ${channel} ${logarithmic}`, () => {
    const distribution = distributionOf(data, channel);
    const found = logarithmic ? distribution.percentiles([1, 99.9], 0) : distribution.percentiles([1, 99]);
    if (found === null) return logarithmic ? [0.1, 1] : [0, 1];
    let [low, high] = found.map((number) => number * data.scale);
    if (logarithmic) return [Math.min(Math.max(low, high / 1e4), high / 10), high];
    if (low > 0 && low < high / 4) low = 0;
    return low < high ? [low, high] : [low - Math.abs(low || 1) / 2, low + Math.abs(low || 1) / 2];
  });
}

// Counts of numbers in equal steps from the smallest to the largest, or of their logarithms: {low, high, counts}.
export function histogramOf(data, channel, logarithmic, steps) {
  return keep(data, `histogram ${channel} ${logarithmic} ${steps}`, () => {
    const distribution = distributionOf(data, channel);
    const ends = distribution.percentiles([0, 100], logarithmic ? 0 : -Infinity);
    if (ends === null) return null;
    const [low, high] = logarithmic ? [Math.max(ends[0], ends[1] / 1e8), ends[1]] : ends;
    const of = logarithmic ? Math.log : (number) => number;
    const counts = new Array(steps).fill(0);
    const width = of(high) - of(low) || 1;
    distribution.numbers.forEach((number, index) => {
      const step = Math.min(steps - 1, Math.floor((steps * (of(number) - of(low))) / width));
      if (number >= low) counts[step] += distribution.counts[index];
    });
    return { low: low * data.scale, high: high * data.scale, counts };
  });
}
