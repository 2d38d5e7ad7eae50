// Histograms.

const MAX_BARS = 32;

function svg(name, attributes, text) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  if (text !== undefined) made.textContent = text;
  return made;
}

/** Mean, median, 99th percentile and maximum of pairs of a value and its count. */
function summary(pairs) {
  const total = pairs.reduce((sum, [, count]) => sum + count, 0);
  const at = (share) => {
    let seen = 0;
    return pairs.find(([, count]) => (seen += count) >= share * total)[0];
  };
  const mean = pairs.reduce((sum, [value, count]) => sum + value * count, 0) / total;
  return { total, mean, median: at(0.5), most: at(0.99), max: pairs[pairs.length - 1][0] };
}

/** Bars of equal width from minimum to maximum; with many values, several share a bar. */
function bars(pairs) {
  const low = pairs[0][0], high = pairs[pairs.length - 1][0];
  const width = Math.ceil((high - low + 1) / MAX_BARS);
  const list = [];
  for (let from = low; from <= high; from += width) list.push({ from, to: from + width - 1, count: 0 });
  for (const [value, count] of pairs) list[Math.floor((value - low) / width)].count += count;
  return list;
}

function chart(title, unit, pairs) {
  const figure = element("figure");
  figure.append(element("h3", title));
  const { total, mean, median, most, max } = summary(pairs);
  const list = bars(pairs);
  const percent = (count) => {
    const share = (100 * count) / total;
    return count === total ? "100 %" : share < 0.01 && count ? "< 0.01 %" : `${share.toFixed(share < 1 ? 2 : 1)} %`;
  };
  const range = ({ from, to }) => (from === to ? grouped(from) : `${grouped(from)}–${grouped(to)}`);
  const sentence = `mean ${short(mean)}, median ${grouped(median)}, 99 % take at most ${grouped(most)}, all at most ${grouped(max)} ${unit}`;
  const picture = svg("svg", { viewBox: "0 0 440 190", class: "chart", role: "img", "aria-label": `${title}: ${sentence}` });
  const top = Math.max(...list.map(({ count }) => count));
  const step = 430 / Math.max(list.length, 6);
  const every = Math.ceil(list.length / Math.floor(430 / 44));
  picture.append(svg("line", { x1: 5, y1: 165, x2: 435, y2: 165 }));
  list.forEach((bar, place) => {
    const height = (140 * bar.count) / top;
    const x = 5 + place * step;
    const box = svg("rect", { x: x + step * 0.08, y: 165 - height, width: step * 0.84, height, rx: 1.5 });
    box.append(svg("title", {}, `${range(bar)} ${unit}: ${percent(bar.count)}`));
    picture.append(box);
    if (step >= 38 && bar.count) {
      picture.append(svg("text", { x: x + step / 2, y: 160 - height, "text-anchor": "middle" }, percent(bar.count)));
    }
    if (place % every === 0) picture.append(svg("text", { x: x + step / 2, y: 180, "text-anchor": "middle" }, range(bar)));
  });
  figure.append(picture, element("figcaption", sentence));
  const details = element("details");
  details.append(element("summary", "As numbers"));
  const table = element("table");
  const head = table.createTHead().insertRow();
  for (const text of [unit, "queries", "share"]) {
    const cell = element("th", text);
    cell.scope = "col";
    head.append(cell);
  }
  const body = table.createTBody();
  for (const bar of list) {
    if (!bar.count) continue;
    const row = body.insertRow();
    for (const text of [range(bar), grouped(bar.count), percent(bar.count)]) row.insertCell().textContent = text;
  }
  details.append(table);
  figure.append(details);
  return figure;
}
