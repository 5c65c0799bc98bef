// SPDX-License-Identifier: BSD-3-Clause
#include "signorom/petsc_support.h"

#include <petscmat.h>
#include <slepcsys.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "signorom/signals.h"

// Sets options of Open MPI for a process that no launcher started, which has no other processes to communicate with.
// Open MPI would start a daemon for it and search the networks, which takes a third of a second. Without the daemon,
// all such processes of a user share one session folder, and one process may remove it while another one starts. So
// there is no session folder, and a killed process leaves nothing behind. Options that the user has set are kept.
static void spare_lone_process(void) {
  const char *const launched[] = {"OMPI_COMM_WORLD_SIZE", "PMIX_RANK", "PMI_RANK"};
  const char *const isolated = "OMPI_MCA_ess_singleton_isolated";

  for (size_t i = 0; i < sizeof launched / sizeof *launched; i++)
    if (getenv(launched[i])) return;
  setenv(isolated, "1", 0);
  if (strcmp(getenv(isolated), "1") == 0) setenv("OMPI_MCA_orte_create_session_dirs", "0", 0);
  setenv("OMPI_MCA_pml", "ob1", 0);
}

static void end_all_ranks(void) { MPI_Abort(MPI_COMM_WORLD, SIG_EXIT_STOPPED); }

// A rank that ends by force also ends the other ranks, because they wait for it. mpirun kills its ranks one second
// after it has sent them a signal, so the ranks end themselves before.
static PetscErrorCode share_ends(void) {
  const double grace_of_ranks = 0.6;
  int n_ranks;

  PetscCallMPI(MPI_Comm_size(MPI_COMM_WORLD, &n_ranks));
  if (n_ranks == 1) return 0;
  sig_set_stop_grace(grace_of_ranks);
  sig_set_end_of_others(end_all_ranks);
  return 0;
}

int sig_petsc_start(void) {
  spare_lone_process();
  // After an interrupt PETSc's signal handlers would print a stack trace; without them the program finishes its point.
  PetscCall(PetscOptionsSetValue(NULL, "-no_signal_handler", "true"));
  PetscCall(SlepcInitializeNoArguments());
  PetscCall(PetscInitializeFortran());
  PetscCall(share_ends());
  return 0;
}

int sig_petsc_end(void) {
  // Options that nothing used are an error, which the program reports itself.
  PetscCall(PetscOptionsSetValue(NULL, "-options_left", "no"));
  return SlepcFinalize();
}

int sig_petsc_insert_options(const char *options, char *message) {
  PetscBool wants_log;

  message[0] = '\0';
  sig_quiet_errors(message);
  const PetscErrorCode code = PetscOptionsInsertString(NULL, options);
  sig_loud_errors();
  if (code && message[0]) return 0;
  PetscCall(code);
  // PETSc reads -log_view when it starts, before these options are set, and fails at its end if nothing was logged.
  PetscCall(PetscOptionsHasName(NULL, NULL, "-log_view", &wants_log));
  if (wants_log) PetscCall(PetscLogDefaultBegin());
  return 0;
}

int sig_petsc_unused_options(char *names_of_unused, int capacity) {
  PetscInt n_options = 0;
  char **names = NULL, **values = NULL;

  names_of_unused[0] = '\0';
  PetscCall(PetscOptionsLeftGet(NULL, &n_options, &names, &values));
  for (PetscInt i = 0; i < n_options; i++) {
    PetscCall(PetscStrlcat(names_of_unused, "-", (size_t)capacity));
    PetscCall(PetscStrlcat(names_of_unused, names[i], (size_t)capacity));
    PetscCall(PetscStrlcat(names_of_unused, " ", (size_t)capacity));
  }
  PetscCall(PetscOptionsLeftRestore(NULL, &n_options, &names, &values));
  return 0;
}

int sig_library_versions(char *versions, int capacity) {
  PetscInt petsc[3], slepc[3], release;
  char mpi[MPI_MAX_LIBRARY_VERSION_STRING];
  int length;

  PetscCall(PetscGetVersionNumber(&petsc[0], &petsc[1], &petsc[2], &release));
  PetscCall(SlepcGetVersionNumber(&slepc[0], &slepc[1], &slepc[2], &release));
  PetscCallMPI(MPI_Get_library_version(mpi, &length));
  // The text behind the first comma is the packager and the date.
  mpi[strcspn(mpi, ",\n")] = '\0';
  snprintf(versions, (size_t)capacity, "%d.%d.%d;%d.%d.%d;%s", petsc[0], petsc[1], petsc[2], slepc[0], slepc[1],
           slepc[2], mpi);
  return 0;
}

int sig_has_multigrid_vi(void) { return PETSC_VERSION_GE(3, 19, 0); }

int sig_matrix_create(int comm, int n_local, int block_size, const int *diagonal, const int *off_diagonal,
                      intptr_t *matrix) {
  Mat created;

  PetscCall(MatCreate(MPI_Comm_f2c(comm), &created));
  PetscCall(MatSetSizes(created, n_local, n_local, PETSC_DETERMINE, PETSC_DETERMINE));
  PetscCall(MatSetType(created, MATAIJ));
  PetscCall(MatXAIJSetPreallocation(created, block_size, diagonal, off_diagonal, NULL, NULL));
  *matrix = (intptr_t)created;
  return 0;
}

int sig_matrix_multiply(intptr_t matrix, int n_local, int n_columns, const double *columns, double *product) {
  MPI_Comm comm = PetscObjectComm((PetscObject)(Mat)matrix);
  Mat from, to;

  // MatCreateDense takes no const array, but the columns are only read.
  PetscCall(MatCreateDense(comm, n_local, PETSC_DECIDE, PETSC_DETERMINE, n_columns, (PetscScalar *)(uintptr_t)columns,
                           &from));
  PetscCall(MatCreateDense(comm, n_local, PETSC_DECIDE, PETSC_DETERMINE, n_columns, product, &to));
  PetscCall(MatMatMult((Mat)matrix, from, MAT_REUSE_MATRIX, PETSC_DEFAULT, &to));
  PetscCall(MatDestroy(&from));
  PetscCall(MatDestroy(&to));
  return 0;
}

static PetscErrorCode keep_first_message(MPI_Comm comm, int line, const char *function, const char *file,
                                         PetscErrorCode code, PetscErrorType type, const char *message, void *context) {
  (void)comm, (void)line, (void)function, (void)file;
  if (type == PETSC_ERROR_INITIAL && message != NULL) snprintf(context, SIG_MESSAGE_SIZE, "%s", message);
  return code;
}

void sig_quiet_errors(char *message) { (void)PetscPushErrorHandler(keep_first_message, message); }

void sig_loud_errors(void) { (void)PetscPopErrorHandler(); }

int sig_precondition_failed(int code, const char *sentence, const char *file, int line) {
  return PetscError(PETSC_COMM_SELF, line, "precondition", file, code, PETSC_ERROR_INITIAL, "%s", sentence);
}
