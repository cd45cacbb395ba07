// A relay between a browser and a service, which counts what is sent.
import { connect, createServer } from 'node:net';
import { once } from 'node:events';

export class Relay {
  // Relays to a service. `isLast` tells the path of the request before whose answer the counting ends.
  static async start(address, isLast) {
    const relay = new Relay(new URL(address), isLast);
    relay.server.listen(0, '127.0.0.1');
    await once(relay.server, 'listening');
    relay.address = `http://127.0.0.1:${relay.server.address().port}/`;
    return relay;
  }

  // Bytes of answers, heads too, and the paths that were asked for, until the last.
  bytes = 0;
  paths = [];
  isOver = false;

  constructor(target, isLast) {
    this.target = target;
    this.isLast = isLast;
    this.sockets = new Set();
    this.server = createServer((browser) => this.#relay(browser));
  }

  #relay(browser) {
    const service = connect(Number(this.target.port), this.target.hostname);
    let isLast = false;
    for (const [socket, other] of [[browser, service], [service, browser]]) {
      this.sockets.add(socket);
      socket.on('close', () => other.destroy());
      socket.on('error', () => other.destroy());
    }
    browser.on('data', (part) => {
      const found = /^(?:GET|HEAD|POST) (\S+) HTTP/.exec(part.toString('latin1'));
      if (found && !this.isOver) {
        this.paths.push(found[1]);
        isLast ||= this.isLast(found[1]);
      }
      service.write(part);
    });
    service.on('data', (part) => {
      this.isOver ||= isLast;
      if (!this.isOver) this.bytes += part.length;
      browser.write(part);
    });
  }

  async stop() {
    this.server.close();
    for (const socket of this.sockets) socket.destroy();
    await once(this.server, 'close');
  }
}
