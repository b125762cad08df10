// What each line of a certificate stands for, in plain words: what is looked at, how, and what a failure would mean.

export const MEANINGS = {
  "standard error": {
    what: "How well the brightness of the whole picture is known.",
    how: "The picture is rendered in many launches. How much their means differ is compared with what the pixels’ own scatter predicts.",
    failed: "The two disagree: samples depend on each other, or a few outweigh all others. The error that is stated is too small.",
  },
  bound: {
    what: "How far any pixel can be off. There is no noise in this picture, so this is a limit and no estimate.",
    how: "The errors of rounding and of interpolation are carried along every ray.",
    failed: "Some pixels have no such limit: nothing is known of how far they are off.",
  },
  "worst tile": {
    what: "Where the picture is least certain.",
    how: "The error of a pixel, averaged over each tile of 32 × 32; the largest is named.",
    failed: "The error of the tiles is not known.",
  },
  convergence: {
    what: "Whether the error shrinks as it should: half of it in four times the samples.",
    how: "A line through the error’s history, with allowance for what its points share; chance flags one render in ten thousand.",
    failed: "The error falls at another pace: a few rare samples carry much of the light, or there is a bias. More time may not help.",
  },
  contract: {
    what: "Whether what the scene asks for was kept.",
    how: "The samples, seconds or error that were reached, against those that were asked for.",
    failed: "The picture has less than was asked for. Extending it may reach it.",
  },
  samples: {
    what: "Whether every sample was a number that light can have.",
    how: "Each one is looked at: none may be infinite, negative, undefined or unfinished, and none is clamped.",
    failed: "Some were thrown away, which makes the picture darker than it should be. Few do little harm; many are a fault of the scene or of the renderer.",
  },
  majorant: {
    what: "Whether light was tracked through the medium by valid bounds of its density.",
    how: "Each tentative collision compares the density with the bound that it was drawn by.",
    failed: "The medium is denser somewhere than its bound: light gets through too easily there, and the picture is biased.",
  },
  series: {
    what: "Whether any orders of scattering were left out.",
    how: "Paths end by chance in a way that keeps the mean, and what the later orders hold is measured where the scene asks for orders.",
    failed: "Orders are missing: the picture is too dark.",
  },
  rounding: {
    what: "What single precision does to the picture.",
    how: "The same paths are traced in double precision, and the means compared.",
    failed: "Rounding moves the picture by more than it may. Sizes or densities of the scene differ by too much for single precision.",
  },
  build: {
    what: "How the program was compiled.",
    how: "The compiler’s options are listed; some make arithmetic faster and less exact.",
    failed: "How the program was built is not known.",
  },
  laws: {
    what: "Whether this program keeps the laws that light keeps, on this device.",
    how: "It renders small scenes whose answer is known.",
    failed: "The program is wrong on this device.",
  },
  "white furnace": {
    what: "Whether light is neither lost nor made.",
    how: "The scene is lit evenly from everywhere and absorbs nothing: nothing may be seen of it.",
    failed: "The program loses or makes light on this device: brightness is wrong.",
  },
  "isothermal furnace": {
    what: "Whether a glowing medium gives as much light as it takes.",
    how: "The medium stands between walls as hot as itself: nothing may be seen of it.",
    failed: "Glow and absorption do not balance: fires are too bright or too dark.",
  },
  darkness: {
    what: "Whether light comes from lights alone.",
    how: "All lights are switched off: every pixel must be black.",
    failed: "The program makes light out of nothing.",
  },
  absorption: {
    what: "Whether random paths agree with an exact calculation.",
    how: "Scattering is switched off, and the picture compared with one computed without random numbers.",
    failed: "Random paths absorb too much or too little light on this device.",
  },
  "squared transmittance": {
    what: "Whether light fades as it should.",
    how: "Twice the medium must let through the square of what the medium lets through.",
    failed: "Light fades wrongly with depth on this device.",
  },
};
