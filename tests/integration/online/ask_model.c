/* SPDX-License-Identifier: BSD-3-Clause */
/* An engineer's program that asks a trained model: nothing but signorom.h and the library.
 *
 *     cc ask_model.c $(pkg-config --cflags --libs signorom_online) -Wl,-rpath,PREFIX/lib -o ask_model
 *     ./ask_model model.h5 170.0 3.2
 */
#include <signorom.h>

#include <stdio.h>
#include <stdlib.h>

static int fail(const char *sentence) {
  fprintf(stderr, "%s\n", sentence);
  return 2;
}

static void print_answer(const signorom_model *model, const signorom_sizes *sizes, const signorom_answer *answer,
                         const double *multipliers) {
  double sum = 0;
  int n_active = 0;
  for (int i = 0; i < sizes->n_contacts; i++) {
    sum += multipliers[i];
    n_active += multipliers[i] > 0;
  }
  printf("method %d, residual %.1e, distance %.3g%s\n", answer->method, answer->residual, answer->distance,
         answer->is_inside_box ? "" : ", outside the trained box");
  printf("contact force %.12g %s on %d of %d pairs\n", sum, signorom_text(model, SIGNOROM_TEXT_FORCE_UNIT), n_active,
         sizes->n_contacts);
  printf("error of the displacement %.12g\n", answer->relative_displacement_bound);
  if (answer->n_solutions > 1) printf("the reduced problem has several solutions here: the forces are less reliable\n");
}

static int ask(signorom_context *context, const signorom_model *model, const double *point) {
  signorom_sizes sizes;
  signorom_answer answer = SIGNOROM_ANSWER;
  signorom_get_sizes(model, &sizes);
  if (signorom_query(context, point, &answer)) return fail(signorom_message(context));
  double *multipliers = calloc(sizes.n_contacts + 1, sizeof *multipliers);
  double *displacement = calloc(sizes.n_dofs + 1, sizeof *displacement);
  int status = 0;
  if (signorom_get_multipliers(context, multipliers) || signorom_get_displacement(context, displacement))
    status = fail(signorom_message(context));
  else
    print_answer(model, &sizes, &answer, multipliers);
  int next;
  if (sizes.n_clusters > 1 && signorom_get_next_cluster(model, point, &next) == SIGNOROM_OK)
    printf("cluster %d of %d, next to it %d\n", answer.cluster + 1, sizes.n_clusters, next + 1);
  free(displacement);
  free(multipliers);
  return status;
}

int main(int argc, char **argv) {
  signorom_model *model;
  signorom_context *context;
  signorom_sizes sizes;
  double point[16];
  if (argc < 2) return fail("usage: ask_model MODEL VALUE...");
  if (signorom_open(argv[1], &model)) {
    const int status = fail(signorom_model_message(model));
    signorom_close(model);
    return status;
  }
  signorom_get_sizes(model, &sizes);
  if (argc - 2 != sizes.n_parameters || sizes.n_parameters > 16) {
    signorom_close(model);
    return fail("one value for each parameter is needed");
  }
  for (int i = 0; i < sizes.n_parameters; i++) {
    const char *name, *unit;
    signorom_get_parameter(model, i, &name, &unit, NULL, NULL);
    point[i] = atof(argv[2 + i]);
    printf("%s = %g %s\n", name, point[i], unit);
  }
  int status = signorom_create_context(model, &context);
  status = status ? fail(signorom_message(context)) : ask(context, model, point);
  signorom_free_context(context);
  signorom_close(model);
  return status;
}
