// The replay: a timeline over a scene that viser has exported, and the motion of its nodes.
"use strict";

const SPEEDS = [0.1, 0.25, 0.5, 1, 2];
const REST = 0.6; // s at the end before it begins again
const FAR = 10; // frames that an arrow key moves with Shift

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
  return Object.fromEntries(Object.entries(facts.arrays).map(([name, { start, length }]) =>
    [name, new Float32Array(bytes, start, length)]));
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
    this.seek(this.times[Math.min(Math.max(here + frames, 0), this.times.length - 1)]);
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

// ---- the picture: viser draws it, this moves its nodes

const TINY = [1e-6, 1e-6, 1e-6]; // a scale that is not seen

const add = (a, b, share = 1) => a.map((value, i) => value + share * b[i]);
const mix = (a, b, share) => a.map((value, i) => value + share * (b[i] - value));
const unit = (a) => a.map((value) => value / Math.hypot(...a));

// viser's viewer, once all nodes of the scene are there.
function viewer() {
  return new Promise((found) => {
    const wait = setInterval(() => {
      const there = window.__viserMutable;
      if (!there?.cameraControl || !facts.nodes.every((name) => there.nodeRefFromName[name])) return;
      clearInterval(wait);
      found(there);
    }, 30);
  });
}

class Picture {
  constructor(viser, numbers) {
    Object.assign(this, { viser, numbers, visible: {}, follow: false, followed: null });
    viser.camera.fov = facts.camera.fieldOfView;
    viser.camera.updateProjectionMatrix();
    this.com = facts.nodes.find((name) => name.endsWith("/com_now"));
    viser.nodeRefFromName[this.com].traverse((object) => {
      if (!object.material) return;
      Object.assign(object.material, { depthTest: false, transparent: true });
      object.renderOrder = 1; // over all else: it lies inside the robot
    });
    viser.canvas.addEventListener("dblclick", () => this.reset());
    this.reset();
  }

  // A number's value (n parts) at an instant, straight from frame to frame.
  value(array, n, [frame, share], first = 0, stride = n) {
    const last = array.length / stride - 1, a = frame * stride + first;
    const b = Math.min(frame + 1, last) * stride + first;
    return mix([...array.subarray(a, a + n)], array.subarray(b, b + n), share);
  }

  move(name, position, wxyz = [1, 0, 0, 0], scale = null) {
    const pose = this.viser.nodePoseData[name];
    Object.assign(pose, { position, wxyz });
    if (pose.poseUpdateState === "updated") pose.poseUpdateState = "needsUpdate";
    if (scale) this.viser.nodeRefFromName[name].scale.set(...scale);
  }

  show(name, visible) {
    if (this.visible[name] === visible) return;
    this.visible[name] = visible;
    this.viser.messageQueue.push({ type: "SetSceneNodeVisibilityMessage", name, visible });
  }

  moveBodies(layer, array, instant) {
    const stride = 7 * facts.bodies.length;
    facts.bodies.forEach((name, body) => {
      const place = this.value(array, 3, instant, 7 * body, stride);
      const quat = unit(this.value(array, 4, instant, 7 * body + 3, stride));
      this.move(`/${layer}/${name}`, place, quat);
    });
  }

  moveArrows(instant) {
    const { force } = this.numbers, { thickness } = facts.arrow;
    // Forces jump from frame to frame: they are those from this one to the next.
    const frame = instant[0] + (instant[1] > 0.999 ? 1 : 0);
    facts.legs.forEach((leg, i) => {
      const first = 6 * (frame * facts.legs.length + i), node = `/forces/${leg}`;
      const along = [...force.subarray(first + 3, first + 6)], size = Math.hypot(...along);
      const hide = (part) => this.move(`${node}/${part}`, [0, 0, 0], undefined, TINY);
      if (size < facts.arrow.least) return ["shaft", "head"].forEach(hide);
      const length = size * facts.arrow.perNewton, head = Math.min(6 * thickness, 0.5 * length);
      const z = unit(along);
      this.move(node, [...force.subarray(first, first + 3)],
        z[2] < -0.99999 ? [0, 1, 0, 0] : unit([1 + z[2], -z[1], z[0], 0]));
      const [wide, tip] = [thickness, 2.6 * thickness];
      this.move(`${node}/shaft`, [0, 0, 0], undefined, [wide, wide, length - head]);
      this.move(`${node}/head`, [0, 0, length - head], undefined, [tip, tip, head]);
    });
  }

  // As far as the robot has come; what is to come is a paler line of its own.
  drawTrails(time) {
    for (const { name, times } of facts.trails) {
      const count = times.filter((each) => each <= time).length;
      this.viser.nodeRefFromName[name].traverse(({ geometry }) => {
        if (geometry?.isInstancedBufferGeometry) geometry.instanceCount = count;
      });
    }
  }

