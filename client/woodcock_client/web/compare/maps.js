// Maps of how two pictures differ: what they show, and in which colours.

// colours: of viewer/colours.js. span: colours go so far to either side of 0; top: from 0 to there; where neither is given,
// as far as nearly all pixels go, to both sides of 0 if `zero`. part: a channel of its own is shown, not their luminance.
export const MAPS = {
  difference: {
    name: "Difference",
    formula: "I − R",
    says: "Red where the render is brighter than the reference, blue where it is darker.",
    unit: "radiance",
    colours: "rdbu",
    zero: true,
  },
  absolute: {
    name: "Size of the difference",
    formula: "|I − R|",
    says: "In the scene’s unit of radiance.",
    unit: "radiance",
    colours: "inferno",
  },
  relative: {
    name: "Relative square",
    formula: "(I − R)² / (R² + ε), ε = 0.01 ⟨R⟩²",
    says: "Dark parts count as much as bright ones. Its mean is the relMSE, with the reference’s noise still in it.",
    colours: "inferno",
  },
  smape: {
    name: "SMAPE",
    formula: "|I − R| / (|I| + |R|)",
    says: "From 0, equal, to 1, one of them black.",
    colours: "inferno",
    top: 1,
  },
  flip: {
    name: "FLIP",
    formula: "HDR-FLIP, Andersson et al. 2021, at 67 pixels a degree",
    says: "What an eye sees that flips between the two, at the exposure where it sees most: from 0, nothing, to 1.",
    colours: "inferno",
    top: 1,
  },
  z: {
    name: "z-score",
    formula: "z = (I − R) / √(var I + var R)",
    says: "How many standard errors apart. Noise is an even grain of which 1 pixel in 22 is beyond ±2; bias has shapes, or one colour.",
    colours: "rdbu",
    span: 5,
    part: true,
  },
};

const LUMINANCE = "";

// The channel of a map that is shown, of those that it has.
export const channelOf = (map, { channels }, wanted) =>
  channels.includes(wanted) ? wanted : MAPS[map].part && channels.length > 1 ? channels[1] : LUMINANCE;

// [low, high] of its colours. found: as statistics.js has it.
export function rangeOf(map, [low, high]) {
  const { span, top, zero } = MAPS[map];
  if (span) return [-span, span];
  if (top) return [0, top];
  const most = Math.max(-low, high, Number.MIN_VALUE);
  return [zero ? -most : 0, most];
}
