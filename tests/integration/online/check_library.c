/* SPDX-License-Identifier: BSD-3-Clause */
/* check_library MODEL N: asks N points of the box from several threads that share a model, and compares bit by bit with
 * one thread; counts what a query allocates; gives wrong arguments. Prints what it counted; ends with 1 where something
 * is wrong. */
#include "random_points.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { n_threads = 4 };

/* Every allocation of the process, the library's too. */
static _Thread_local long n_allocations;
void *__libc_malloc(size_t size);
void *__libc_calloc(size_t n, size_t size);
void *__libc_realloc(void *block, size_t size);
void *malloc(size_t size) {
  n_allocations++;
  return __libc_malloc(size);
}
void *calloc(size_t n, size_t size) {
  n_allocations++;
  return __libc_calloc(n, size);
}
void *realloc(void *block, size_t size) {
  n_allocations++;
  return __libc_realloc(block, size);
}

typedef struct {
  const signorom_model *model;
  signorom_context *context;
  int first, n;
  const double *points;
  double *multipliers;
  signorom_answer *answers;
  int code;
} job_t;

static void *work(void *argument) {
  job_t *job = argument;
  signorom_sizes sizes;
  signorom_get_sizes(job->model, &sizes);
  if (!job->code)
    job->code =
        signorom_query_many(job->context, job->n, job->points + (size_t)job->first * sizes.n_parameters,
                            job->answers + job->first, job->multipliers + (size_t)job->first * sizes.n_contacts);
  return NULL;
}

static int compare_threads(const signorom_model *model, const signorom_sizes *sizes, const double *points, int n) {
  const size_t size = (size_t)n * sizes->n_contacts;
  double *alone = calloc(size + 1, sizeof *alone), *shared = calloc(size + 1, sizeof *shared);
  signorom_answer *answers = calloc(2 * n, sizeof *answers);
  for (int i = 0; i < 2 * n; i++) answers[i] = (signorom_answer)SIGNOROM_ANSWER;
  job_t whole = {.model = model, .n = n, .points = points, .multipliers = alone, .answers = answers};
  whole.code = signorom_create_context(model, &whole.context);
  work(&whole);
  signorom_free_context(whole.context);
  job_t jobs[n_threads];
  pthread_t threads[n_threads];
  for (int i = 0; i < n_threads; i++) {
    const int first = (int)((long)n * i / n_threads);
    jobs[i] = (job_t){.model = model,
                      .first = first,
                      .n = (int)((long)n * (i + 1) / n_threads) - first,
                      .points = points,
                      .multipliers = shared,
                      .answers = answers + n};
    jobs[i].code = signorom_create_context(model, &jobs[i].context);
  }
  for (int i = 0; i < n_threads; i++) pthread_create(&threads[i], NULL, work, &jobs[i]);
  for (int i = 0; i < n_threads; i++) {
    pthread_join(threads[i], NULL);
    signorom_free_context(jobs[i].context);
  }
  const int is_same = memcmp(alone, shared, size * sizeof *alone) == 0;
  int n_answered = 0;
  for (int i = 0; i < n; i++) n_answered += answers[i].code == SIGNOROM_OK;
  printf("answered %d of %d, %d threads %s\n", n_answered, n, n_threads, is_same ? "agree" : "differ");
  free(answers);
  free(shared);
  free(alone);
  return is_same && n_answered == n;
}

static int count_allocations(const signorom_model *model, const signorom_sizes *sizes, const double *points, int n) {
  signorom_context *context;
  long n_before = 0;
  if (signorom_create_context(model, &context)) return 0;
  double *forces = malloc(((size_t)sizes->n_contacts + 1) * sizeof *forces);
  double area, force[3], moment[3]; /* of the one contact of the deck */
  for (int i = 0; i < 2 * n; i++) {
    if (i == n) n_before = n_allocations;
    signorom_query(context, points + (size_t)(i % n) * sizes->n_parameters, NULL);
    signorom_get_multipliers(context, forces);
    signorom_get_resultants(model, forces, &area, force, moment);
  }
  const long n_made = n_allocations - n_before;
  printf("allocations in %d queries: %ld\n", n, n_made);
  free(forces);
  signorom_free_context(context);
  return n_made == 0;
}

