// The language for CodeMirror: highlighting by the vocabulary of `cdb generate vocabulary`, indentation, comments.
import { HighlightStyle, LanguageSupport, StreamLanguage, syntaxHighlighting } from '@codemirror/language';
import { tags } from '@lezer/highlight';

// Kinds of words in the vocabulary, in the order in which they are tried; the same as in the grammar for TextMate.
const kKinds = { statements: 'keyword', modifiers: 'keyword', functions: 'function', constants: 'constant',
  parameters: 'property', blocks: 'block', words: 'constant' };

const kTokens = { comment: tags.comment, string: tags.string, number: tags.number, keyword: tags.keyword,
  function: tags.macroName, constant: tags.atom, property: tags.propertyName, block: tags.tagName, name: tags.definition(tags.name) };

export function languageOf(vocabulary) {
  const kinds = new Map();
  for (const [list, kind] of Object.entries(kKinds))
    for (const word of vocabulary[list]) if (!kinds.has(word)) kinds.set(word, kind);

  // Also `pebbles.size`, with the name of a group.
  const kindOf = (word, stream) => {
    if (vocabulary.blocks.concat(vocabulary.parameters).includes(word) && stream.match(/\s*\{/, false)) return 'block';
    const kind = kinds.get(word);
    if (kind) return kind;
    const rest = word.slice(word.indexOf('.') + 1);
    return word.includes('.') && kinds.get(rest) === 'property' ? 'property' : null;
  };

  const parser = {
    name: 'cdb',
    startState: () => ({ depth: 0, names: false }),
    copyState: (state) => ({ ...state }),
    token(stream, state) {
      if (stream.eatSpace()) return null;
      const names = state.names && !stream.sol(); // of a benchmark, a let or a group of objects
      state.names = false;
      if (stream.match(/#.*/)) return 'comment';
      if (stream.match(/"(?:\\.|[^"\\])*"?/)) return 'string';
      if (stream.match(/0[xX][0-9A-Fa-f_]+|[0-9][0-9_]*(?:\.[0-9][0-9_]*)?(?:[eE][+-]?[0-9]+)?/)) return 'number';
      const word = stream.match(/[A-Za-z_]\w*(?:\.[A-Za-z_]\w*)*/);
      if (word) {
        if (names) return 'name';
        state.names = ['benchmark', 'let', 'objects'].includes(word[0]);
        return kindOf(word[0], stream);
      }
      const sign = stream.next();
      if (sign === '{') ++state.depth;
      if (sign === '}') state.depth = Math.max(0, state.depth - 1);
      return null;
    },
    indent: (state, after, { unit }) => unit * Math.max(0, state.depth - (after.startsWith('}') ? 1 : 0)),
    languageData: { commentTokens: { line: '#' }, indentOnInput: /^\s*\}$/, closeBrackets: { brackets: ['(', '{', '"'] } },
    tokenTable: kTokens,
  };
  const colour = (tag, name, more = {}) => ({ tag, color: `var(--code-${name})`, ...more });
  return new LanguageSupport(StreamLanguage.define(parser), syntaxHighlighting(HighlightStyle.define([
    colour(tags.comment, 'comment', { fontStyle: 'italic' }), colour(tags.string, 'string'), colour(tags.number, 'number'),
    colour(tags.keyword, 'keyword', { fontWeight: '600' }), colour(tags.macroName, 'function'), colour(tags.atom, 'constant'),
    colour(tags.propertyName, 'property'), colour(tags.tagName, 'property', { fontWeight: '600' }),
    { tag: tags.definition(tags.name), fontWeight: '600' },
  ])));
}
