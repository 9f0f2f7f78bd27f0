const parse = (color) => color.match(/[\d.]+/g).map(Number);
const channel = (v) => (v /= 255) <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4;
const light = ([r, g, b]) => 0.2126 * channel(r) + 0.7152 * channel(g) + 0.0722 * channel(b);
const contrast = (a, b) => {
  const [low, high] = [light(a), light(b)].sort((x, y) => x - y);
  return (high + 0.05) / (low + 0.05);
};
function ground(element) {
  for (; element; element = element.parentElement) {
    const color = parse(getComputedStyle(element).backgroundColor);
    if (color.length < 4 || color[3] > 0) return color;
  }
  return [255, 255, 255];
}
const found = [];
function check(element, ink, paper) {
  if (contrast(ink, paper) < 4.5) found.push(`${element.textContent.slice(0, 40)}: ${contrast(ink, paper).toFixed(2)}`);
}
const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
while (walker.nextNode()) {
  const element = walker.currentNode.parentElement;
  if (!walker.currentNode.data.trim() || element.closest("svg, script, template, style")) continue;
  check(element, parse(getComputedStyle(element).color), ground(element));
}
for (const text of document.querySelectorAll("svg text")) {
  const rects = [...text.parentNode.querySelectorAll(":scope > rect")];
  const own = text.getBoundingClientRect();
  const inside = rects.findLast((rect) => {
    const box = rect.getBoundingClientRect();
    const fill = getComputedStyle(rect).fill;
    return box.left <= own.left + 1 && box.right >= own.right - 1 && box.top <= own.top + 3 && fill.startsWith("rgb");
  });
  const base = inside ?? text.ownerSVGElement.querySelector("rect");
  check(text, parse(getComputedStyle(text).fill), parse(getComputedStyle(base).fill));
}
return found;
