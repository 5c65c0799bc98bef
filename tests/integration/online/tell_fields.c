/* SPDX-License-Identifier: BSD-3-Clause */
/* tell_fields MODEL VALUE...: numbers of cells, regions and facets, then stresses, contact pressures and status of all
 * nodes and cells; what wrong calls return. */
#include <signorom.h>

#include <stdio.h>
#include <stdlib.h>

static void print(const char *name, const double *values, int n) {
  printf("%s", name);
  for (int i = 0; i < n; i++) printf(" %.17g", values[i]);
  printf("\n");
}

static int refuses(signorom_context *context, const signorom_model *model) {
  return signorom_get_stresses(NULL, NULL, NULL, NULL, NULL) == SIGNOROM_BAD_ARGUMENT &&
         signorom_get_stresses(context, NULL, NULL, NULL, NULL) == SIGNOROM_BAD_ARGUMENT && // nothing asked yet
         signorom_get_field_sizes(NULL, NULL, NULL, NULL, NULL, NULL) == SIGNOROM_BAD_ARGUMENT &&
         signorom_get_cells(NULL, NULL, NULL, NULL) == SIGNOROM_BAD_ARGUMENT && !signorom_region_name(model, 99);
}

static int tell(const signorom_model *model, signorom_context *context, const double *point) {
  signorom_sizes sizes;
  int n_cells, n_cell_nodes, n_regions, n_facets, n_facet_nodes;
  signorom_get_sizes(model, &sizes);
  signorom_get_field_sizes(model, &n_cells, &n_cell_nodes, &n_regions, &n_facets, &n_facet_nodes);
  printf("%d %d %d %d %d %s %s\n", n_cells, n_cell_nodes, n_regions, n_facets, n_facet_nodes,
         signorom_text(model, SIGNOROM_TEXT_STRESS_UNIT), signorom_text(model, SIGNOROM_TEXT_AREA_UNIT));
  for (int i = 0; i < n_regions; i++) printf("%s\n", signorom_region_name(model, i));
  if (!refuses(context, model)) return 1;
  if (signorom_query(context, point, NULL)) return 1;
  double *stress = calloc(6 * (size_t)n_cells + 1, sizeof *stress);
  double *pressure = calloc(sizes.n_nodes + 1, sizeof *pressure);
  int *status = calloc(sizes.n_nodes + 1, sizeof *status);
  int code = signorom_get_stresses(context, stress, NULL, NULL, NULL);
  if (!code) code = signorom_get_contact_fields(context, NULL, pressure, NULL, status, NULL);
  if (code) {
    puts(signorom_message(context));
  } else {
    print("stress", stress, 6 * n_cells);
    print("pressure", pressure, sizes.n_nodes);
    int n_closed = 0;
    for (int i = 0; i < sizes.n_nodes; i++) n_closed += status[i] == 2;
    printf("closed %d\n", n_closed);
  }
  free(status);
  free(pressure);
  free(stress);
  return code;
}

int main(int argc, char **argv) {
  signorom_model *model;
  signorom_context *context = NULL;
  double point[16];
  for (int i = 2; i < argc && i < 18; i++) point[i - 2] = atof(argv[i]);
  int code = signorom_open(argv[1], &model);
  if (!code) code = signorom_create_context(model, &context);
  if (!code) code = tell(model, context, point);
  signorom_free_context(context);
  signorom_close(model);
  return code;
}
