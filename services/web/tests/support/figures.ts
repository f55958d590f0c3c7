/** Of many figures, the middle and what 95 in 100 stay below. */
export function summary(figures: readonly number[]): { n: number; median: number; p95: number } {
  const sorted = [...figures].sort((a, b) => a - b);
  const at = (part: number) => {
    const index = Math.min(Math.floor(part * sorted.length), sorted.length - 1);
    return Math.round((sorted[index] ?? Number.NaN) * 10) / 10;
  };
  return { n: sorted.length, median: at(0.5), p95: at(0.95) };
}
