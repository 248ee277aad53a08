// The camera: views, following, a picture as a file; its buttons at the picture's top left, and the
// backdrop behind the picture. A clip says what there is to look at (app/motion/clip.py, `CameraTarget`).
(() => {
  const { player, layout, element, save, addToPage, lacking, listenToKeys } = window.llsrbm;
  const AROUND = [0.78, -0.82, 0.5]; // from the right, ahead and above
  const VIEWS = { front: [1, 0, 0.12], side: [0, -1, 0.12], top: [-1e-3, 0, 1], all: AROUND };
  const MARGIN = 0.06; // share of the picture's height that stays free around the robot

  // Every field of viser's that this script uses, below `window.__viserMutable`.
  const needs = [
    "canvas.getBoundingClientRect", "camera.fov", "cameraControl.setLookAt",
    "cameraControl.setPosition", "cameraControl.setTarget", "cameraControl.getPosition",
    "cameraControl.getTarget", "cameraControl.moveTo", "cameraControl.addEventListener",
    "nodePoseData", "nodeRefFromName", "requestRender",
  ];

  // The last rule: without a graphics processor Chromium cuts off a canvas at its top by as much as
  // something opaque covers at its bottom.
  const STYLE = `
    canvas[data-engine] { background: linear-gradient(#6f8aa6 0%, #9fb2c4 40%, #b3c1ce 60%); }
    [data-mantine-color-scheme=dark] canvas[data-engine] {
      background: linear-gradient(#18212d 0%, #263343 38%, #334152 60%); }
    #llsrbm-camera { left: 10px; top: 10px; display: none; gap: 2px; padding: 3px;
      border-radius: 6px; color: var(--mantine-color-text);
      border: 1px solid transparent; }
    /* The first is there; a pointer or the keys bring the others. */
    #llsrbm-camera button { background: var(--mantine-color-body); }
    @media (hover: hover) {
      #llsrbm-camera:not(:hover, :focus-within) button:not(:first-child, [aria-pressed=true]) {
        opacity: 0; } }
    #llsrbm-camera button { display: grid; place-items: center; width: 28px; height: 28px;
      padding: 0; color: inherit; border: 0; border-radius: 4px;
      cursor: pointer; }
    #llsrbm-camera button:hover { background: var(--mantine-color-default-hover); }
    #llsrbm-camera button:focus-visible { outline: 2px solid var(--mantine-primary-color-filled); }
    #llsrbm-camera button[aria-pressed=true] { background: var(--mantine-primary-color-light); }
    #llsrbm-camera svg { width: 18px; height: 18px; fill: none; stroke: currentColor;
      stroke-width: 1.5; stroke-linejoin: round; stroke-linecap: round; }
    #llsrbm-transport {
      background: color-mix(in srgb, var(--mantine-color-body) 99.5%, transparent) !important; }`;

  // A cube with the side that is looked at filled, a frame, a robot that is followed, a camera.
  const CUBE = '<path d="M3 6.5 10 3l7 3.5v7L10 17l-7-3.5zM3 6.5l7 3.5 7-3.5M10 10v7"/>';
  const FILLED = 'fill="currentColor" fill-opacity=".45" stroke="none"';
  const ICONS = {
    front: `<path ${FILLED} d="M3 6.5 10 10v7l-7-3.5z"/>${CUBE}`,
    side: `<path ${FILLED} d="M10 10l7-3.5v7L10 17z"/>${CUBE}`,
    top: `<path ${FILLED} d="M3 6.5 10 3l7 3.5-7 3.5z"/>${CUBE}`,
    all: '<path d="M3 7V3h4M13 3h4v4M17 13v4h-4M7 17H3v-4"/><path d="M7 8h6v4H7z"/>',
    follow: '<circle cx="10" cy="10" r="5"/><path d="M10 2v4M10 14v4M2 10h4M14 10h4"/>',
    picture: '<path d="M2.5 6h3.5l1.5-2h5L14 6h3.5v10h-15z"/><circle cx="10" cy="11" r="3"/>',
  };

  let cameraTarget = null, framed = null, moved = false, follows = false, followed = null;
  let listensTo = null, later = 0;

  const viewer = () => window.__viserMutable;
  const missing = () => lacking(viewer(), needs);

  // ---- geometry; three's world is the scene's, turned as the scene's root is

  const plus = (a, b, share = 1) => a.map((value, i) => value + share * b[i]);
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const cross = (a, b) =>
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const unit = (a) => a.map((value) => value / (Math.hypot(...a) || 1));

  function rooted(vector, back = false) {
    const turn = viewer().nodeRefFromName[""]?.quaternion;
    if (!turn) return vector;
    const axis = [turn.x, turn.y, turn.z].map((value) => (back ? -value : value));
    const twice = cross(axis, vector).map((value) => 2 * value);
    return plus(plus(vector, twice, turn.w), cross(axis, twice));
  }

  const numbers = (vector) => [vector.x, vector.y, vector.z];

  // The free part of the canvas: shares of its half height above, below and at the sides.
  function free() {
    const box = viewer().canvas.getBoundingClientRect();
    const bar = document.querySelector("#llsrbm-transport")?.getBoundingClientRect();
    const under = bar?.height ? Math.max(0, box.bottom - bar.top) : 0;
    const half = box.height / 2, side = box.width / box.height;
    return { up: 1 - 2 * MARGIN, down: 1 - under / half - 2 * MARGIN, side: side - 2 * MARGIN };
  }

  // Where a camera that looks from `direction` sees all of the points, as large as it can be.
  function fit({ points }, direction) {
    const half = Math.tan((viewer().camera.fov * Math.PI) / 360);
    const room = free(), ahead = unit(direction.map((value) => -value));
    const right = unit(cross(ahead, [0, 0, 1])), up = cross(right, ahead);
    const along = (axis) => points.map((point) => dot(point, axis));
    const x = along(right), y = along(up), z = along(ahead);
    // Each side of the view lets the camera's place be only so far on: c - slope d >= p - slope z.
    const bound = (values, sign, slope) =>
      Math.max(...values.map((value, i) => sign * value - slope * z[i]));
    const [wide, top, low_] = [room.side * half, room.up * half, Math.max(0.2, room.down) * half];
    const [r, l] = [bound(x, 1, wide), bound(x, -1, wide)];
    const [t, b] = [bound(y, 1, top), bound(y, -1, low_)];
    const depth = Math.min(-(r + l) / (2 * wide), -(t + b) / (top + low_));
    const across = (r - l) / 2, height = (t - b + (top - low_) * depth) / 2;
    const place = [right, up, ahead].reduce(
      (sum, axis, i) => plus(sum, axis, [across, height, depth][i]), [0, 0, 0]);
    const middle = (Math.min(...z) + Math.max(...z)) / 2;
    return { place, target: plus(place, ahead, middle - depth) };
  }

  // Where somebody asked for: azimuth, elevation (deg) and distance from the points' middle.
  function placed({ points, camera: [azimuth, elevation, distance] }) {
    const middle = [0, 1, 2].map((axis) => points.map((point) => point[axis]))
      .map((values) => (Math.min(...values) + Math.max(...values)) / 2);
    const [a, e] = [azimuth, elevation].map((angle) => (angle * Math.PI) / 180);
    const away = [Math.cos(e) * Math.cos(a), Math.cos(e) * Math.sin(a), Math.sin(e)];
    return { place: plus(middle, away, distance), target: middle };
  }

  // Whether all of the points are in the free part of the picture.
  function inSight({ points }) {
    const { camera, cameraControl } = viewer();
    const [place, target] = [cameraControl.getPosition(), cameraControl.getTarget()]
      .map((vector) => rooted(numbers(vector), true));
    const ahead = unit(plus(target, place, -1));
    const right = unit(cross(ahead, [0, 0, 1])), up = cross(right, ahead);
    const half = Math.tan((camera.fov * Math.PI) / 360), room = free();
    return points.every((point) => {
      const from = plus(point, place, -1), far = dot(from, ahead) * half;
      const [x, y] = [dot(from, right) / far, dot(from, up) / far];
      return far > 0 && Math.abs(x) < room.side + MARGIN && y < room.up + MARGIN
        && y > -room.down - MARGIN;
    });
  }

  // ---- what it does

  function look(name, smoothly = true) {
    if (!cameraTarget || missing().length) return;
    const { place, target } = name === "all" && cameraTarget.camera
      ? placed(cameraTarget)
      : fit(cameraTarget, (name === "all" && cameraTarget.direction) || VIEWS[name]);
    const [from, at] = [rooted(place), rooted(target)];
    const control = viewer().cameraControl;
    // viser: `setLookAt` without a transition seems to break later ones.
    if (smoothly) control.setLookAt(...from, ...at, true);
    else {
      control.setPosition(...from, false);
      control.setTarget(...at, false);
    }
    framed = cameraTarget;
    moved = name !== "all";
    followed = null;
    viewer().requestRender();
  }

  function place(node) {
    const position = viewer()?.nodePoseData[node]?.position;
    return position ? [...position] : null;
  }

  // Moved by as much as the base: however one looks at it, it stays there in the picture.
  function follow() {
    if (!follows || !cameraTarget || missing().length) return;
    const now = place(cameraTarget.follow);
    if (now && followed?.node === cameraTarget.follow) {
      const by = rooted(plus(now, followed.place, -1));
      if (Math.hypot(...by) > 0) {
        const control = viewer().cameraControl;
        control.moveTo(...plus(numbers(control.getTarget()), by), false);
      }
    }
    followed = now && { node: cameraTarget.follow, place: now };
  }

  function setFollows(value) {
    follows = value;
    followed = null;
    buttons.follow.setAttribute("aria-pressed", follows);
    follow();
  }

  // The canvas keeps what was drawn last: the frame that is asked for here.
  function photograph() {
    viewer().requestRender();
    return new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve)))
      .then(() => {
        const { canvas } = viewer(), { width, height } = canvas;
        const picture = Object.assign(document.createElement("canvas"), { width, height });
        const context = picture.getContext("2d");
        const colours = getComputedStyle(canvas).backgroundImage
          .match(/rgba?\([^)]*\)\s*[\d.]*%?/g) ?? ["rgb(255, 255, 255) 0%"];
        const backdrop = context.createLinearGradient(0, 0, 0, height);
        for (const stop of colours) {
          const [, colour, share] = stop.match(/(rgba?\([^)]*\))\s*([\d.]*)/);
          backdrop.addColorStop(Math.min(1, Number(share || 0) / 100), colour);
        }
        context.fillStyle = backdrop;
        context.fillRect(0, 0, width, height);
        context.drawImage(canvas, 0, 0);
        return new Promise((resolve) => picture.toBlob(resolve, "image/png"));
      });
  }

  async function download() {
    const robot = player.clip?.request.robot?.split(/[\\/]/).at(-1).replace(/\.toml$/, "");
    save(await photograph(), `${robot ?? "jump"}-${player.time.toFixed(2)}s.png`);
  }

  // Called by the player with every clip. Another robot is looked at anew; as long as nobody has
  // moved the camera, so is a motion that leaves the picture.
  function show(next) {
    cameraTarget = next ?? null;
    bar.style.display = cameraTarget ? "flex" : "none";
    attend();
  }

  function attend() {
    clearTimeout(later);
    if (!cameraTarget || window.llsrbm.parts?.pulls) return;
    // viser fills some fields when it has drawn first.
    if (missing().length) return void (later = setTimeout(attend, 100));
    if (listensTo !== viewer().cameraControl) {
      listensTo = viewer().cameraControl;
      listensTo.addEventListener("controlstart", () => (moved = true));
      listensTo.addEventListener("update", () => window.llsrbm.parts?.look());
    }
    const alike = (name) => String(cameraTarget[name]) === String(framed?.[name]);
    if (!alike("follow") || !alike("direction")) look("all", false);
    else if (!moved && !follows && !inSight(cameraTarget)) look("all");
  }

  // ---- buttons and keys

  const ACTS = [
    ["all", "Frame all", "0", () => look("all")],
    ["front", "Front view", "1", () => look("front")],
    ["side", "Side view", "2", () => look("side")],
    ["top", "Top view", "3", () => look("top")],
    ["follow", "Follow the base", "F", () => setFollows(!follows)],
    ["picture", "Save picture", "P", () => download()],
  ];
  const buttons = Object.fromEntries(ACTS.map(([name, label, key, act]) => {
    const made = element("button",
      { type: "button", "aria-label": label, title: `${label} (${key})`, onclick: act });
    made.innerHTML = `<svg viewBox="0 0 20 20" aria-hidden="true">${ICONS[name]}</svg>`;
    return [name, made];
  }));
  const bar = element("div", { id: "llsrbm-camera", role: "toolbar", "aria-label": "Camera" },
    ...Object.values(buttons));
  buttons.follow.setAttribute("aria-pressed", false);

  // A picture of another size shows all again; what a hand holds stays where it is.
  let size = "";
  function resize({ width, height }) {
    if (!cameraTarget || window.llsrbm.parts?.pulls) return;
    const now = [width, height, JSON.stringify(free())].join();
    if (size && size !== now && !moved && !follows) look("all", false);
    size = now;
  }

  listenToKeys(Object.fromEntries(ACTS.map(([, , key, act]) => [key, () => act()])),
    (event) => cameraTarget && !event.repeat);
  addToPage(STYLE);
  layout.over.append(bar);
  layout.onMove(resize);
  window.llsrbm.require(missing);
  player.listen(follow);

  window.llsrbm.camera = {
    show, look, photograph, needs, missing, setFollows,
    get follows() { return follows; },
    get target() { return cameraTarget; },
  };
})();
