// Zoom of a chart's values: the wheel over its upright axis, or with Shift over its curves, zooms;
// dragging the axis shifts; a double-click shows all again. window.llsrbm.plotZoom(chart).
(() => {
  const TURN = 0.0015; // of a wheel, a pixel
  const HINT = "Turn the wheel or drag: zoom. Double-click: all";

  window.llsrbm.plotZoom = (chart) => {
    const scale = chart.scales.y, axis = chart.root.querySelectorAll(".u-axis")[1];
    if (!scale || !axis) return;
    const automatic = scale.range;
    let chosen = null; // [least, most] in sight; null: as the curves need
    // Asked on every drawing, so that a zoom outlives other data.
    scale.range = (...given) => chosen ?? automatic(...given);

    function show(next) {
      chosen = next;
      const [min, max] = next ?? [scale.min, scale.max];
      if (next) chart.setScale("y", { min, max });
      else chart.setScale("x", { min: chart.scales.x.min, max: chart.scales.x.max });
    }

    function zoom(event) {
      const { top, height } = chart.over.getBoundingClientRect();
      const { min, max } = scale, factor = Math.exp(TURN * (event.deltaY || event.deltaX));
      const at = max - ((event.clientY - top) / height) * (max - min);
      event.preventDefault();
      show([at + factor * (min - at), at + factor * (max - at)]);
    }

    axis.title = HINT;
    axis.style.cursor = "ns-resize";
    axis.style.touchAction = "none";
    axis.addEventListener("wheel", zoom, { passive: false });
    chart.over.addEventListener("wheel", (event) => event.shiftKey && zoom(event),
      { passive: false });
    let from = null; // clientY and range where a drag began
    axis.addEventListener("pointerdown", (event) => {
      axis.setPointerCapture(event.pointerId);
      from = [event.clientY, scale.min, scale.max];
    });
    axis.addEventListener("pointermove", (event) => {
      if (!axis.hasPointerCapture(event.pointerId)) return;
      const [start, min, max] = from;
      const by = ((event.clientY - start) / chart.over.clientHeight) * (max - min);
      if (by) show([min + by, max + by]);
    });
    axis.addEventListener("dblclick", () => show(null));
    chart.over.addEventListener("dblclick", () => chosen && show(null));
  };
})();
