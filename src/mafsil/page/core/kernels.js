// Compiled kernels: one WebAssembly module, called with arrays of numbers.

/**
 * @typedef {{name: string, shape: number[]}} Port
 * @typedef {{memory: {pages: number, stack: number, first: number},
 *            kernels: Object<string, {inputs: Port[], outputs: Port[]}>}} Layout
 * @typedef {(...inputs: ArrayLike<number>[]) => Float64Array[]} Kernel  views of the outputs, valid until the next call
 */

/**
 * The kernels of a module, by name. Each checks how many numbers it is given.
 *
 * @param {BufferSource} code
 * @param {Layout} layout
 * @returns {Promise<Object<string, Kernel>>}
 */
export async function loadKernels(code, layout) {
  const memory = new WebAssembly.Memory({ initial: layout.memory.pages });
  const stack = new WebAssembly.Global({ value: "i32", mutable: true }, layout.memory.stack);
  const env = { __linear_memory: memory, __stack_pointer: stack };
  const { instance } = await WebAssembly.instantiate(code, { env });
  /** @type {Object<string, Kernel>} */
  const kernels = {};
  for (const [name, ports] of Object.entries(layout.kernels)) {
    kernels[name] = kernel(name, /** @type {Function} */ (instance.exports[name]), ports, memory, layout.memory.first);
  }
  return kernels;
}

/** One kernel; all share the same place in memory, so inputs are copied in and outputs read before the next call. */
function kernel(name, entry, { inputs, outputs }, memory, first) {
  let address = first;
  const place = ({ shape }) => {
    const view = new Float64Array(memory.buffer, address, shape.reduce((a, b) => a * b, 1));
    address += view.byteLength;
    return view;
  };
  const into = inputs.map(place), out = outputs.map(place);
  const addresses = [...into, ...out].map((view) => view.byteOffset);
  return (...values) => {
    if (values.length !== into.length) throw new RangeError(`${name}: ${into.length} inputs, not ${values.length}`);
    values.forEach((value, k) => {
      if (value.length !== into[k].length) throw new RangeError(`${name}: ${inputs[k].name} has ${into[k].length} numbers, not ${value.length}`);
      into[k].set(value);
    });
    entry(...addresses);
    return out;
  };
}

/**
 * Bytes of a base64 text.
 *
 * @param {string} text
 */
export function bytes(text) {
  return Uint8Array.from(atob(text), (character) => character.charCodeAt(0));
}
