// The subscriptions, timers and listeners that a panel must end.
export class Scope {
  constructor(ros) {
    this.ros = ros;
    this.ended = false;
    this._ends = new Set();
  }

  // Call a function at the end; return one that calls it earlier.
  add(end) {
    const once = () => {
      if (this._ends.delete(once)) end();
    };
    this._ends.add(once);
    if (this.ended) once();
    return once;
  }

  listen(target, name, listener, options) {
    target.addEventListener(name, listener, options);
    return this.add(() => target.removeEventListener(name, listener, options));
  }

  // Call `work` now and again `seconds` after it has ended, while the page is visible and ROS is connected; `work` may
  // be async, `failed` gets its error. Return a function that asks for a call at once.
  every(seconds, work, failed = console.error) {
    let timer = null;
    let running = false;
    let again = false;
    const run = async () => {
      clearTimeout(timer);
      again = running;
      if (running || this.ended) return;
      running = true;
      try {
        if (!document.hidden && this.ros.connected) await work();
      } catch (error) {
        if (!this.ended) failed(error);
      }
      running = false;
      if (!this.ended) timer = setTimeout(run, again ? 0 : seconds * 1000);
    };
    this.add(() => clearTimeout(timer));
    this.listen(document, 'visibilitychange', () => document.hidden || run());
    this.add(this.ros.onState(() => this.ros.connected && run()));
    run();
    return run;
  }

  end() {
    this.ended = true;
    for (const end of [...this._ends]) end();
  }
}

// A panel whose subscriptions, timers and listeners are in its scope.
export class Panel {
  constructor(context) {
    this.context = context;
    this.scope = new Scope(context.ros);
  }

  close() {
    this.scope.end();
  }
}
