/* SPDX-License-Identifier: BSD-3-Clause */
#ifndef SIG_RANDOM_POINTS_H
#define SIG_RANDOM_POINTS_H

#include <signorom.h>

#include <stdlib.h>

/* The same n points of the model's box in every run; for free. */
static double *random_points(const signorom_model *model, int n_parameters, int n) {
  double *points = malloc((size_t)n * n_parameters * sizeof *points);
  unsigned long long state = 20220430;
  for (int i = 0; i < n * n_parameters; i++) {
    double minimum, maximum;
    signorom_get_parameter(model, i % n_parameters, NULL, NULL, &minimum, &maximum);
    state = state * 6364136223846793005ULL + 1442695040888963407ULL;
    points[i] = minimum + (maximum - minimum) * (double)(state >> 11) / 9007199254740992.0;
  }
  return points;
}

#endif
