// Designs that were looked at: undo and redo, a picture of each, and the present one as a link.

import { element } from './format.js';

const MOST = 60;
const START = '#design=';

export class History {
  /**
   * @param {HTMLElement} strip where pictures are shown
   * @param {{undo: HTMLElement, redo: HTMLElement}} buttons
   * @param {function(object)} restore called with a state that is gone back to
   */
  constructor(strip, { undo, redo }, restore) {
    this.strip = strip;
    this.buttons = { undo, redo };
    this.restore = restore;
    this.entries = [];
    this.at = -1;
    undo.addEventListener('click', () => this.#go(this.at - 1));
    redo.addEventListener('click', () => this.#go(this.at + 1));
    document.addEventListener('keydown', (event) => {
      const typing = event.target.matches?.('input[type="number"], textarea');
      if (typing || !(event.ctrlKey || event.metaKey) || event.key.toLowerCase() !== 'z') return;
      event.preventDefault();
      this.#go(this.at + (event.shiftKey ? 1 : -1));
    });
    addEventListener('hashchange', () => {
      const state = this.linked();
      if (state) restore(state);
    });
    this.#show();
  }

  get present() {
    return this.entries[this.at]?.state;
  }

  /** The state that the page's address says; null if it says none. */
  linked() {
    if (!location.hash.startsWith(START)) return null;
    try {
      return JSON.parse(decodeURIComponent(location.hash.slice(START.length))) ?? {};
    } catch {
      return {}; // a link that was cut short: of no page
    }
  }

  /** Take up a state after the present one, whose later ones are then gone; it may become the link. */
  add(state, title, link) {
    const text = JSON.stringify(state);
    if (link) history.replaceState(null, '', START + encodeURIComponent(text));
    if (JSON.stringify(this.present) === text) return;
    const button = element('button', { type: 'button' });
    const entry = { state, button, picture: element('img', { alt: '', hidden: '' }) };
    button.append(entry.picture, element('span', {}, title));
    button.addEventListener('click', () => this.#go(this.entries.indexOf(entry)));
    for (const later of this.entries.splice(this.at + 1)) later.button.remove();
    this.entries.push(entry);
    if (this.entries.length > MOST) this.entries.shift().button.remove();
    this.at = this.entries.length - 1;
    this.strip.append(button);
    this.#show();
  }

  /** Say in the tile of the present state that there is no such design. */
  refused() {
    const button = this.entries[this.at]?.button;
    if (button && !button.querySelector('i')) button.prepend(element('i', {}, 'no such design'));
  }

  /** Show a picture of the present state. */
  picture(url) {
    const shown = this.entries[this.at]?.picture;
    if (shown) Object.assign(shown, { src: url, hidden: false });
  }

  #go(at) {
    if (!this.entries[at]) return;
    this.at = at;
    this.#show();
    this.restore(this.present);
  }

  #show() {
    this.buttons.undo.disabled = this.at < 1;
    this.buttons.redo.disabled = this.at >= this.entries.length - 1;
    this.entries.forEach(({ button }, i) => button.setAttribute('aria-pressed', i === this.at));
    const button = this.entries[this.at]?.button;
    // not under the pointer, whose click would meet another design
    if (button && !this.strip.matches(':hover')) {
      this.strip.scrollTo({ left: button.offsetLeft - this.strip.clientWidth / 2 });
    }
  }
}