/* An answer without its size is refused; of a larger one, that of a later header, only the known members are written.
 */
static int check_sizes(signorom_context *context, const double *points) {
  struct {
    signorom_answer known;
    double later;
  } answers[2] = {{.known = SIGNOROM_ANSWER, .later = 7}, {.known = SIGNOROM_ANSWER, .later = 8}};
  signorom_answer none = SIGNOROM_ANSWER;
  none.size = offsetof(signorom_answer, bound) - 1; /* smaller than the first version */
  int is_fine = signorom_query(context, points, &none) == SIGNOROM_BAD_ARGUMENT;
  is_fine &= strstr(signorom_message(context), "SIGNOROM_ANSWER") != NULL;
  is_fine &= signorom_query_many(context, 1, points, &none, NULL) == SIGNOROM_BAD_ARGUMENT;
  none = (signorom_answer)SIGNOROM_ANSWER;
  none.size = offsetof(signorom_answer, n_free_motions); /* the version before that member */
  none.n_free_motions = 9;
  is_fine &= signorom_query(context, points, &none) == SIGNOROM_OK && none.n_free_motions == 9;
  none.size = offsetof(signorom_answer, error_estimate);
  none.error_estimate = 9;
  is_fine &= signorom_query(context, points, &none) == SIGNOROM_OK && none.error_estimate == 9;
  none.size = sizeof none;
  is_fine &= signorom_query(context, points, &none) == SIGNOROM_OK && none.n_free_motions == 0;
  is_fine &= none.error_estimate == SIGNOROM_NO_BOUND; /* no material flows */
  none.size = (size_t)1 << 40;                         /* what was there before: no version is as large */
  is_fine &= signorom_query_many(context, 1, points, &none, NULL) == SIGNOROM_BAD_ARGUMENT;
  memset(&none, 0, sizeof none); /* the first version: what came later is not written */
  is_fine &= signorom_query(context, points, &none) == SIGNOROM_OK && none.size == offsetof(signorom_answer, bound);
  is_fine &= none.n_solutions >= 1 && none.bound == 0 && none.relative_bound == 0;
  answers[0].known.size =
      0; /* one answer may have the first version's size, of several it would not be their distance */
  is_fine &= signorom_query_many(context, 1, points, &answers[0].known, NULL) == SIGNOROM_OK;
  answers[0].known.size = 0;
  is_fine &= signorom_query_many(context, 2, points, &answers[0].known, NULL) == SIGNOROM_BAD_ARGUMENT;
  answers[0].known = (signorom_answer)SIGNOROM_ANSWER;
  answers[0].known.size = sizeof answers[0];
  is_fine &= signorom_query_many(context, 2, points, &answers[0].known, NULL) == SIGNOROM_OK;
  is_fine &= answers[0].later == 7 && answers[1].later == 8 && answers[1].known.size == sizeof answers[0];
  is_fine &= answers[0].known.n_solutions >= 1 && answers[1].known.n_solutions >= 1;
  return is_fine;
}

