// The page on a phone and in the dark, and for those who do not see it.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { createRequire } from 'node:module';
import { test } from 'node:test';
import { query } from './support/oracle.mjs';
import { luminance } from './support/picture.mjs';
import { keep } from './support/shots.mjs';
import { world } from './support/world.mjs';

const it = world(['town', 'survey']);

const PHONE = { viewport: { width: 390, height: 844 }, deviceScaleFactor: 2, isMobile: true, hasTouch: true };
const PATH = 'file=town&ask=path&from=100,100&to=900,900';
const axe = readFile(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');

// Rules that the page breaks seriously.
async function broken(page) {
  await page.evaluate(await axe);
  const { violations, passes } = await page.evaluate(() => window.axe.run(document, {
    runOnly: ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa', 'best-practice'],
  }));
  assert.ok(passes.length > 15, `only ${passes.length} rules found something to check`);
  return violations
    .filter(({ impact }) => impact === 'serious' || impact === 'critical')
    .flatMap(({ id, nodes }) => nodes.map(({ target, failureSummary }) => `${id}: ${target} ${failureSummary}`));
}

for (const [name, context] of [
  ['in the light', { colorScheme: 'light' }],
  ['in the dark', { colorScheme: 'dark' }],
  ['on a phone', PHONE],
]) {
  test(`axe finds nothing serious ${name}, with an answer and without`, async () => {
    const tab = await it.open('file=survey', context);
    assert.deepEqual(await broken(tab.page), []);
    await tab.follow(PATH);
    await tab.answered('ok');
    assert.deepEqual(await broken(tab.page), []);
    await keep(`axe-${name.replaceAll(' ', '-')}`, tab.page);
    await tab.close();
  });
}

test('the page is dark where the system is', async () => {
  const means = {};
  for (const colorScheme of ['light', 'dark']) {
    const tab = await it.open('file=town', { colorScheme });
    const panel = await tab.panel.screenshot();
    means[colorScheme] = (await luminance(it.browser, panel)).mean;
    await keep(colorScheme, tab.page);
    await tab.close();
  }
  assert.ok(means.light > 180 && means.dark < 80, JSON.stringify(means));
});

test('on a phone the page fits, the panel can be pulled down, and a finger asks', async () => {
  const tab = await it.open('file=town&x=500&y=600&zoom=6&ask=here', PHONE);
  const { page } = tab;
  const [wide, high] = await page.evaluate(() => [document.documentElement.scrollWidth, document.documentElement.scrollHeight]);
  assert.ok(wide <= 390 && high <= 844, `the page is ${wide} × ${high}`);
  await keep('phone', page);
  const seen = async () => (await tab.panel.boundingBox()).y;
  const top = await seen();
  await tab.pullDown();
  await tab.idle();
  assert.ok((await seen()) > Math.max(top, 844 * 0.7), `the panel stays at ${await seen()}`);
  await keep('phone-map', page);
  await page.touchscreen.tap(...(await tab.places(1))[0]);
  const status = await tab.status();
  const { at } = await tab.parameters();
  const truth = await query('town', 'locate', { at });
  assert.equal(status, truth.status);
  await keep('phone-answer', page);
  await tab.close();
});

for (const [name, context] of [['beside the map', {}], ['on a phone', PHONE]]) {
  test(`nothing in the panel ${name} is cut off, whatever is asked`, async () => {
    const tab = await it.open('file=town&at=500.5,600.25&from=100,100&to=900,900', context);
    for (const ask of ['here', 'sites', 'reach', 'path']) {
      await tab.question(ask).check({ force: true });
      await tab.answered('ok');
      const cut = await tab.panel.evaluate((panel) => {
        const { left, right } = panel.getBoundingClientRect();
        const isCut = (box) => box.width > 0 && (box.left < left || box.right > right);
        const outside = [...panel.querySelectorAll('#sheet > *:not(#legend) *')].filter((element) => isCut(element.getBoundingClientRect()));
        return outside.map((element) => element.outerHTML.slice(0, 80));
      });
      assert.deepEqual(cut, [], ask);
    }
    await tab.close();
  });
}

test('who wants no motion sees none, and others do', async () => {
  for (const reducedMotion of ['reduce', 'no-preference']) {
    const tab = await it.open('file=town', { reducedMotion });
    const moving = await tab.page.evaluate(() => [...document.querySelectorAll('body *')]
      .filter((element) => getComputedStyle(element).transitionDuration.split(',').some((time) => parseFloat(time) > 0.01))
      .length);
    assert.equal(moving > 0, reducedMotion === 'no-preference', `${moving} elements move`);
    await tab.close();
  }
});
