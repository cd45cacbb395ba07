// The page after many pans and zooms.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { luminance } from './support/picture.mjs';
import { world } from './support/world.mjs';

const it = world(['town']);

const MOVES = 200;
// What a tab may hold more after the second half of the moves than after the first: caches are full by then.
const MORE_HEAP = 4 << 20;

// What the tab holds, after what is not needed has been collected.
async function held(session) {
  await session.send('HeapProfiler.collectGarbage');
  const { metrics } = await session.send('Performance.getMetrics');
  const value = (name) => metrics.find((metric) => metric.name === name).value;
  return { heap: value('JSHeapUsedSize'), nodes: value('Nodes'), listeners: value('JSEventListeners') };
}

// Closer and back, with a step aside at each zoom, so that it ends where it began.
const KEYS = ['ArrowRight', '+', 'ArrowDown', '+', 'ArrowLeft', '+', 'ArrowUp', '+',
  '-', 'ArrowDown', '-', 'ArrowRight', '-', 'ArrowUp', '-', 'ArrowLeft'];

// Pans or zooms by a key, and after each round drags the map by the mouse, towards the middle and back.
async function move(tab, [x, y], number) {
  const { keyboard, mouse } = tab.page;
  const step = number % (KEYS.length + 1);
  if (step < KEYS.length) {
    await keyboard.press(KEYS[step]);
  } else {
    const ends = [[x, y], [x - 60, y]];
    const [from, to] = number % 2 ? ends : ends.reverse();
    await mouse.move(...from);
    await mouse.down();
    await mouse.move(...to, { steps: 2 });
    await mouse.up();
  }
  if (number % 4 === 3) await tab.idle();
}

test(`after ${MOVES} pans and zooms the tab holds what it held, and draws at all zooms`, async (context) => {
  const tab = await it.open('file=town&layers=shade,walls,triangles,sites', { viewport: { width: 700, height: 500 } });
  const { zoom } = await tab.parameters();
  const [place] = await tab.places(1);
  await tab.page.locator('canvas.maplibregl-canvas').focus();
  const session = await tab.page.context().newCDPSession(tab.page);
  await session.send('Performance.enable');
  const after = [];
  for (let number = 0; number < MOVES; number += 1) {
    await move(tab, place, number);
    if (number === MOVES / 2 - 1 || number === MOVES - 1) after.push(await held(session));
  }
  const [half, whole] = after;
  context.diagnostic(`heap ${(half.heap / 1e6).toFixed(1)} MB after ${MOVES / 2} moves, ${(whole.heap / 1e6).toFixed(1)} MB after ${MOVES}`);
  assert.ok(whole.heap < half.heap + MORE_HEAP, `heap from ${half.heap} to ${whole.heap} bytes`);
  assert.ok(whole.nodes < half.nodes + 50, `nodes from ${half.nodes} to ${whole.nodes}`);
  assert.ok(whole.listeners < half.listeners + 20, `listeners from ${half.listeners} to ${whole.listeners}`);
  for (const closer of [0, 2, 4, 6]) {
    await tab.follow(`file=town&x=500&y=600&zoom=${Number(zoom) + closer}&layers=shade,walls,triangles,sites`);
    assert.ok((await luminance(it.browser, await tab.map())).deviation > 4, `zoom ${closer} closer is flat`);
  }
  await tab.close();
});
