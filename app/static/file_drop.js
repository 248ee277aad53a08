// Opens files that are dropped anywhere on the page, through the panel's upload button, and keeps
// files from being sent that are too large. Leans on the file input of viser's upload button.
(() => {
  const { element, addToPage } = window.llsrbm;
  const LARGEST = Number(document.querySelector("meta[name=largest-file]").content); // bytes

  const one = (file) => {
    const list = new DataTransfer();
    list.items.add(file);
    return list.files;
  };

  // An empty file of this type stands for one that is too large, so that 100 MB are not sent in vain
  // (app/viser_private.py).
  window.addEventListener("change", (event) => {
    const input = event.target;
    const file = input instanceof HTMLInputElement && input.type === "file" && input.files[0];
    if (!file || file.size <= LARGEST) return;
    input.files = one(new File([], file.name, { type: "application/x-too-large" }));
  }, true);

  const veil = element("div", {
    id: "llsrbm-drop",
    style: "position:fixed;inset:0;z-index:10000;display:none;pointer-events:none;" +
      "align-items:center;justify-content:center;background:rgba(62,78,99,0.14);" +
      "outline:3px dashed rgb(62,78,99);outline-offset:-14px",
  }, element("div", {
    style: "font:600 17px sans-serif;color:#fff;background:rgb(62,78,99);" +
      "padding:0.7em 1.1em;border-radius:0.4em",
  }, "Drop a design, plan, simulation or motion file to open it"));
  addToPage("", veil);
  const show = (visible) => { veil.style.display = visible ? "flex" : "none"; };
  const holdsFiles = (event) => [...(event.dataTransfer?.types ?? [])].includes("Files");

  window.addEventListener("dragover", (event) => {
    if (!holdsFiles(event)) return;
    event.preventDefault();
    event.dataTransfer.dropEffect = "copy";
    show(true);
  }, true);
  // Leaving one element for another inside the page has a place to go to.
  window.addEventListener("dragleave", (event) => event.relatedTarget === null && show(false), true);
  window.addEventListener("drop", (event) => {
    show(false);
    if (!holdsFiles(event)) return;
    event.preventDefault();
    const input = document.querySelector('input[type="file"]');
    const file = event.dataTransfer.files[0];
    if (!input || !file) return;
    input.files = one(file);
    input.dispatchEvent(new Event("change", { bubbles: true }));
  }, true);
})();
