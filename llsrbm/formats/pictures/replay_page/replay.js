// The replay: unpacks the motion, plays it, and lets people look at it from where they want.
"use strict";

const SPEEDS = [0.1, 0.25, 0.5, 1, 2];
const REST = 0.6; // s at the end before it begins again
const FAR = 10; // frames that an arrow key moves with Shift
const KINDS = { "<f4": Float32Array, "<i2": Int16Array, "|i1": Int8Array, "|u1": Uint8Array,
  "<u4": Uint32Array };

const facts = JSON.parse(document.getElementById("facts").textContent);
const find = (selector) => document.querySelector(selector);

function element(kind, attributes = {}, ...children) {
  const made = document.createElement(kind);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else made.setAttribute(name, value);
  }
  made.append(...children);
  return made;
}

// The numbers: base64 of a gzip of one array after the other, where `facts.arrays` says.
async function unpacked() {
  const text = atob(document.getElementById("numbers").textContent);
  const packed = Uint8Array.from(text, (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  const bytes = await new Response(stream).arrayBuffer();
  return Object.fromEntries(Object.entries(facts.arrays).map(([name, { kind, start, length }]) =>
    [name, new KINDS[kind](bytes, start, length)]));
}

// ---- time

class Player {
  constructor(times) {
    Object.assign(this, { times, start: times[0], end: times[times.length - 1] });
    Object.assign(this, { time: this.start, playing: false, loop: true, speed: 0.5, rested: 0 });
    this.changed = () => {};
  }

  // Index of the frame at or before a time, and the share of the way to the next.
  at(time) {
    let low = 0, high = this.times.length - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (this.times[middle] <= time) low = middle; else high = middle;
    }
    const share = (time - this.times[low]) / (this.times[high] - this.times[low] || 1);
    return [low, Math.min(Math.max(share, 0), 1)];
  }

  seek(time) {
    this.time = Math.min(Math.max(time, this.start), this.end);
    this.rested = 0;
    this.changed();
  }

  step(frames) {
    this.pause();
    const [frame, share] = this.at(this.time);
    const here = frame + (share > 0.999 ? 1 : 0);
    const next = Math.min(Math.max(here + frames, 0), this.times.length - 1);
    this.seek(this.times[next]);
  }

  play() {
    if (this.time >= this.end) this.seek(this.start);
    this.playing = true;
    this.changed();
  }

  pause() { this.playing = false; this.changed(); }

  toggle() { if (this.playing) this.pause(); else this.play(); }

  // Go on by `seconds` of the wall's clock.
  advance(seconds) {
    if (!this.playing) return;
    if (this.time < this.end) {
      this.time = Math.min(this.time + this.speed * seconds, this.end);
    } else if (!this.loop) {
      this.playing = false;
    } else {
      this.rested += seconds;
      if (this.rested >= REST) Object.assign(this, { time: this.start, rested: 0 });
    }
    this.changed();
  }
}

// ---- camera

class Camera {
  constructor(canvas, changed) {
    Object.assign(this, { canvas, changed, follow: false });
    this.pointers = new Map();
    this.reset();
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      this.pointers.set(event.pointerId, [event.clientX, event.clientY]);
    });
    for (const name of ["pointerup", "pointercancel"]) {
      canvas.addEventListener(name, (event) => this.pointers.delete(event.pointerId));
    }
    canvas.addEventListener("pointermove", (event) => this.dragged(event));
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.zoom(Math.exp(event.deltaY * (event.deltaMode === 1 ? 0.03 : 0.0012)));
    }, { passive: false });
    canvas.addEventListener("dblclick", () => this.reset());
  }

  reset() {
    const { target, azimuth, elevation, distance } = facts.camera;
    // Narrower windows need more distance than the picture that the distance is for.
    const aspect = this.canvas.clientWidth / Math.max(this.canvas.clientHeight, 1);
    const further = Math.max(1, facts.camera.aspect / aspect);
    Object.assign(this, { target: [...target], azimuth, elevation, distance: distance * further });
    this.changed();
  }

  dragged(event) {
    const before = this.pointers.get(event.pointerId);
    if (!before) return;
    const here = [event.clientX, event.clientY];
    const dx = here[0] - before[0], dy = here[1] - before[1];
    if (this.pointers.size === 2) {
      const other = [...this.pointers].find(([id]) => id !== event.pointerId)[1];
      const apart = (point) => Math.max(Math.hypot(point[0] - other[0], point[1] - other[1]), 10);
      this.zoom(apart(before) / apart(here));
      this.pan(dx / 2, dy / 2);
    } else if (event.buttons & 6 || event.shiftKey) {
      this.pan(dx, dy);
    } else {
      this.turn(dx, dy);
    }
    this.pointers.set(event.pointerId, here);
  }

  turn(dx, dy) {
    this.azimuth -= 0.4 * dx;
    this.elevation = Math.min(Math.max(this.elevation + 0.3 * dy, -5), 89);
    this.changed();
  }

  pan(dx, dy) {
    const { right, up } = this.axes();
    const step = (2 * this.distance * Math.tan(facts.camera.fieldOfView / 2))
      / this.canvas.clientHeight;
    this.target = vec.add(this.target, vec.add(vec.times(right, -dx * step),
      vec.times(up, dy * step)));
    this.changed();
  }

  zoom(factor) {
    this.distance = Math.min(Math.max(this.distance * factor, 0.1), 50);
    this.changed();
  }

  axes() {
    const a = (this.azimuth * Math.PI) / 180, e = (this.elevation * Math.PI) / 180;
    const back = [Math.cos(e) * Math.cos(a), Math.cos(e) * Math.sin(a), Math.sin(e)];
    const right = [-Math.sin(a), Math.cos(a), 0];
    return { right, up: vec.cross(back, right), back };
  }
}

