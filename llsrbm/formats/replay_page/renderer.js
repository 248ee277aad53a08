// Lit meshes with a shadow, a floor with a grid, translucent shells and lines of constant width,
// drawn with WebGL2. World: x ahead, y left, z up, m. Quaternions w, x, y, z.
"use strict";

const vec = {
  add: (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]],
  sub: (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]],
  times: (a, s) => a.map((value) => value * s),
  dot: (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2],
  cross: (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
    a[0] * b[1] - a[1] * b[0]],
  unit: (a) => vec.times(a, 1 / (Math.hypot(...a) || 1)),
  mix: (a, b, s) => a.map((value, i) => value + s * (b[i] - value)),
};

// 4 x 4 matrices, column after column as WebGL takes them.
function product(a, b) {
  const c = new Float32Array(16);
  for (let i = 0; i < 4; i++) {
    for (let j = 0; j < 4; j++) {
      for (let k = 0; k < 4; k++) c[4 * j + i] += a[4 * k + i] * b[4 * j + k];
    }
  }
  return c;
}

function looking(eye, target) {
  const back = vec.unit(vec.sub(eye, target));
  const right = vec.unit(vec.cross([0, 0, 1], back));
  const up = vec.cross(back, right);
  return [right[0], up[0], back[0], 0, right[1], up[1], back[1], 0, right[2], up[2], back[2], 0,
    -vec.dot(right, eye), -vec.dot(up, eye), -vec.dot(back, eye), 1];
}

// `raised`: by which share of half the picture's height the middle is above the picture's.
function perspective(fieldOfView, aspect, near, far, raised) {
  const f = 1 / Math.tan(fieldOfView / 2);
  return [f / aspect, 0, 0, 0, 0, f, 0, 0, 0, -raised, (near + far) / (near - far), -1,
    0, 0, (2 * near * far) / (near - far), 0];
}

function parallel(half, depth) {
  return [1 / half, 0, 0, 0, 0, 1 / half, 0, 0, 0, 0, -2 / depth, 0, 0, 0, -1, 1];
}

function rotation([w, x, y, z]) {
  return [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y),
    2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x),
    2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)];
}

const STILL = [1, 0, 0, 0];
const LIGHT = vec.unit([0.35, -0.55, 1.0]); // towards it
const HORIZON = [0.914, 0.929, 0.949]; // as in the style sheet
const SHADOW = 1024; // pixels

const PLACED = `#version 300 es
  precision highp float;
  layout(location = 0) in vec3 point;
  layout(location = 1) in vec3 normal;
  layout(location = 2) in vec4 paint;
  uniform mat4 seen, lit;
  uniform mat3 turn;
  uniform vec3 place, size, eye;
  uniform float behind; // m, away from the eye
  out vec3 at, across, inLight;
  out vec4 colour;
  void main() {
    at = place + turn * (size * point);
    across = turn * (normal / size);
    colour = paint;
    at += behind * normalize(at - eye);
    vec4 shaded = lit * vec4(at + 0.004 * normalize(across), 1.0);
    inLight = 0.5 + 0.5 * shaded.xyz;
    gl_Position = seen * vec4(at, 1.0);
  }`;

const SHADE = `
  uniform mediump sampler2DShadow shadow;
  float sunlight(vec3 inLight) {
    if (any(lessThan(inLight, vec3(0.0))) || any(greaterThan(inLight, vec3(1.0)))) return 1.0;
    float sum = 0.0;
    for (int i = -1; i <= 1; i++) for (int j = -1; j <= 1; j++) {
      vec2 offset = 1.8 * vec2(i, j) / ${SHADOW}.0;
      sum += texture(shadow, vec3(inLight.xy + offset, inLight.z - 0.0015));
    }
    return sum / 9.0;
  }`;

