// The answers of `tiletool query`, with which those of the page are compared.
import { execFile } from 'node:child_process';
import { promisify } from 'node:util';
import { tileFile, tiletool } from './settings.mjs';

const run = promisify(execFile);

// Returns the answer to a query of a file, such as `query('town', 'path', {from: '0,0', to: '8,8'})`.
export async function query(file, kind, flags) {
  const args = Object.entries(flags).flatMap(([name, value]) => {
    const flag = name.length === 1 ? `-${name}` : `--${name}`;
    // A coordinate may begin with a minus.
    return value === true ? [flag] : name.length === 1 ? [flag, `${value}`] : [`${flag}=${value}`];
  });
  const { stdout } = await run(tiletool, ['query', kind, tileFile(file), '--json', ...args]);
  return JSON.parse(stdout);
}
