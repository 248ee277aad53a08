// The meaning of the page's words, in a dialog: topics that open, and a line on each term. The server
// has topics, figures and buttons (app/panel/help.py), the notes of the controls are tips.js's.
(() => {
  const { element, addToPage, dialog: { chooser } } = window.llsrbm;

  const STYLE = `
    #llsrbm-help header button:first-child { padding: 0 0.8rem; }
    #llsrbm-help .words { padding: 4px 16px 18px; max-width: 46rem; }
    #llsrbm-help summary { cursor: pointer; padding: 5px 0; font-weight: 600; }
    #llsrbm-help p { margin: 0 0 8px; }
    #llsrbm-help h3 { margin: 12px 0 4px; font-size: 14px; }
    #llsrbm-help dl { display: grid; grid-template-columns: minmax(8rem, auto) 1fr; gap: 4px 14px;
      margin: 0; }
    #llsrbm-help dt { font-weight: 600; }
    #llsrbm-help dd { margin: 0; }`;

  const topics = element("div"), terms = element("dl");
  const tour = element("button", {
    type: "button",
    onclick() {
      dialog.close();
      window.llsrbm.tour.start();
    },
  }, "Start the tour");
  const dialog = chooser("llsrbm-help", "Help", tour,
    element("div", { class: "words" }, topics, element("h3", {}, "Terms"), terms));
  addToPage(STYLE, dialog);

  // Words between asterisks are names of the page.
  const marked = (text) =>
    text.split("*").map((part, index) => (index % 2 ? element("em", {}, part) : part));

  window.llsrbm.help = {
    open(paragraphs, meanings) {
      topics.replaceChildren(...paragraphs.map(([title, text]) => element("details", {},
        element("summary", {}, title), element("p", {}, ...marked(text)))));
      const all = Object.entries({ ...meanings, ...window.llsrbm.tips.terms });
      terms.replaceChildren(...all.sort(([one], [other]) => one.localeCompare(other))
        .flatMap(([term, text]) => [element("dt", {}, term), element("dd", {}, text)]));
      if (!dialog.open) dialog.showModal();
    },
  };
})();
