// What the map shows, at zooms from the whole file to single triangles.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { difference, luminance } from './support/picture.mjs';
import { keep } from './support/shots.mjs';
import { WIDE } from './support/browser.mjs';
import { world } from './support/world.mjs';

const it = world(['town', 'survey', 'indonesia']);

// Where to look closer, and how far each step goes.
const PLACES = [
  { file: 'town', x: 500, y: 600, step: 1.6 },
  { file: 'survey', x: 600060, y: 4900040, step: 2 },
  { file: 'indonesia', x: 110, y: -6.9, step: 2.5 },
];
// Standard deviation of luminance that no single colour reaches, from 0 to 127.
const NOT_FLAT = 4;
// Share of pixels in which another view differs at least.
const ANOTHER = 0.02;
// Share of pixels that a layer changes at least.
const SEEN = 0.002;

for (const { file, x, y, step } of PLACES) {
  test(`${file} is drawn at four zooms, each unlike the one before`, async () => {
    const tab = await it.open(`file=${file}`, WIDE);
    const { zoom } = await tab.parameters();
    let before = await tab.map();
    assert.ok((await luminance(it.browser, before)).deviation > NOT_FLAT, 'the whole file is flat');
    await keep(`${file}-1`, tab.page);
    for (const number of [2, 3, 4]) {
      await tab.follow(`file=${file}&x=${x}&y=${y}&zoom=${Number(zoom) + step * (number - 1)}`);
      const map = await tab.map();
      await keep(`${file}-${number}`, tab.page);
      assert.ok((await luminance(it.browser, map)).deviation > NOT_FLAT, `zoom ${number} is flat`);
      assert.ok((await difference(it.browser, before, map)) > ANOTHER, `zoom ${number} is as the one before`);
      before = map;
    }
    await tab.close();
  });
}

test('a place of the map shows what the page names there: an obstacle and a street', async () => {
  const tab = await it.open('file=town&x=20&y=13.4&zoom=9&layers=shade');
  const means = [];
  for (const place of await tab.screen([15.4, 13.4], [25, 13.4])) {
    means.push(await luminance(it.browser, await tab.map(place)));
  }
  const [obstacle, street] = means;
  // Each is one colour, and they are not the same.
  assert.ok(obstacle.deviation < 2 && street.deviation < 2, JSON.stringify(means));
  assert.ok(street.mean - obstacle.mean > 10, JSON.stringify(means));
  await tab.close();
});

for (const [file, place, layers] of [
  ['town', { x: 500, y: 600, step: 3 }, ['shade', 'cells', 'triangles', 'walls', 'holes', 'sites']],
  ['survey', { x: 600060, y: 4900040, step: 2 }, ['shade', 'heights', 'cells', 'triangles', 'lines']],
]) {
  test(`each layer of ${file} is seen when its switch is on, and not when it is off`, async () => {
    const tab = await it.open(`file=${file}`, { viewport: { width: 700, height: 500 } });
    const zoom = Number((await tab.parameters()).zoom) + place.step;
    const view = `file=${file}&x=${place.x}&y=${place.y}&zoom=${zoom}`;
    await tab.follow(`${view}&layers=`);
    const empty = await tab.map();
    for (const layer of layers) {
      const switched = tab.layer(layer);
      await switched.check();
      await tab.idle();
      assert.ok((await difference(it.browser, empty, await tab.map())) > SEEN, `${layer} is not seen`);
      assert.equal((await tab.parameters()).layers, layer);
      await switched.uncheck();
      await tab.idle();
      assert.ok((await difference(it.browser, empty, await tab.map())) < SEEN, `${layer} stays`);
    }
    await tab.close();
  });
}

test('terrain in 3D is drawn, and leaves when its switch is off', async () => {
  const tab = await it.open('file=survey', WIDE);
  const flat = await tab.map();
  await tab.layer('three').check();
  await tab.idle();
  await keep('survey-3d', tab.page);
  const terrain = await tab.map();
  assert.ok((await luminance(it.browser, terrain)).deviation > NOT_FLAT);
  assert.ok((await difference(it.browser, flat, terrain)) > ANOTHER, 'the terrain looks as the plane');
  assert.equal((await tab.parameters()).three, '1');
  await tab.layer('three').uncheck();
  await tab.idle();
  assert.equal((await tab.parameters()).three, undefined);
  await tab.close();
});
