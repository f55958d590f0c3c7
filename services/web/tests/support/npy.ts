import fs from "node:fs";

/** A picture of numbers, row by row. */
export interface NumberPicture {
  readonly rows: number;
  readonly columns: number;
  readonly values: Float32Array;
}

/** Reads a two-dimensional little-endian float32 array of NumPy. */
export function readNpy(file: string): NumberPicture {
  const bytes = fs.readFileSync(file);
  const major = bytes[6];
  const headerAt = major === 1 ? 10 : 12;
  const headerBytes = major === 1 ? bytes.readUInt16LE(8) : bytes.readUInt32LE(8);
  const header = bytes.toString("latin1", headerAt, headerAt + headerBytes);
  const [, rows, columns] = /'shape': \((\d+), (\d+)\)/.exec(header) ?? [];
  if (!/'descr': '<f4'/.test(header) || !/'fortran_order': False/.test(header)) {
    throw new Error(`${file}: ${header.trim()} is no row-major float32 array`);
  }
  const data = bytes.subarray(headerAt + headerBytes);
  const values = new Float32Array(
    data.buffer.slice(data.byteOffset, data.byteOffset + data.length),
  );
  return { rows: Number(rows), columns: Number(columns), values };
}
