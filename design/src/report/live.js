// A page that computes: one worker sketches the diagrams while a slider moves, another studies the scene when it rests.
(async () => {
  const get = (id) => document.getElementById(id), state = get('state'), live = get('live'), form = get('dials');
  if (!globalThis.WebAssembly || !globalThis.Worker) return;
  // The module is packed as LZMA, which takes a quarter less than what browsers unpack themselves, in 85 signs. (Called also where
  // a page is tested.)
  const unpack = (text) => {
    const packed = new DataView(new ArrayBuffer((text.length / 5) * 4));
    for (let i = 0; i < text.length; i += 5) {
      let word = 0;
      for (let k = i; k < i + 5; k++) { const c = text.charCodeAt(k); word = word * 85 + (c < 60 ? c - 40 : c < 62 ? 20 : c - 42); }
      packed.setUint32((i / 5) * 4, word);
    }
    const out = new Uint8Array(packed.getUint32(5, true)), first = packed.getUint8(0);
    const lc = first % 9, lp = Math.floor(first / 9) % 5, pb = Math.floor(first / 45);
    const [match, rep, rep0, rep1, rep2, long, slots, near, align, length, again, literal] = [0, 192, 204, 216, 228, 240, 432, 688, 803, 819, 1333, 1847];
    const odds = new Uint16Array(literal + (0x300 << (lc + lp))).fill(1024);
    let range = 0xffffffff, code = packed.getUint32(14), at = 18, n = 0, state = 0, d0 = 0, d1 = 0, d2 = 0, d3 = 0;
    const next = () => { if (range < 0x1000000) { range *= 256; code = code * 256 + packed.getUint8(at++); } };
    const bit = (i) => {
      const bound = (range >>> 11) * odds[i], one = code >= bound;
      if (one) { range -= bound; code -= bound; odds[i] -= odds[i] >> 5; } else { range = bound; odds[i] += (2048 - odds[i]) >> 5; }
      next();
      return one ? 1 : 0;
    };
    const tree = (i, bits) => { let m = 1; for (let k = 0; k < bits; k++) m = m * 2 + bit(i + m); return m - (1 << bits); };
    const reverse = (i, bits) => { let m = 1, sum = 0; for (let k = 0; k < bits; k++) { const b = bit(i + m); m = m * 2 + b; sum += b << k; } return sum; };
    const count = (i, p) => (!bit(i) ? tree(i + 2 + p * 8, 3) : !bit(i + 1) ? 8 + tree(i + 130 + p * 8, 3) : 16 + tree(i + 258, 8));
    while (n < out.length) {
      const p = n & ((1 << pb) - 1);
      if (!bit(match + state * 16 + p)) {
        const i = literal + 0x300 * (((n & ((1 << lp) - 1)) << lc) + ((n && out[n - 1]) >> (8 - lc)));
        let m = 1;
        if (state > 6) for (let old = out[n - d0 - 1]; m < 256; old <<= 1) {
          const o = (old >> 7) & 1, b = bit(i + ((1 + o) << 8) + m);
          m = m * 2 + b;
          if (o !== b) break;
        }
        while (m < 256) m = m * 2 + bit(i + m);
        out[n++] = m;
        state = state < 4 ? 0 : state < 10 ? state - 3 : state - 6;
        continue;
      }
      let many = 0;
      if (bit(rep + state)) {
        if (bit(rep0 + state)) {
          let d = d1;
          if (bit(rep1 + state)) { d = d2; if (bit(rep2 + state)) { d = d3; d3 = d2; } d2 = d1; }
          [d1, d0] = [d0, d];
        } else if (!bit(long + state * 16 + p)) { state = state < 7 ? 9 : 11; many = 1; }
        if (!many) { many = 2 + count(again, p); state = state < 7 ? 8 : 11; }
      } else {
        [d3, d2, d1] = [d2, d1, d0];
        many = 2 + count(length, p);
        state = state < 7 ? 7 : 10;
        d0 = tree(slots + Math.min(many - 2, 3) * 64, 6);
        if (d0 > 3) {
          const slot = d0, bits = (slot >> 1) - 1;
          d0 = (2 + (slot & 1)) << bits;
          if (slot < 14) d0 += reverse(near + d0 - slot, bits);
          else {
            let far = 0;
            for (let k = 4; k < bits; k++) { range = Math.floor(range / 2); const b = code >= range; if (b) code -= range; far = far * 2 + b; next(); }
            d0 += far * 16 + reverse(align, 4);
          }
        }
      }
      for (; many-- && n < out.length; n++) out[n] = out[n - d0 - 1];
    }
    return out;
  };
  const work = () => {
    let engine;
    const ask = ({ exports }, asked) => {
      const text = new TextEncoder().encode(JSON.stringify(asked));
      const place = exports.room(text.length);
      new Uint8Array(exports.memory.buffer, place, text.length).set(text);
      const answer = exports.ask();
      return JSON.parse(new TextDecoder().decode(new Uint8Array(exports.memory.buffer, answer, exports.length())));
    };
    onmessage = async ({ data: { module, files, ...asked } }) => {
      try {
        if (module) {
          const progress = (part) => postMessage({ progress: part });
          engine = WebAssembly.instantiate(module, { page: { progress } }).then((made) => { const { faults } = ask(made, { files }); if (faults) throw Error(faults[0].text); return made; });
          await engine;
          postMessage({ ready: true });
        } else postMessage({ ...asked, ...ask(await engine, asked) });
      } catch (error) { postMessage({ ...asked, broken: String(error) }); }
    };
  };
  const module = await WebAssembly.compile(unpack(get('module').textContent.trim()));
  const files = JSON.parse(get('files').textContent), source = URL.createObjectURL(new Blob([`(${work})()`], { type: 'text/javascript' }));

  // A worker that takes the newest request; one that shall not finish the last is replaced.
  const worker = (depth, show) => {
    let own, busy, next, opened;
    const send = () => { busy = next; next = undefined; if (busy) own.postMessage({ values: busy, depth: depth() }); };
    const start = () => {
      own = new Worker(source);
      own.postMessage({ module, files });
      [busy, opened] = [[], false];
      own.onmessage = ({ data }) => {
        if (data.progress) { passed = data.progress < 1 ? ` ${Math.round(100 * data.progress)} %` : ''; return; }
        if (data.broken && opened) { own.terminate(); start(); } else busy = undefined;
        opened ||= !!data.ready;
        if (!data.ready && !next) show(data);
        if (!busy) send();
      };
    };
    start();
    return (values, replaces) => {
      next = values;
      if (busy && replaces && opened) { own.terminate(); start(); }
      if (!busy) send();
    };
  };
  const parsed = (html) => { const part = document.createElement('div'); part.innerHTML = html; enhance(part); return part; };
  const fields = [...form.querySelectorAll('input[type=text]')], own = new Map(fields.map((field) => [field.dataset.key, field.defaultValue]));
  const slider = (field) => field.parentNode.querySelector('input[type=range]');
  const split = (text) => text.match(/^\s*([-+\u2212]?[\d.]+(?:[eE][-+]?\d+)?)\s*([^]*?)\s*$/);
  const number = (text) => +text.replace('\u2212', '-');
  const plain = (text) => { const [, value, unit] = split(text) ?? []; return value === undefined || isNaN(number(value)) ? text : `${number(value)} ${unit}`.trim(); };
  const changed = () => fields.filter((field) => plain(field.value) !== plain(own.get(field.dataset.key))).map((field) => [field.dataset.key, field.value]);
  const isOf = (key, field) => key && (key === field.dataset.key || ['.', '['].some((sign) => field.dataset.key.startsWith(key + sign)));
  const tell = (faults = []) => {
    // A fault of several keys is told at the one that moved, or the first.
    const place = ({ key }) => { const all = fields.filter((field) => isOf(key, field)); return all.includes(moved) ? moved : all[0]; };
    for (const field of fields) {
      const text = faults.filter((fault) => place(fault) === field).map(({ text }) => text).join(' ');
      field.setAttribute('aria-invalid', String(!!text));
      get(field.getAttribute('aria-describedby')).textContent = text;
    }
    const other = faults.filter((fault) => !place(fault));
    if (faults.length) state.textContent = other.map(({ text }) => text).join(' ') || 'A value is out of range. The page shows the last valid motion.';
  };
  let last = 0, timer, passed = '', moved;
  // Work that takes longer shows how far it is, or for how long it has been going on.
  setInterval(() => {
    const seconds = Math.floor((performance.now() - last) / 1000);
    if (state.textContent.startsWith('Computing') && seconds) state.textContent = `Computing …${passed || ` ${seconds} s`}`;
  }, 500);
  const done = (start) => { performance.measure('redraw', { start, end: performance.now() }); };
  // The default experiment is on the page if the scene has no periodic motion.
  const sketcher = worker(() => (live.querySelector('figure[data-key^=run]') ? 'run' : 'sketch'), ({ html, faults, broken }) => {
    tell(faults ?? (broken ? [{ text: broken }] : []));
    if (!html) return;
    for (const figure of parsed(html).querySelectorAll('figure')) {
      const old = live.querySelector(`figure[data-key="${figure.dataset.key}"]`), focused = old === document.activeElement;
      old?.replaceWith(figure);
      if (focused) figure.focus({ preventScroll: true });
    }
    done(last);
  });
  const student = worker(() => 'whole', ({ html, faults, broken }) => {
    tell(faults ?? (broken ? [{ text: broken }] : []));
    if (!html) return;
    const open = live.querySelector('details')?.open;
    live.replaceChildren(...parsed(html).childNodes);
    live.querySelectorAll('details').forEach((part) => { part.open = open; });
    // The contents show the levels, too.
    for (const part of live.querySelectorAll('section')) {
      const [old, own] = [document.querySelector(`nav a[href="#${part.id}"] + .level`), part.querySelector('.level')];
      if (old && own) old.replaceWith(own.cloneNode(true));
    }
    state.textContent = changed().length ? 'Thin lines show the scene in the file.' : 'Move a slider: diagrams, figures and verdict follow.';
    live.dataset.done = JSON.stringify(changed());
  });

  // The state is in the address: #speed=1900rpm; a key whose last part is not the only one is written whole.
  const short = (key) => { const part = key.split('.').pop(); return fields.filter((field) => field.dataset.key.split('.').pop() === part).length > 1 ? key : part; };
  const follow = () => {
    const values = changed(), hash = values.map(([key, text]) => `${short(key)}=${encodeURIComponent(text.replace(/^(\S+) /, '$1'))}`).join('&');
    history.replaceState(null, '', hash ? '#' + hash : location.pathname + location.search);
    [last, passed] = [performance.now(), ''];
    get('copied').hidden = true;
    sketcher(values);
    state.textContent = 'Computing …';
    clearTimeout(timer);
    timer = setTimeout(() => student(values, true), 200);
  };
  const set = (field, text) => {
    field.value = text;
    const range = slider(field), [, value, unit] = split(text) ?? [], [, , usual] = split(own.get(field.dataset.key));
    // The slider has the unit of the file.
    if (range && value && (unit === usual || !unit)) range.value = number(value);
    if (range) range.setAttribute('aria-valuetext', text);
  };
  form.addEventListener('input', ({ target }) => {
    const field = target.parentNode.querySelector('input[type=text]');
    moved = field;
    if (target.type === 'range') {
      const [, , unit] = split(own.get(field.dataset.key));
      field.value = +(+target.value).toPrecision(4) + (unit ? ' ' + unit : '');
      target.setAttribute('aria-valuetext', field.value);
    } else set(field, field.value);
    follow();
  });
  form.addEventListener('submit', (event) => event.preventDefault());
  form.addEventListener('reset', (event) => { event.preventDefault(); fields.forEach((field) => set(field, own.get(field.dataset.key))); follow(); });
  get('copy').addEventListener('click', async () => {
    const area = get('copied');
    let table;
    const written = (text) => (split(text)?.[2] === '' ? plain(text) : JSON.stringify(text));
    // A list is copied whole: its numbers are the fields whose keys end in a bracket.
    const values = new Map(changed().map(([key, text]) => {
      const list = key.replace(/\[\d+\]$/, ''), items = fields.filter((field) => field.dataset.key.startsWith(list + '['));
      return [list, list === key ? written(text) : `[${items.map((field) => written(field.value)).join(', ')}]`];
    }));
    const lines = [...values].flatMap(([key, value]) => {
      const parts = key.split('.'), at = parts.findLastIndex((part) => part.endsWith(']')) + 1 || parts.length - 1;
      const head = parts.slice(0, at).join('.');
      const title = head === table || !head ? [] : [head.includes('[') ? `# ${head.replace(/\[(\d+)\]/g, ' $1')}` : `[${head}]`];
      table = head;
      return [...title, `${parts.slice(at).join('.')} = ${value}`];
    });
    area.value = lines.join('\n') || '# no key is changed';
    area.hidden = false;
    area.select();
    try { await navigator.clipboard.writeText(area.value); } catch { document.execCommand('copy'); }
  });
  const read = () => {
    // An address of a part of the page.
    if (location.hash && !location.hash.includes('=')) return;
    const before = String(changed()), decoded = (text) => { try { return decodeURIComponent(text); } catch { return text; } };
    const given = new Map(location.hash.slice(1).split('&').filter((part) => part.includes('=')).map((part) => { const at = part.indexOf('='); return [part.slice(0, at), decoded(part.slice(at + 1))]; }));
    for (const field of fields) {
      const text = given.get(field.dataset.key) ?? given.get(short(field.dataset.key)) ?? given.get(field.dataset.variable), [, number, unit] = split(text ?? '') ?? [];
      set(field, text === undefined ? own.get(field.dataset.key) : number && unit ? `${number} ${unit}` : text);
    }
    if (String(changed()) !== before) follow();
  };
  addEventListener('hashchange', read);
  form.hidden = false;
  state.textContent = 'Move a slider: diagrams, figures and verdict follow.';
  read();
  if (!live.querySelector('figure')) student(changed());
})();
