// A chart's title, or the button that adds a chart, dragged onto another chart: their signals share
// it. window.llsrbm.plotDrag(chart), and plotDrag.offer(button).
(() => {
  const { page, element } = window.llsrbm;
  const KIND = "application/x-llsrbm-chart"; // of what is dragged: its title; null: what is on offer
  const ONTO = "llsrbm-onto";

  document.addEventListener("DOMContentLoaded", () => document.head.append(element("style", {}, `
    .uplot .u-title[draggable=true] { cursor: grab; }
    .${ONTO} { outline: 2px dashed var(--mantine-primary-color-filled); outline-offset: -2px; }`)));

  const titleOf = (chart) => chart.root.querySelector(".u-title")?.firstChild?.textContent ?? "";
  const isChart = (event) => event.dataTransfer.types.includes(KIND);

  function draggable(thing, title) {
    thing.draggable = true;
    thing.addEventListener("dragstart", (event) => {
      event.dataTransfer.setData(KIND, JSON.stringify(title()));
      event.dataTransfer.effectAllowed = "move";
    });
  }

  function plotDrag(chart) {
    const { root } = chart, title = root.querySelector(".u-title");
    if (title) draggable(title, () => titleOf(chart));
    root.addEventListener("dragover", (event) => {
      if (!isChart(event)) return;
      event.preventDefault();
      root.classList.add(ONTO);
    });
    root.addEventListener("dragleave", (event) => {
      if (!root.contains(event.relatedTarget)) root.classList.remove(ONTO);
    });
    root.addEventListener("drop", (event) => {
      root.classList.remove(ONTO);
      if (!isChart(event)) return;
      event.preventDefault();
      const dropped = JSON.parse(event.dataTransfer.getData(KIND));
      page.send({ kind: "chart", chart: dropped, onto: titleOf(chart) });
    });
  }

  const offered = new WeakSet();
  plotDrag.offer = (button) => {
    if (!button || offered.has(button)) return;
    offered.add(button);
    draggable(button, () => null);
  };
  window.llsrbm.plotDrag = plotDrag;
})();
