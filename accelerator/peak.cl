/* How fast the device multiplies and adds: chains of operations that do not wait for memory.
 * SPDX-License-Identifier: Apache-2.0 */
#define JOIN(a, b) a##b
#define VECTOR(type, width) JOIN(type, width)

kernel void peak(global float *out, int rounds) {
  const VECTOR(float, WIDE) a = 1.0f + 1e-7f * get_global_id(0), b = 1e-3f;
  VECTOR(float, WIDE) x[CHAINS], sum = 0;
  for (int i = 0; i < CHAINS; i++)
    x[i] = i;
  for (int k = 0; k < rounds; k++)
    for (int i = 0; i < CHAINS; i++)
      x[i] = mad(x[i], a, b);
  for (int i = 0; i < CHAINS; i++)
    sum += x[i];
  VECTOR(vstore, WIDE)(sum, get_global_id(0), out);
}
