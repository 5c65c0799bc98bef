// SPDX-License-Identifier: BSD-3-Clause
// PETSc's interface to MUMPS cannot give an ordering where unknowns stay, and that of MUMPS for this case, approximate
// minimum degree, takes several times as long in space. So MUMPS is called directly: once to order K alone, then to
// eliminate in this order.
#include "signorom/elimination.h"

#include <dmumps_c.h>
#include <petscmat.h>

#include "factorization.h"
#include "signorom/linear_solver.h"
#include "signorom/petsc_support.h"

// values of `job`, and of others in the words of the manual of MUMPS
enum { BEGIN = -1, ANALYZE = 1, FACTOR = 2, END = -2 };
enum { SYMMETRIC = 2, HOST_WORKS = 1, GIVEN_ORDERING = 1, METIS = 5, ENTRIES_ON_ALL_RANKS = 3, SCHUR_ON_HOST = 1 };

// Entries on and above the diagonal that this rank has, 1-based.
typedef struct {
  MUMPS_INT8 n;
  MUMPS_INT *rows, *columns;
  double *values;
} entries_t;

static PetscErrorCode reserve(MUMPS_INT8 n, entries_t *entries) {
  entries->n = 0;
  PetscCall(PetscMalloc3(n, &entries->rows, n, &entries->columns, n, &entries->values));
  return 0;
}

static PetscErrorCode free_entries(entries_t *entries) {
  PetscCall(PetscFree3(entries->rows, entries->columns, entries->values));
  return 0;
}

static void add(entries_t *entries, PetscInt row, PetscInt column, double value) {
  entries->rows[entries->n] = (MUMPS_INT)row + 1;
  entries->columns[entries->n] = (MUMPS_INT)column + 1;
  entries->values[entries->n++] = value;
}

// Takes the upper triangle of K, then B' of [K B'; B 0].
static PetscErrorCode collect(Mat stiffness, int n_rows, const int *offsets, const int *places,
                              const double *coefficients, entries_t *entries, MUMPS_INT8 *n_of_stiffness) {
  PetscInt first, last, n, n_entries;
  const PetscInt *columns;
  const PetscScalar *values;
  MatInfo info;

  PetscCall(MatGetInfo(stiffness, MAT_LOCAL, &info));
  PetscCall(MatGetSize(stiffness, &n, NULL));
  PetscCall(MatGetOwnershipRange(stiffness, &first, &last));
  PetscCall(reserve((MUMPS_INT8)info.nz_used + offsets[n_rows], entries));
  for (PetscInt i = first; i < last; i++) {
    PetscCall(MatGetRow(stiffness, i, &n_entries, &columns, &values));
    for (PetscInt k = 0; k < n_entries; k++)
      if (columns[k] >= i) add(entries, i, columns[k], values[k]);
    PetscCall(MatRestoreRow(stiffness, i, &n_entries, &columns, &values));
  }
  *n_of_stiffness = entries->n;
  for (int row = 0; row < n_rows; row++)
    for (int k = offsets[row]; k < offsets[row + 1]; k++)
      if (places[k] >= first && places[k] < last) add(entries, places[k], n + row, coefficients[k]);
  return 0;
}

static void run(DMUMPS_STRUC_C *mumps, int job) {
  mumps->job = job;
  dmumps_c(mumps);
}

static void begin(DMUMPS_STRUC_C *mumps, MPI_Comm comm) {
  mumps->par = HOST_WORKS;
  mumps->sym = SYMMETRIC;
  mumps->comm_fortran = (MUMPS_INT)MPI_Comm_c2f(comm);
  run(mumps, BEGIN);
  // no output
  for (int i = 0; i < 3; i++) mumps->icntl[i] = -1;
  mumps->icntl[3] = 0;
  mumps->icntl[17] = ENTRIES_ON_ALL_RANKS;
}

static void give_entries(DMUMPS_STRUC_C *mumps, MUMPS_INT n, MUMPS_INT8 n_entries, const entries_t *entries) {
  mumps->n = n;
  mumps->nnz_loc = n_entries;
  mumps->irn_loc = entries->rows;
  mumps->jcn_loc = entries->columns;
  mumps->a_loc = entries->values;
}

