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

// A formula that is too wide is set smaller; one that would be too small scrolls.
// Letters lean out of their boxes: that little is left to stick out, as is a short
// formula whose column is as narrow as itself.
const LEAN = 14, SHORT = 150; // pixels
function fit() {
  const all = [...document.querySelectorAll("main mjx-container:has(> svg)")];
  for (const math of all) {
    math.style.overflow = "";
    math.firstChild.style.width = math.firstChild.style.height = "";
  }
  const least = window.innerWidth < 700 ? 0.75 : 0.58;
  const whole = all.map((math) => math.firstChild.getBoundingClientRect());
  const parts = all.map(() => 1);
  for (let round = 0; round < 2; round++) { // columns move when formulas shrink
    const now = all.map((math) => (math.clientWidth - 1) / math.scrollWidth);
    now.forEach((part, k) => {
      if (part >= 1 || whole[k].width < SHORT) return;
      parts[k] = Math.max(least, parts[k] * part);
      const { style } = all[k].firstChild;
      style.width = `${parts[k] * whole[k].width}px`;
      style.height = `${parts[k] * whole[k].height}px`;
    });
  }
  const wide = all.map((math) => math.scrollWidth - math.clientWidth);
  wide.forEach((by, k) => {
    if (0 < by && (by <= LEAN || whole[k].width < SHORT))
      all[k].style.overflow = "visible";
  });
}

// What scrolls is reached with the keyboard.
function reach() {
  for (const box of document.querySelectorAll("main :is(mjx-container, pre, div, p)")) {
    const scrolls = box.scrollWidth > box.clientWidth
      && /auto|scroll/.test(getComputedStyle(box).overflowX);
    if (scrolls && box.tabIndex < 0) { // the theme writes -1
      box.tabIndex = 0;
      box.dataset.scrolls = "";
    } else if (!scrolls && "scrolls" in box.dataset) {
      box.removeAttribute("tabindex");
      delete box.dataset.scrolls;
    }
  }
}

// The theme's arrows that unfold the contents, and its title, are given names.
document.addEventListener("DOMContentLoaded", () => {
  for (const arrow of document.querySelectorAll("nav summary")) {
    const page = arrow.closest("li")?.querySelector("a")?.textContent.trim();
    arrow.setAttribute("aria-label", `Pages of ${page}`);
  }
  const title = document.querySelector(".sidebar-primary-item:has(> .navbar-brand)");
  title?.setAttribute("role", "navigation");
  title?.setAttribute("aria-label", "First page");
});

// On paper everything is unfolded, solutions too; the screen gets back what it had.
window.addEventListener("beforeprint", () => {
  for (const box of document.querySelectorAll("main details:not([open])")) {
    box.open = true;
    box.dataset.folded = "";
  }
  fit();
});
window.addEventListener("afterprint", () => {
  for (const box of document.querySelectorAll("main details[data-folded]")) {
    box.open = false;
    delete box.dataset.folded;
  }
});

window.addEventListener("load", async () => {
  await window.MathJax?.startup?.promise;
  await document.fonts.ready;
  fit();
  reach();
  let width = window.innerWidth;
  window.addEventListener("resize", () => {
    if (window.innerWidth !== width) fit(), reach();
    width = window.innerWidth;
  });
});
