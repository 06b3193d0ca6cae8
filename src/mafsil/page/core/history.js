// What has lately been measured: a ring of rows of one length, so that memory does not grow with time.

export class History {
  /** @param {number} width  numbers in a row @param {number} most  rows that are kept */
  constructor(width, most) {
    this.width = width;
    this.most = most;
    this.rows = new Float64Array(width * most);
    this.count = 0; // rows since the beginning, those that are forgotten included
  }

  /** @param {number[]} row */
  push(row) {
    this.rows.set(row, this.width * (this.count++ % this.most));
  }

  clear() {
    this.count = 0;
  }

  get length() {
    return Math.min(this.count, this.most);
  }

  /** One number of a kept row, the oldest row first. @param {number} k @param {number} column */
  at(k, column) {
    return this.rows[this.width * ((this.count - this.length + k) % this.most) + column];
  }
}