// ---- what is drawn

class Scene {
  constructor(renderer, numbers) {
    const { gl } = renderer;
    Object.assign(this, { gl, renderer, numbers, drawn: {} });
    this.coarse = this.shapes("coarse");
    this.fine = renderer.slow ? this.coarse : this.shapes("fine");
    this.ball = renderer.shape(sphere());
    this.cube = renderer.shape(box());
    this.shaft = renderer.shape(rod());
    this.head = renderer.shape(tip());
    this.hoops = hoops().map((points) => renderer.line(points));
    this.trails = this.paths();
  }

  // The bodies' meshes, with all faces or with few.
  shapes(detail) {
    const { numbers } = this;
    let point = 0, face = 0;
    return facts.bodies.map(({ [detail]: { points, faces } }) => {
      const of = (name) => numbers[`${detail}_${name}`].subarray(4 * point, 4 * (point + points));
      const shape = this.renderer.shape({ points: of("points"), normals: of("normals"),
        paint: of("paint"), unit: facts.meshUnit,
        faces: numbers[`${detail}_faces`].subarray(3 * face, 3 * (face + faces)) });
      [point, face] = [point + points, face + faces];
      return shape;
    });
  }

  // Lines of the CoM over the whole motion, and of the feet in flight.
  paths() {
    const { time, com, ghost_com, foot, flight } = this.numbers, lines = [];
    const add = (layer, tint, width, pick, frames) => {
      if (frames.length < 2) return;
      const points = frames.flatMap((frame) => [...pick(frame), time[frame]]);
      const line = this.renderer.line(new Float32Array(points));
      lines.push({ layer, line, tint, width });
    };
    const of = (array, width) => (frame) => array.subarray(width * frame, width * frame + 3);
    const all = [...time.keys()], flying = all.filter((frame) => flight[frame]);
    if (ghost_com) add("ghost", [...facts.colours.planned, 0.8], 1.5, of(ghost_com, 3), all);
    add("trails", [...facts.colours.com, 0.95], 2.6, of(com, 3), all);
    for (let leg = 0; leg < facts.legs; leg++) {
      const pick = (frame) => {
        const first = 3 * (frame * facts.legs + leg);
        return foot.subarray(first, first + 3);
      };
      add("trails", [...facts.colours.foot, 0.9], 1.8, pick, flying);
    }
    return lines;
  }

  // A number's value (n parts) at an instant, straight from frame to frame.
  value(array, n, [frame, share], first = 0, stride = n) {
    const last = array.length / stride - 1, a = frame * stride + first;
    const b = Math.min(frame + 1, last) * stride + first;
    return vec.mix([...array.subarray(a, a + n)], array.subarray(b, b + n), share);
  }

