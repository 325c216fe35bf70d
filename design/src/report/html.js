'use strict';
// What the pointer or the keyboard reads, in words; screen readers tell it.
const tip = document.body.appendChild(document.createElement('div'));
tip.id = 'tip';
tip.setAttribute('role', 'status');
const hide = () => { tip.textContent = ''; };
const show = (text, { left, right, top, bottom }) => {
  tip.textContent = text;
  const { width, height } = tip.getBoundingClientRect();
  tip.style.left = Math.max(4, Math.min((left + right - width) / 2, innerWidth - width - 4)) + 'px';
  tip.style.top = (bottom + height + 12 > innerHeight ? Math.max(4, top - height - 8) : bottom + 8) + 'px';
};
// A cell that is read by the keyboard keeps its words when its focus moves the page.
addEventListener('scroll', () => {
  hide();
  if (document.activeElement.matches('td')) document.activeElement.dispatchEvent(new FocusEvent('focusin', { bubbles: true }));
}, { capture: true, passive: true });
addEventListener('keydown', (event) => { if (event.key === 'Escape') hide(); });
addEventListener('beforeprint', () => document.querySelectorAll('details').forEach((part) => { part.open = true; }));

// What is in a part of the page:
const enhance = (root) => {
// Tables: a click or Enter on a heading sorts, arrows go from cell to cell, a cell tells all of its digits.
for (const table of root.querySelectorAll('.table table')) {
  const heads = [...table.tHead.rows[0].cells], body = table.tBodies[0];
  const key = (row, i) => row.cells[i].dataset.v ?? row.cells[i].textContent;
  const sort = (head, i) => {
    const sign = head.ariaSort === 'ascending' ? -1 : 1;
    heads.forEach((other) => other.setAttribute('aria-sort', 'none'));
    head.setAttribute('aria-sort', sign > 0 ? 'ascending' : 'descending');
    const compare = (a, b) => {
      const texts = [a, b].map((row) => key(row, i)), empty = texts.map((text) => text === '–');
      if (empty[0] || empty[1]) return empty[0] - empty[1];
      const numbers = texts.map(parseFloat);
      return sign * (numbers.some(isNaN) ? texts[0].localeCompare(texts[1]) : numbers[0] === numbers[1] ? 0 : numbers[0] - numbers[1]);
    };
    body.append(...[...body.rows].sort(compare));
  };
  heads.forEach((head, i) => {
    // A heading that stands again over the next column or page has text there, but no button.
    const button = document.createElement('span');
    button.tabIndex = 0;
    button.setAttribute('role', 'button');
    button.append(...head.childNodes);
    button.addEventListener('click', () => sort(head, i));
    button.addEventListener('keydown', (event) => {
      if (event.key !== 'Enter' && event.key !== ' ') return;
      event.preventDefault();
      sort(head, i);
    });
    head.setAttribute('aria-sort', 'none');
    head.append(button);
  });
  const tell = (cell) => {
    const unit = heads[cell.cellIndex]?.dataset.unit ?? '';
    if (cell.dataset.v) show(cell.dataset.v.replace('Infinity', '∞') + (unit === '°' ? unit : ' ' + unit), cell.getBoundingClientRect());
  };
  const cells = [...body.querySelectorAll('td')];
  cells.forEach((cell, i) => { cell.tabIndex = i ? -1 : 0; });
  const ways = { ArrowLeft: [0, -1], ArrowRight: [0, 1], ArrowUp: [-1, 0], ArrowDown: [1, 0] };
  body.addEventListener('keydown', (event) => {
    const way = ways[event.key], cell = event.target.closest('td');
    if (!way || !cell) return;
    event.preventDefault();
    const next = body.rows[cell.parentNode.sectionRowIndex + way[0]]?.cells[cell.cellIndex + way[1]];
    if (!next) return;
    cell.tabIndex = -1;
    next.tabIndex = 0;
    next.focus();
  });
  body.addEventListener('focusin', (event) => tell(event.target));
  body.addEventListener('focusout', hide);
  body.addEventListener('mouseover', (event) => { const cell = event.target.closest('td'); if (cell) tell(cell); });
  body.addEventListener('mouseleave', hide);
}

// Diagrams: the nearest point of a line under the pointer; arrows go along a line and from line to line.
for (const figure of root.querySelectorAll('figure[data-x]')) {
  const svg = figure.querySelector('svg');
  const axis = (text) => {
    const [, first, last, low, high, scale, label] = text.match(/^(\S+) (\S+) (\S+) (\S+) (\S+) ([^]*)$/);
    const [, name, unit] = label.match(/^(.*?)(?: \[(.*)\])?$/), log = scale === 'log';
    const way = (last - first) / (high - low);
    return {
      set: (value) => `${name}=${encodeURIComponent(+value.toPrecision(9) + ' ' + (unit ?? '').replace('°', 'deg'))}`,
      pixel: (value) => +first + ((log ? Math.log10(value) : value) - low) * way,
      value: (pixel) => { const place = +low + (pixel - first) / way; return log ? 10 ** place : place; },
      text: (value) => {
        const least = log ? 0 : Math.abs(high - low) * 1e-5;
        const shown = Math.abs(value) > least ? String(+value.toPrecision(4)) : '0';
        return name + ': ' + shown + (unit ? (unit === '°' ? '' : ' ') + unit : '');
      },
    };
  };
  const x = axis(figure.dataset.x), y = axis(figure.dataset.y), z = figure.dataset.z && axis(figure.dataset.z);
  const lines = [...figure.querySelectorAll('data')].flatMap((data) => data.value.split(';').filter(Boolean).map((part) => ({
    name: data.textContent,
    points: part.split(' ').map((point) => point.split(',').map(Number)),
  })));
  if (!lines.length) continue;
  lines.forEach((line) => { line.pixels = line.points.map(([a, b]) => [x.pixel(a), y.pixel(b)]); });
  const mark = svg.appendChild(document.createElementNS(svg.namespaceURI, 'path'));
  for (const [key, value] of Object.entries({ fill: 'none', stroke: '#222', 'stroke-width': 1, class: 'mark' })) mark.setAttribute(key, value);
  const [left, right] = figure.dataset.x.split(' ').map(Number), [bottom, top] = figure.dataset.y.split(' ').map(Number);
  let told;
  const read = (line, [px, py], [vx, vy, vz]) => {
    told = [x.set(vx), ...(vz === undefined ? [] : [y.set(vy)])];
    mark.setAttribute('d', `M${px} ${top}V${bottom}M${left} ${py}H${right}M${px - 6} ${py}a6 6 0 1 0 12 0a6 6 0 1 0 -12 0`);
    const place = svg.createSVGPoint();
    [place.x, place.y] = [px, py];
    const at = place.matrixTransform(svg.getScreenCTM());
    show([line.name, vz === undefined ? '' : z.text(vz), x.text(vx), y.text(vy)].filter(Boolean).join('\n'), { left: at.x, right: at.x, top: at.y - 8, bottom: at.y + 8 });
  };
  const clear = () => { told = undefined; mark.removeAttribute('d'); hide(); };
  svg.addEventListener('pointermove', (event) => {
    const place = svg.createSVGPoint();
    [place.x, place.y] = [event.clientX, event.clientY];
    const { x: mx, y: my } = place.matrixTransform(svg.getScreenCTM().inverse());
    let best = [Infinity];
    for (const line of lines) line.pixels.forEach(([ax, ay], i) => {
      // Between the cells of a map there is nothing.
      const [bx, by] = (z ? null : line.pixels[i + 1]) ?? [ax, ay], dx = bx - ax, dy = by - ay, size = dx * dx + dy * dy;
      let share = size ? Math.min(1, Math.max(0, ((mx - ax) * dx + (my - ay) * dy) / size)) : 0;
      // A point of the data within two pixels is meant.
      const length = Math.sqrt(size);
      if (share * length < 2) share = 0; else if ((1 - share) * length < 2) share = 1;
      const [px, py] = [ax + share * dx, ay + share * dy], far = Math.hypot(mx - px, my - py);
      if (far < best[0]) best = [far, line, [px, py], share === 0 ? line.points[i] : share === 1 ? line.points[i + 1] : [x.value(px), y.value(py)]];
    });
    read(...best.slice(1));
  });
  svg.addEventListener('pointerleave', clear);
  // A point of a study opens the page of its scene with these values.
  const page = document.querySelector('main').dataset.live;
  const open = () => { if (told && page) location.href = page + '#' + told.join('&'); };
  if (page) svg.style.cursor = 'pointer';
  svg.addEventListener('click', open);
  figure.tabIndex = 0;
  figure.setAttribute('role', 'group');
  figure.setAttribute('aria-label', svg.getAttribute('aria-label') + ': arrow keys read values' + (page ? ', Enter opens the run' : ''));
  let at = [0, 0];
  const tell = () => { const line = lines[at[0]]; read(line, line.pixels[at[1]], line.points[at[1]]); };
  figure.addEventListener('focus', () => { if (figure.matches(':focus-visible')) tell(); });
  figure.addEventListener('blur', clear);
  figure.addEventListener('keydown', (event) => {
    const ways = { ArrowLeft: [0, -1], ArrowRight: [0, 1], ArrowUp: [-1, 0], ArrowDown: [1, 0], Home: [0, -Infinity], End: [0, Infinity] };
    const way = ways[event.key];
    if (event.key === 'Enter') open();
    if (!way) return;
    event.preventDefault();
    const line = Math.min(lines.length - 1, Math.max(0, at[0] + way[0]));
    at = [line, Math.min(lines[line].points.length - 1, Math.max(0, at[1] + way[1]))];
    tell();
  });
}
};
enhance(document);
