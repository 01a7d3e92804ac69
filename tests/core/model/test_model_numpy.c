/* Tests of the model file with NumPy: numpy.load opens the files of Thrum, Thrum opens the files of
 * numpy.savez, and the Python code of docs/model_format.md does as that page says. The tests run
 * /usr/bin/python3 with numpy.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "io/file.h"
#include "io/npy_file.h"
#include "io/npz.h"
#include "tests/support/model_archive.h"
#include "tests/support/random_model.h"
#include "thrum/polynomial.h"

static char folder[] = "/tmp/thrum-numpy-XXXXXX";

static int make_folder(void **state) {
  (void)state;
  return mkdtemp(folder) == NULL || chdir(folder) != 0;
}

static int remove_folder(void **state) {
  (void)state;
  char command[64];
  snprintf(command, sizeof command, "rm -r %s", folder);
  return chdir("/") != 0 || system(command) != 0;
}

// runs a script in the folder; an exception in it fails the test
static void python(const char *script) {
  assert_int_equal(thrum_file_write_atomic("script.py", script, strlen(script), NULL), THRUM_OK);
  if (system("/usr/bin/python3 -W error script.py") != 0)
    fail_msg("the script failed (does /usr/bin/python3 have numpy?)");
}

static void save(const char *path, const thrum_model *model) {
  thrum_error error = {.status = THRUM_OK};
  if (thrum_model_save(path, model, &error) != THRUM_OK)
    fail_msg("%s", error.message);
}

static void expect_sample(const char *path) {
  thrum_error error = {.status = THRUM_OK};
  thrum_model sample = sample_model();
  const thrum_model *model = NULL;
  if (thrum_model_load(path, &model, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  assert_true(models_bit_equal(&sample, model));
  thrum_model_destroy(model);
}

static void expect_refused(const char *path, thrum_status status, const char *words) {
  thrum_error error = {.status = THRUM_OK};
  const thrum_model *model = NULL;
  thrum_status got = thrum_model_load(path, &model, &error);
  if (got != status || strstr(error.message, words) == NULL ||
      strncmp(error.message, path, strlen(path)) != 0)
    fail_msg("wanted %d '%s', got %d '%s'", status, words, got, error.message);
  assert_null(model);
}

static void numpy_opens_a_saved_model(void **state) {
  (void)state;
  thrum_model model = sample_model();
  save("ours.npz", &model);

  // the script checks names, types, values and the layout of the archive
  python("import numpy as np, zipfile, json\n"
         "d = np.load('ours.npz')\n"
         "assert d.files == ['format', 'meta', 'omega2', 'c3', 'c4', 'axis_mass', 'vertices',\n"
         "  'tets', 'tet_region', 'material', 'fixed', 'basis', 'group_names', 'group_ends',\n"
         "  'group_vertices']\n"
         "assert d['format'].dtype == np.int32 and d['format'].tolist() == [1, 0]\n"
         "assert json.loads(bytes(d['meta'])) == {'note': '\\u00e9'}\n"
         "assert d['c3'].tolist() == [1.5, -2.25, 1e-300, 3e10]\n"
         "assert np.copysign(1, d['c4'][2]) == -1 and d['c4'][4] == np.finfo(float).max\n"
         "assert d['axis_mass'].shape == (3, 2) and d['axis_mass'][1, 1] == 2\n"
         "assert d['tets'].tolist() == [[0, 1, 2, 3], [1, 2, 3, 4]]\n"
         "assert d['fixed'].dtype == np.uint8 and d['fixed'].tolist() == [7, 0, 5, 0, 0]\n"
         "assert d['basis'].shape == (15, 2) and d['basis'][14, 1] == 4\n"
         "assert bytes(d['group_names']) == b'left\\0right side\\0'\n"
         "z = zipfile.ZipFile('ours.npz')\n"
         "assert z.testzip() is None and z.comment == b''\n"
         "for i in z.infolist():\n"
         "  assert i.compress_type == 0 and i.flag_bits == 0 and i.extra == b''\n"
         "  assert i.date_time == (1980, 1, 1, 0, 0, 0)\n"
         "m = np.memmap('ours.npz', np.uint8, 'r')\n"
         "for i in z.infolist():\n"
         "  o = i.header_offset\n"
         "  o += 30 + int(m[o+26]) + 256*int(m[o+27]) + int(m[o+28]) + 256*int(m[o+29])\n"
         "  assert bytes(m[o+1:o+6]) == b'NUMPY'\n"
         "  assert (o + 10 + int(m[o+8]) + 256*int(m[o+9])) % 64 == 0\n");
}

static void a_model_that_numpy_saves_again_is_the_same(void **state) {
  (void)state;
  thrum_model model = sample_model();
  save("ours.npz", &model);
  python("import numpy as np, random\n"
         "d = dict(np.load('ours.npz'))\n"
         "np.savez('theirs.npz', **d)\n"
         "names = list(d)\n"
         "random.Random(1).shuffle(names)\n"
         "np.savez('shuffled.npz', **{n: d[n] for n in names})\n"
         "np.savez('more.npz', **d, notes=np.array('words'), table=np.zeros((2, 3, 4), '>c8'))\n");
  expect_sample("theirs.npz");
  expect_sample("shuffled.npz");
  expect_sample("more.npz");
}

static void files_that_numpy_makes_in_other_ways_are_refused(void **state) {
  (void)state;
  thrum_model model = sample_model();
  save("ours.npz", &model);

  // one file for each way in which NumPy could write something else
  python("import numpy as np, subprocess\n"
         "d = dict(np.load('ours.npz'))\n"
         "np.savez_compressed('compressed.npz', **d)\n"
         "def save(file, **changes):\n"
         "  np.savez(file, **{k: v for k, v in {**d, **changes}.items() if v is not None})\n"
         "save('big.npz', c3=d['c3'].astype('>f8'))\n"
         "save('single.npz', c4=np.zeros(5, 'f4'))\n"
         "save('fortran.npz', basis=np.asfortranarray(d['basis']))\n"
         "save('long.npz', format=np.array([1, 0]))\n"
         "save('missing.npz', c4=None)\n"
         "save('nan.npz', vertices=d['vertices'] * np.nan)\n"
         "save('falling.npz', omega2=d['omega2'][::-1])\n"
         "save('index.npz', tets=d['tets'] + np.int32(1))\n"
         "save('shape.npz', basis=d['basis'][3:])\n"
         "save('object.npz', meta=np.array({}))\n"
         "save('text.npz', meta=np.array('{}'))\n"
         "np.save('array.npy', d['c3'])\n"
         "cat = subprocess.Popen('cat > piped.npz', shell=True, stdin=subprocess.PIPE)\n"
         "np.savez(cat.stdin, **d)\n"
         "cat.stdin.close()\n"
         "assert cat.wait() == 0\n");

  // each is refused with the reason, and where possible with the remedy
  expect_refused("compressed.npz", THRUM_UNSUPPORTED, "use numpy.savez, not savez_compressed");
  expect_refused("piped.npz", THRUM_UNSUPPORTED, "save to a file on disk");
  expect_refused("big.npz", THRUM_BAD_SHAPE, "array 'c3' has type '>f8', '<f8' is needed");
  expect_refused("single.npz", THRUM_BAD_SHAPE, "array 'c4' has type '<f4', '<f8' is needed");
  expect_refused("fortran.npz", THRUM_BAD_SHAPE, "array 'basis' is in Fortran order");
  expect_refused("long.npz", THRUM_BAD_SHAPE, "array 'format' has type '<i8', '<i4' is needed");
  expect_refused("missing.npz", THRUM_MISSING, "array 'c4' is missing");
  expect_refused("nan.npz", THRUM_BAD_VALUE, "array 'vertices' holds a value that is not finite");
  expect_refused("falling.npz", THRUM_BAD_VALUE, "array 'omega2' is not in ascending order");
  expect_refused("index.npz", THRUM_BAD_VALUE, "array 'tets' holds the index 5 (entry 7)");
  expect_refused("shape.npz", THRUM_BAD_SHAPE, "array 'basis' has shape (12, 2)");
  expect_refused("object.npz", THRUM_BAD_SHAPE, "array 'meta' has type '|O', '|u1' is needed");
  expect_refused("text.npz", THRUM_BAD_SHAPE, "array 'meta' has type '<U2', '|u1' is needed");
  expect_refused("array.npy", THRUM_BAD_FORMAT, "single .npy array");
}

static void npy_files_pass_both_ways(void **state) {
  (void)state;

  // a matrix of the sample's basis as Thrum writes it
  thrum_error error = {.status = THRUM_OK};
  unsigned char bytes[192 + sizeof sample_basis];
  size_t header = thrum_npy_header_f8(bytes, 15, 2);
  memcpy(bytes + header, sample_basis, sizeof sample_basis);
  assert_int_equal(thrum_file_write_atomic("out.npy", bytes, header + sizeof sample_basis, NULL),
                   THRUM_OK);

  // NumPy reads it, and writes it back in several forms
  python("import numpy as np\n"
         "a = np.load('out.npy')\n"
         "assert a.dtype == '<f8' and a.flags.c_contiguous and a.shape == (15, 2)\n"
         "np.save('back.npy', a)\n"
         "np.save('row.npy', a.ravel())\n"
         "np.save('scalar.npy', 1.0)\n"
         "np.save('fortran.npy', np.asfortranarray(a))\n"
         "np.save('int.npy', np.arange(3))\n");

  // a matrix and a vector are read
  double *values = NULL;
  int64_t rows = 0, columns = 0;
  assert_int_equal(thrum_npy_read_f8("back.npy", &values, &rows, &columns, &error), THRUM_OK);
  assert_true(rows == 15 && columns == 2);
  assert_memory_equal(values, sample_basis, sizeof sample_basis);
  free(values);
  assert_int_equal(thrum_npy_read_f8("row.npy", &values, &rows, &columns, &error), THRUM_OK);
  assert_true(rows == 30 && columns == 0);
  assert_memory_equal(values, sample_basis, sizeof sample_basis);
  free(values);

  // scalars, Fortran order and integers are refused
  assert_int_equal(thrum_npy_read_f8("scalar.npy", &values, &rows, &columns, &error),
                   THRUM_BAD_SHAPE);
  assert_non_null(strstr(error.message, "scalar.npy has shape ()"));
  assert_int_equal(thrum_npy_read_f8("fortran.npy", &values, &rows, &columns, &error),
                   THRUM_BAD_SHAPE);
  assert_non_null(strstr(error.message, "fortran.npy is in Fortran order"));
  assert_int_equal(thrum_npy_read_f8("int.npy", &values, &rows, &columns, &error), THRUM_BAD_SHAPE);
  assert_non_null(strstr(error.message, "int.npy has type '<i8'"));
}

// the Python blocks of the page run as they stand, one after the other
#define DOCS_BLOCKS                                                                                \
  "import pathlib, re\n"                                                                           \
  "page = pathlib.Path('" THRUM_TEST_DATA "/../../docs/model_format.md').read_text('utf-8')\n"     \
  "blocks = re.findall(r'```python\\n(.*?)```', page, re.S)\n"                                     \
  "assert len(blocks) == 2\n"                                                                      \
  "for block in blocks: exec(block)\n"

static void the_energy_of_the_format_page_is_that_of_the_runtime(void **state) {
  (void)state;

  // the page's code evaluates the energy of a random model at random points
  random_model m;
  random_model_make_wild(&m, 7, 6);
  save("wild.npz", &m.model);
  python(DOCS_BLOCKS "model = dict(np.load('wild.npz'))\n"
                     "q = np.random.default_rng(3).uniform(-1, 1, (20, 6))\n"
                     "np.save('q.npy', q)\n"
                     "np.save('v.npy', np.array([energy(model, x) for x in q]))\n");

  // the runtime gives the same energies
  double *q = NULL, *v = NULL;
  int64_t rows = 0, columns = 0;
  assert_int_equal(thrum_npy_read_f8("q.npy", &q, &rows, &columns, NULL), THRUM_OK);
  assert_int_equal(thrum_npy_read_f8("v.npy", &v, &rows, &columns, NULL), THRUM_OK);
  assert_int_equal(rows, 20);
  double *work = random_alloc((int64_t)thrum_work_count(&m.model), sizeof *work);
  for (int64_t i = 0; i < rows; i++)
    assert_true(fabs(thrum_strain_energy(&m.model, q + 6 * i, work) - v[i]) <=
                1e-12 * (1 + fabs(v[i])));

  free(work);
  free(q);
  free(v);
  random_model_free(&m);
}

static void the_model_by_hand_of_the_format_page_is_a_model(void **state) {
  (void)state;
  thrum_error error = {.status = THRUM_OK};
  const thrum_model *model = NULL;
  python(DOCS_BLOCKS);
  if (thrum_model_load("duffing.npz", &model, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  assert_int_equal(model->rank, 1);
  assert_null(model->vertices);
  assert_null(model->basis);
  double work[2048], q = 2;
  assert_true(thrum_work_count(model) <= 2048);
  // 1/2 * 4 * 2^2 + 1/4 * 2^4
  assert_true(thrum_strain_energy(model, &q, work) == 12);
  thrum_model_destroy(model);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(numpy_opens_a_saved_model),
      cmocka_unit_test(a_model_that_numpy_saves_again_is_the_same),
      cmocka_unit_test(files_that_numpy_makes_in_other_ways_are_refused),
      cmocka_unit_test(npy_files_pass_both_ways),
      cmocka_unit_test(the_energy_of_the_format_page_is_that_of_the_runtime),
      cmocka_unit_test(the_model_by_hand_of_the_format_page_is_a_model),
  };
  return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