  pose(array, body, instant) {
    const stride = 7 * facts.bodies.length;
    const place = this.value(array, 3, instant, 7 * body, stride);
    const quat = this.value(array, 4, instant, 7 * body + 3, stride);
    return { place, quat: vec.times(quat, 1 / Math.hypot(...quat)) };
  }

  arrows(instant) {
    const { force } = this.numbers, arrows = [], stride = 6 * facts.legs;
    // Forces jump from frame to frame: they are those from this one to the next.
    const frame = instant[0] + (instant[1] > 0.999 ? 1 : 0);
    for (let leg = 0; leg < facts.legs; leg++) {
      const first = frame * stride + 6 * leg;
      const place = [...force.subarray(first, first + 3)];
      const along = [...force.subarray(first + 3, first + 6)];
      const size = Math.hypot(...along), length = size * facts.arrow.perNewton;
      if (size < facts.arrow.least) continue;
      const z = vec.times(along, 1 / size), { thickness } = facts.arrow;
      const quat = z[2] < -0.99999 ? [0, 1, 0, 0] : vec.times([1 + z[2], -z[1], z[0], 0],
        1 / Math.sqrt(2 + 2 * z[2]));
      const head = Math.min(6 * thickness, 0.5 * length);
      const tint = [...facts.colours.force, 1];
      arrows.push({ shape: this.shaft, place, quat, tint,
        size: [thickness, thickness, length - head] });
      arrows.push({ shape: this.head, place: vec.add(place, vec.times(z, length - head)), quat,
        tint, size: [2.6 * thickness, 2.6 * thickness, head] });
    }
    return arrows;
  }

  // Boxes and boards that stand there, and faintly those that will.
  blocks(time) {
    const { block } = facts.colours;
    return facts.blocks.filter(({ until }) => until === null || time < until)
      .map(({ centre, size, yaw, from }) => ({ shape: this.cube, place: centre, size,
        stands: from <= time, tint: [...block, from <= time ? 1 : 0.16],
        quat: [Math.cos(yaw / 2), 0, 0, Math.sin(yaw / 2)] }));
  }

  draw(player, camera, layers) {
    const { numbers } = this, instant = player.at(player.time);
    const com = this.value(numbers.com, 3, instant);
    const blocks = this.blocks(player.time), solid = blocks.filter(({ stands }) => stands);
    const shells = blocks.filter(({ stands }) => !stands).map((block) => [block]);
    const shades = [...solid], through = [], lines = [];
    this.drawn = {};
    facts.bodies.forEach(({ name }, body) => {
      const pose = this.pose(numbers.solid, body, instant);
      this.drawn[name] = [...pose.place, ...pose.quat];
      if (!layers.robot) return;
      solid.push({ shape: this.fine[body], ...pose });
      shades.push({ shape: this.coarse[body], ...pose });
    });
    if (layers.forces) {
      for (const part of this.arrows(instant)) {
        solid.push(part);
        through.push({ ...part, tint: [...facts.colours.force, 0.4] });
      }
    }
    if (layers.ellipsoid) {
      const size = this.value(numbers.ellipsoid, 3, instant, 0, 7);
      let quat = this.value(numbers.ellipsoid, 4, instant, 3, 7);
      quat = vec.times(quat, 1 / Math.hypot(...quat));
      const tint = facts.colours.ellipsoid;
      shells.push([{ shape: this.ball, place: com, quat, size, tint: [...tint, 0.27], shell: 1 }]);
      for (const line of this.hoops) {
        lines.push({ line, place: com, quat, size: vec.times(size, 1.004), width: 1.2,
          tint: [...tint, 0.75] });
      }
    }
    if (layers.ghost && numbers.ghost) {
      shells.push(facts.bodies.map((_, body) => ({ shape: this.coarse[body],
        ...this.pose(numbers.ghost, body, instant), tint: [...facts.colours.planned, 0.3],
        behind: 0.012 })));
    }
    if (layers.trails) {
      const radius = facts.arrow.thickness * 1.6;
      through.push({ shape: this.ball, place: com, size: [radius, radius, radius],
        tint: [...facts.colours.com, 0.9] });
    }
    lines.push(...this.trails.filter(({ layer }) => layers[layer]));

    const { canvas } = this.renderer, { back } = camera.axes();
    const start = this.value(numbers.com, 3, [0, 0]);
    const moved = camera.follow ? [com[0] - start[0], com[1] - start[1], 0] : [0, 0, 0];
    const target = vec.add(camera.target, moved);
    const eye = vec.add(target, vec.times(back, camera.distance));
    this.renderer.draw({
      eye, target, fieldOfView: facts.camera.fieldOfView, near: 0.04 * camera.distance,
      far: camera.distance + 30, reach: Math.max(6, 2.2 * camera.distance), floor: facts.ground,
      spot: [com[0], com[1], facts.ground], span: facts.span, now: player.time,
      // In the middle of what title and timeline leave free.
      raised: (find("footer").offsetHeight - find("header").offsetHeight) / canvas.clientHeight,
    }, { solid, shades, shells, lines: lines.map((line) => ({ ...line,
      width: line.width * this.density })), through });
  }
}

