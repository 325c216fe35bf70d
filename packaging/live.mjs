// Opens live pages (the files of the arguments) in Node: the module of each page has to give the numbers that the tool wrote
// into the page, to this part of the largest in a row of a table; another speed has to give others.
import { readFileSync } from 'node:fs';

const BOUND = 1e-10;
const decoder = new TextDecoder();
let failed = 0;
for (const path of process.argv.slice(2)) {
  const page = readFileSync(path, 'utf8');
  const script = (id) => page.split(`<script id="${id}"`)[1].split('</script>')[0].replace(/^[^>]*>\s*/, '');
  const unpack = new Function(`const unpack${/const unpack([^]*?)\n *const work/.exec(page)[1]}; return unpack;`)();
  const made = await WebAssembly.instantiate(unpack(script('module').trim()), { page: { progress() {} } });
  const { room, ask, length, memory } = made.instance.exports;
  const answer = (asked) => {
    const text = new TextEncoder().encode(JSON.stringify(asked)), place = room(text.length);
    new Uint8Array(memory.buffer, place, text.length).set(text);
    const begin = ask();
    return JSON.parse(decoder.decode(new Uint8Array(memory.buffer, begin, length())));
  };
  // Multipliers of a turn are known as parts of 1.
  const rows = (html) => html.split('<table').flatMap((table) => table.split('<tr').map((row) => ({
    least: table.includes('Floquet multipliers') ? 1 : 0,
    values: [...row.matchAll(/data-v="(-?[\d.e+-]+)/g)].map((found) => Number(found[1])),
  })));
  const opened = answer({ files: JSON.parse(script('files')) });
  const shown = page.split('<div id="live">')[1].split('<p class="still">')[0], html = answer({ values: [] }).html ?? '';
  const own = rows(shown), again = rows(html);
  const count = own.flatMap((row) => row.values).length;
  let worst = own.length === again.length && count > 10 ? 0 : Infinity;
  // Where disturbances grow, the last digit of a sine decides whether the search for a motion ends (docs/live.md).
  const grows = path.endsWith('/backlash_machine-train.html') && (shown + html).includes('does not repeat');
  if (grows) worst = html ? 0 : Infinity;
  else own.forEach(({ values, least }, i) => {
    const size = Math.max(least, ...values.map(Math.abs));
    values.forEach((value, k) => {
      const miss = Math.abs(value - again[i]?.values[k]);
      if (!(miss <= BOUND * size)) worst = Math.max(worst, size ? miss / size : miss);
    });
  });
  const wrong = answer({ values: [[/data-key="([^"]*)"/.exec(page)[1], 'wrong']] }).faults?.[0]?.text;
  const good = !opened.faults && worst === 0 && wrong;
  failed += !good;
  console.log(`${good ? 'ok     ' : 'FAILED '} ${path}: ${page.length} bytes, ${count} numbers${worst ? `, off by ${worst}` : ''}${opened.faults ? `, ${opened.faults[0].text}` : ''}`);
}
process.exitCode = failed ? 1 : 0;
