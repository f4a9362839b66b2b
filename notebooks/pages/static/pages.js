// Filters: each form.filter hides the entries of its page that do not match it.
function filter(form) {
  const entries = [...document.querySelectorAll("article .entry")];
  const boxes = [...form.querySelectorAll("input[type=checkbox]")];
  function apply() {
    const paper = form.paper.value && `of-${form.paper.value}`;
    const kind = form.kind?.value && `is-${form.kind.value}`;
    const wanted = [paper, kind, ...boxes.map((box) => box.checked && box.name)];
    const words = form.words.value.toLowerCase().split(/\s+/);
    let shown = 0;
    for (const entry of entries) {
      const text = (entry.dataset.text ??= entry.textContent.toLowerCase());
      const match =
        wanted.every((name) => !name || entry.classList.contains(name)) &&
        words.every((word) => text.includes(word));
      entry.hidden = !match;
      shown += match;
    }
    for (const section of document.querySelectorAll("article section section"))
      section.hidden = !section.querySelector(".entry:not([hidden])");
    form.querySelector("output").value = `${shown} of ${entries.length}`;
  }
  form.addEventListener("input", apply);
  form.addEventListener("submit", (event) => event.preventDefault());
  apply();
}
document.addEventListener("DOMContentLoaded", () =>
  document.querySelectorAll("form.filter").forEach(filter),
);