/* The model has no history: its states are its points. */
static int refuse_histories(const signorom_model *model, signorom_context *context, const double *points) {
  double states[64], value;
  int n_given = -1, n_times = -1, n_memory = -1, is_fine = 1;
  is_fine &= signorom_get_history(NULL, &n_given, &n_times, NULL) == SIGNOROM_BAD_ARGUMENT;
  is_fine &= signorom_get_history(model, &n_given, &n_times, NULL) == SIGNOROM_OK && n_given > 0 && n_times == 0;
  is_fine &= signorom_get_states(context, points, states) == SIGNOROM_OK && states[0] == points[0];
  is_fine &= signorom_get_states(context, points, NULL) == SIGNOROM_BAD_ARGUMENT;
  is_fine &= signorom_start(NULL, points) == SIGNOROM_BAD_ARGUMENT;
  is_fine &= signorom_start(context, NULL) == SIGNOROM_BAD_ARGUMENT;
  is_fine &= signorom_start(context, points) == SIGNOROM_BAD_ARGUMENT;
  is_fine &= strstr(signorom_message(context), "no history") != NULL;
  is_fine &= signorom_advance(NULL, 1, NULL, NULL) == SIGNOROM_BAD_ARGUMENT;
  is_fine &= signorom_advance(context, 1, NULL, NULL) == SIGNOROM_BAD_ARGUMENT;
  is_fine &= strstr(signorom_message(context), "start comes first") != NULL;
  is_fine &= signorom_get_point(context, &value) == SIGNOROM_BAD_ARGUMENT;
  is_fine &= signorom_get_memory_size(NULL, &n_memory) == SIGNOROM_BAD_ARGUMENT;
  is_fine &= signorom_get_memory_size(model, &n_memory) == SIGNOROM_OK && n_memory == 0;
  is_fine &= signorom_get_memory(NULL, &value) == SIGNOROM_BAD_ARGUMENT;
  is_fine &= signorom_get_memory(context, NULL) == SIGNOROM_BAD_ARGUMENT;
  is_fine &= signorom_get_memory(context, &value) == SIGNOROM_OK; /* no numbers */
  is_fine &= signorom_set_memory(NULL, &value) == SIGNOROM_BAD_ARGUMENT;
  is_fine &= signorom_set_memory(context, NULL) == SIGNOROM_BAD_ARGUMENT;
  is_fine &= strstr(signorom_message(context), "null") != NULL;
  is_fine &= signorom_set_memory(context, &value) == SIGNOROM_OK;
  return is_fine;
}

