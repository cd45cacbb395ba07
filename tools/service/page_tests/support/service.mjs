// `tiletool serve`, started and stopped.
import { spawn } from 'node:child_process';
import { once } from 'node:events';
import { tiletool } from './settings.mjs';

export class Service {
  // Serves tile files. `listen` is an address such as 127.0.0.1:0.
  static async start(files, { options = [], listen = '127.0.0.1:0' } = {}) {
    const args = ['serve', ...files, '--listen', listen, ...options];
    const process = spawn(tiletool, args, { stdio: ['ignore', 'pipe', 'pipe'] });
    const service = new Service(process);
    service.address = await service.#announced();
    return service;
  }

  #errors = '';

  constructor(process) {
    this.process = process;
    process.stderr.on('data', (text) => (this.#errors += text));
  }

  async #announced() {
    let text = '';
    for await (const part of this.process.stdout) {
      text += part;
      const found = /at (http:\S+)\s/.exec(text);
      if (found) return found[1];
    }
    throw new Error(`the service did not start: ${this.#errors}`);
  }

  get listen() {
    return new URL(this.address).host;
  }

  // Ends the service at once, as a machine that loses its power does.
  async stop() {
    if (this.process.exitCode !== null || this.process.signalCode !== null) return;
    const ended = once(this.process, 'exit');
    this.process.kill('SIGKILL');
    await ended;
  }
}
