/* SPDX-License-Identifier: BSD-3-Clause */
/* compare_threads MODEL THREADS N: each thread asks N points of the box (each begins at another one) and compares every
 * answer bit by bit with that of one thread alone. Prints how many differ; ends with 1 where some do. */
#include "random_points.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
  const signorom_sizes *sizes;
  signorom_context *context;
  int n, first;
  const double *points;
  double *forces; /* of all points; the first thread fills it, the others compare with it */
  int is_reference, n_different;
  double worst;
} job_t;

static double larger(double a, double b) { return a > b ? a : b; }

/* Forces of all contacts; no answer is an array of -1. */
static void ask(job_t *job, int i, double *forces) {
  const double *point = job->points + (size_t)i * job->sizes->n_parameters;
  if (signorom_query(job->context, point, NULL) || signorom_get_multipliers(job->context, forces))
    for (int k = 0; k < job->sizes->n_contacts; k++) forces[k] = -1;
}

/* The largest difference over the largest force. */
static double difference_of(int n, const double *forces, const double *expected) {
  double largest = 0, difference = 0;
  for (int k = 0; k < n; k++) {
    largest = larger(largest, expected[k]);
    difference = larger(difference, larger(forces[k] - expected[k], expected[k] - forces[k]));
  }
  return difference / largest;
}

static void *work(void *argument) {
  job_t *job = argument;
  const int n = job->sizes->n_contacts;
  double *forces = calloc((size_t)n + 1, sizeof *forces);
  for (int k = 0; k < job->n; k++) {
    const int i = (job->first + k) % job->n;
    double *expected = job->forces + (size_t)i * n;
    ask(job, i, job->is_reference ? expected : forces);
    if (job->is_reference || memcmp(forces, expected, (size_t)n * sizeof *forces) == 0) continue;
    job->n_different++;
    job->worst = larger(job->worst, difference_of(n, forces, expected));
  }
  free(forces);
  return NULL;
}

/* Runs the jobs side by side: how many of their answers differ. */
static long run(job_t *jobs, int n_threads, double *worst) {
  pthread_t *threads = malloc((size_t)n_threads * sizeof *threads);
  long n_different = 0;
  for (int i = 0; i < n_threads; i++) pthread_create(&threads[i], NULL, work, &jobs[i]);
  for (int i = 0; i < n_threads; i++) {
    pthread_join(threads[i], NULL);
    signorom_free_context(jobs[i].context);
    n_different += jobs[i].n_different;
    *worst = larger(*worst, jobs[i].worst);
  }
  free(threads);
  return n_different;
}

int main(int argc, char **argv) {
  signorom_model *model;
  signorom_sizes sizes;
  double worst = 0;
  if (argc != 4) return 2;
  const int n_threads = atoi(argv[2]), n = atoi(argv[3]);
  double *points = open_with_points(argv[1], n, &model, &sizes);
  if (!points) return 2;
  double *forces = calloc((size_t)n * sizes.n_contacts + 1, sizeof *forces);
  job_t *jobs = calloc((size_t)n_threads, sizeof *jobs);
  job_t alone = {.sizes = &sizes, .n = n, .points = points, .forces = forces, .is_reference = 1};
  signorom_create_context(model, &alone.context);
  run(&alone, 1, &worst);
  for (int i = 0; i < n_threads; i++) {
    jobs[i] = (job_t){.sizes = &sizes, .n = n, .points = points, .forces = forces};
    jobs[i].first = (int)((long)n * i / n_threads);
    signorom_create_context(model, &jobs[i].context);
  }
  const long n_different = run(jobs, n_threads, &worst);
  printf("%d contacts, %d clusters: %ld of %ld answers differ, by up to %.2g of the largest force\n", sizes.n_contacts,
         sizes.n_clusters, n_different, (long)n_threads * n, worst);
  free(jobs);
  free(forces);
  free(points);
  signorom_close(model);
  return n_different > 0;
}