const MESH = `#version 300 es
  precision highp float;
  in vec3 at, across, inLight;
  in vec4 colour;
  uniform vec3 eye, light;
  uniform vec4 tint; // in place of the mesh's colours where its alpha is above 0
  uniform float shell; // 1: more opaque where seen from the side
  out vec4 pixel;
  ${SHADE}
  void main() {
    vec3 n = normalize(across), v = normalize(eye - at);
    if (dot(n, v) < 0.0 && shell < 0.5) n = -n;
    vec3 base = pow(tint.a > 0.0 ? tint.rgb : colour.rgb, vec3(2.2));
    float sun = max(dot(n, light), 0.0) * sunlight(inLight);
    vec3 sky = mix(vec3(0.30, 0.28, 0.27), vec3(0.62, 0.67, 0.75), 0.5 + 0.5 * n.z);
    float head = 0.22 * max(dot(n, v), 0.0);
    float shine = pow(max(dot(n, normalize(light + v)), 0.0), 36.0) * sun;
    float rim = pow(1.0 - max(dot(n, v), 0.0), 3.0);
    vec3 sum = base * (sky + 1.5 * sun * vec3(1.0, 0.97, 0.92) + head)
      + 0.16 * shine + 0.07 * rim * sky;
    float alpha = tint.a > 0.0 ? tint.a : 1.0;
    if (shell > 0.5) alpha *= 0.35 + 1.4 * pow(1.0 - abs(dot(n, v)), 1.5);
    sum = sum / (1.0 + 0.22 * max(max(sum.r, sum.g), sum.b)); // no glaring white
    pixel = vec4(pow(sum, vec3(1.0 / 2.2)), alpha);
  }`;

const NOTHING = `#version 300 es
  precision lowp float;
  void main() {}`;

const FLOOR = `#version 300 es
  precision highp float;
  in vec3 at, across, inLight;
  in vec4 colour;
  uniform vec3 eye, around;
  uniform float reach;
  out vec4 pixel;
  ${SHADE}
  float lines(float every, float width) {
    vec2 cell = at.xy / every, span = max(fwidth(cell), 1e-5);
    vec2 off = abs(fract(cell - 0.5) - 0.5) / span;
    vec2 on = clamp(width + 0.5 - off, 0.0, 1.0) * clamp(0.45 / span - 0.6, 0.0, 1.0);
    return max(on.x, on.y);
  }
  void main() {
    vec3 base = vec3(0.955, 0.962, 0.972);
    base = mix(base, vec3(0.80, 0.83, 0.87), 0.75 * lines(0.1, 0.35));
    base = mix(base, vec3(0.62, 0.67, 0.73), 0.85 * lines(0.5, 0.6));
    base *= mix(vec3(0.60, 0.63, 0.69), vec3(1.0), sunlight(inLight));
    float away = length(at.xy - around.xy) / reach;
    pixel = vec4(base, 1.0 - smoothstep(0.35, 1.0, away));
    if (eye.z < at.z) pixel.a *= 0.25;
  }`;

const RIBBON = `#version 300 es
  precision highp float;
  layout(location = 0) in vec4 start; // xyz, time
  layout(location = 1) in vec4 end;
  uniform mat4 seen;
  uniform mat3 turn;
  uniform vec3 place, size;
  uniform vec2 screen;
  uniform float width;
  out float when;
  void main() {
    vec4 a = seen * vec4(place + turn * (size * start.xyz), 1.0);
    vec4 b = seen * vec4(place + turn * (size * end.xyz), 1.0);
    bool second = (gl_VertexID & 1) == 1;
    float side = gl_VertexID < 2 ? -1.0 : 1.0;
    vec2 along = (b.xy / b.w - a.xy / a.w) * screen;
    along = length(along) > 1e-6 ? normalize(along) : vec2(1.0, 0.0);
    vec4 here = second ? b : a;
    when = second ? end.w : start.w;
    vec2 off = (side * vec2(-along.y, along.x) + (second ? 0.4 : -0.4) * along) * width;
    here.xy += off / screen * here.w;
    here.z -= 0.0006 * here.w; // above the floor that it lies on
    gl_Position = a.w < 0.01 || b.w < 0.01 ? vec4(2.0, 2.0, 2.0, 1.0) : here;
  }`;

