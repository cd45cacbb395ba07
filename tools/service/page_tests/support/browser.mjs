// Chromium, with WebGL in software, and tabs that note what goes wrong in them.
import { chromium as launcher } from 'playwright-core';
import { chromium } from './settings.mjs';
import { Tab } from './tab.mjs';

// All is drawn in software, so views are small, and nothing moves softly unless a test wants it.
const VISITOR = { viewport: { width: 800, height: 520 }, reducedMotion: 'reduce' };
// A visitor with a larger screen, for pictures that people look at.
export const WIDE = { viewport: { width: 1000, height: 660 } };

const FLAGS = [
  '--use-angle=swiftshader',
  '--enable-unsafe-swiftshader',
  '--ignore-gpu-blocklist',
  // No name but that of this machine is known, so that a call elsewhere fails.
  '--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1',
];

export class Browser {
  // Fails if the browser has no WebGL: nothing would be drawn.
  static async launch() {
    const asRoot = process.getuid() === 0 ? ['--no-sandbox'] : [];
    const browser = await launcher.launch({ executablePath: chromium, args: [...FLAGS, ...asRoot] });
    const started = new Browser(browser);
    const hasWebGl = await started.blank.then((page) =>
      page.evaluate(() => document.createElement('canvas').getContext('webgl2') !== null),
    );
    if (!hasWebGl) {
      await started.close();
      throw new Error('the browser has no WebGL 2: nothing of the map would be drawn');
    }
    return started;
  }

  constructor(browser) {
    this.browser = browser;
    this.visitors = new Map();
    // A page of nothing, to decode pictures in.
    this.blank = browser.newPage();
  }

  // Opens the page of a service at `address`. `hash` is what follows the #. Visits of the same kind of visitor share what the
  // browser keeps of the service.
  async open(address, hash = '', visitor = {}) {
    const kind = JSON.stringify(visitor);
    if (!this.visitors.has(kind)) this.visitors.set(kind, this.browser.newContext({ ...VISITOR, ...visitor }));
    const context = await this.visitors.get(kind);
    const tab = new Tab(await context.newPage(), address);
    await tab.visit(hash);
    return tab;
  }

  // A tab of a visitor who comes for the first time to a page at `address`, which is not open yet.
  async first(address, visitor = {}) {
    const context = await this.browser.newContext({ ...VISITOR, ...visitor });
    return new Tab(await context.newPage(), address);
  }

  async close() {
    await this.browser.close();
  }
}
