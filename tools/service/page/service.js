/** Requests to the service that serves this page. */

/** Why there is no answer. `status` is 0 if the service does not answer at all. */
export class Problem extends Error {
  constructor(status, what, advice) {
    super(what);
    this.status = status;
    this.advice = advice;
  }
}

/** Returns the absolute address of a path of the service. */
export function address(path) {
  return new URL(path, document.baseURI).href;
}

/** Asks for a path. Returns the body, and the headers. */
export async function ask(path, signal) {
  let response;
  try {
    response = await fetch(address(path), {signal, cache: 'no-cache'});
  } catch (error) {
    if (error.name === 'AbortError') throw error;
    throw new Problem(0, 'The server does not answer.', 'It may have stopped, or the network is down.');
  }
  const body = await response.json().catch(() => null);
  if (!response.ok || !body) {
    const what = body?.what ? `${body.what[0].toUpperCase()}${body.what.slice(1)}.` : `The server answers ${response.status}.`;
    const advice = body?.advice ? `${body.advice[0].toUpperCase()}${body.advice.slice(1)}.` : '';
    throw new Problem(response.status, what, advice);
  }
  return {body, headers: response.headers};
}

/** Returns what is known of a file, and the first zoom of its pictures. */
export async function describe(id) {
  const [file, shade] = await Promise.all([ask(id), ask(`${id}/native/shade.json`)]);
  return {...file.body, minZoom: shade.body.minzoom};
}
