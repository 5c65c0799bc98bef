// SPDX-License-Identifier: BSD-3-Clause
// Counts the reductions and broadcasts that the Fortran side of the program calls by itself, which PETSc does not
// count. communication.py loads it before the program (LD_PRELOAD), and each rank writes its two lines, number and
// bytes, to the file COUNT_REDUCTIONS.<process number>.
#define _GNU_SOURCE /* RTLD_NEXT */
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef void reduction(void *sent, void *received, int *count, int *type, int *operation, int *comm, int *ierr);
typedef void broadcast(void *buffer, int *count, int *type, int *root, int *comm, int *ierr);
typedef void size_of_type(int *type, int *size, int *ierr);

enum { REDUCTION, BROADCAST, N_KINDS };
static long n_calls[N_KINDS];
static double n_bytes[N_KINDS];

void mpi_allreduce_(void *sent, void *received, int *count, int *type, int *operation, int *comm, int *ierr);
void mpi_bcast_(void *buffer, int *count, int *type, int *root, int *comm, int *ierr);

// A pointer to an object is no pointer to a function in C, so its bytes are copied.
static void find_next(const char *name, void *function, size_t size) {
  void *found = dlsym(RTLD_NEXT, name);
  if (!found) abort();
  memcpy(function, &found, size);
}

static void note(int kind, const int *count, int *type) {
  size_of_type *size_of;
  int size = 0, ierr;
  find_next("mpi_type_size_", &size_of, sizeof size_of);
  size_of(type, &size, &ierr);
  n_calls[kind]++;
  n_bytes[kind] += (double)*count * size;
}

void mpi_allreduce_(void *sent, void *received, int *count, int *type, int *operation, int *comm, int *ierr) {
  reduction *next;
  note(REDUCTION, count, type);
  find_next("mpi_allreduce_", &next, sizeof next);
  next(sent, received, count, type, operation, comm, ierr);
}

void mpi_bcast_(void *buffer, int *count, int *type, int *root, int *comm, int *ierr) {
  broadcast *next;
  note(BROADCAST, count, type);
  find_next("mpi_bcast_", &next, sizeof next);
  next(buffer, count, type, root, comm, ierr);
}

__attribute__((destructor)) static void write_counts(void) {
  const char *path = getenv("COUNT_REDUCTIONS");
  char name[4096];
  if (!path || n_calls[REDUCTION] + n_calls[BROADCAST] == 0) return;
  snprintf(name, sizeof name, "%s.%ld", path, (long)getpid());
  FILE *file = fopen(name, "w");
  if (!file) return;
  for (int kind = 0; kind < N_KINDS; kind++) fprintf(file, "%ld %.0f\n", n_calls[kind], n_bytes[kind]);
  fclose(file);
}
