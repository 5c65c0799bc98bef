/* SPDX-License-Identifier: BSD-3-Clause */
/* tell_resultants MODEL VALUE: of a model with one parameter, area, force and moment of each contact of the deck. */
#include <signorom.h>

#include <stdio.h>
#include <stdlib.h>

static int tell(const signorom_model *model, const double *multipliers) {
  signorom_sizes sizes;
  int n_entries, n_moments;
  signorom_get_sizes(model, &sizes);
  if (signorom_get_contact_entries(model, &n_entries, &n_moments, NULL)) return 1;
  const int n = sizes.n_dimensions;
  double *areas = calloc((size_t)n_entries * (1 + n + n_moments), sizeof *areas);
  double *forces = areas + n_entries, *moments = forces + (size_t)n_entries * n;
  const int code = signorom_get_resultants(model, multipliers, areas, forces, moments);
  for (int i = 0; i < n_entries && !code; i++) {
    printf("%s: %.17g", signorom_contact_entry_name(model, i), areas[i]);
    for (int k = 0; k < n; k++) printf(" %.17g", forces[i * n + k]);
    for (int k = 0; k < n_moments; k++) printf(" %.17g", moments[i * n_moments + k]);
    printf("\n");
  }
  free(areas);
  return code;
}

int main(int argc, char **argv) {
  signorom_model *model;
  signorom_context *context = NULL;
  signorom_sizes sizes;
  if (argc != 3) return 1;
  int code = signorom_open(argv[1], &model);
  if (!code) code = signorom_create_context(model, &context);
  if (!code) {
    const double point = atof(argv[2]);
    signorom_get_sizes(model, &sizes);
    double *multipliers = calloc(sizes.n_contacts + 1, sizeof *multipliers);
    code = signorom_query(context, &point, NULL);
    if (!code) code = signorom_get_multipliers(context, multipliers);
    if (!code) code = tell(model, multipliers);
    free(multipliers);
    signorom_free_context(context);
  }
  signorom_close(model);
  return code;
}
