// The images of a topic in an <img>: as one stream, or one after the other where the page is below a path. There a proxy
// has led to it, and that of JupyterLab and JupyterHub passes on whole answers only, of which a stream has none.

const RETRY = 1000; // [ms] after an answer without an image

export function isStreamed(path) {
  return path.lastIndexOf('/') === 0;
}

export class Video {
  constructor(image) {
    this._image = image;
    this._end = () => {};
  }

  // Show the images of a query to web_video_server, such as {topic: '/image_raw', type: 'png'}.
  show(query) {
    this.stop();
    if (isStreamed(location.pathname)) {
      this._image.src = `stream?${new URLSearchParams(query)}`;
      return;
    }
    const ended = new AbortController();
    this._end = () => ended.abort();
    this._follow(query, ended.signal);
  }

  stop() {
    this._end();
    this._end = () => {};
    this._image.removeAttribute('src');
  }

  async _follow(query, signal) {
    let after = 0;
    while (!signal.aborted) {
      try {
        const answer = await fetch(`snapshot?${new URLSearchParams({...query, after})}`, {signal});
        if (!answer.ok) throw new Error(`the server answers ${answer.status}`);
        after = answer.headers.get('Image-Number');
        await this._draw(await answer.blob(), signal);
      } catch {
        await new Promise((done) => setTimeout(done, RETRY));
      }
    }
  }

  async _draw(data, signal) {
    if (signal.aborted) return;
    const address = URL.createObjectURL(data);
    this._image.src = address;
    try {
      await this._image.decode();
    } finally {
      URL.revokeObjectURL(address);
    }
  }
}
