/* SPDX-License-Identifier: BSD-3-Clause */
/* PETSc corners that are safer from C: start and end, options, matrices with exact preallocation.
   A PETSc object crosses the border as its pointer in an intptr_t (component %v of the Fortran handle).
   Functions return a PETSc error code, 0 = success, unless they say otherwise. */
#ifndef SIGNOROM_PETSC_SUPPORT_H
#define SIGNOROM_PETSC_SUPPORT_H
#include <stdint.h>

/* Starts MPI, PETSc and SLEPc without reading the command line. PETSc installs no signal handlers. On several ranks, a
 * rank that ends by force (signals.h) also ends the others, unless their launcher has sent the signal. */
int sig_petsc_start(void);
/* Ends SLEPc, PETSc and MPI. Unused options are not reported here (sig_petsc_unused_options). */
int sig_petsc_end(void);

/* Adds "-name value ..." (null-terminated) to the options database; later calls win. `message` (SIG_MESSAGE_SIZE bytes)
 * gets PETSc's complaint, for example about a missing file of options; it is empty where all is well. A complaint is
 * not a failure. */
int sig_petsc_insert_options(const char *options, char *message);

/* Gives the options that no object used, "-name -name ", cut at the capacity; empty when every option was used. */
int sig_petsc_unused_options(char *names, int capacity);

/* Gives the versions of the PETSc and SLEPc in use and the name of the MPI library, separated by semicolons, cut at the
 * capacity. */
int sig_library_versions(char *versions, int capacity);

/* Returns 1 where SNESVI can use GAMG. PETSc before 3.19 stops when the inactive set changes its size. */
int sig_has_multigrid_vi(void);

/* Creates a square AIJ matrix on comm (a Fortran handle) with n_local rows per rank, blocks of block_size rows, and
 * memory for diagonal[i] + off_diagonal[i] blocks in local block row i (arrays of n_local / block_size). */
int sig_matrix_create(int comm, int n_local, int block_size, const int *diagonal, const int *off_diagonal,
                      intptr_t *matrix);

/* Multiplies a matrix by n_columns columns, which hold this rank's n_local rows each; product is an array of the same
 * shape. */
int sig_matrix_multiply(intptr_t matrix, int n_local, int n_columns, const double *columns, double *product);

/* Between these two calls errors of PETSc are returned without a trace. The text of the last error goes to `message`,
 * which holds SIG_MESSAGE_SIZE bytes and must exist until the second call; without an error it does not change. Use
 * them where wrong options may cause errors, so that these become a failure with a reason. */
enum { SIG_MESSAGE_SIZE = 256 };
void sig_quiet_errors(char *message);
void sig_loud_errors(void);

/* Puts a broken precondition on PETSc's error stack with the caller's place; returns the code. */
int sig_precondition_failed(int code, const char *sentence, const char *file, int line);
#endif
