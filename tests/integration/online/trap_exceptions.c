/* SPDX-License-Identifier: BSD-3-Clause */
/* trap_exceptions MODEL: opens a model and asks 100 points of its box while invalid operations, divisions by zero and
 * overflows end the process, as in hosts that look for their own errors. */
#define _GNU_SOURCE
#include "random_points.h"

#include <fenv.h>

int main(int argc, char **argv) {
  enum { N_POINTS = 100 };
  signorom_model *model;
  signorom_sizes sizes;
  signorom_context *context;
  if (argc != 2) return 2;
  feenableexcept(FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW);
  double *points = open_with_points(argv[1], N_POINTS, &model, &sizes);
  if (!points || signorom_create_context(model, &context)) return 2;
  for (int i = 0; i < N_POINTS; i++) signorom_query(context, points + i * sizes.n_parameters, NULL);
  signorom_free_context(context);
  signorom_close(model);
  free(points);
  return 0;
}