const INK = `#version 300 es
  precision highp float;
  in float when;
  uniform vec4 tint;
  uniform float now;
  out vec4 pixel;
  void main() { pixel = vec4(tint.rgb, tint.a * (when > now ? 0.28 : 1.0)); }`;

// Whether there is no graphics card to draw with.
function drawnByProcessor() {
  const gl = document.createElement("canvas").getContext("webgl2");
  const told = gl && gl.getExtension("WEBGL_debug_renderer_info");
  const name = told ? gl.getParameter(told.UNMASKED_RENDERER_WEBGL) : "";
  gl?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software|basic render/i.test(name);
}

class Renderer {
  constructor(canvas) {
    this.slow = drawnByProcessor();
    const gl = canvas.getContext("webgl2", { antialias: !this.slow, alpha: false });
    if (!gl) throw new Error("this browser has no WebGL2");
    Object.assign(this, { canvas, gl });
    this.mesh = this.program(PLACED, MESH);
    this.depth = this.program(PLACED, NOTHING);
    this.floor = this.program(PLACED, FLOOR);
    this.ribbon = this.program(RIBBON, INK);
    this.shadow = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, this.shadow);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.DEPTH_COMPONENT24, SHADOW, SHADOW);
    for (const [name, value] of [["MIN_FILTER", gl.LINEAR], ["MAG_FILTER", gl.LINEAR],
      ["WRAP_S", gl.CLAMP_TO_EDGE], ["WRAP_T", gl.CLAMP_TO_EDGE],
      ["COMPARE_MODE", gl.COMPARE_REF_TO_TEXTURE], ["COMPARE_FUNC", gl.LEQUAL]]) {
      gl.texParameteri(gl.TEXTURE_2D, gl[`TEXTURE_${name}`], value);
    }
    this.shadowBuffer = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.shadowBuffer);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, this.shadow, 0);
    this.square = this.shape(square());
  }

  program(vertices, pixels) {
    const { gl } = this, made = gl.createProgram(), uniforms = {};
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertices], [gl.FRAGMENT_SHADER, pixels]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(made, shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) {
        throw new Error(gl.getShaderInfoLog(shader));
      }
    }
    gl.linkProgram(made);
    if (!gl.getProgramParameter(made, gl.LINK_STATUS)) {
      throw new Error(gl.getProgramInfoLog(made));
    }
    const count = gl.getProgramParameter(made, gl.ACTIVE_UNIFORMS);
    for (let i = 0; i < count; i++) {
      const { name, type } = gl.getActiveUniform(made, i);
      uniforms[name] = { at: gl.getUniformLocation(made, name), type };
    }
    return { made, uniforms };
  }

  // Take a program and set those of the values that it has.
  use(program, values) {
    const { gl } = this;
    gl.useProgram(program.made);
    for (const [name, value] of Object.entries(values)) {
      const uniform = program.uniforms[name];
      if (!uniform) continue;
      switch (uniform.type) {
        case gl.FLOAT: gl.uniform1f(uniform.at, value); break;
        case gl.FLOAT_VEC2: gl.uniform2fv(uniform.at, value); break;
        case gl.FLOAT_VEC3: gl.uniform3fv(uniform.at, value); break;
        case gl.FLOAT_VEC4: gl.uniform4fv(uniform.at, value); break;
        case gl.FLOAT_MAT3: gl.uniformMatrix3fv(uniform.at, false, value); break;
        case gl.FLOAT_MAT4: gl.uniformMatrix4fv(uniform.at, false, value); break;
        default: gl.uniform1i(uniform.at, value);
      }
    }
  }

  buffer(target, values) {
    const { gl } = this, made = gl.createBuffer();
    gl.bindBuffer(target, made);
    gl.bufferData(target, values, gl.STATIC_DRAW);
    return made;
  }

  // A mesh. `points` (n, 4) are floats, or shares of 32767 as 16 bit numbers; `normals` (n, 4)
  // floats or bytes; `paint` (n, 4) bytes or nothing.
  shape({ points, normals, paint, faces, unit = 1 }) {
    const { gl } = this, array = gl.createVertexArray();
    const kinds = { Float32Array: gl.FLOAT, Int16Array: gl.SHORT, Int8Array: gl.BYTE,
      Uint8Array: gl.UNSIGNED_BYTE };
    gl.bindVertexArray(array);
    [points, normals, paint].forEach((values, place) => {
      if (!values) return;
      this.buffer(gl.ARRAY_BUFFER, values);
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, place === 2 ? 4 : 3, kinds[values.constructor.name],
        !(values instanceof Float32Array), 4 * values.BYTES_PER_ELEMENT, 0);
    });
    this.buffer(gl.ELEMENT_ARRAY_BUFFER, faces);
    gl.bindVertexArray(null);
    return { array, count: faces.length, unit };
  }

  // A line through `points` (n, 4): x, y, z and when it is passed, s.
  line(points) {
    const { gl } = this, array = gl.createVertexArray();
    gl.bindVertexArray(array);
    this.buffer(gl.ARRAY_BUFFER, points);
    for (const place of [0, 1]) {
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, 4, gl.FLOAT, false, 16, 16 * place);
      gl.vertexAttribDivisor(place, 1);
    }
    gl.bindVertexArray(null);
    return { array, count: points.length / 4 - 1 };
  }

  // Draw one picture. view: eye, target, fieldOfView (rad), near, far, raised, reach (m, of the floor),
  // spot and span (m) of what casts shadows, floor (m). things: {shape, place, quat, size, tint}
  // in lists solid, shades (of what casts shadows), through (seen through the others), lines, and lists of such lists shells
  // (translucent, with `behind`, `shell`).
  draw(view, things) {
    const { gl, canvas } = this, screen = [canvas.width, canvas.height];
    const lit = product(parallel(view.span, 8 * view.span),
      looking(vec.add(view.spot, vec.times(LIGHT, 4 * view.span)), view.spot));
    const seen = product(
      perspective(view.fieldOfView, screen[0] / screen[1], view.near, view.far, view.raised),
      looking(view.eye, view.target));
    const common = { seen, lit, eye: view.eye, light: LIGHT, shadow: 0, screen,
      now: view.now, behind: 0, shell: 0 };

    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LEQUAL);
    gl.disable(gl.BLEND);
    gl.depthMask(true);
    gl.bindTexture(gl.TEXTURE_2D, null);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.shadowBuffer);
    gl.viewport(0, 0, SHADOW, SHADOW);
    gl.clear(gl.DEPTH_BUFFER_BIT);
    this.use(this.depth, { ...common, seen: lit });
    for (const thing of things.shades) this.put(this.depth, thing);

    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.bindTexture(gl.TEXTURE_2D, this.shadow);
    gl.viewport(0, 0, ...screen);
    gl.clearColor(...HORIZON, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    this.use(this.mesh, common);
    for (const thing of things.solid) this.put(this.mesh, thing);

    gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    this.use(this.floor, { ...common, around: view.spot, reach: view.reach });
    this.put(this.floor, { shape: this.square, place: [view.spot[0], view.spot[1], view.floor],
      size: [view.reach, view.reach, 1] });

    this.use(this.ribbon, common);
    for (const { line, place = [0, 0, 0], quat = STILL, size = [1, 1, 1], tint, width } of
      things.lines) {
      this.use(this.ribbon, { place, turn: rotation(quat), size, tint, width });
      gl.bindVertexArray(line.array);
      gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, line.count);
    }

    for (const shells of things.shells) this.fronts(common, shells);
    gl.clear(gl.DEPTH_BUFFER_BIT);
    this.fronts(common, things.through);
    gl.bindVertexArray(null);
  }

  // Of what is translucent only the front is seen: first its depth, then its colour.
  fronts(common, shells) {
    const { gl } = this;
    gl.colorMask(false, false, false, false);
    this.use(this.depth, common);
    for (const shell of shells) this.put(this.depth, shell);
    gl.colorMask(true, true, true, true);
    gl.depthMask(false);
    this.use(this.mesh, common);
    for (const shell of shells) this.put(this.mesh, shell);
    gl.depthMask(true);
  }

  put(program, { shape, place = [0, 0, 0], quat = STILL, size = [1, 1, 1], tint = [0, 0, 0, 0],
    behind = 0, shell = 0 }) {
    const { gl } = this;
    this.use(program, { place, turn: rotation(quat), size: vec.times(size, shape.unit), tint,
      behind, shell });
    gl.bindVertexArray(shape.array);
    gl.drawElements(gl.TRIANGLES, shape.count, gl.UNSIGNED_INT, 0);
  }
}

