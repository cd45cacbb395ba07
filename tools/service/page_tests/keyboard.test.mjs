// The page without a mouse.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { query } from './support/oracle.mjs';
import { keep } from './support/shots.mjs';
import { world } from './support/world.mjs';

const it = world(['town', 'survey']);

// Presses Tab until the focus has gone once through the page. Returns what had it, and whether that was seen.
async function focused(page) {
  const seen = [];
  for (let presses = 0; presses < 80; presses += 1) {
    await page.keyboard.press('Tab');
    const now = await page.evaluate(() => {
      const element = document.activeElement;
      if (!element || element === document.body || element.dataset.focusSeen) return null;
      element.dataset.focusSeen = 'true';
      const looks = [element, element.nextElementSibling, element.closest('label')].filter(Boolean).map((one) => getComputedStyle(one));
      const isMarked = looks.some((look) => (look.outlineStyle !== 'none' && parseFloat(look.outlineWidth) > 0) || look.boxShadow !== 'none');
      return { html: element.outerHTML.slice(0, 120), isMarked };
    });
    if (!now) break;
    seen.push(now);
  }
  return seen;
}

test('each control is reached by Tab, and is seen to have the focus', async () => {
  const tab = await it.open('file=survey');
  const seen = await focused(tab.page);
  assert.deepEqual(seen.filter(({ isMarked }) => !isMarked).map(({ html }) => html), [], 'focus that is not seen');
  // Of radio buttons of one name, Tab reaches one, and arrows the others.
  const missed = await tab.page.evaluate(() => {
    const controls = [...document.querySelectorAll('a[href], button, input, select, summary, [tabindex="0"]')];
    const isShown = (element) => element.checkVisibility({ visibilityProperty: true }) && !element.disabled;
    const isReached = (element) => element.dataset.focusSeen ||
      (element.type === 'radio' && document.querySelector(`input[name="${element.name}"][data-focus-seen]`));
    return controls.filter((element) => isShown(element) && !isReached(element)).map((element) => element.outerHTML.slice(0, 120));
  });
  assert.deepEqual(missed, []);
  await tab.close();
});

test('a path is asked for by keys alone', async () => {
  const tab = await it.open('file=town&x=500&y=600&zoom=6');
  const { keyboard } = tab.page;
  await tab.question('path').focus();
  await keyboard.press('Space');
  await tab.page.locator('canvas.maplibregl-canvas').focus();
  const { x, y } = await tab.parameters();
  await keyboard.press('Enter');
  await tab.idle();
  await keyboard.press('ArrowRight');
  await tab.idle();
  await keyboard.press('ArrowUp');
  await tab.idle();
  await keyboard.press('Enter');
  const status = await tab.status();
  const asked = await tab.parameters();
  const [from, to] = [asked.from, asked.to].map((point) => point.split(',').map(Number));
  // It was asked at the centre: where the view was, and further right and up.
  assert.ok(Math.hypot(from[0] - x, from[1] - y) < 1, `${from} is not the centre ${x},${y}`);
  assert.ok(to[0] > from[0] && to[1] > from[1], `${to} is not right of and above ${from}`);
  const truth = await query('town', 'path', { from: asked.from, to: asked.to });
  assert.equal(status, truth.status);
  await keep('keyboard', tab.page);
  await keyboard.press('Escape');
  await tab.idle();
  assert.equal((await tab.parameters()).from, undefined, 'Escape does not clear');
  await tab.close();
});

test('plus and minus go closer and back', async () => {
  const tab = await it.open('file=town&x=500&y=600&zoom=6');
  await tab.page.locator('canvas.maplibregl-canvas').focus();
  await tab.page.keyboard.press('+');
  await tab.idle();
  const closer = Number((await tab.parameters()).zoom);
  assert.ok(closer > 6, `zoom ${closer}`);
  await tab.page.keyboard.press('-');
  await tab.idle();
  assert.ok(Number((await tab.parameters()).zoom) < closer);
  await tab.close();
});
