// Pause, resume, step, rate and time of a simulator (sim_ros), for the panels of all simulators.

import {el} from './dom.js';

const ENOUGH = 0.9;  // a smaller share of the requested rate is too slow, as in sim_ros

// `call(name, args)` calls a service of the node; `more` are buttons of the panel.
export class SimulationCard {
  constructor(ros, call, ...more) {
    this._ros = ros;
    this.badge = el('span', {class: 'pill busy badge', hidden: true}, 'Paused');
    this._pause = el('button', {type: 'button', on: {click: () => call(this._clock?.paused ? 'resume' : 'pause', {})}}, 'Pause');
    this._steps = el('input', {type: 'number', min: 1, max: 100000, value: 1, 'aria-label': 'Steps', class: 'short'});
    const step = el('button', {type: 'button', on: {click: () => {
      if (this._steps.reportValidity()) call('step', {steps: Number(this._steps.value)});
    }}}, 'Step');
    this._rate = el('input', {type: 'number', min: 0.01, max: 1000, step: 'any', value: 1, class: 'short', on: {change: async () => {
      if (!this._rate.reportValidity()) return;
      const answer = await call('set_rate', {rate: Number(this._rate.value)});
      this._note.textContent = answer?.warning ?? '';
    }}});
    this._note = el('p', {class: 'muted small', role: 'status'});
    this._time = el('p', {class: 'muted small'});
    this.element = el('details', {class: 'card simulation', open: wide()}, el('summary', {}, 'Simulation'), el('div', {class: 'stack'},
      el('div', {class: 'row'}, this._pause, step, this._steps, el('label', {class: 'check'}, 'Rate', this._rate)),
      el('div', {class: 'row'}, more), this._time, this._note));
    this._end = () => {};
  }

  // Show the clock of a node such as /turtlesim; '': of none.
  follow(node) {
    this._end();
    this._clock = null;
    this._end = node ? this._ros.subscribe(`${node}/clock_status`, 'sim_ros/ClockStatus', (clock) => this._show(clock)) : () => {};
  }

  _show(clock) {
    this._clock = clock;
    this._pause.textContent = clock.paused ? 'Resume' : 'Pause';
    const slow = clock.pace < ENOUGH * clock.rate && clock.rate !== null && !clock.paused && !clock.lockstep;
    const behind = slow && this._slow;  // for two seconds: a short stall is caught up
    this._slow = slow;
    const pace = `${Number(clock.pace).toFixed(1)} times real time`;
    this.badge.hidden = !clock.paused && !behind;
    this.badge.textContent = clock.paused ? 'Paused' : `Slow: ${pace}`;
    if (document.activeElement !== this._rate) this._rate.value = clock.rate ?? '';  // null: as fast as possible
    const rate = clock.rate === null ? 'as fast as possible' : clock.rate === 1 ? 'real time' : `${clock.rate} times real time`;
    this._time.textContent = clock.paused ? `Paused at ${Number(clock.time).toFixed(2)} s, step ${clock.steps}`
      : behind ? `Time runs at ${pace}, not ${clock.rate}: this machine is too slow, or too busy`
        : `Time runs: ${rate}${clock.lockstep ? ', in lockstep' : ''}`;
  }
}

// Return whether the screen has room for open cards.
export function wide() {
  return matchMedia('(width >= 900px)').matches;
}
