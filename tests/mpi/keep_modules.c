/* Keeps the modules that Open MPI loads until the end, in a build with the address sanitizer, which
 * names the places of a leak when the program ends: those in a module that is gone have no names.
 * SPDX-License-Identifier: Apache-2.0 */
int dlclose(void *module);

__attribute__((visibility("default"))) int dlclose(void *module) {
  (void)module;
  return 0;
}