// Gives the place of each unknown of K in the order of elimination, 1-based, on the first rank.
static void order(MPI_Comm comm, MUMPS_INT n, MUMPS_INT8 n_entries, const entries_t *entries, int is_first,
                  MUMPS_INT *place, MUMPS_INT infog[2]) {
  DMUMPS_STRUC_C mumps;

  begin(&mumps, comm);
  give_entries(&mumps, n, n_entries, entries);
  mumps.icntl[6] = METIS;
  run(&mumps, ANALYZE);
  for (int i = 0; i < 2; i++) infog[i] = mumps.infog[i];
  if (is_first && infog[0] >= 0)
    for (MUMPS_INT i = 0; i < n; i++) place[i] = mumps.sym_perm[i];
  run(&mumps, END);
}

// Eliminates with more and more memory, until it is enough.
static void eliminate_ordered(DMUMPS_STRUC_C *mumps) {
  run(mumps, ANALYZE);
  if (mumps->infog[0] < 0) return;
  for (int workspace = FIRST_WORKSPACE; workspace < LARGEST_WORKSPACE; workspace *= 2) {
    mumps->icntl[13] = workspace;
    run(mumps, FACTOR);
    if (mumps->infog[0] != -8 && mumps->infog[0] != -9) return;
  }
}

// MUMPS gives the lower triangle of what is left, row by row, and zeros above it.
static void take_compliance(size_t n, double *compliance) {
  for (size_t i = 0; i < n; i++)
    for (size_t j = 0; j <= i; j++) compliance[j * n + i] = compliance[i * n + j] = -compliance[i * n + j];
}

static PetscErrorCode eliminate(MPI_Comm comm, MUMPS_INT n, MUMPS_INT n_rows, MUMPS_INT8 n_of_stiffness,
                                const entries_t *entries, double *compliance, int *reason, char *message) {
  DMUMPS_STRUC_C mumps;
  PetscMPIInt rank;
  MUMPS_INT *place, *staying, infog[2];

  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCall(PetscMalloc2(n + n_rows, &place, n_rows, &staying));
  for (MUMPS_INT i = 0; i < n_rows; i++) place[n + i] = staying[i] = n + i + 1;
  order(comm, n, n_of_stiffness, entries, rank == 0, place, infog);
  if (infog[0] >= 0) {
    begin(&mumps, comm);
    give_entries(&mumps, n + n_rows, entries->n, entries);
    mumps.icntl[6] = GIVEN_ORDERING;
    mumps.perm_in = place;
    mumps.icntl[18] = SCHUR_ON_HOST;
    mumps.size_schur = n_rows;
    mumps.listvar_schur = staying;
    mumps.schur = compliance;
    mumps.icntl[23] = SIG_MUMPS_FINDS_NULL_PIVOTS;
    mumps.cntl[2] = SIG_MUMPS_NULL_PIVOT;
    // factors are not kept
    mumps.icntl[30] = 1;
    eliminate_ordered(&mumps);
    for (int i = 0; i < 2; i++) infog[i] = mumps.infog[i];
    *reason = mumps.infog[27] > 0 ? SIG_LINEAR_SINGULAR : SIG_LINEAR_DONE;
    run(&mumps, END);
  }
  PetscCall(PetscFree2(place, staying));
  if (infog[0] < 0) {
    *reason = SIG_LINEAR_FAILED;
    sig_tell_mumps_failure(infog[0], infog[1], message);
  } else if (*reason == SIG_LINEAR_DONE && rank == 0) {
    take_compliance((size_t)n_rows, compliance);
  }
  return 0;
}

int sig_eliminate(intptr_t stiffness, int n_rows, const int *offsets, const int *places, const double *coefficients,
                  double *compliance, int *reason, char *message) {
  MPI_Comm comm = PetscObjectComm((PetscObject)(Mat)stiffness);
  entries_t entries;
  MUMPS_INT8 n_of_stiffness = 0;
  PetscInt n;

  message[0] = '\0';
  PetscCall(MatGetSize((Mat)stiffness, &n, NULL));
  PetscCall(collect((Mat)stiffness, n_rows, offsets, places, coefficients, &entries, &n_of_stiffness));
  PetscCall(eliminate(comm, (MUMPS_INT)n, n_rows, n_of_stiffness, &entries, compliance, reason, message));
  PetscCall(free_entries(&entries));
  return 0;
}