// Shapes of size one, from their points and normals.
function square() {
  return { points: new Float32Array([-1, -1, 0, 1, 1, -1, 0, 1, 1, 1, 0, 1, -1, 1, 0, 1]),
    normals: new Float32Array([0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0]),
    faces: new Uint32Array([0, 1, 2, 0, 2, 3]) };
}

function box() {
  const points = [], normals = [], faces = [];
  for (let axis = 0; axis < 3; axis++) {
    for (const side of [-1, 1]) {
      const first = points.length / 4;
      for (const [u, v] of [[-1, -1], [1, -1], [1, 1], [-1, 1]]) {
        const point = [0, 0, 0], normal = [0, 0, 0];
        point[axis] = side / 2;
        point[(axis + 1) % 3] = (u * side) / 2;
        point[(axis + 2) % 3] = v / 2;
        normal[axis] = side;
        points.push(...point, 1);
        normals.push(...normal, 0);
      }
      faces.push(first, first + 1, first + 2, first, first + 2, first + 3);
    }
  }
  return { points: new Float32Array(points), normals: new Float32Array(normals),
    faces: new Uint32Array(faces) };
}

// Turned around z: `outline` lists radius, height and the normal's two parts.
function turned(outline, sides) {
  const points = [], normals = [], faces = [], rows = outline.length;
  for (let i = 0; i <= sides; i++) {
    const c = Math.cos((2 * Math.PI * i) / sides), s = Math.sin((2 * Math.PI * i) / sides);
    for (const [radius, height, outwards, upwards] of outline) {
      points.push(radius * c, radius * s, height, 1);
      normals.push(outwards * c, outwards * s, upwards, 0);
    }
  }
  for (let i = 0; i < sides; i++) {
    for (let j = 0; j + 1 < rows; j++) {
      const a = i * rows + j, b = a + rows;
      faces.push(a, b, b + 1, a, b + 1, a + 1);
    }
  }
  return { points: new Float32Array(points), normals: new Float32Array(normals),
    faces: new Uint32Array(faces) };
}

const sphere = (rows = 24) => turned(Array.from({ length: rows + 1 }, (_, i) => {
  const c = Math.cos((Math.PI * i) / rows), s = Math.sin((Math.PI * i) / rows);
  return [s, -c, s, -c];
}), 2 * rows);
const rod = () => turned([[1, 0, 1, 0], [1, 1, 1, 0]], 16);
const tip = () => turned([[0, 0, 0, -1], [1, 0, 0, -1], [1, 0, 0.9, 0.4], [0, 1, 0.9, 0.4]], 20);

// Around the three axes of a ball of size one.
function hoops(steps = 96) {
  return [0, 1, 2].map((axis) => {
    const points = [];
    for (let i = 0; i <= steps; i++) {
      const point = [0, 0, 0, 0];
      point[(axis + 1) % 3] = Math.cos((2 * Math.PI * i) / steps);
      point[(axis + 2) % 3] = Math.sin((2 * Math.PI * i) / steps);
      points.push(...point);
    }
    return new Float32Array(points);
  });
}
