// What a first visit costs before the first map tile, and how soon there is a picture.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Relay } from './support/bytes.mjs';
import { world } from './support/world.mjs';

const it = world(['town', 'survey']);

const TILE = /^\/\w+\/native\/\w+\/\d+\/\d+\/\d+\.(png|mvt)/;
const MOST_BYTES = 700_000;
const VISITS = 3;
const TILE_SIZE = 256;
const MOVING = { reducedMotion: 'no-preference' };

for (const file of ['town', 'survey']) {
  test(`the page of ${file} asks for less than ${MOST_BYTES / 1000} KB before its first tile`, async (context) => {
    const relay = await Relay.start(it.service.address, (path) => TILE.test(path));
    try {
      const tab = await it.browser.first(relay.address);
      await tab.visit(`file=${file}`);
      assert.ok(relay.isOver, 'no tile was asked for');
      // What is counted is all there is, or the relay does not see the page.
      assert.ok(relay.bytes > 100_000, `${relay.bytes} bytes are not a page`);
      context.diagnostic(`${relay.bytes} bytes in ${relay.paths.length - 1} requests before the first tile`);
      assert.ok(relay.bytes < MOST_BYTES, `${relay.bytes} bytes: ${relay.paths.join(' ')}`);
      await tab.close();
    } finally {
      await relay.stop();
    }
  });
}

// A page that has MapLibre as the page of the service has it, and draws nothing by it.
const EMPTY = (vendor) => `<!doctype html><title>empty</title><link rel="stylesheet" href="${vendor}maplibre-gl.css">
<style>body { margin: 0 } #map { height: 100vh }</style><main data-idle="false"><div id="map"></div></main>
<script type="module">import { Map } from '${vendor}maplibre-gl.mjs';
new Map({ container: 'map', style: { version: 8, sources: {}, layers: [] } })
  .once('idle', () => { document.querySelector('main').dataset.idle = 'true'; });
</script>`;

// Returns the address of the folder of MapLibre that the page names.
async function vendorOf(address) {
  const page = await (await fetch(address)).text();
  const [, style] = /href="([^"]*)maplibre-gl\.css"/.exec(page);
  return new URL(style, address).href;
}

// Milliseconds from the start of a visit until the page is at rest for the first time, and until it shows its first map tile:
// two frames after WebGL is given a picture of the size of a tile.
async function times(tab, hash) {
  await tab.page.addInitScript((size) => {
    new MutationObserver(() => {
      if (document.querySelector('main')?.dataset.idle === 'true') window.atRest ??= performance.now();
    }).observe(document, { attributes: true, childList: true, subtree: true });
    const graphics = WebGL2RenderingContext.prototype;
    const { texSubImage2D } = graphics;
    graphics.texSubImage2D = function (...given) {
      if (given.at(-1)?.width === size) {
        graphics.texSubImage2D = texSubImage2D;
        requestAnimationFrame(() => requestAnimationFrame(() => { window.firstTile = performance.now(); }));
      }
      return texSubImage2D.apply(this, given);
    };
  }, TILE_SIZE);
  await tab.visit(hash);
  return tab.page.evaluate(() => ({ atRest: window.atRest, firstTile: window.firstTile }));
}

function median(values) {
  return [...values].sort((a, b) => a - b)[Math.floor(values.length / 2)];
}

test('the first map tile is shown, and an empty page of MapLibre is measured beside it', async (context) => {
  const vendor = await vendorOf(it.service.address);
  const visits = { empty: [], town: [] };
  for (let visit = 0; visit < VISITS; visit += 1) {
    const empty = await it.browser.first(it.service.address, MOVING);
    await empty.page.route('**/empty', (route) => route.fulfill({ contentType: 'text/html', body: EMPTY(vendor) }));
    empty.address += 'empty';
    visits.empty.push(await times(empty, ''));
    await empty.close();
    const tab = await it.browser.first(it.service.address, MOVING);
    visits.town.push(await times(tab, 'file=town'));
    await tab.close();
  }
  const empty = median(visits.empty.map(({ atRest }) => atRest));
  const ratios = ['firstTile', 'atRest'].map((moment) => {
    const town = median(visits.town.map((all) => all[moment]));
    assert.ok(empty > 0 && town > 0);
    return `${town.toFixed(0)} ms (${(town / empty).toFixed(2)} times)`;
  });
  context.diagnostic(`empty page after ${empty.toFixed(0)} ms; first map tile after ${ratios[0]}, all at rest after ${ratios[1]}`);
});
