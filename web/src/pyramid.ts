// Least and largest values of a series at ever coarser steps, so that a plot draws as many points as
// it has pixels and shows every extreme.

export interface Level {
  time: ArrayLike<number>; // of each bin's first row
  low: ArrayLike<number>;
  high: ArrayLike<number>;
}

function halved(level: Level): Level {
  const n = Math.ceil(level.time.length / 2);
  const time = new Float64Array(n);
  const low = new Float64Array(n);
  const high = new Float64Array(n);
  for (let i = 0; i < n; ++i) {
    const a = 2 * i;
    const b = Math.min(a + 1, level.time.length - 1);
    time[i] = level.time[a];
    low[i] = least(level.low[a], level.low[b]);
    high[i] = largest(level.high[a], level.high[b]);
  }
  return { time, low, high };
}

const least = (a: number, b: number) => (Number.isNaN(a) || b < a ? b : a);
const largest = (a: number, b: number) => (Number.isNaN(a) || b > a ? b : a);

export class Pyramid {
  private levels: Level[];

  constructor(finest: Level) {
    this.levels = [finest];
  }

  // The finest level with at most `most` points between begin and end.
  at(begin: number, end: number, most: number): Level {
    for (let k = 0; ; ++k) {
      if (k === this.levels.length) this.levels.push(halved(this.levels[k - 1]));
      const { time } = this.levels[k];
      let count = 0;
      for (let i = 0; i < time.length && count <= most; ++i) if (time[i] >= begin && time[i] <= end) ++count;
      if (count <= most || time.length <= 2) return this.levels[k];
    }
  }

  extremes(): [number, number] {
    const { low, high } = this.levels[0];
    let a = NaN;
    let b = NaN;
    for (let i = 0; i < low.length; ++i) {
      a = least(a, low[i]);
      b = largest(b, high[i]);
    }
    return [a, b];
  }
}