static int refuse_wrong_arguments(const signorom_model *model, const signorom_sizes *sizes, const double *points) {
  signorom_context *context;
  double value;
  double *displacement = malloc((size_t)sizes->n_dimensions * sizeof *displacement);
  int node = sizes->n_nodes, is_fine = 1;
  is_fine &= signorom_create_context(NULL, &context) == SIGNOROM_BAD_ARGUMENT && strlen(signorom_message(context)) > 0;
  signorom_free_context(context);
  is_fine &= signorom_create_context(model, NULL) == SIGNOROM_BAD_ARGUMENT;
  is_fine &= signorom_open("model.h5", NULL) == SIGNOROM_BAD_ARGUMENT;
  is_fine &= signorom_create_context(model, &context) == SIGNOROM_OK;
  is_fine &= signorom_get_multipliers(context, &value) == SIGNOROM_BAD_ARGUMENT;
  is_fine &= signorom_query(context, NULL, NULL) == SIGNOROM_BAD_ARGUMENT;
  is_fine &= signorom_query(NULL, points, NULL) == SIGNOROM_BAD_ARGUMENT;
  is_fine &= signorom_query(context, points, NULL) == SIGNOROM_OK;
  is_fine &= check_sizes(context, points);
  is_fine &= signorom_get_displacement_at(context, 1, &node, displacement) == SIGNOROM_BAD_ARGUMENT;
  node = sizes->n_nodes - 1;
  is_fine &= signorom_get_displacement_at(context, 1, &node, displacement) == SIGNOROM_OK;
  is_fine &= signorom_get_multipliers(context, NULL) == SIGNOROM_BAD_ARGUMENT;
  is_fine &= strstr(signorom_message(context), "null pointer") != NULL;
  is_fine &= signorom_get_displacement_at(context, 1, NULL, displacement) == SIGNOROM_BAD_ARGUMENT;
  is_fine &= signorom_differentiate(context, 0, NULL, NULL) == SIGNOROM_BAD_ARGUMENT;
  is_fine &= strstr(signorom_message(context), "must be 1 or -1") != NULL;
  is_fine &= signorom_get_multiplier_gradient(context, &value) == SIGNOROM_BAD_ARGUMENT;
  is_fine &= signorom_get_resultant_gradient(context, &value, &value) == SIGNOROM_BAD_ARGUMENT;
  is_fine &= signorom_get_displacement_gradient_at(context, 1, &node, displacement) == SIGNOROM_BAD_ARGUMENT;
  is_fine &= signorom_get_displacement_gradient_errors(context, displacement) == SIGNOROM_BAD_ARGUMENT;
  is_fine &= strstr(signorom_message(context), "signorom_differentiate") != NULL;
  is_fine &= signorom_get_parameter(model, -1, NULL, NULL, NULL, NULL) == SIGNOROM_BAD_ARGUMENT;
  is_fine &= signorom_get_parameter(model, sizes->n_parameters, NULL, NULL, NULL, NULL) == SIGNOROM_BAD_ARGUMENT;
  is_fine &= signorom_text(model, 99) == NULL && signorom_text(NULL, 0) == NULL;
  is_fine &= strstr(signorom_text(model, SIGNOROM_TEXT_VERDICT), "accepted: ") != NULL;
  is_fine &= signorom_get_domain_contacts(model, sizes->n_clusters, NULL, NULL) == SIGNOROM_BAD_ARGUMENT;
  is_fine &= signorom_get_contact_nodes(model, 2, NULL, NULL, NULL, NULL) == SIGNOROM_BAD_ARGUMENT;
  is_fine &= signorom_get_contact_nodes(model, 1, NULL, NULL, NULL, NULL) == SIGNOROM_OK;
  is_fine &= signorom_get_contact_areas(NULL, NULL) == SIGNOROM_BAD_ARGUMENT;
  is_fine &= signorom_get_force_directions(NULL, NULL, NULL) == SIGNOROM_BAD_ARGUMENT;
  is_fine &= signorom_get_force_directions(model, NULL, NULL) == SIGNOROM_OK;
  is_fine &= signorom_get_contact_entries(NULL, &node, NULL, NULL) == SIGNOROM_BAD_ARGUMENT;
  is_fine &= signorom_get_contact_entries(model, &node, NULL, NULL) == SIGNOROM_OK && node == 1;
  is_fine &= signorom_contact_entry_name(model, 0) != NULL && signorom_contact_entry_name(model, 1) == NULL;
  is_fine &= signorom_contact_entry_name(model, -1) == NULL && signorom_contact_entry_name(NULL, 0) == NULL;
  is_fine &= signorom_get_resultants(model, NULL, &value, &value, &value) == SIGNOROM_BAD_ARGUMENT;
  is_fine &= signorom_get_resultants(model, &value, &value, NULL, &value) == SIGNOROM_BAD_ARGUMENT;
  is_fine &= signorom_get_next_cluster(model, NULL, &node) == SIGNOROM_BAD_ARGUMENT;
  is_fine &= signorom_get_next_cluster(model, points, NULL) == SIGNOROM_BAD_ARGUMENT;
  is_fine &= refuse_histories(model, context, points);
  signorom_free_context(context);
  signorom_free_context(NULL);
  signorom_close(NULL);
  free(displacement);
  printf("wrong arguments %s\n", is_fine ? "refused" : "accepted");
  return is_fine;
}

int main(int argc, char **argv) {
  signorom_model *model;
  signorom_sizes sizes;
  if (argc != 3) return 1;
  const int n = atoi(argv[2]);
  double *points = open_with_points(argv[1], n, &model, &sizes);
  if (!points) return 2;
  int is_fine = compare_threads(model, &sizes, points, n);
  is_fine &= count_allocations(model, &sizes, points, n);
  is_fine &= refuse_wrong_arguments(model, &sizes, points);
  free(points);
  signorom_close(model);
  return is_fine ? 0 : 1;
}
