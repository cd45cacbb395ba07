// Answers of the page, compared with those of `tiletool query` to the last digit.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { query } from './support/oracle.mjs';
import { WIDE } from './support/browser.mjs';
import { world } from './support/world.mjs';
import { keep } from './support/shots.mjs';

const it = world(['town', 'survey', 'indonesia']);

const ENDS = { from: '450,540', to: '547,642' };

for (const mode of ['exact', 'fast']) {
  test(`a path in mode ${mode} has the length, the bounds and the bends that the tool finds`, async () => {
    const truth = await query('town', 'path', { ...ENDS, mode });
    const tab = await it.open(`file=town&x=490&y=590&zoom=6.5&ask=path&from=${ENDS.from}&to=${ENDS.to}&mode=${mode}`, WIDE);
    await tab.answered('ok');
    assert.equal(await tab.number('distance'), truth.distance);
    assert.equal(await tab.number('lower'), truth.lower);
    assert.equal(await tab.number('upper'), truth.upper);
    assert.equal(await tab.answer.locator('li').count(), truth.path.bends.length);
    assert.ok((await tab.number('tiles_read')) >= 1);
    await keep(`path-${mode}`, tab.page);
    await tab.close();
  });
}

test('two clicks ask for the path between them', async () => {
  const tab = await it.open('file=town&x=510&y=610&zoom=6&ask=path');
  const ends = [[450, 580], [594, 628]];
  for (const place of await tab.screen(...ends)) await tab.page.mouse.click(...place);
  await tab.answered('ok');
  const { from, to } = await tab.parameters();
  for (const [number, asked] of [from, to].entries()) {
    const [x, y] = asked.split(',');
    assert.ok(Math.hypot(x - ends[number][0], y - ends[number][1]) < 2, `${asked} is not at ${ends[number]}`);
  }
  const truth = await query('town', 'path', { from, to });
  assert.equal(await tab.number('distance'), truth.distance);
  await tab.close();
});

test('the nearest sites and their walking distances are those that the tool finds', async () => {
  const truth = await query('town', 'knn', { at: '500.5,600.25', k: 8 });
  const tab = await it.open('file=town&x=500&y=600&zoom=7&ask=sites&at=500.5,600.25&k=8', WIDE);
  await tab.answered('ok');
  assert.deepEqual(await tab.numbers('distance'), truth.sites.map((site) => site.distance));
  await keep('sites', tab.page);
  await tab.close();
});

test('the area within reach, and its sites, are those that the tool finds', async () => {
  const truth = await query('town', 'range', { at: '500.5,600.25', radius: 120, area: true });
  const tab = await it.open('file=town&x=500&y=600&zoom=5.5&ask=reach&at=500.5,600.25&radius=120', WIDE);
  await tab.answered('ok');
  assert.equal(await tab.number('area'), truth.area);
  assert.deepEqual(await tab.numbers('distance'), truth.sites.map((site) => site.distance));
  await keep('reach', tab.page);
  await tab.close();
});

test('the height at a point is that which the tool finds', async () => {
  const truth = await query('survey', 'z', { at: '600060.5,4900040.25' });
  const tab = await it.open('file=survey&ask=here&at=600060.5,4900040.25', WIDE);
  await tab.answered('ok');
  assert.equal(await tab.number('z'), truth.z);
  await keep('here-survey', tab.page);
  await tab.close();
});

test('a click on the map tells the triangle there', async () => {
  const tab = await it.open('file=indonesia&ask=here');
  await tab.page.mouse.click(...(await tab.places(1))[0]);
  const status = await tab.status();
  const { at } = await tab.parameters();
  const truth = await query('indonesia', 'locate', { at });
  assert.equal(status, truth.status);
  assert.match(await tab.answer.innerText(), new RegExp(truth.vertices[0]));
  await tab.close();
});
