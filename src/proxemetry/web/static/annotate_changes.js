// Changes of one photo, kept in the order in which they were made; those of arrow keys once no key is pressed.

import * as api from "./annotate_api.js";
import { Problem } from "./api.js";
import { tell } from "./elements.js";

export class KeptChanges {
  // Subclasses have `fields`, `closed`, `changed(fields)`, show(fields), draw() and notice(text).

  // Keep what is not kept yet before anything else happens.
  async leave() {
    await this.rest();
  }

  async asked(run) {
    try {
      return await run();
    } catch (error) {
      if (!(error instanceof Problem)) throw error;
      tell(error.message, true);
      this.notice(error.message);
      return null;
    }
  }

  // Keep an action, in the order in which they were made, after what arrow keys have moved.
  act(action, value, text) {
    this.flush();
    const turn = (this.queue ?? Promise.resolve()).then(async () => {
      const fields = await this.asked(() => api.act(this.fields.id, action, value));
      if (this.closed) return null;
      if (fields === null) {
        this.draw(); // a point that was dragged in vain goes back
        return null;
      }
      this.show(fields);
      this.changed(fields);
      if (text) tell(text);
      return fields;
    });
    this.queue = turn.catch(() => null);
    return turn;
  }

  async rest() {
    this.flush();
    await this.queue;
  }

  flush() {
    clearTimeout(this.resting);
    const { nudged } = this;
    this.nudged = null;
    if (nudged) this.act("set_point", nudged);
  }
}
