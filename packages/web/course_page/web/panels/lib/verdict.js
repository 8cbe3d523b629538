// What the panel Grade says about a grading.

const KINDS = {passed: 'good', failed: 'bad', undecided: 'busy'};

// Return {text, kind, hints, checks, notes} of a grading that has ended; without a result, it broke off.
export function verdictOf({result}) {
  if (!result) return {text: 'no verdict', kind: 'bad', hints: [], checks: [], notes: []};
  const {outcome, score, objections, hints, certain, notes, reasons, seconds, isolation} = result;
  const points = outcome === 'undecided' ? '' : `, ${number(score)} of 100`;
  const again = outcome === 'undecided' ? ['That is no fault of the program: grade it again.'] : [];
  return {
    text: `${outcome}${points}`, kind: KINDS[outcome] ?? 'busy',
    hints: [...objections, ...hints.map((hint) => `${certain ? 'Mistake' : 'Hint'}: ${hint}`), ...again],
    checks: reasons.map((reason) => ({...reason, points: number(reason.points), of: number(reason.of)})),
    notes: [...notes, `Graded ${number(seconds)} s of simulated time; isolation of the program: ${isolation || 'none'}.`],
  };
}

// Return the name of a program, and its folder as seen from one of the folders, with that one's name if there are several.
export function shortPath(path, folders) {
  const folder = folders.filter((one) => path.startsWith(`${one}/`)).sort((a, b) => b.length - a.length)[0];
  if (!folder) return path;
  const parts = path.slice(folder.length + 1).split('/');
  const name = parts.pop();
  if (folders.length > 1) parts.unshift(folder.split('/').pop());
  return parts.length ? `${name} (${parts.join('/')})` : name;
}

function number(value) {
  return String(Math.round(value * 10) / 10);
}
