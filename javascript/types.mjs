// The options of bodies, obstacles, solids, links, loads and contact as TypeScript, by the rows of include/thrum/fields.h.
// SPDX-License-Identifier: Apache-2.0
import { spawnSync } from 'node:child_process';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

const include = join(dirname(dirname(fileURLToPath(import.meta.url))), 'include');

/** Types by the kind of a row; all others are lists of numbers. */
const TYPES = { NUMBER: 'number', COUNT: 'number', WHOLE: 'number', FLAG: 'boolean', INTS: 'Iterable<number>',
  GRID: 'ArrayLike<ArrayLike<number>>' };

/** The rows of a record, with what others lie in it. */
const rowsOf = (record) => `THRUM_${record}_FIELDS(ROW)${record === 'LOAD' ? ' THRUM_COURSE_FIELDS(ROW)' : ''}`;

/** Names in the language for names of rows that it has as words of its own. */
const NAMES = { from: 'start' };

/** A literal of C, which may come in pieces. */
const literal = (pieces) => [...pieces.matchAll(/"((?:[^"\\]|\\.)*)"/g)].map(([, text]) => text).join('').replaceAll('\\"', "'");

/** The members of an interface. @param {string} record BODY @param {string[]} own options that are left out */
export function typesOf(record, own) {
  const row = '#define ROW(where, kind, name, unit, value, otherwise, range, about) '
    + '<|kind|name|unit|THRUM_WORDS(kind, value, otherwise)|about|THRUM_NAMES_##kind|>';
  const source = `#include "thrum/fields.h"\n${row}\n${rowsOf(record)}\n`;
  const { stdout, status } = spawnSync(process.env.CLANG ?? 'clang', ['-E', '-P', '-std=c11', '-I', include, '-x', 'c', '-'],
    { input: source, encoding: 'utf8' });
  if (status !== 0) throw new Error('clang has not read include/thrum/fields.h');
  const rows = stdout.matchAll(/<\|(.*?)\|(.*?)\|(.*?)\|(.*?)\|(.*?)\|(.*?)\|>/gs);
  return [...rows].map(([, kind, name, unit, without, about, names]) => {
    const option = NAMES[name] ?? name.replace(/_(.)/g, (_, letter) => letter.toUpperCase());
    const told = [literal(about) + (unit.startsWith('"') ? ` [${literal(unit)}]` : ''), literal(without) && `default ${literal(without)}`];
    const choices = literal(names).split(' ').map((choice) => `'${choice}'`).join(' | ');
    const type = names.includes('"') ? choices : TYPES[kind] ?? 'ArrayLike<number>';
    return { option, text: `  /** ${told.filter(Boolean).join('; ')}. */\n  ${option}?: ${type};` };
  }).filter(({ option }) => !own.includes(option)).map(({ text }) => text).join('\n');
}
