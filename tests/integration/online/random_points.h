/* SPDX-License-Identifier: BSD-3-Clause */
#ifndef SIG_RANDOM_POINTS_H
#define SIG_RANDOM_POINTS_H

#include <signorom.h>

#include <stdio.h>
#include <stdlib.h>

/* Opens a model and gives n points of its box, the same in every run, for free; NULL, with a message, on failure. */
static double *open_with_points(const char *path, int n, signorom_model **model, signorom_sizes *sizes) {
  if (signorom_open(path, model)) {
    fprintf(stderr, "%s\n", signorom_model_message(*model));
    signorom_close(*model);
    return NULL;
  }
  signorom_get_sizes(*model, sizes);
  const int n_parameters = sizes->n_parameters;
  double *points = malloc((size_t)n * n_parameters * sizeof *points);
  unsigned long long state = 20220430;
  for (int i = 0; i < n * n_parameters; i++) {
    double minimum, maximum;
    signorom_get_parameter(*model, i % n_parameters, NULL, NULL, &minimum, &maximum);
    state = state * 6364136223846793005ULL + 1442695040888963407ULL;
    points[i] = minimum + (maximum - minimum) * (double)(state >> 11) / 9007199254740992.0;
  }
  return points;
}

#endif
