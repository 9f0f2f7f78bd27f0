const svg = document.querySelector("svg");
if (arguments[0]) svg.style.fontFamily = arguments[0], svg.setAttribute("font-family", arguments[0]);
const places = [...svg.querySelectorAll("text")].map((element) => {
  const box = element.getBoundingClientRect();
  return { element, text: element.textContent, left: box.left, right: box.right, top: box.top + box.height * 0.16,
           bottom: box.bottom - box.height * 0.16 };
}).filter((place) => place.text.trim());
const found = [];
const page = svg.getBoundingClientRect();
const slack = 0.75;
for (const p of places) {
  if (p.left < page.left - slack || p.right > page.right + slack || p.top < page.top || p.bottom > page.bottom)
    found.push(`${p.text} is cut`);
}
places.sort((a, b) => a.left - b.left);
places.forEach((a, i) => {
  for (const b of places.slice(i + 1)) {
    if (b.left >= a.right - slack) break;
    if (a.top < b.bottom && b.top < a.bottom) found.push(`${a.text} meets ${b.text}`);
  }
});
for (const group of svg.querySelectorAll("g[data-id], g[data-from]")) {
  const rect = group.querySelector(":scope > rect");
  if (!rect || !arguments[1]) continue;
  const box = rect.getBoundingClientRect();
  for (const p of places.filter((place) => place.element.parentNode === group)) {
    if (p.left < box.left - slack || p.right > box.right + slack || p.top < box.top - 1 || p.bottom > box.bottom + 1)
      found.push(`${p.text} leaves its box`);
  }
}
return found;
