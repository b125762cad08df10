// What the graphics card computes for each pixel of the canvas. Halves are unpacked here, from integers: textures of
// floats may be filtered by hardware that flushes small numbers and whose compiler assumes that there is no NaN.

import { STEPS } from "./colours.js";
import { TONE } from "./curves.js";

export const VERTEX = `#version 300 es
  void main() { // one triangle over everything
    gl_Position = vec4(4.0 * float(gl_VertexID & 1) - 1.0, 2.0 * float(gl_VertexID & 2) - 1.0, 0.0, 1.0);
  }`;

// How the numbers of a picture become colours: `looks` in appearance.js.
export const TONED = 0;
export const MAPPED = 1;
export const SPREAD = 2;

export const FRAGMENT = `#version 300 es
  precision highp float;
  precision highp int;
  precision highp usampler2D;

  uniform usampler2D picture;
  uniform ivec2 size;      // of the picture
  uniform int channels;
  uniform vec2 canvas;     // size of the canvas, pixels
  uniform vec2 corner;     // upper left of the picture on the canvas
  uniform float zoom;      // pixels of the canvas for one of the picture
  uniform bool panorama;
  uniform vec3 view;       // yaw, pitch, and the tangent of half of the vertical field of view
  uniform int many;        // directions along each side of a pixel

  uniform int how;
  uniform float gain;
  uniform int curve;
  uniform vec3 weights;    // of the channels in the number that is mapped
  uniform vec2 line;       // that number, or its logarithm, to 0 to 1: factor and summand
  uniform bool logarithmic;
  uniform vec3 colours[${STEPS}];
  uniform bool flagged;

  out vec4 colour;

  const float PI = 3.14159265358979;

  float half_to_float(uint bits) {
    uint exponent = (bits >> 10) & 31u, fraction = bits & 1023u;
    float value = exponent == 0u
      ? float(fraction) * 5.9604644775390625e-8 // 2^-24
      : uintBitsToFloat(((exponent + 112u) << 23) | (fraction << 13));
    return (bits & 32768u) == 0u ? value : -value;
  }

  // What was seen of some pixels, each with its weight: finite numbers, NaN and infinities.
  struct Sum { vec3 value; float finite; float nan; float infinite; };

  void add(inout Sum sum, ivec2 at, float weight) {
    uvec4 bits = texelFetch(picture, at, 0);
    if (channels == 1) bits = bits.xxxx;
    uvec3 magnitude = bits.xyz & 32767u;
    if (any(greaterThan(magnitude, uvec3(31744u)))) sum.nan += weight;
    else if (any(equal(magnitude, uvec3(31744u)))) sum.infinite += weight;
    else {
      sum.value += weight * vec3(half_to_float(bits.x), half_to_float(bits.y), half_to_float(bits.z));
      sum.finite += weight;
    }
  }

  // The mean over a rectangle of the picture: pixels are squares when they are large, and none is left out when they
  // are small.
  void add_area(inout Sum sum, vec2 low, vec2 high) {
    ivec2 first = max(ivec2(floor(low)), ivec2(0)), last = min(ivec2(ceil(high)), size) - 1;
    for (int y = first.y; y <= last.y; y++) {
      float tall = min(high.y, float(y + 1)) - max(low.y, float(y));
      for (int x = first.x; x <= last.x; x++) {
        add(sum, ivec2(x, y), tall * (min(high.x, float(x + 1)) - max(low.x, float(x))));
      }
    }
  }

  // Between four pixels, round the back too.
  void add_between(inout Sum sum, vec2 at) {
    vec2 from = floor(at - 0.5), part = at - 0.5 - from;
    for (int dy = 0; dy < 2; dy++) {
      for (int dx = 0; dx < 2; dx++) {
        ivec2 texel = ivec2(from) + ivec2(dx, dy);
        texel.x = (texel.x + size.x) % size.x;
        texel.y = clamp(texel.y, 0, size.y - 1);
        add(sum, texel, (dx == 0 ? 1.0 - part.x : part.x) * (dy == 0 ? 1.0 - part.y : part.y));
      }
    }
  }

  // The picture's point in the direction of a point of the canvas: kernels/woodcock/camera/spherical.py.
  vec2 seen(vec2 point) {
    vec2 film = (2.0 * point - canvas) / canvas.y * view.z;
    vec3 d = vec3(film.x, -film.y, 1.0);
    d.yz = vec2(d.y * cos(view.y) + d.z * sin(view.y), d.z * cos(view.y) - d.y * sin(view.y));
    float longitude = atan(d.x, d.z) + view.x, latitude = atan(d.y, length(d.xz));
    return vec2(fract(longitude / (2.0 * PI) + 0.5), 0.5 - latitude / PI) * vec2(size);
  }

  ${TONE}

  vec3 mapped(float t) {
    float place = clamp(t, 0.0, 1.0) * float(${STEPS - 1});
    int cell = min(int(place), ${STEPS - 2});
    return mix(colours[cell], colours[cell + 1], place - float(cell));
  }

  vec3 shown(vec3 value) {
    if (how == ${TONED}) return tone(max(value * gain, 0.0), curve);
    if (how == ${SPREAD}) return clamp(value * line.x + line.y, 0.0, 1.0);
    float number = dot(value, weights);
    if (logarithmic) number = number > 0.0 ? log2(number) : -1e30;
    return mapped(number * line.x + line.y);
  }

  void main() {
    vec2 point = vec2(gl_FragCoord.x, canvas.y - gl_FragCoord.y);
    Sum sum = Sum(vec3(0.0), 0.0, 0.0, 0.0);
    float cover = 1.0;
    if (panorama) {
      for (int y = 0; y < many; y++) {
        for (int x = 0; x < many; x++) {
          add_between(sum, seen(point - 0.5 + (vec2(x, y) + 0.5) / float(many)));
        }
      }
    } else {
      vec2 at = (point - corner) / zoom, reach = vec2(0.499 / zoom);
      vec2 low = max(at - reach, 0.0), high = min(at + reach, vec2(size));
      if (any(greaterThanEqual(low, high))) discard;
      cover = (high.x - low.x) * (high.y - low.y) / (4.0 * reach.x * reach.y);
      add_area(sum, low, high);
    }
    vec3 seen_colour = shown(sum.finite > 0.0 ? sum.value / sum.finite : vec3(0.0));
    // A single bad pixel is seen from afar too; from near, its edges are where they are.
    float bad = (sum.nan + sum.infinite) / (sum.finite + sum.nan + sum.infinite);
    if (flagged && bad > (zoom < 1.0 || panorama ? 0.0 : 0.5)) {
      seen_colour = sum.nan >= sum.infinite ? vec3(1.0, 0.0, 1.0) : vec3(0.0, 1.0, 1.0);
    }
    colour = vec4(seen_colour * cover, cover);
  }`;
