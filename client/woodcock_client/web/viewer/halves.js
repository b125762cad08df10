// IEEE half floats, as numbers.

// Of each of the 65536.
const NUMBERS = Float32Array.from({ length: 1 << 16 }, (_, bits) => {
  const sign = bits & 0x8000 ? -1 : 1;
  const exponent = (bits >> 10) & 31;
  const fraction = bits & 1023;
  if (exponent === 31) return fraction ? NaN : sign * Infinity;
  return sign * (exponent ? (1 + fraction / 1024) * 2 ** (exponent - 15) : fraction * 2 ** -24);
});

export const isFiniteHalf = (bits) => (bits & 0x7c00) !== 0x7c00;

// One number for each pixel: the sum of its channels by weight, in units of the data's scale; NaN unless all its
// channels are finite.
export function numbersOf({ values, channels }, weights) {
  const many = channels.length;
  const numbers = new Float32Array(values.length / many);
  for (let pixel = 0, at = 0; pixel < numbers.length; pixel++, at += many) {
    let sum = 0;
    for (let channel = 0; channel < many; channel++) {
      const bits = values[at + channel];
      sum += isFiniteHalf(bits) ? weights[channel] && weights[channel] * NUMBERS[bits] : NaN;
    }
    numbers[pixel] = sum;
  }
  return numbers;
}

// As numbersOf, but the largest of its channels; what is not finite counts as 0.
export function largestOf({ values, channels }) {
  const many = channels.length;
  const numbers = new Float32Array(values.length / many);
  for (let pixel = 0, at = 0; pixel < numbers.length; pixel++, at += many) {
    let largest = -Infinity;
    for (let channel = 0; channel < many; channel++) {
      const bits = values[at + channel];
      largest = Math.max(largest, isFiniteHalf(bits) ? NUMBERS[bits] : 0);
    }
    numbers[pixel] = largest;
  }
  return numbers;
}
