// What `check_page` passes to the tests.
import { mkdirSync } from 'node:fs';
import { join } from 'node:path';

function setting(name) {
  const value = process.env[name];
  if (!value) throw new Error(`${name} is not set: run the tests by tools/service/check_page`);
  return value;
}

export const tiletool = setting('PAGE_TESTS_TILETOOL');
export const chromium = setting('PAGE_TESTS_CHROMIUM');

const folder = setting('PAGE_TESTS_FILES');

// Path of a tile file that `build_files` has built.
export function tileFile(name) {
  return join(folder, `${name}.tiles`);
}

// Path of a picture in the folder that `--shots` names, if it names one.
export function shot(name) {
  const shots = process.env.PAGE_TESTS_SHOTS;
  if (!shots) return undefined;
  mkdirSync(shots, { recursive: true });
  return join(shots, `${name}.png`);
}
