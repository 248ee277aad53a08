// Moving stick figures of motions (stick_figure.py), in the page's gallery and in a library's site.
// Those that are to be seen move, in the colour of the text around them; a figure in a closed dialog
// is not to be seen. For who asked for less motion, a figure shows the top of its flight.
(() => {
  const STILL = matchMedia("(prefers-reduced-motion: reduce)").matches;
  const [TRUNK, , FOOT] = [0, 1, 2]; // roles of points
  const STANDS = 0.7; // s that a motion's end stays
  const PERIOD = 33; // ms between two pictures
  const MARGIN = 6, WIDER = 1.3; // ground: so much larger than what the feet span
  const SVG = Object.assign(document.createElement("template"), { innerHTML: "<svg></svg>" })
    .content.firstChild.namespaceURI;

  function shape(kind, attributes) {
    const made = document.createElementNS(SVG, kind);
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    return made;
  }

  function opened({ points, bytes }) {
    const numbers = Int8Array.from(atob(bytes), (letter) => letter.charCodeAt(0));
    const count = numbers.length / (2 * points) - 1;
    const row = (at) => Array.from({ length: points }, (_, k) => {
      const place = 2 * (at * points + k);
      return [numbers[place], numbers[place + 1]];
    });
    const [bones, ...instants] = Array.from({ length: count + 1 }, (_, at) => row(at));
    const of = (role) => bones.flatMap(([, own], k) => (own === role ? [k] : []));
    return {
      trunk: of(TRUNK), feet: of(FOOT),
      // Downwards, as pictures have it.
      instants: instants.map((each) => each.map(([x, y]) => [x, -y])),
      links: bones.flatMap(([link], k) => (link === k ? [] : [[link, k]])),
    };
  }

  // The convex outline of some points.
  function outline(points) {
    const sorted = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
    const half = (ordered) => {
      const kept = [];
      for (const [x, y] of ordered) {
        while (kept.length > 1) {
          const [[ax, ay], [bx, by]] = kept.slice(-2);
          if ((bx - ax) * (y - ay) - (by - ay) * (x - ax) > 0) break;
          kept.pop();
        }
        kept.push([x, y]);
      }
      return kept.slice(0, -1);
    };
    return [...half(sorted), ...half(sorted.reverse())];
  }

  const line = (points) => points.map(([x, y]) => `${x.toFixed(1)} ${y.toFixed(1)}`).join("L");
  const closed = (points) => `M${line(points)}Z`;

  // The ground under feet, wider than what they span.
  function ground(feet) {
    const middle = [0, 1].map((axis) => feet.reduce((sum, foot) => sum + foot[axis], 0) / feet.length);
    return outline(feet.map((foot) => foot.map((at, axis) => middle[axis] + WIDER * (at - middle[axis]))));
  }

  function at(instants, share) {
    const place = share * (instants.length - 1), first = Math.min(Math.floor(place), instants.length - 2);
    const rest = place - first, next = instants[first + 1];
    return instants[first].map(([x, y], k) => [x + rest * (next[k][0] - x), y + rest * (next[k][1] - y)]);
  }

  // When the trunk is highest, as a share of the motion.
  function top({ instants, trunk }) {
    const heights = instants.map((points) => trunk.reduce((sum, k) => sum - points[k][1], 0));
    return heights.indexOf(Math.max(...heights)) / (instants.length - 1);
  }

  function viewBox(points) {
    const [x, y] = [0, 1].map((axis) => points.map((point) => point[axis]));
    const low = [Math.min(...x) - MARGIN, Math.min(...y) - MARGIN];
    return [...low, Math.max(...x) + MARGIN - low[0], Math.max(...y) + MARGIN - low[1]].join(" ");
  }

  const DRAWN = { fill: "none", stroke: "currentColor", "stroke-width": 2, "stroke-linecap": "round",
    "stroke-linejoin": "round", "vector-effect": "non-scaling-stroke" };

  // Puts a figure into its svg, and returns what shows it at a share of its motion.
  function draw(svg, motion) {
    const { instants, feet, trunk, links } = motion;
    const grounds = [instants[0], instants.at(-1)].map((points) => ground(feet.map((k) => points[k])));
    const body = shape("path", { ...DRAWN, fill: "currentColor", "fill-opacity": 0.25 });
    const limbs = shape("path", DRAWN);
    svg.setAttribute("viewBox", viewBox([...instants, ...grounds].flat()));
    svg.append(shape("path", { d: grounds.map(closed).join(""), fill: "currentColor", opacity: 0.2 }),
      limbs, body);
    return (share) => {
      const points = at(instants, share);
      body.setAttribute("d", closed(outline(trunk.map((k) => points[k]))));
      limbs.setAttribute("d", links.map((ends) => `M${line(ends.map((k) => points[k]))}`).join(""));
    };
  }

  // ---- those that are to be seen move; the others are not even unpacked until then

  const figures = new WeakMap(), seen = new Map(); // by their svg: what was sent, what shows it
  let running = false, last = 0;

  function step(now) {
    running = seen.size > 0;
    if (!running) return;
    requestAnimationFrame(step);
    if (now - last < PERIOD) return;
    last = now;
    for (const show of seen.values()) show(now / 1000);
  }

  function appear(svg) {
    const figure = figures.get(svg), { duration } = figure;
    if (!figure.show) {
      const motion = opened(figure), show = draw(svg, motion);
      show(top(motion));
      figure.show = (now) => show(Math.min(1, (now % (duration + STANDS)) / duration));
    }
    if (STILL) observer.unobserve(svg);
    else seen.set(svg, figure.show);
  }

  const observer = new IntersectionObserver((entries) => {
    for (const { target, isIntersecting } of entries) {
      if (isIntersecting) appear(target);
      else seen.delete(target);
    }
    if (!running && seen.size) {
      running = true;
      requestAnimationFrame(step);
    }
  });

  // An svg that shows a figure, as `StickFigure.drawn` gives it.
  (window.llsrbm ??= {}).stickFigure = (figure) => {
    const svg = shape("svg", { preserveAspectRatio: "xMidYMax", "aria-hidden": "true" });
    figures.set(svg, { ...figure });
    observer.observe(svg);
    return svg;
  };
})();
