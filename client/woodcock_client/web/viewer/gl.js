// WebGL2: a picture of halves in a texture, drawn with a view of it. Knows nothing of the page.

import { STEPS, tableOf } from "./colours.js";
import { FRAGMENT, VERTEX } from "./shaders.js";

export class Fault extends Error {}

export class Screen {
  // Throws a Fault that says why nothing can be drawn here.
  constructor(canvas) {
    const gl = canvas.getContext("webgl2", { antialias: false, depth: false });
    if (!gl) throw new Fault("This browser draws no WebGL2, or is set not to.");
    this.gl = gl;
    this.restore();
  }

  // After the context was lost, and at first.
  restore() {
    const { gl } = this;
    this.program = link(gl);
    this.at = new Map();
    this.texture = gl.createTexture();
    this.data = null;
    this.map = null;
    gl.useProgram(this.program);
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    // Integers have no filter but this one.
    for (const each of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, each, gl.NEAREST);
    for (const each of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, each, gl.CLAMP_TO_EDGE);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 2);
  }

  // data: {width, height, channels, values}. Throws a Fault.
  show(data) {
    const { gl } = this;
    if (data === this.data) return;
    const most = gl.getParameter(gl.MAX_TEXTURE_SIZE);
    if (Math.max(data.width, data.height) > most) {
      throw new Fault(`The picture is larger than the ${most} pixels a side that this graphics card draws.`);
    }
    const [internal, format] = { 1: [gl.R16UI, gl.RED_INTEGER], 3: [gl.RGB16UI, gl.RGB_INTEGER] }[data.channels.length];
    while (gl.getError() !== gl.NO_ERROR);
    gl.texImage2D(gl.TEXTURE_2D, 0, internal, data.width, data.height, 0, format, gl.UNSIGNED_SHORT, data.values);
    if (gl.getError() === gl.OUT_OF_MEMORY) throw new Fault("The picture does not fit into the graphics card’s memory.");
    this.data = data;
    gl.uniform2i(this.place("size"), data.width, data.height);
    gl.uniform1i(this.place("channels"), data.channels.length);
  }

  // looks: appearance.js; placed: placement.js. Both in device pixels.
  draw(looks, placed) {
    const { gl } = this;
    const { width, height } = gl.canvas;
    gl.viewport(0, 0, width, height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT);
    if (!this.data) return;
    gl.uniform2f(this.place("canvas"), width, height);
    gl.uniform2f(this.place("corner"), placed.left, placed.top);
    gl.uniform1f(this.place("zoom"), placed.zoom);
    gl.uniform1i(this.place("panorama"), placed.panorama ? 1 : 0);
    gl.uniform3f(this.place("view"), placed.yaw, placed.pitch, placed.tangent);
    gl.uniform1i(this.place("many"), placed.many);
    gl.uniform1i(this.place("how"), looks.how);
    gl.uniform1f(this.place("gain"), looks.gain);
    gl.uniform1i(this.place("curve"), looks.curve);
    gl.uniform3fv(this.place("weights"), looks.weights);
    gl.uniform2fv(this.place("line"), looks.line);
    gl.uniform1i(this.place("logarithmic"), looks.logarithmic ? 1 : 0);
    gl.uniform1i(this.place("flagged"), looks.flagged ? 1 : 0);
    if (looks.map && looks.map !== this.map) {
      gl.uniform3fv(this.place("colours"), tableOf(looks.map), 0, 3 * STEPS);
      this.map = looks.map;
    }
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  // Browsers keep few contexts; those of pages that are gone should not be among them.
  close() {
    this.gl.getExtension("WEBGL_lose_context")?.loseContext();
  }

  place(name) {
    if (!this.at.has(name)) this.at.set(name, this.gl.getUniformLocation(this.program, name));
    return this.at.get(name);
  }
}

function link(gl) {
  const program = gl.createProgram();
  for (const [kind, source] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS) && !gl.isContextLost()) {
      throw new Fault(`This browser’s graphics driver does not take the viewer: ${gl.getShaderInfoLog(shader)}`);
    }
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost()) {
    throw new Fault(`This browser’s graphics driver does not take the viewer: ${gl.getProgramInfoLog(program)}`);
  }
  return program;
}
