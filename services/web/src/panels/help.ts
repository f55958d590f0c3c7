import { element } from "../dom";
import { icon } from "../icons";
import { TEXT } from "../strings";

/** What hands and keys do. */
export function helpDialog(): HTMLDialogElement {
  const rows = element("dl", { class: "help-rows" });
  for (const [how, what] of TEXT.helpRows) {
    rows.append(element("dt", {}, how), element("dd", {}, what));
  }
  const close = element("button", { type: "button", class: "plain", "aria-label": TEXT.close });
  close.append(icon("close"));
  const title = element("h2", { id: "help-title" }, TEXT.help);
  const dialog = element(
    "dialog",
    { class: "help-dialog", "aria-labelledby": "help-title" },
    element("header", {}, title, close),
    rows,
    element("footer", {}, element("a", { href: "./licences.txt" }, TEXT.licences)),
  );
  close.addEventListener("click", () => dialog.close());
  dialog.addEventListener("click", (event) => {
    if (event.target === dialog) {
      dialog.close();
    }
  });
  return dialog;
}
