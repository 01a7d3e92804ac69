"""`thrum export --header`: C for controllers against the library. SPDX-License-Identifier: Apache-2.0"""
import os
import shutil
import subprocess
import sys
import unittest
from pathlib import Path

import numpy as np
from support import FOLDER, beam, beam_file, model_file

import thrum

PROGRAM = os.environ["THRUM_PROGRAM"]
STEP, STEPS = 0.002, 50
WARNINGS = ("-Wall", "-Wextra", "-Werror", "-ffp-contract=off", "-O1", "-I.")

# What a controller does with the header: energies, forces and a tangent, then steps under a pull and in free motion.
CLIENT = r"""
#include <stdio.h>
#include "beam.h"
static double memory[BEAM_MEMORY(BEAM_RANK)];
static void show(int count, const double *x) {
  int i;
  for (i = 0; i < count; i++)
    printf("%.17g\n", x[i]);
}
int main(void) {
  static double q[BEAM_RANK], p[BEAM_RANK], f[BEAM_RANK], force[BEAM_RANK], tangent[BEAM_RANK * BEAM_RANK];
  const double pull[3] = {0.0, 0.0, -10.0}, g[3] = {0.0, 0.0, -9.81};
  double energy, u[3];
  int i, k;
  for (i = 0; i < BEAM_RANK; i++)
    q[i] = 0.04 * (i % 3 - 1) / (1 + i) + 0.001;
  energy = beam_energy(&beam_model, q, memory);
  show(1, &energy);
  energy = beam_force(&beam_model, q, force, memory);
  show(1, &energy);
  show(BEAM_RANK, force);
  beam_tangent(&beam_model, q, tangent, memory);
  show(BEAM_RANK * BEAM_RANK, tangent);
  beam_displacement(&beam_model, beam_at_tip, q, u);
  show(3, u);
  beam_pull(&beam_model, beam_axis_mass, g, f);
  show(BEAM_RANK, f);
  for (k = 0; k < 4; k++) {
    const double alpha = k % 2 ? 1.0 : 0.0, beta = k % 2 ? 1e-4 : 0.0;
    int n, taken = 1;
    for (i = 0; i < BEAM_RANK; i++)
      q[i] = p[i] = f[i] = 0.0;
    beam_pull(&beam_model, beam_at_tip, pull, f);
    for (n = 0; n < 50 && taken; n++)
      taken = (k < 2 ? beam_step_midpoint : beam_step_energy)(&beam_model, q, p, f, 0.002, alpha, beta, 20, memory);
    show(BEAM_RANK, q);
    show(BEAM_RANK, p);
  }
  /* a swing of a third of the length, whose energy stays, and a step that is too long to be solved */
  for (i = 0; i < BEAM_RANK; i++)
    p[i] = q[i] = f[i] = 0.0;
  p[0] = 4.0;
  energy = 0.0;
  for (k = 0; k < 100 && k >= 0; k++) {
    double now = beam_energy(&beam_model, q, memory);
    for (i = 0; i < BEAM_RANK; i++)
      now += 0.5 * p[i] * p[i];
    energy = k == 0 || fabs(now - 8.0) > energy ? fabs(now - 8.0) : energy;
    if (!beam_step_energy(&beam_model, q, p, f, 0.002, 0.0, 0.0, 20, memory))
      return 1;
  }
  show(1, &energy);
  show(1, q);
  f[0] = 1e300;
  energy = q[0];
  return beam_step_energy(&beam_model, q, p, f, 1.0, 0.0, 0.0, 20, memory) || energy < q[0] || energy > q[0];
}
"""

# What the C library of a bare processor asks for, as three calls of Linux: qemu-arm has no machine with a Cortex-M.
SYSTEM = r"""
#include <stdio.h>
int main(void);
int _write(int file, const void *data, int size);
void *_sbrk(int more);
void _exit(int code);
void _start(void);
static int call(int number, int a, const void *b, int c) {
  register int r7 __asm__("r7") = number, r0 __asm__("r0") = a, r2 __asm__("r2") = c;
  register const void *r1 __asm__("r1") = b;
  __asm__ volatile("svc 0" : "+r"(r0) : "r"(r7), "r"(r1), "r"(r2) : "memory");
  return r0;
}
int _write(int file, const void *data, int size) {
  return call(4, file, data, size);
}
void _exit(int code) {
  for (;;)
    call(1, code, 0, 0);
}
void *_sbrk(int more) {
  static char heap[1 << 16] __attribute__((aligned(8)));
  static int used;
  used += more;
  return used <= (int)sizeof heap ? heap + used - more : (void *)-1;
}
void _start(void) {
  const int code = main();
  fflush(0);
  _exit(code);
}
"""


def run(command, **options):
    done = subprocess.run(command, cwd=FOLDER, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **options)
    if done.returncode != 0:
        raise AssertionError(f"{command}: {done.returncode}\n{done.stdout}")
    return done.stdout


def client(compiler, *options, by=()):
    """What the client prints that this compiler makes."""
    run([*compiler, *WARNINGS, "client.c", *options, "-o", "client"])
    return run([*by, "./client"])


