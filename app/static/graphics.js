// Before the page makes its canvas: a browser without a graphics processor draws twice as fast
// without multisampling (measured: 142 to 82 ms of processor time a frame).
(() => {
  const getContext = HTMLCanvasElement.prototype.getContext;

  function drawsInSoftware() {
    const probe = getContext.call(document.createElement("canvas"), "webgl2");
    if (!probe) return false;
    const info = probe.getExtension("WEBGL_debug_renderer_info");
    const name = probe.getParameter(info ? info.UNMASKED_RENDERER_WEBGL : probe.RENDERER);
    probe.getExtension("WEBGL_lose_context")?.loseContext();
    return /swiftshader|llvmpipe|software|basic render/i.test(String(name));
  }

  const llsrbm = (window.llsrbm = { software: false });
  let probed = false;
  HTMLCanvasElement.prototype.getContext = function (kind, attributes) {
    if (!probed && String(kind).startsWith("webgl")) {
      probed = true;
      llsrbm.software = drawsInSoftware();
    }
    if (llsrbm.software && attributes && String(kind).startsWith("webgl"))
      attributes = { ...attributes, antialias: false };
    return getContext.call(this, kind, attributes);
  };
})();
