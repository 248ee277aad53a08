// Handles that are dragged, in the colour of what they move. viser leaves them those of its library,
// one an axis, and puts these back after each touch of the pointer.
(() => {
  const OWN = [0xff2060, 0x20df80, 0x2080ff]; // drei's PivotControls: x, y, z
  const colours = {}; // by the handle's node

  function paint(material, colour) {
    const own = material?.color;
    if (!own || !OWN.includes(own.getHex())) return false;
    const set = own.set;
    own.set = (...value) => {
      set.apply(own, value);
      return OWN.includes(own.getHex()) ? set.call(own, colour) : own;
    };
    own.set(own.getHex());
    return true;
  }

  function look() {
    const viewer = window.__viserMutable;
    let painted = false;
    for (const [node, colour] of Object.entries(colours))
      viewer?.nodeRefFromName?.[node]?.traverse(({ material }) => {
        painted = paint(material, colour) || painted;
      });
    if (painted) viewer.requestRender();
  }
  // A handle that was hidden is made anew, and what it belongs to is drawn.
  window.llsrbm.player.listen(look);

  window.llsrbm.handles = {
    paint(node, colour) {
      colours[node] = `rgb(${colour.join()})`;
      look();
    },
  };
})();
