// A remark on the motion that is shown, at the top of the picture: that it is not what was asked for.
(() => {
  const { element, addToPage } = window.llsrbm;

  const STYLE = `
    #llsrbm-remark { position: fixed; z-index: 4; top: 12px; transform: translateX(-50%);
      padding: 4px 12px; border-radius: 14px; font: 600 0.85rem/1.4 system-ui, sans-serif;
      color: #3a2600; background: #ffd98a; border: 1px solid #d08a1d; pointer-events: none;
      white-space: nowrap; overflow: hidden; text-overflow: ellipsis; }
    #llsrbm-remark:empty { display: none; }`;

  const remark = element("div", { id: "llsrbm-remark" });

  // In the middle of the picture, beside the buttons of the camera, however wide the panel is.
  function place() {
    const box = window.__viserMutable?.canvas?.getBoundingClientRect();
    if (!box) return;
    remark.style.left = `${box.left + box.width / 2}px`;
    remark.style.maxWidth = `${Math.max(120, box.width - 2 * 240)}px`;
  }

  addToPage(STYLE, remark);
  window.addEventListener("resize", place);
  window.llsrbm.remark = {
    show(text) {
      remark.textContent = text;
      place();
    },
  };
})();
