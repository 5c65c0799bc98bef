/* SPDX-License-Identifier: BSD-3-Clause */
/* query_times MODEL N: wall time of single queries at N random points of the trained box, of the contact forces
   everywhere after them, and what answered.
   query_times MODEL N POINTS: seconds of a query with the contact forces everywhere at each of N points of a file. */
#define _POSIX_C_SOURCE 199309L
#include <signorom.h>

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { n_warm = 1000, most_parameters = 16 };

static int compare(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

static double seconds(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void draw(const signorom_model *model, int n_parameters, unsigned long long *state, double *point) {
  for (int i = 0; i < n_parameters; i++) {
    double minimum, maximum;
    signorom_get_parameter(model, i, NULL, NULL, &minimum, &maximum);
    *state = *state * 6364136223846793005ULL + 1442695040888963407ULL;
    point[i] = minimum + (maximum - minimum) * (double)(*state >> 11) / 9007199254740992.0;
  }
}

/* As many points as the file has of these; the model answers each once before. */
static int tell_points(signorom_context *context, const signorom_sizes *sizes, const char *path, int n,
                       double *multipliers) {
  signorom_answer answer = SIGNOROM_ANSWER;
  double point[most_parameters];
  FILE *file = fopen(path, "r");
  if (!file) return 2;
  for (int i = 0; i < n; i++) {
    double elapsed = 0;
    for (int k = 0; k < sizes->n_parameters; k++)
      if (fscanf(file, "%lf", &point[k]) != 1) return 2;
    for (int turn = 0; turn < 2; turn++) {
      const double start = seconds();
      if (signorom_query(context, point, &answer)) return 1;
      signorom_get_multipliers(context, multipliers);
      elapsed = seconds() - start;
    }
    printf("%.9g\n", elapsed);
  }
  fclose(file);
  return 0;
}

/* Median and 99th percentile, in microseconds. */
static void tell(const char *what, double *times, int n) {
  qsort(times, (size_t)n, sizeof *times, compare);
  printf("%s: median %.1f us, p99 %.1f us\n", what, 1e6 * times[n / 2], 1e6 * times[(int)(0.99 * n)]);
}

int main(int argc, char **argv) {
  signorom_model *model;
  signorom_context *context;
  signorom_sizes sizes;
  signorom_answer answer = SIGNOROM_ANSWER;
  int counts[5] = {0}, n_several = 0;
  unsigned long long state = 20220430;
  double point[most_parameters];
  if (argc != 3 && argc != 4) return 2;
  const int n = atoi(argv[2]);
  if (signorom_open(argv[1], &model) || signorom_create_context(model, &context)) {
    fprintf(stderr, "%s\n", signorom_model_message(model));
    return 2;
  }
  signorom_get_sizes(model, &sizes);
  double *times = calloc((size_t)n, sizeof *times), *times_everywhere = calloc((size_t)n, sizeof *times);
  double *multipliers = calloc((size_t)sizes.n_contacts, sizeof *multipliers);
  if (!times || !times_everywhere || !multipliers || sizes.n_parameters > most_parameters) return 2;
  if (argc == 4) return tell_points(context, &sizes, argv[3], n, multipliers);
  for (int i = -n_warm; i < n; i++) {
    draw(model, sizes.n_parameters, &state, point);
    const double start = seconds();
    signorom_query(context, point, &answer);
    const double answered = seconds();
    if (answer.code == SIGNOROM_OK) signorom_get_multipliers(context, multipliers);
    if (i < 0) continue;
    times[i] = answered - start;
    times_everywhere[i] = seconds() - answered;
    counts[answer.method]++;
    n_several += answer.n_solutions > 1;
  }
  printf("%d points, %d contacts, %d in the domain of the last one\n", n, sizes.n_contacts, answer.n_domain_contacts);
  tell("query (load, coordinates, contact forces of the domain)", times, n);
  tell("then the contact forces everywhere", times_everywhere, n);
  printf("none %d, active_set %d, block_pivoting %d, lemke %d, condensed %d\n", counts[0], counts[1], counts[2],
         counts[3], counts[4]);
  printf("points with several solutions of the reduced problem: %d\n", n_several);
  free(times);
  free(times_everywhere);
  free(multipliers);
  signorom_free_context(context);
  signorom_close(model);
  return counts[0] > 0;
}
