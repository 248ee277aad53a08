// The verdict opens the certificate in the tab Results; a finding there goes to its instant.
(() => {
  const { page, player, addToPage } = window.llsrbm;

  const STYLE = `
    .llsrbm-status b button { font: inherit; color: inherit; padding: 0; background: none;
      border: 0; cursor: pointer; text-decoration: underline dotted 1px; text-underline-offset: 3px; }
    .llsrbm-certificate button { font: inherit; color: var(--mantine-color-anchor); padding: 0;
      background: none; border: 0; cursor: pointer; text-align: left; }
    .llsrbm-certificate :is(td, th) { line-height: 1.3; overflow-wrap: anywhere; }`;

  addToPage(STYLE);

  const details = () => [...document.querySelectorAll("[aria-expanded=false]")]
    .find((title) => title.textContent.trim() === "Details");
  const results = () => [...document.querySelectorAll("[role=tab]")]
    .find((tab) => tab.textContent.trim() === "Results");

  document.addEventListener("click", ({ target }) => {
    if (!(target instanceof Element)) return;
    const finding = target.closest(".llsrbm-certificate [data-seek]");
    if (finding) player.goTo(Number(finding.dataset.seek));
    if (target.closest(".llsrbm-status b button")) {
      details()?.click();
      // On viser's tabs the pointer is for dragging: a key turns to one.
      results()?.dispatchEvent(new KeyboardEvent("keydown", { key: "Enter", bubbles: true }));
      results()?.scrollIntoView({ block: "start", behavior: "smooth" });
      page.send({ kind: "certificate" });
    }
  });
})();
