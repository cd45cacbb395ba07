// What the page says when there is no ordinary answer, in words that a person understands.
import assert from 'node:assert/strict';
import { copyFile, mkdtemp, rename, rm } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import { query } from './support/oracle.mjs';
import { Service } from './support/service.mjs';
import { tileFile } from './support/settings.mjs';
import { keep } from './support/shots.mjs';
import { world } from './support/world.mjs';

const it = world(['town', 'yard']);

// Serves files with options of its own while `use` runs.
async function served(files, options, use) {
  const service = await Service.start(files, options);
  try {
    await use(service);
  } finally {
    await service.stop();
  }
}

test('a point in an obstacle is said to be in one, and the nearest free point is a click away', async () => {
  const truth = await query('town', 'locate', { at: '17,13' });
  const tab = await it.open('file=town&ask=sites&at=17,13&k=3');
  assert.match(await tab.answered('inside_obstacle'), /inside an obstacle/i);
  await keep('inside-obstacle', tab.page);
  await tab.answer.getByRole('button', { name: /nearest free/i }).click();
  await tab.answered('ok');
  const { at } = await tab.parameters();
  assert.deepEqual(at.split(',').map(Number), truth.nearest_free);
  const sites = (await query('town', 'knn', { at, k: 3 })).sites;
  assert.deepEqual(await tab.numbers('distance'), sites.map((site) => site.distance));
  await tab.close();
});

test('a closed yard is said to be out of reach', async () => {
  const tab = await it.open('file=yard&ask=path&from=1005,1005&to=1040,1040');
  assert.match(await tab.answered('unreachable'), /no (path|way)/i);
  await keep('unreachable', tab.page);
  await tab.close();
});

test('a path that takes more tiles than a request may read is said to be at least so long', async () => {
  const ends = { from: '100,100', to: '900,900' };
  const truth = await query('town', 'path', { ...ends, 'max-tiles': 3 });
  assert.ok(truth.lower_bound > 0);
  await served([tileFile('town')], { options: ['--max-tiles', '3'] }, async ({ address }) => {
    const tab = await it.browser.open(address, 'file=town&ask=path&from=100,100&to=900,900');
    assert.match(await tab.answered('out_of_budget'), /at least/i);
    assert.equal(await tab.number('lower_bound'), truth.lower_bound);
    await keep('out-of-budget', tab.page);
    await tab.close();
  });
});

test('a point beyond the data is said to be outside', async () => {
  const tab = await it.open('file=town&ask=here&at=-500,-500');
  assert.match(await tab.answered('ok'), /outside|beyond/i);
  await tab.close();
});

test('a name that no file has is said to be unknown, and the files that there are can be chosen', async () => {
  const tab = await it.open('file=nothing');
  assert.match(await tab.page.locator('main').innerText(), /nothing/);
  await tab.choose('yard');
  assert.equal((await tab.parameters()).file, 'yard');
  await tab.close();
});

test('a server that is gone is said to be gone, and the question is answered when it is back', async () => {
  const truth = await query('town', 'knn', { at: '500.5,600.25', k: 2 });
  let { address, listen } = {};
  let tab;
  await served([tileFile('town')], {}, async (service) => {
    ({ address, listen } = service);
    tab = await it.browser.open(address, 'file=town&ask=sites&at=100,100&k=2');
    await tab.answered('ok');
  });
  await tab.follow('file=town&ask=sites&at=500.5,600.25&k=2');
  assert.match(await tab.answered('error'), /server|service/i);
  await keep('server-gone', tab.page);
  await tab.answer.getByRole('button', { name: /again/i }).waitFor();
  // The browser itself notes that nobody answered, and no other error is there.
  assert.deepEqual(tab.errors.filter((error) => !/ERR_CONNECTION_(REFUSED|RESET)/.test(error)), []);
  tab.errors = [];
  await served([tileFile('town')], { listen }, async () => {
    await tab.answered('ok');
    assert.deepEqual(await tab.numbers('distance'), truth.sites.map((site) => site.distance));
    await tab.close();
  });
});

test('a file that is replaced is noticed and said, and the answer is that of the new one', async () => {
  const ends = { from: '1005,1005', to: '1110,1060' };
  const [old, changed] = await Promise.all(['yard', 'yard_changed'].map((file) => query(file, 'path', ends)));
  assert.notEqual(old.distance, changed.distance);
  const folder = await mkdtemp(join(tmpdir(), 'page-'));
  const [path, next] = [join(folder, 'yard.tiles'), join(folder, 'next')];
  await copyFile(tileFile('yard'), path);
  await served([path], {}, async ({ address }) => {
    const tab = await it.browser.open(address, 'file=yard&ask=path&from=1005,1005&to=1110,1060');
    await tab.answered('ok');
    assert.equal(await tab.number('distance'), old.distance);
    await copyFile(tileFile('yard_changed'), next);
    await rename(next, path);
    await tab.page.getByText(/(changed|replaced|new version)/i).first().waitFor();
    await tab.idle();
    assert.equal(await tab.number('distance'), changed.distance);
    await keep('replaced', tab.page);
    await tab.close();
  });
  await rm(folder, { recursive: true });
});
