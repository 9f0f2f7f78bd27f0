
"use strict";
(() => {
  const { links, order } = JSON.parse(document.getElementById("plan-links").textContent);
  const figures = [...document.querySelectorAll("figure.picture[data-what]")];
  const panel = document.querySelector(".about");
  const after = new Map();
  const before = new Map();
  for (const [from, to] of links) {
    if (!after.has(from)) after.set(from, []);
    if (!before.has(to)) before.set(to, []);
    after.get(from).push(to);
    before.get(to).push(from);
  }
  // A bar of the reservation chart stands for its operation.
  const boxOf = (element) => element.dataset.id.replace(/^slot\./, "op.");
  let selected = null;
  let pinned = false;

  function reached(start, next) {
    const found = new Set([start]);
    for (const box of found) for (const other of next.get(box) ?? []) found.add(other);
    return found;
  }

  function show(box, at) {
    if (at) {
      // In the other half of the window, so that it does not cover what it is about.
      const place = at.getBoundingClientRect();
      panel.classList.toggle("above", place.top + place.height / 2 > innerHeight / 2);
    }
    if (box === selected) return;
    selected = box;
    const up = box ? reached(box, before) : new Set();
    const down = box ? reached(box, after) : new Set();
    for (const figure of figures) {
      figure.classList.toggle("tracing", box !== null);
      for (const element of figure.querySelectorAll("[data-id]")) {
        const own = boxOf(element);
        element.classList.toggle("lit", up.has(own) || down.has(own));
        element.classList.toggle("self", own === box);
      }
      for (const element of figure.querySelectorAll("[data-from]")) {
        const from = element.dataset.from;
        const ends = element.dataset.to.split(" ");
        const on = [up, down].some((side) => side.has(from) && ends.some((end) => side.has(end)));
        element.classList.toggle("lit", on);
      }
    }
    describe(box);
  }

  function describe(box) {
    const card = box && document.getElementById("about-" + box);
    panel.hidden = !card;
    panel.replaceChildren();
    if (!card) return;
    const what = document.createElement("div");
    const facts = document.createElement("div");
    what.className = "what";
    facts.className = "facts";
    for (const part of [...card.content.cloneNode(true).children]) {
      (part.tagName === "DL" ? facts : what).append(part);
    }
    const close = document.createElement("button");
    close.type = "button";
    close.textContent = "×";
    close.setAttribute("aria-label", "Close");
    close.addEventListener("click", release);
    panel.append(what, facts, close);
  }

  function release() {
    pinned = false;
    show(null);
  }

  function pin(element) {
    pinned = !(pinned && selected === boxOf(element));
    if (pinned) show(boxOf(element), element);
    else show(null);
  }

  for (const figure of figures) {
    const elements = [...figure.querySelectorAll("[data-id]")];
    const rank = new Map(order.map((box, index) => [box, index]));
    elements.sort((a, b) => rank.get(boxOf(a)) - rank.get(boxOf(b)));
    // One stop of the Tab key for each picture; the arrow keys go on from there.
    elements.forEach((element, index) => {
      const title = element.querySelector("title");
      element.setAttribute("role", "button");
      element.setAttribute("tabindex", index === 0 ? "0" : "-1");
      element.setAttribute("aria-label", title ? title.textContent.replaceAll("\n", ", ") : boxOf(element));
      title?.remove();
      element.addEventListener("pointerenter", () => pinned || show(boxOf(element), element));
      element.addEventListener("pointerleave", () => pinned || show(null));
      element.addEventListener("click", () => pin(element));
      element.addEventListener("focus", () => {
        if (!element.matches(":focus-visible")) return;
        pinned = false;
        show(boxOf(element), element);
      });
      element.addEventListener("blur", () => pinned || show(null));
      element.addEventListener("keydown", (event) => {
        const steps = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 };
        let goal = index + (steps[event.key] ?? 0);
        if (event.key === "Home") goal = 0;
        if (event.key === "End") goal = elements.length - 1;
        if (event.key === "Enter" || event.key === " ") pin(element);
        else if (goal === index || !elements[goal]) return;
        else {
          element.setAttribute("tabindex", "-1");
          elements[goal].setAttribute("tabindex", "0");
          elements[goal].focus();
        }
        event.preventDefault();
      });
    });
    addTools(figure);
  }
  document.addEventListener("keydown", (event) => {
    if (event.key === "Escape") release();
  });

  function addTools(figure) {
    const boxes = [...figure.querySelectorAll(".wide")].filter((box) => box.querySelector("[data-id]"));
    const tools = document.createElement("div");
    tools.className = "tools";
    tools.setAttribute("role", "group");
    tools.setAttribute("aria-label", "Size of the picture");
    const hint = document.createElement("span");
    hint.textContent = "Point at a part to see what it is and its way from inputs to outputs; click or Enter keeps it.";
    tools.append(hint);
    let factor = 0;
    const resize = (change) => {
      factor = change === 0 ? 0 : Math.min(Math.max((factor || fitted()) * change, 0.25), 4);
      for (const box of boxes) {
        box.classList.toggle("zoomed", factor > 0);
        const svg = box.querySelector("svg");
        svg.style.width = factor ? factor * svg.viewBox.baseVal.width + "px" : "";
      }
    };
    const fitted = () => {
      const svg = boxes[0].querySelector("svg");
      return svg.getBoundingClientRect().width / svg.viewBox.baseVal.width;
    };
    for (const [text, label, change] of [["−", "Smaller", 0.8], ["+", "Larger", 1.25], ["Fit", "Fit to the page", 0]]) {
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = text;
      button.setAttribute("aria-label", label);
      button.addEventListener("click", () => resize(change));
      tools.append(button);
    }
    figure.prepend(tools);
  }
})();
