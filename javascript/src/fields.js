// Defs of bodies, obstacles, solids, links, loads and contact, filled by name from the rows of thrum/fields.h.
// SPDX-License-Identifier: Apache-2.0
import { ThrumError, doubles, vertices } from './memory.js';

/** Records, in the order of thrum_record. */
export const RECORDS = ['body', 'obstacle', 'solid', 'link', 'pairs', 'wind', 'load'];

/** What a field holds, in the order of thrum_field_kind. */
export const KINDS = ['double', 'float', 'int64', 'int32', 'flag', 'choice', 'doubles', 'ints', 'grid'];

const camel = (name) => name.replace(/_(.)/g, (_, letter) => letter.toUpperCase());

/** The fields of a record. @param {import('./memory.js').Memory} memory @param {string} record */
export function fieldsOf(memory, record) {
  const number = RECORDS.indexOf(record);
  const fields = [];
  while (memory.calls.js_field(number, fields.length)) {
    const [kind, width, offset, countOffset, least, most, above, key] = memory.numbers;
    const text = (which) => {
      const at = memory.calls.js_field_text(number, fields.length, which);
      return at === 0 ? undefined : memory.text(at);
    };
    const [name, names, otherwise] = [0, 1, 2].map(text);
    fields.push({ name, option: camel(name), kind: KINDS[kind], width, offset, countOffset, least, most,
      above: above === 1, key: key === 1, names: names?.split(' '), otherwise });
  }
  return fields;
}

const known = new WeakMap();

/** The fields of a record by the names of options: `touchMax`, or `touch_max` as C has it. */
function fieldsByName(memory, record) {
  if (!known.has(memory)) known.set(memory, {});
  const found = known.get(memory);
  found[record] ??= Object.fromEntries(fieldsOf(memory, record).flatMap((field) => [[field.name, field], [field.option, field]]));
  return found[record];
}

/** Those entries of an object that are fields of a record. @returns {object} */
export function pick(memory, record, from) {
  const fields = fieldsByName(memory, record);
  return Object.fromEntries(Object.entries(from).filter(([name]) => Object.hasOwn(fields, name)));
}

/** The numbers of a member, which `value` must be. */
function numbersOf({ option, width }, value) {
  if (width > 1) return doubles(value, width, option, true);
  if (typeof value !== 'number') throw new ThrumError(`${option}: ${String(value)} is no number`, -1);
  return [value];
}

/** The array that an option is, with its rows. @returns {{array: Float64Array|Int32Array, counts: number[]}} */
function arrayOf({ option, kind, width }, value, vertexCount) {
  if (kind === 'grid') {
    const columns = value[0]?.length ?? 0;
    return { array: Float64Array.from([...value].flatMap((row) => [...doubles(row, columns, option)])), counts: [value.length, columns] };
  }
  const array = kind === 'ints' ? vertices(value, vertexCount, option) : doubles(value, value.length, option);
  if (array.length % width !== 0) throw new ThrumError(`${option}: ${array.length} numbers are no rows of ${width}`, -11);
  return { array, counts: [array.length / width] };
}

/** Makes the def of a record with these options, undefined ones apart, and calls with the arrays of it in memory.
 * @param {import('./memory.js').Memory} memory @param {string} record @param {object} options
 * @param {() => T} call @param {number} [vertexCount] that bounds lists of vertices @returns {T} @template T */
export function withDef(memory, record, options, call, vertexCount = 2 ** 31) {
  const fields = fieldsByName(memory, record);
  const given = Object.entries(options).filter(([, value]) => value !== undefined).map(([name, value]) => {
    if (!Object.hasOwn(fields, name)) {
      const names = [...new Set(Object.values(fields).map(({ option }) => option))].join(', ');
      throw new ThrumError(`${record}: there is no option '${name}'; there are: ${names}`, -1);
    }
    const field = fields[name];
    return { field, value, ...(['doubles', 'ints', 'grid'].includes(field.kind) && arrayOf(field, value, vertexCount)) };
  });
  const arrays = given.filter(({ array }) => array);
  return memory.lend(arrays.map(({ array }) => array), (...places) => {
    // room was made before: the view holds while the def is filled in
    const def = memory.calls.js_def(RECORDS.indexOf(record));
    const view = new DataView(memory.calls.memory.buffer, def);
    for (const { field, value, array, counts } of given) {
      if (array) {
        view.setUint32(field.offset, places[arrays.findIndex((of) => of.field === field)], true);
        const before = Number(view.getBigInt64(field.countOffset, true));
        if (before !== 0 && before !== counts[0])
          throw new ThrumError(`${field.option}: ${counts[0]} of them do not fit the ${before} of another array`, -11);
        counts.forEach((count, n) => view.setBigInt64(field.countOffset + 8 * n, BigInt(count), true));
      } else setMember(view, field, value);
    }
    return call();
  });
}

/** Writes a member that is no array. */
function setMember(view, field, value) {
  const { option, kind, offset, names } = field;
  const whole = () => {
    if (!Number.isSafeInteger(value)) throw new ThrumError(`${option}: ${String(value)} is no whole number`, -1);
    return value;
  };
  if (kind === 'double') numbersOf(field, value).forEach((number, n) => view.setFloat64(offset + 8 * n, number, true));
  else if (kind === 'float') numbersOf(field, value).forEach((number, n) => view.setFloat32(offset + 4 * n, number, true));
  else if (kind === 'int64') view.setBigInt64(offset, BigInt(whole()), true);
  else if (kind === 'int32') view.setInt32(offset, whole(), true);
  else if (kind === 'flag') view.setInt32(offset, value ? 1 : 0, true);
  else {
    if (!names.includes(value)) throw new ThrumError(`${option}: '${String(value)}' is none of ${names.join(', ')}`, -1);
    view.setInt32(offset, names.indexOf(value), true);
  }
}
