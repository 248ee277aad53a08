// A remark on the motion that is shown, at the top of the picture: that it is not what was asked for.
(() => {
  const { layout, element, addToPage } = window.llsrbm;

  const STYLE = `
    /* In the middle of the picture, beside the buttons of the camera. */
    #llsrbm-remark { top: 12px; left: 50%; transform: translateX(-50%);
      max-width: max(120px, 100% - 480px);
      padding: 4px 12px; border-radius: 14px; font: 600 14px/1.4 system-ui, sans-serif;
      color: #3a2600; background: #ffd98a; border: 1px solid #d08a1d; pointer-events: none !important;
      width: max-content; text-align: center; text-wrap: balance; }
    #llsrbm-remark:empty { display: none; }`;

  const remark = element("div", { id: "llsrbm-remark" });

  layout.over.append(remark);
  addToPage(STYLE);

  window.llsrbm.remark = { show: (text) => (remark.textContent = text) };
})();
