// Tone curves: from radiance that exposure brought near 1 to what a screen shows, as GLSL and in words.
//
// Each function takes linear Rec. 709 radiance, 0 or more, and returns display values that are sRGB-encoded.

export const CURVES = {
  soft: {
    name: "Soft",
    // As previews have it (kernels/woodcock/image.py, tone_map), so that nothing changes where a viewer takes its place.
    formula: "x up to 0.8, then 0.8 + 0.2 (1 − e^(−(x − 0.8) / 0.2)); sRGB",
    glsl: `
      vec3 curve_soft(vec3 x) {
        return srgb(mix(x, 0.8 + 0.2 * (1.0 - exp(-(x - 0.8) / 0.2)), greaterThanEqual(x, vec3(0.8))));
      }`,
  },
  linear: {
    name: "Linear",
    formula: "x, clipped at 1; sRGB (IEC 61966-2-1)",
    glsl: `
      vec3 curve_linear(vec3 x) {
        return srgb(x);
      }`,
  },
  filmic: {
    name: "Filmic",
    // John Hable, "Filmic Tonemapping for Real-time Rendering" (SIGGRAPH 2010 course; "Uncharted 2"): his constants, his
    // exposure of 2 and his white of 11.2.
    formula: "h(2x) / h(11.2), h(x) = (x (0.15x + 0.05) + 0.004) / (x (0.15x + 0.5) + 0.06) − 0.02 / 0.3; sRGB",
    glsl: `
      vec3 hable(vec3 x) {
        return (x * (0.15 * x + 0.05) + 0.004) / (x * (0.15 * x + 0.5) + 0.06) - 0.02 / 0.3;
      }
      vec3 curve_filmic(vec3 x) {
        return srgb(hable(min(2.0 * x, 1e6)) / hable(vec3(11.2)));
      }`,
  },
  agx: {
    name: "AgX",
    // Troy Sobotka's AgX, in the approximation of Benjamin Wrensch, "Minimal AgX Implementation" (2023; MIT): colours are
    // drawn together, 16.5 stops from 2^-12.47393 to 2^4.026069 go through a polynomial of degree 6 that stands for
    // AgX's sigmoid, and colours are drawn apart again. What comes out is display-encoded already.
    formula: "inset, log₂ from −12.47 to 4.03, sigmoid (polynomial of degree 6), outset",
    glsl: `
      const mat3 AGX_INSET = mat3(
        0.842479062253094, 0.0423282422610123, 0.0423756549057051,
        0.0784335999999992, 0.878468636469772, 0.0784336,
        0.0792237451477643, 0.0791661274605434, 0.879142973793104);
      const mat3 AGX_OUTSET = mat3(
        1.19687900512017, -0.0528968517574562, -0.0529716355144438,
        -0.0980208811401368, 1.15190312990417, -0.0980434501171241,
        -0.0990297440797205, -0.0989611768448433, 1.15107367264116);
      vec3 curve_agx(vec3 x) {
        vec3 t = (clamp(log2(max(AGX_INSET * x, 1e-10)), -12.47393, 4.026069) + 12.47393) / 16.499999;
        vec3 s = ((((((15.5 * t - 40.14) * t + 31.96) * t - 6.868) * t + 0.4298) * t + 0.1191) * t) - 0.00232;
        return clamp(AGX_OUTSET * s, 0.0, 1.0);
      }`,
  },
};

export const CURVE_NAMES = Object.keys(CURVES);

// `vec3 tone(vec3 x, int curve)`: curve is an index into CURVE_NAMES.
export const TONE = `
  vec3 srgb(vec3 linear) {
    vec3 x = clamp(linear, 0.0, 1.0);
    return mix(12.92 * x, 1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055, greaterThan(x, vec3(0.0031308)));
  }
  ${CURVE_NAMES.map((name) => CURVES[name].glsl).join("\n")}
  vec3 tone(vec3 x, int curve) {
    ${CURVE_NAMES.map((name, index) => `if (curve == ${index}) return curve_${name}(x);`).join("\n    ")}
    return x;
  }`;
