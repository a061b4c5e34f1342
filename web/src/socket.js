// A websocket that connects again after its server was started anew.

const FIRST_MS = 400;
const LAST_MS = 5000;

/** Call `hear` with each message; `send` queues the newest message of each kind until it can go. */
export class Socket {
  constructor(path, { hear, state }) {
    this.address = `ws://${location.host}${path}`;
    this.hear = hear;
    this.state = state;
    this.wait = FIRST_MS;
    this.waiting = new Map();
    this.#connect();
  }

  send(message) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(message));
    else this.waiting.set(message.do, message);
  }

  #connect() {
    this.socket = new WebSocket(this.address);
    this.socket.addEventListener('open', () => {
      this.wait = FIRST_MS;
      this.state(true);
      for (const message of this.waiting.values()) this.send(message);
      this.waiting.clear();
    });
    this.socket.addEventListener('message', (event) => this.hear(JSON.parse(event.data)));
    this.socket.addEventListener('close', () => {
      this.state(false);
      setTimeout(() => this.#connect(), this.wait);
      this.wait = Math.min(2 * this.wait, LAST_MS);
    });
  }
}
