// The address holds the view and the query, so that a link shows what its sender saw.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { difference } from './support/picture.mjs';
import { world } from './support/world.mjs';

const it = world(['town', 'survey']);

const VIEWS = {
  path: 'file=town&x=400&y=500&zoom=6.5&layers=shade,walls&ask=path&from=300,420&to=505,580&mode=fast',
  sites: 'file=town&x=400&y=500&zoom=7&layers=shade,sites&ask=sites&at=401.5,502.25&k=5&mode=exact',
  reach: 'file=town&x=400&y=500&zoom=6&layers=shade,holes&ask=reach&at=401.5,502.25&radius=90&mode=exact',
  terrain: 'file=survey&x=600060&y=4900050&zoom=5&layers=heights&ask=here&at=600062,4900041&three=1&pitch=50',
};

// What the answer says, but for what it took.
async function said(tab) {
  return (await tab.answer.innerText()).replace(/\d+ tiles? read in .*/, '');
}

for (const [name, view] of Object.entries(VIEWS)) {
  test(`the address of a view (${name}) is kept, and opens the same view elsewhere`, async () => {
    const tab = await it.open(view);
    await tab.answered('ok');
    const shown = await tab.parameters();
    for (const [key, value] of new URLSearchParams(view)) assert.equal(shown[key], value, key);
    const again = await it.open(await tab.page.evaluate(() => location.hash.slice(1)));
    await again.answered('ok');
    assert.equal(await said(again), await said(tab));
    assert.ok((await difference(it.browser, await tab.map(), await again.map())) < 0.01, 'another map');
    await tab.close();
    await again.close();
  });
}

test('back and forward go through the queries that were asked', async () => {
  const tab = await it.open('file=town&x=500&y=600&zoom=6&ask=here');
  const [first, second] = await tab.places(2);
  await tab.page.mouse.click(...first);
  await tab.answered('ok');
  const { at } = await tab.parameters();
  await tab.page.mouse.click(...second);
  await tab.idle();
  const later = (await tab.parameters()).at;
  assert.notEqual(later, at);
  await tab.page.goBack();
  await tab.idle();
  assert.equal((await tab.parameters()).at, at);
  await tab.page.goForward();
  await tab.idle();
  assert.equal((await tab.parameters()).at, later);
  await tab.close();
});

test('an address that is damaged opens what can be opened of it', async () => {
  const tab = await it.open('file=town&x=abc&zoom=&layers=none,shade&ask=everything&k=-5&from=1&mode=%3Cb%3E');
  assert.equal((await tab.parameters()).file, 'town');
  await tab.close();
});
