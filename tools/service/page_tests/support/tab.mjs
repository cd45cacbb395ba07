// A tab with the page: how it is waited for, asked and read.
import assert from 'node:assert/strict';

const QUIET_FRAMES = 3;
// Milliseconds after which something that is waited for will not come.
const MOST_WAITED = 30_000;
// What people read on the switches of layers and on the kinds of questions.
const LAYERS = {
  shade: 'Picture', heights: 'Heights', cells: 'Cells of tiles', triangles: 'Triangles', lines: 'Break lines', walls: 'Walls',
  holes: 'Holes', sites: 'Sites', three: '3D',
};
const QUESTIONS = { here: 'Here', sites: 'Nearest sites', reach: 'Within reach', path: 'Path' };

export class Tab {
  constructor(page, address) {
    this.page = page;
    this.address = address;
    this.errors = [];
    this.elsewhere = [];
    page.setDefaultTimeout(MOST_WAITED);
    page.on('console', (message) => {
      if (message.type() === 'error') this.errors.push(`${message.text()} (${message.location().url})`);
    });
    page.on('pageerror', (error) => this.errors.push(`${error}`));
    page.on('request', (request) => {
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

  get panel() {
    return this.page.locator('#panel');
  }

  // The switch of a layer, by its name in the address.
  layer(name) {
    return this.page.getByRole('switch', { name: LAYERS[name], exact: true });
  }

  // The radio button of a kind of question, by its name in the address.
  question(name) {
    return this.page.getByRole('radio', { name: QUESTIONS[name], exact: true });
  }

  // Chooses another file in the list of files.
  async choose(file) {
    await this.page.getByRole('button', { name: /other files/i }).click();
    await this.page.getByRole('button', { name: `Show ${file}`, exact: true }).click();
    await this.idle();
  }

  // Pulls the panel of a phone down with a finger.
  async pullDown() {
    const grip = await this.page.getByRole('button', { name: 'Panel' }).boundingBox();
    const [x, y] = [grip.x + grip.width / 2, grip.y + grip.height / 2];
    const session = await this.page.context().newCDPSession(this.page);
    const touch = (type, ...touchPoints) => session.send('Input.dispatchTouchEvent', { type, touchPoints });
    await touch('touchStart', { x, y });
    for (const pulled of [30, 60, 90, 120]) await touch('touchMove', { x, y: y + pulled });
    await touch('touchEnd');
    await this.idle();
  }

  // The point of the file that the page names under a point of the screen.
  async under(place) {
    await this.page.mouse.move(...place);
    const text = await this.page.locator('#coordinates').innerText();
    return text.split(', ').map((number) => Number(number.replaceAll('\u202f', '').replace('\u2212', '-')));
  }

  // The points of the screen that show points of the file, by what the page names under two other points.
  async screen(...points) {
    const places = await this.places(2);
    const [a, b] = [await this.under(places[0]), await this.under(places[1])];
    const along = (axis, value) =>
      places[0][axis] + ((value - a[axis]) / (b[axis] - a[axis])) * (places[1][axis] - places[0][axis]);
    return points.map((point) => point.map((value, axis) => along(axis, value)));
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

  // Waits for an answer, and returns its status.
  async status() {
    await this.answer.waitFor();
    await this.idle();
    return this.answer.getAttribute('data-status');
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
      // A panel beside the map grows with its answer.
      const panel = document.querySelector('#panel').getBoundingClientRect();
      const isBelow = panel.width > width / 2;
      const free = [];
      for (let row = 1; row < 20; row += 1) {
        for (let column = 1; column < 20; column += 1) {
          const place = [Math.round(left + (width * column) / 20), Math.round(top + (height * row) / 20)];
          const isFree = document.elementFromPoint(...place)?.closest('.maplibregl-canvas-container');
          if (isFree && (isBelow || place[0] > panel.right)) free.push(place);
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

  // The map as it is seen, without what lies on it: all of it, or a square of 16 pixels around a point.
  async map(around) {
    const canvas = await this.page.locator('canvas.maplibregl-canvas').boundingBox();
    const clip = around ? { x: around[0] - 8, y: around[1] - 8, width: 16, height: 16 } : canvas;
    await this.page.evaluate(() => {
      const sheet = new CSSStyleSheet();
      sheet.replaceSync('body * { visibility: hidden !important } canvas.maplibregl-canvas { visibility: visible !important }');
      document.adoptedStyleSheets = [...document.adoptedStyleSheets, sheet];
    });
    const picture = await this.page.screenshot({ clip });
    await this.page.evaluate(() => { document.adoptedStyleSheets = document.adoptedStyleSheets.slice(0, -1); });
    return picture;
  }

  // Fails if anything went wrong in this tab, or was asked elsewhere, and closes it.
  async close() {
    await this.page.close();
    assert.deepEqual(this.errors, [], 'errors in the console');
    assert.deepEqual(this.elsewhere, [], 'requests elsewhere');
  }
}
