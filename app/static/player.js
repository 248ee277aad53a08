// Plays clips (app/motion/clip.py) without the server: it moves viser's nodes on every frame.
// Leans on what viser exposes to its own tests: __viserMutable and __viserTestpoints.
(() => {
  const HOLD = 0.7; // s of rest at the end before a loop starts anew
  const LARGEST_STEP = 0.1; // s; a tab that was hidden goes on where it was
  const SETTLE = 1.5; // s; nodes may come after their clip
  const REPORT_EVERY = 100; // ms between messages to the server while scrubbing
  const SLOW = 1 / 33, FAST = 1 / 58; // s a frame, beyond which the resolution changes
  const FINEST = 1, COARSEST = 0.45; // pixels a CSS pixel without a graphics processor
  const WINDOW = 12; // frames between decisions about the resolution
  const HURRIED = 0.35; // pixels a CSS pixel while clips come in a hurry
  const HURRY = 700; // ms after a slider's last step, or between two clips: drawn coarsely, and
  const SPARING = 250; // ms; without a graphics processor no oftener than this,
  const FRESH = 50; // ms; but for a moment after each clip
  const ABOVE = "/push/"; // nodes below are drawn over all else: arrows that begin in a robot

  const llsrbm = window.llsrbm;
  const listeners = new Set();
  let clip = null, time = 0, playing = false, speed = 1, loop = true, held = 0;
  let range = null; // [from, to] s that is played again and again; null: all
  let last = null, settleUntil = 0, requested = false;
  let reportedAt = -Infinity, reportLater = null;
  let resolution = FINEST, frames = 0, spent = 0, drawn = 0;
  let hurry = false, hurriedAt = -Infinity, sparedAt = -Infinity;
  let loadedAt = -Infinity, applied = null, seen = null;

  // Names of the fields of viser's that are missing.
  const lacks = () => llsrbm.lacking(window, ["__viserMutable.nodePoseData",
    "__viserMutable.nodeRefFromName", "__viserMutable.requestRender",
    "__viserTestpoints.rendererInfo", "__viserTestpoints.devSettings"]);

  // ---- clips

  function decode(header, blob) {
    const bytes = Uint8Array.from(atob(blob), (c) => c.charCodeAt(0));
    const numbers = new Float32Array(bytes.buffer);
    let at = 0;
    const take = (n) => numbers.subarray(at, (at += n));
    const channels = header.channels.map(({ frames, tracks }) => ({
      time: take(frames),
      tracks: tracks.map(({ nodes, turns, scales }) => ({
        nodes,
        position: take(3 * frames),
        wxyz: turns ? take(4 * frames) : null,
        scale: scales ? take(3 * frames) : null,
      })),
    }));
    return { ...header, channels };
  }

  // Index of the instant before `t`, and how far `t` is from it to the next, 0 to 1.
  function place(times, t) {
    const lastIndex = times.length - 1;
    if (lastIndex < 1 || t <= times[0]) return [0, 0];
    if (t >= times[lastIndex]) return [lastIndex - 1, 1];
    let low = 0, high = lastIndex;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (times[middle] <= t) low = middle;
      else high = middle;
    }
    return [low, (t - times[low]) / (times[high] - times[low])];
  }

  function mix(values, size, index, share) {
    const out = new Array(size), a = index * size, b = share > 0 ? a + size : a;
    for (let i = 0; i < size; i++) out[i] = values[a + i] + share * (values[b + i] - values[a + i]);
    return out;
  }

  function unit(q) {
    const norm = Math.hypot(...q) || 1;
    return q.map((value) => value / norm);
  }

  function apply() {
    const viewer = window.__viserMutable;
    if (!clip || lacks().length) return;
    for (const channel of clip.channels) {
      const [index, share] = place(channel.time, time);
      for (const track of channel.tracks) {
        const position = mix(track.position, 3, index, share);
        const wxyz = track.wxyz && unit(mix(track.wxyz, 4, index, share));
        const scale = track.scale && mix(track.scale, 3, index, share);
        for (const name of track.nodes) {
          const pose = viewer.nodePoseData[name];
          if (pose) {
            pose.position = position;
            if (wxyz) pose.wxyz = wxyz;
            if (pose.poseUpdateState === "updated") pose.poseUpdateState = "needsUpdate";
          }
          if (scale) viewer.nodeRefFromName[name]?.scale.set(...scale);
        }
      }
    }
    raise(viewer);
    viewer.requestRender();
  }

  function raise(viewer) {
    for (const [name, node] of Object.entries(viewer.nodeRefFromName))
      if (node && name.startsWith(ABOVE)) node.traverse(lift);
  }

  function lift(object) {
    if (!object.material || object.material.depthTest === false) return;
    // Translucent objects are drawn after all others.
    Object.assign(object.material, { depthTest: false, depthWrite: false, transparent: true });
    object.material.needsUpdate = true;
    object.renderOrder = 1;
  }

  // ---- time

  function frame(now) {
    requested = false;
    const step = last === null ? 0 : (now - last) / 1000;
    last = now;
    if (playing && clip) {
      const moved = Math.min(step, LARGEST_STEP) * speed;
      const [start, stop] = bounds();
      if (time < stop) time = Math.min(time + moved, stop);
      else if (loop) {
        held += moved / speed;
        if (stop < clip.end || held >= HOLD) {
          time = start;
          held = 0;
        }
      } else {
        playing = false;
        report();
      }
      if (!hurry) adapt(step);
    }
    spare(now);
    if (hurry && now - hurriedAt > HURRY) {
      hurry = false;
      if (playing) draw(resolution);
    }
    notice(now);
    if (!llsrbm.skips) {
      apply();
      drawn += 1;
      changed();
    }
    if (playing || now < settleUntil) request();
    else {
      last = null;
      llsrbm.skips = false;
      draw(FINEST);
    }
  }

  // From where to where it plays: the range, unless it was sought behind it.
  function bounds() {
    const [from, to] = loop && range && range[0] < clip.end ? range : [0, clip.end];
    return [from, time > to ? clip.end : Math.min(to, clip.end)];
  }

  // A jump is on its way that is planned on the same processor: that is worth more than the picture.
  function hasten() {
    hurriedAt = performance.now();
    if (!hurry) draw(HURRIED);
    hurry = true;
    settle();
  }

  function spare(now) {
    llsrbm.skips =
      llsrbm.software && hurry && now - loadedAt > FRESH && now - sparedAt < SPARING;
    if (!llsrbm.skips) sparedAt = now;
  }

  // Takes down when a clip's first picture has been rendered.
  function notice(now) {
    const rendered = window.__viserTestpoints?.rendererInfo.render.frame;
    if (!clip || rendered === undefined || seen?.clip === clip) return;
    if (applied?.clip !== clip) applied = { clip, rendered };
    else if (rendered > applied.rendered) seen = { clip, request: clip.request, at: now };
  }

  function request() {
    if (!requested) {
      requested = true;
      requestAnimationFrame(frame);
    }
  }

  function settle() {
    settleUntil = performance.now() + 1000 * SETTLE;
    request();
  }

  // A still picture is worth its time; a moving one is drawn as finely as it stays smooth.
  function adapt(step) {
    if (!llsrbm.software || step <= 0 || step > 0.5) return;
    spent += step;
    if (++frames < WINDOW) return;
    const mean = spent / frames;
    frames = spent = 0;
    if (mean > SLOW) resolution = Math.max(COARSEST, resolution - 0.25);
    else if (mean < FAST) resolution = Math.min(FINEST, resolution + 0.125);
    draw(resolution);
  }

  function draw(pixels) {
    if (!llsrbm.software) return;
    const settings = window.__viserTestpoints?.devSettings;
    if (settings && settings.get().fixedDpr !== pixels) settings.set({ fixedDpr: pixels });
  }

  function play() {
    if (!clip || playing) return;
    const [start, stop] = bounds();
    if (time >= stop) time = start;
    held = 0;
    playing = true;
    window.llsrbm.tour?.offer();
    draw(resolution);
    report();
    request();
  }

  function pause() {
    if (!playing) return;
    playing = false;
    report();
    settle();
  }

  function seek(instant) {
    time = Math.min(Math.max(instant, 0), clip ? clip.end : 0);
    held = 0;
    report();
    settle();
  }

  function goTo(instant) {
    pause();
    seek(instant);
  }

  // ---- the server

  function report() {
    clearTimeout(reportLater);
    const wait = reportedAt + REPORT_EVERY - performance.now();
    if (wait > 0) reportLater = setTimeout(report, wait);
    else {
      reportedAt = performance.now();
      llsrbm.page.send({ kind: "state", time, playing });
    }
  }

  function changed() {
    for (const listener of listeners) listener();
  }

  // Steps of a slider, by hand and by keys.
  const SLIDER = ".mantine-Slider-root";
  let dragged = false;
  window.addEventListener("pointerdown", ({ target }) => {
    dragged = Boolean(target.closest?.(SLIDER));
  }, true);
  window.addEventListener("pointermove", ({ buttons }) => dragged && buttons && hasten(), true);
  window.addEventListener("keydown", ({ target, key }) => {
    if (key.startsWith("Arrow") && target.closest?.(SLIDER)) hasten();
  }, true);

  llsrbm.require(lacks);

  llsrbm.player = {
    load(header, blob, number) {
      clip = decode(header, blob);
      time = Math.min(time, clip.end);
      const now = performance.now();
      if (now - loadedAt < HURRY) hasten();
      loadedAt = now;
      llsrbm.skips = false;
      // Loaded within a frame of viser's, before it moves its nodes: they are drawn in this frame.
      notice(now);
      apply();
      window.llsrbm.camera?.show(header.camera_target);
      window.llsrbm.parts?.forget();
      settle();
      llsrbm.page.send({ kind: "clip", number });
    },
    clear() {
      clip = null;
      changed();
    },
    play, pause, seek, goTo, settle,
    toggle: () => (playing ? pause() : play()),
    // One step is a sixtieth of a second: the distance between a clip's instants.
    step(frames) {
      goTo(time + frames / 60);
    },
    setSpeed(value) {
      speed = value;
      changed();
    },
    setLoop(value) {
      loop = value;
      changed();
    },
    setRange(value) {
      range = value;
      changed();
    },
    listen: (listener) => listeners.add(listener),
    get clip() { return clip; },
    get time() { return time; },
    get playing() { return playing; },
    get speed() { return speed; },
    get loop() { return loop; },
    get range() { return range; },
    get frames() { return drawn; },
    get resolution() { return resolution; },
    get seen() { return seen; },
  };
})();