  draw(player, layers) {
    const { numbers } = this, instant = player.at(player.time);
    const com = this.value(numbers.com, 3, instant);
    this.moveBodies("robot", numbers.solid, instant);
    if (numbers.ghost) this.moveBodies("ghost", numbers.ghost, instant);
    const turn = unit(this.value(numbers.ellipsoid, 4, instant, 3, 7));
    this.move("/ellipsoid", com, turn, this.value(numbers.ellipsoid, 3, instant, 0, 7));
    this.moveArrows(instant);
    this.drawTrails(player.time);
    this.move(this.com, com);
    for (const [layer, shown] of Object.entries(layers)) this.show(`/${layer}`, shown);
    // Boxes and boards that stand there, and faintly those that will.
    facts.blocks.forEach(({ from, until }, i) => {
      const over = until !== null && player.time >= until;
      this.show(`/blocks/${i}/there`, !over && from <= player.time);
      this.show(`/blocks/${i}/to_come`, !over && from > player.time);
    });
    if (this.follow && this.followed) this.carry(add(com, this.followed, -1));
    this.followed = com;
    this.viser.requestRender();
  }

  // viser's scene is turned in three's world, in which cameras are.
  inWorld(point) {
    const { camera, nodeRefFromName } = this.viser;
    return nodeRefFromName[""].localToWorld(camera.position.clone().set(...point)).toArray();
  }

  carry([x, y]) {
    const { cameraControl } = this.viser, moved = this.inWorld([x, y, 0]);
    const [from, to] = [cameraControl.getPosition(), cameraControl.getTarget()]
      .map((vector) => add(vector.toArray(), moved));
    cameraControl.setLookAt(...from, ...to, false);
  }

  reset() {
    const { eye, target, aspect } = facts.camera, { canvas, cameraControl } = this.viser;
    // Narrower windows need more distance than the picture that the distance is for.
    const further = Math.max(1, aspect * canvas.clientHeight / Math.max(canvas.clientWidth, 1));
    const from = this.inWorld(mix(target, eye, further));
    cameraControl.setLookAt(...from, ...this.inWorld(target), false);
    this.viser.requestRender();
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

function controls(player, picture) {
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
    pressed("Move along with the robot (F)", "Follow", picture, "follow"),
    button("Look from where it began (double-click)", "Reset view", () => picture.reset()),
    element("span", { class: "events", title: facts.timeline.summary }, facts.timeline.summary));
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
    if (colours[layer]) spot.style.background = facts.colours[colours[layer]];
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
      Object.assign(part.style, { left: percent(piece.start), background: piece.colour,
        width: `calc(${percent(piece.end)} - ${percent(piece.start)})` });
      row.append(part);
    }
    return row;
  }));
  const shown = marks.filter(({ time }) => share(time) <= 1.0001 && share(time) >= 0);
  for (const simulated of [false, true]) {
    const line = shown.filter((mark) => (mark.colour !== facts.colours.planned) === simulated);
    line.forEach(({ name, time, colour }, i) => {
      const mark = element("div", { class: "mark" }, element("span", {}, name));
      const near = i + 1 < line.length && share(line[i + 1].time) - share(time) < 0.12;
      mark.classList.toggle("second", simulated);
      mark.classList.toggle("left", near || share(time) > 0.85);
      Object.assign(mark.style, { left: percent(time), background: colour, color: colour });
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
  window.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.target.matches("select, input") && event.key !== " ") return;
    const many = event.shiftKey ? FAR : 1;
    const does = { " ": () => player.toggle(), ArrowLeft: () => player.step(-many),
      ArrowRight: () => player.step(many), Home: () => player.seek(player.start),
      End: () => player.seek(player.end), l: () => press("L"), f: () => press("F") }[event.key];
    if (!does) return;
    event.preventDefault(); // a button in focus would be pressed as well
    event.stopImmediatePropagation(); // and viser would move its camera
    does();
  }, true);
}

function announce(outcome, bad) {
  find("#replay header p").textContent = outcome;
  find("#replay header p").classList.toggle("bad", bad);
}

async function begin() {
  find("#replay h1").textContent = facts.title;
  announce(facts.outcome, facts.bad);
  const [viser, numbers] = await Promise.all([viewer(), unpacked()]);
  const player = new Player(numbers.time), picture = new Picture(viser, numbers);
  const layers = { robot: true, ...(numbers.ghost ? { ghost: true } : {}), ellipsoid: true,
    forces: true, trails: true };
  let stale = true;
  const changed = () => { stale = true; };
  player.changed = changed;
  const written = [controls(player, picture), track(player)];
  layerSwitches(layers, changed);
  keys(player);
  const fit = () =>
    document.body.style.setProperty("--bar", `${find("#replay footer").offsetHeight}px`);
  new ResizeObserver(fit).observe(find("#replay footer"));
  fit();
  let before = performance.now();
  const frame = (now) => {
    player.advance(Math.min(now - before, 100) / 1000);
    before = now;
    if (stale) {
      stale = false;
      picture.draw(player, layers);
      written.forEach((write) => write());
    }
    requestAnimationFrame(frame);
  };
  requestAnimationFrame(frame);
  player.play();
  window.replay = { player, picture, layers, changed };
}

begin().catch((error) =>
  announce(`This replay cannot be shown: ${error.message || error}.`, true));