// ---- what people press

const SIGNS = { play: "M2 0v14l11-7z", pause: "M1 0h4v14H1zM9 0h4v14H9z",
  back: "M1 0h3v14H1zM13 0v14L5 7z", forth: "M1 0v14l8-7zM10 0h3v14h-3z" };

function sign(name) {
  const drawing = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  const path = document.createElementNS("http://www.w3.org/2000/svg", "path");
  drawing.setAttribute("viewBox", "0 0 14 14");
  path.setAttribute("d", SIGNS[name]);
  drawing.append(path);
  return drawing;
}

const button = (label, content, onclick) =>
  element("button", { type: "button", "aria-label": label, title: label, onclick }, content);

function controls(player, camera) {
  const toggle = button("Play or pause (space)", sign("play"), () => player.toggle());
  toggle.className = "play";
  const pace = element("select", { "aria-label": "Speed", title: "Speed",
    onchange: () => { player.speed = Number(pace.value); } },
    ...SPEEDS.map((speed) => element("option", { value: speed }, `${speed}×`)));
  pace.value = player.speed;
  const pressed = (label, text, holder, name) => {
    const made = button(label, text, () => {
      holder[name] = !holder[name];
      made.setAttribute("aria-pressed", holder[name]);
      player.changed();
    });
    made.setAttribute("aria-pressed", holder[name]);
    return made;
  };
  const clock = element("output", {});
  find("#controls").append(
    button("One frame back (left arrow)", sign("back"), () => player.step(-1)), toggle,
    button("One frame on (right arrow)", sign("forth"), () => player.step(1)), clock, pace,
    pressed("Begin again at the end (L)", "Loop", player, "loop"),
    pressed("Move along with the robot (F)", "Follow", camera, "follow"),
    button("Look from where it began (double-click)", "Reset view", () => camera.reset()),
    element("span", { class: "told", title: facts.timeline.told }, facts.timeline.told));
  return () => {
    if (toggle.dataset.sign !== String(player.playing)) {
      toggle.replaceChildren(sign(player.playing ? "pause" : "play"));
      toggle.dataset.sign = player.playing;
    }
    clock.value = `${player.time.toFixed(3)} s of ${player.end.toFixed(2)} s`;
  };
}

function layerSwitches(layers, changed) {
  const colours = { ghost: "planned", ellipsoid: "ellipsoid", forces: "force", trails: "com" };
  const names = { robot: facts.rollout ? "Simulated robot" : "Robot", ghost: "Plan",
    ellipsoid: "Inertia ellipsoid", forces: "Contact forces", trails: "CoM, trails" };
  for (const [layer, name] of Object.entries(names)) {
    if (!(layer in layers)) continue;
    const box = element("input", { type: "checkbox", onchange: () => {
      layers[layer] = box.checked;
      changed();
    } });
    box.checked = layers[layer];
    const spot = element("i");
    if (colours[layer]) {
      const rgb = facts.colours[colours[layer]].map((share) => Math.round(255 * share));
      spot.style.background = `rgb(${rgb})`;
    }
    find("#layers").append(element("label", {}, box, name, spot));
  }
}

