// A page that computes: one worker sketches the diagrams while a slider moves, another studies the scene when it rests.
(async () => {
  const get = (id) => document.getElementById(id), state = get('state'), live = get('live'), form = get('dials');
  if (!globalThis.WebAssembly || !globalThis.DecompressionStream || !globalThis.Worker) return;
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
          engine = WebAssembly.instantiate(module, {}).then((made) => { const { faults } = ask(made, { files }); if (faults) throw Error(faults[0].text); return made; });
          await engine;
          postMessage({ ready: true });
        } else postMessage({ ...asked, ...ask(await engine, asked) });
      } catch (error) { postMessage({ ...asked, broken: String(error) }); }
    };
  };
  const bytes = Uint8Array.from(atob(get('module').textContent), (c) => c.charCodeAt(0));
  const unpacked = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('gzip'));
  const module = await WebAssembly.compile(await new Response(unpacked).arrayBuffer());
  const files = JSON.parse(get('files').textContent), source = URL.createObjectURL(new Blob([`(${work})()`], { type: 'text/javascript' }));

  // A worker that takes the newest request; one that shall not finish the last is replaced.
  const worker = (sketch, show) => {
    let own, busy, next;
    const send = () => { busy = next; next = undefined; if (busy) own.postMessage({ values: busy, sketch }); };
    const start = () => {
      own = new Worker(source);
      own.postMessage({ module, files });
      busy = [];
      own.onmessage = ({ data }) => {
        if (data.broken) { own.terminate(); start(); }
        busy = undefined;
        if (!data.ready && !next) show(data);
        send();
      };
    };
    start();
    return (values, replaces) => {
      next = values;
      if (busy && replaces && busy.length + next.length) { own.terminate(); start(); }
      if (!busy) send();
    };
  };
  const parsed = (html) => { const part = document.createElement('div'); part.innerHTML = html; enhance(part); return part; };
  const fields = [...form.querySelectorAll('input[type=text]')], own = new Map(fields.map((field) => [field.dataset.key, field.defaultValue]));
  const slider = (field) => field.parentNode.querySelector('input[type=range]');
  const changed = () => fields.filter((field) => field.value !== own.get(field.dataset.key)).map((field) => [field.dataset.key, field.value]);
  const tell = (faults = []) => {
    for (const field of fields) {
      const text = faults.filter(({ key }) => key && (key === field.dataset.key || field.dataset.key.startsWith(key + '.'))).map(({ text }) => text).join(' ');
      field.setAttribute('aria-invalid', String(!!text));
      get(field.getAttribute('aria-describedby')).textContent = text;
    }
    const other = faults.filter(({ key }) => !fields.some((field) => key && (key === field.dataset.key || field.dataset.key.startsWith(key + '.'))));
    if (faults.length) state.textContent = other.map(({ text }) => text).join(' ') || 'A value is not admissible; the page shows the last one that was.';
  };
  let last = 0, timer;
  const done = (start) => { performance.measure('redraw', { start, end: performance.now() }); };
  const sketcher = worker(true, ({ html, faults, broken }) => {
    tell(faults ?? (broken ? [{ text: broken }] : []));
    if (!html) return;
    for (const figure of parsed(html).querySelectorAll('figure')) {
      const old = live.querySelector(`figure[data-key="${figure.dataset.key}"]`), focused = old === document.activeElement;
      old?.replaceWith(figure);
      if (focused) figure.focus({ preventScroll: true });
    }
    done(last);
  });
  const student = worker(false, ({ html, faults, broken }) => {
    tell(faults ?? (broken ? [{ text: broken }] : []));
    if (!html) return;
    const open = live.querySelector('details')?.open;
    live.replaceChildren(...parsed(html).childNodes);
    live.querySelectorAll('details').forEach((part) => { part.open = open; });
    state.textContent = changed().length ? 'Thin lines show the scene as its file has it.' : 'Move a slider: diagrams, figures and verdict follow.';
    live.dataset.done = JSON.stringify(changed());
  });

  // The state is in the address: #speed=1900rpm; a key whose last part is not the only one is written whole.
  const short = (key) => { const part = key.split('.').pop(); return fields.filter((field) => field.dataset.key.split('.').pop() === part).length > 1 ? key : part; };
  const follow = () => {
    const values = changed(), hash = values.map(([key, text]) => `${short(key)}=${encodeURIComponent(text.replace(/^(\S+) /, '$1'))}`).join('&');
    history.replaceState(null, '', hash ? '#' + hash : location.pathname + location.search);
    last = performance.now();
    get('copied').hidden = true;
    sketcher(values);
    state.textContent = 'Computing …';
    clearTimeout(timer);
    timer = setTimeout(() => student(values, true), 200);
  };
  const split = (text) => text.match(/^\s*([-+\u2212]?[\d.]+(?:[eE][-+]?\d+)?)\s*([^]*)$/);
  const set = (field, text) => {
    field.value = text;
    const range = slider(field), number = split(text)?.[1];
    if (range && number) range.value = number.replace('\u2212', '-');
    if (range) range.setAttribute('aria-valuetext', text);
  };
  form.addEventListener('input', ({ target }) => {
    const field = target.parentNode.querySelector('input[type=text]');
    if (target.type === 'range') {
      const unit = split(field.value)?.[2] || split(own.get(field.dataset.key))[2];
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
    const lines = changed().flatMap(([key, text]) => {
      const parts = key.split('.'), at = parts.findLastIndex((part) => part.endsWith(']')) + 1 || parts.length - 1;
      const head = parts.slice(0, at).join('.'), value = split(text)?.[2] === '' ? text : JSON.stringify(text);
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
    const given = new Map(location.hash.slice(1).split('&').filter((part) => part.includes('=')).map((part) => { const at = part.indexOf('='); return [part.slice(0, at), decodeURIComponent(part.slice(at + 1))]; }));
    for (const field of fields) {
      const text = given.get(field.dataset.key) ?? given.get(short(field.dataset.key)), [, number, unit] = split(text ?? '') ?? [];
      set(field, text === undefined ? own.get(field.dataset.key) : number && unit ? `${number} ${unit}` : text);
    }
    if (changed().length) follow();
  };
  addEventListener('hashchange', read);
  form.hidden = false;
  state.textContent = 'Move a slider: diagrams, figures and verdict follow.';
  read();
})();
