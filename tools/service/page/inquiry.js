/** Asks the question of a state, and shows the answer. A new question ends the one before. */

import {clearAnswer, marksOf, showAnswer, showProblem} from './answer.js';
import {byId} from './dom.js';
import {groundAt, question} from './questions.js';
import {ask} from './service.js';

/** The time after which a question that takes long is shown as such, in milliseconds. */
const PATIENCE = 250;

export class Inquiry {
  /** `actions` has `goTo`, `use` and `failed`, which the answer's buttons and a problem call. */
  constructor(chart, idle, actions) {
    Object.assign(this, {chart, idle, actions});
    this.panel = byId('answer');
    this.running = null;
  }

  /** Asks the question of a state, if it has all points. */
  async run(file, plane, state) {
    this.running?.abort();
    const path = question(file, state);
    if (!path) {
      this.running = null;
      clearAnswer(this.panel);
      this.chart.setMarks(marksOf(null, state, plane));
      this.idle.end('query');
      return;
    }
    const running = (this.running = new AbortController());
    this.idle.begin('query');
    this.idle.begin('map');
    this.chart.setMarks(marksOf(null, state, plane));
    const late = setTimeout(() => this.panel.classList.add('busy'), PATIENCE);
    try {
      const {body, headers} = await ask(path, running.signal);
      const ground = await this.ground(file, state, body, running.signal);
      if (this.running !== running) return;
      this.show(body, headers, state, {file, plane, ground});
    } catch (problem) {
      if (problem.name === 'AbortError' || this.running !== running) return;
      showProblem(this.panel, problem, () => this.run(file, plane, state));
      this.actions.failed(problem);
    } finally {
      clearTimeout(late);
      if (this.running === running) {
        this.panel.classList.remove('busy');
        this.idle.end('query');
      }
    }
  }

  show(body, headers, state, known) {
    const {goTo, use} = this.actions;
    const context = {...known, zoom: this.chart.map.getZoom(), goTo, use};
    showAnswer(this.panel, body, headers, state, context);
    this.chart.setMarks(marksOf(body, state, known.plane));
    this.actions.answered();
  }

  /** Returns the height of the ground in a hole, which `locate` does not say. */
  async ground(file, state, body, signal) {
    if (state.ask !== 'here' || !file.has_z || body.z !== null || body.element === 'outside') return null;
    return (await ask(groundAt(file, state.at), signal)).body.z;
  }
}
