import { element } from "../dom";
import { icon } from "../icons";
import { TEXT } from "../strings";

/**
 * Copies a text and says whether it did. Browsers let pages of plain http copy nothing: there the
 * text is shown, selected, to be copied by hand.
 */
export async function copyText(text: string): Promise<boolean> {
  try {
    await navigator.clipboard.writeText(text);
    return true;
  } catch {
    showToCopy(text);
    return false;
  }
}

function showToCopy(text: string): void {
  const field = element("textarea", {
    class: "figures",
    readonly: true,
    rows: 3,
    spellcheck: "false",
    "aria-label": TEXT.copyField,
    "aria-describedby": "copy-help",
  });
  field.value = text;
  const close = element("button", { type: "button", class: "plain", "aria-label": TEXT.close });
  close.append(icon("close"));
  const dialog = element(
    "dialog",
    { class: "copy-dialog", "aria-labelledby": "copy-title" },
    element("header", {}, element("h2", { id: "copy-title" }, TEXT.copy), close),
    element("div", { class: "body" }, field, element("p", { id: "copy-help" }, TEXT.copyByHand)),
  );
  close.addEventListener("click", () => dialog.close());
  dialog.addEventListener("click", (event) => {
    if (event.target === dialog) {
      dialog.close();
    }
  });
  dialog.addEventListener("close", () => dialog.remove());
  // Whoever has copied it is done.
  field.addEventListener("copy", () => setTimeout(() => dialog.close()));
  document.body.append(dialog);
  dialog.showModal();
  field.focus();
  field.select();
}
