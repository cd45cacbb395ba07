// Pictures of what was seen, for people.
import { writeFile } from 'node:fs/promises';
import { shot } from './settings.mjs';

// Writes a picture of a page, if `check_page` was asked for pictures.
export async function keep(name, page) {
  const path = shot(name);
  if (path) await writeFile(path, await page.screenshot());
}
