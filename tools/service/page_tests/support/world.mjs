// A service and a browser for the tests of one file.
import { after, before } from 'node:test';
import { Browser } from './browser.mjs';
import { Service } from './service.mjs';
import { tileFile } from './settings.mjs';

// Starts both before the tests of a file, and ends them after.
export function world(files, options = []) {
  const started = {};
  before(async () => {
    started.service = await Service.start(files.map(tileFile), { options });
    started.browser = await Browser.launch();
    started.open = (hash, context) => started.browser.open(started.service.address, hash, context);
  });
  after(async () => {
    await started.browser?.close();
    await started.service?.stop();
  });
  return started;
}