class Header(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        subprocess.run([PROGRAM, "export", beam_file(), "--header", Path(FOLDER, "beam.h")], check=True,
                       stdout=subprocess.DEVNULL)
        Path(FOLDER, "client.c").write_text(CLIENT)
        cls.printed = client(("gcc", "-std=c99", "-pedantic"), "-lm")
        cls.numbers = np.array(cls.printed.split(), float)

    def take(self, count):
        taken, self.numbers = np.split(self.numbers, [count])
        return taken

    def near(self, one, other, share):
        one, other = np.asarray(one), np.asarray(other)
        self.assertEqual(one.shape, other.shape)
        self.assertLessEqual(abs(one - other).max(), share * abs(other).max())

    def test_it_computes_what_the_library_does(self):
        model = beam()
        r = model.rank
        q = np.array([0.04 * (i % 3 - 1) / (1 + i) + 0.001 for i in range(r)])

        # the same bits
        self.assertEqual(self.take(1)[0], model.strain_energy(q))
        self.assertEqual(self.take(1)[0], model.strain_energy(q))
        np.testing.assert_array_equal(self.take(r), model.internal_force(q))

        # and to rounding
        self.near(self.take(r * r).reshape(r, r), model.tangent_stiffness(q), 1e-12)
        self.near(self.take(3), model.displacement(q)[model.group("tip")].mean(0), 1e-12)
        self.near(self.take(r), model.external_load(gravity=(0, 0, -9.81)), 1e-12)
        load = model.external_load((0, 0, -10), group="tip")
        for integrator in ("midpoint", "energy"):
            for alpha, beta in ((0.0, 0.0), (1.0, 1e-4)):
                with model.state(integrator=integrator, dt=STEP, tolerance=1e-13, damping_alpha=alpha,
                                 damping_beta=beta) as state:
                    state.force = load
                    state.step(STEPS)
                    self.near(self.take(r), state.q, 1e-10)
                    self.near(self.take(r), state.p, 1e-8)

        # the energy of the swing, which was a large one
        self.assertLess(self.take(1)[0], 8e-12)
        self.assertGreater(abs(self.take(1)[0]), 0.01)
        self.assertEqual(len(self.numbers), 0)

    def test_compilers_agree_in_every_bit(self):
        self.assertEqual(client(("gcc", "-x", "c++", "-pedantic"), "-lm", "-lstdc++"), self.printed)
        if shutil.which("clang"):
            self.assertEqual(client(("clang", "-std=c99", "-pedantic"), "-lm"), self.printed)
            self.assertEqual(client(("clang", "-x", "c++", "-pedantic"), "-lm", "-lstdc++"), self.printed)

    def test_the_example_of_the_page_compiles(self):
        page = Path(__file__).parents[2] / "docs" / "exchange.md"
        example = page.read_text().split('#include "beam.h"', 1)[1].split("```")[0]
        Path(FOLDER, "example.c").write_text('#include "beam.h"' + example)
        run(("gcc", "-std=c99", *WARNINGS, "-c", "example.c"))

    def other_processor(self, compiler, emulator, *options):
        """Sines and roots are the other library's, so what follows them agrees to rounding."""
        if not shutil.which(compiler[0]) or not shutil.which(emulator[0]):
            self.skipTest(f"{compiler[0]} or {emulator[0]} is not installed")
        lines, here = client(compiler, *options, "-lm", by=emulator).split(), self.printed.split()
        r = beam().rank
        self.assertEqual(lines[:2 + r], here[:2 + r])
        self.near(np.array(lines[:-2], float), np.array(here[:-2], float), 1e-9)

    def test_an_arm_of_64_bits_agrees(self):
        self.other_processor(("aarch64-linux-gnu-gcc", "-std=c99", "-static"), ("qemu-aarch64",))

    def test_a_cortex_m_agrees(self):
        Path(FOLDER, "system.c").write_text(SYSTEM)
        self.other_processor(("arm-none-eabi-gcc", "-std=c99", "-mcpu=cortex-m4", "-mthumb", "--specs=nosys.specs",
                              "-nostartfiles"), ("qemu-arm",), "system.c")

    def test_what_it_cannot_hold_is_refused(self):
        condensed = model_file("condensed", "beam:4x1x1@1x0.1x0.1", fix="x<0.001", modes=4, rank=8, condense=True)
        for model, name, said in ((condensed, "none.h", "follow the others at rest"),
                                  (beam_file(), "none.txt", "end with .h"), (beam_file(), "2beam.h", "digit"),
                                  (beam_file(), "my-beam.h", "letters, digits and underscores"), (beam_file(), ".h", ".h")):
            done = subprocess.run([PROGRAM, "export", model, "--header", Path(FOLDER, name)], stderr=subprocess.PIPE,
                                  text=True)
            self.assertNotEqual(done.returncode, 0)
            self.assertIn(said, done.stderr)
            self.assertFalse(Path(FOLDER, name).exists())


if __name__ == "__main__":
    unittest.main()