function track(player) {
  const share = (time) => (time - player.start) / (player.end - player.start);
  const percent = (time) => `${100 * Math.min(Math.max(share(time), 0), 1)}%`;
  const { rows, marks } = facts.timeline;
  find("#rows").append(...rows.map(({ name, pieces }) => {
    const row = element("div", { class: "row", title: name });
    for (const piece of pieces) {
      const feet = piece.feet ? `, ${piece.feet}` : "";
      const part = element("div", { title: `${name}: ${piece.name}${feet}` },
        rows.length > 1 ? `${name}: ${piece.name}` : piece.name);
      part.classList.toggle("low", piece.low);
      part.style.left = percent(piece.start);
      part.style.width = `calc(${percent(piece.end)} - ${percent(piece.start)})`;
      part.style.background = piece.colour;
      row.append(part);
    }
    return row;
  }));
  const shown = marks.filter(({ time }) => share(time) <= 1.0001 && share(time) >= 0);
  for (const simulated of [false, true]) {
    const line = shown.filter((mark) => mark.simulated === simulated);
    line.forEach(({ name, time, colour }, i) => {
      const mark = element("div", { class: "mark" }, element("span", {}, name));
      const near = i + 1 < line.length && share(line[i + 1].time) - share(time) < 0.12;
      mark.classList.toggle("second", simulated);
      mark.classList.toggle("left", near || share(time) > 0.85);
      mark.style.left = percent(time);
      mark.style.background = mark.style.color = colour;
      find("#track").append(mark);
    });
  }
  const scrub = (event) => {
    const { left, width } = find("#rows").getBoundingClientRect();
    player.seek(player.start + ((event.clientX - left) / width) * (player.end - player.start));
  };
  let goesOn = false, held = false;
  find("#track").addEventListener("pointerdown", (event) => {
    find("#track").setPointerCapture(event.pointerId);
    [goesOn, held] = [player.playing, true];
    player.pause();
    scrub(event);
  });
  find("#track").addEventListener("pointermove", (event) => { if (held) scrub(event); });
  for (const name of ["pointerup", "pointercancel"]) {
    find("#track").addEventListener(name, () => {
      if (held && goesOn && player.time < player.end) player.play();
      held = false;
    });
  }
  return () => { find("#cursor").style.transform = `translateX(${100 * share(player.time)}%)`; };
}

function keys(player) {
  const press = (label) => find(`[aria-label*="(${label})"]`).click();
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.target.matches("select, input") && event.key !== " ") return;
    const many = event.shiftKey ? FAR : 1;
    const does = { " ": () => player.toggle(), ArrowLeft: () => player.step(-many),
      ArrowRight: () => player.step(many), Home: () => player.seek(player.start),
      End: () => player.seek(player.end), l: () => press("L"), f: () => press("F") }[event.key];
    if (!does) return;
    event.preventDefault(); // a button in focus would be pressed as well
    does();
  });
}

async function begin() {
  document.querySelector("h1").textContent = facts.title;
  const told = find("header p");
  told.textContent = facts.told;
  told.classList.toggle("bad", facts.bad);
  const canvas = find("#picture");
  const renderer = new Renderer(canvas);
  const numbers = await unpacked();
  const player = new Player(numbers.time);
  const scene = new Scene(renderer, numbers);
  const layers = { robot: true, ...(numbers.ghost ? { ghost: true } : {}), ellipsoid: true,
    forces: true, trails: true };
  let stale = true;
  const changed = () => { stale = true; };
  player.changed = changed;
  const camera = new Camera(canvas, changed);
  const written = [controls(player, camera), track(player)];
  layerSwitches(layers, changed);
  keys(player);

  const fit = () => {
    scene.density = Math.min(window.devicePixelRatio || 1, 2);
    canvas.width = Math.max(Math.round(canvas.clientWidth * scene.density), 1);
    canvas.height = Math.max(Math.round(canvas.clientHeight * scene.density), 1);
    changed();
  };
  new ResizeObserver(fit).observe(canvas);
  fit();
  camera.reset();
  let before = performance.now();
  const frame = (now) => {
    player.advance(Math.min(now - before, 100) / 1000);
    before = now;
    if (stale) {
      stale = false;
      scene.draw(player, camera, layers);
      written.forEach((write) => write());
    }
    requestAnimationFrame(frame);
  };
  requestAnimationFrame(frame);
  player.play();
  window.replay = { player, camera, layers, scene, changed };
}

begin().catch((error) => {
  const told = find("header p");
  told.textContent = `This replay cannot be shown: ${error.message || error}.`;
  told.classList.add("bad");
});
