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

// Drags and turns the wheel, from place to place and from zoom to zoom, so that it ends about where it began.
async function move(tab, place, number) {
  const { mouse } = tab.page;
  const [x, y] = place;
  const [right, down] = [[90, 20], [-20, 70], [-90, -20], [20, -70]][(number / 2) % 4 | 0];
  await mouse.move(x, y);
  if (number % 2) {
    await mouse.wheel(0, number % 20 < 10 ? -240 : 240);
  } else {
    await mouse.down();
    await mouse.move(x + right, y + down, { steps: 2 });
    await mouse.up();
  }
  if (number % 10 === 9) await tab.idle();
}

test(`after ${MOVES} pans and zooms the tab holds what it held, and draws at all zooms`, async (context) => {
  const tab = await it.open('file=town&layers=shade,walls,triangles,sites', { viewport: { width: 700, height: 500 } });
  const { zoom } = await tab.parameters();
  const [place] = await tab.places(1);
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
