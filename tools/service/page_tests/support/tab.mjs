// A tab with the page: how it is waited for, asked and read.
import assert from 'node:assert/strict';

const QUIET_FRAMES = 3;

export class Tab {
  constructor(page, address) {
    this.page = page;
    this.address = address;
    this.errors = [];
    this.elsewhere = [];
    page.setDefaultTimeout(15_000);
    page.on('console', (message) => {
      if (message.type() === 'error') this.errors.push(`${message.text()} (${message.location().url})`);
    });
    page.on('pageerror', (error) => this.errors.push(`${error}`));
    page.context().on('request', (request) => {
      const url = request.url();
      if (!url.startsWith(address) && !/^(data|blob):/.test(url)) this.elsewhere.push(url);
    });
  }

  async visit(hash) {
    await this.page.goto(hash ? `${this.address}#${hash}` : this.address);
    await this.idle();
  }

  // Changes the address without a new load, as a link within the page does.
  async follow(hash) {
    await this.page.evaluate((hash) => { location.hash = hash; }, hash);
    await this.idle();
  }

  // Waits until map and query have been at rest for some frames.
  async idle() {
    await this.page.waitForFunction((frames) => {
      const quiet = document.querySelector('main')?.dataset.idle === 'true';
      window.quietFrames = quiet ? (window.quietFrames ?? 0) + 1 : 0;
      if (window.quietFrames <= frames) return false;
      window.quietFrames = 0;
      return true;
    }, QUIET_FRAMES, { polling: 'raf' });
  }

  // What the address says after its #, by name.
  async parameters() {
    const hash = await this.page.evaluate(() => location.hash.slice(1));
    return Object.fromEntries(new URLSearchParams(hash));
  }

  get answer() {
    return this.page.locator('[role=status][data-status]');
  }

  // Waits for an answer with one of the statuses of queries, and returns its text.
  async answered(status) {
    await this.page.locator(`[role=status][data-status=${status}]`).waitFor();
    await this.idle();
    return this.answer.innerText();
  }

  // All numbers of a name in the answer, in full precision.
  async numbers(name) {
    const values = await this.answer
      .locator(`data[data-name="${name}"]`)
      .evaluateAll((all) => all.map((element) => element.value));
    return values.map((value) => {
      assert.match(value, /^-?\d+(\.\d+)?(e[-+]?\d+)?$/, `${name} is no number`);
      return Number(value);
    });
  }

  // The one number of a name in the answer.
  async number(name) {
    const numbers = await this.numbers(name);
    assert.equal(numbers.length, 1, `the answer has ${numbers.length} numbers ${name}`);
    return numbers[0];
  }

  // Points of the map, as far from each other as they can be, on which nothing lies.
  async places(count) {
    const places = await this.page.evaluate((count) => {
      const canvas = document.querySelector('canvas.maplibregl-canvas');
      const { left, top, width, height } = canvas.getBoundingClientRect();
      const free = [];
      for (let row = 1; row < 20; row += 1) {
        for (let column = 1; column < 20; column += 1) {
          const place = [Math.round(left + (width * column) / 20), Math.round(top + (height * row) / 20)];
          if (document.elementFromPoint(...place)?.closest('.maplibregl-canvas-container')) free.push(place);
        }
      }
      const chosen = free.slice(Math.floor(free.length / 2)).slice(0, 1);
      while (chosen.length < Math.min(count, free.length)) {
        const apart = ([x, y]) => Math.min(...chosen.map(([a, b]) => Math.hypot(x - a, y - b)));
        chosen.push(free.reduce((best, place) => (apart(place) > apart(best) ? place : best)));
      }
      return chosen;
    }, count);
    assert.equal(places.length, count, 'the map is covered');
    return places;
  }

  // The map as it is seen, without what lies on it.
  async map() {
    const canvas = this.page.locator('canvas.maplibregl-canvas');
    await this.page.evaluate(() => {
      const sheet = new CSSStyleSheet();
      sheet.replaceSync('body * { visibility: hidden !important } canvas.maplibregl-canvas { visibility: visible !important }');
      document.adoptedStyleSheets = [...document.adoptedStyleSheets, sheet];
    });
    const picture = await this.page.screenshot({ clip: await canvas.boundingBox() });
    await this.page.evaluate(() => { document.adoptedStyleSheets = document.adoptedStyleSheets.slice(0, -1); });
    return picture;
  }

  // Fails if anything went wrong in this tab, or was asked elsewhere, and closes it.
  async close() {
    await this.page.context().close();
    assert.deepEqual(this.errors, [], 'errors in the console');
    assert.deepEqual(this.elsewhere, [], 'requests elsewhere');
  }
}
