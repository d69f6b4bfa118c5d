// Times over the cycles of runs (figure 3 of the paper).
import { describeLines, describePhaseLines } from './cycle_lines.js';
import { representatives, usedBins, whereText } from './cycle_points.js';
import { describeStack } from './cycle_stack.js';

const describers = { phases: describeStack, lines: describePhaseLines, points: describeLines };

export function describeCycles(doc, view, how) {
  const { cycles } = doc.raw;
  const available = cycles?.points ?? (cycles ? doc.at.map((_, i) => i) : []);
  if (!cycles || available.length === 0)
    return { title: 'Over the cycles', empty: 'This document has no times of individual cycles.' };
  const chosen = representatives(doc, view, available);
  const drawing = describers[view.cycles](doc, view, how, chosen);
  if (drawing.empty) return drawing;
  const widest = Math.max(...usedBins(cycles, chosen).map(([from, to]) => to - from), 1);
  const where = whereText(doc, view, chosen);
  const repeats = (doc.raw.runs?.repeats ?? 1) > 1 ? 'median over the repeats' : 'one repeat';
  const bins = widest > 1 ? `, averaged over up to ${widest} cycles` : '';
  return {
    ...drawing,
    notes: [
      `Each cycle: ${repeats}${bins}.`,
      ...(where ? [`At ${where}.`] : []),
      ...drawing.notes,
      ...(available.length < doc.count
        ? [`The page has the cycles of ${available.length} of ${doc.count} points.`]
        : []),
    ],
  };
}
