/* SPDX-License-Identifier: BSD-3-Clause */
/* Types and functions that the files of the dense kernels share. */
#ifndef SIGNOROM_DENSE_PARTS_H
#define SIGNOROM_DENSE_PARTS_H
#include <stddef.h>

/* Number of columns of the smallest triangles and panels. Larger ones are divided into halves, and products of these do
   most of the work. */
enum { SIG_BLOCK = 8 };

/* On Linux with x86-64, a function with this mark is compiled in three versions, and the loader chooses the best one
   for the processor. On other systems there is one version, and also with the address sanitizer: its checks would run
   in the loader, before the sanitizer has started. */
#if defined(__has_attribute) && defined(__x86_64__) && defined(__gnu_linux__) && !defined(__SANITIZE_ADDRESS__)
#if __has_attribute(target_clones)
#define SIG_FOR_EACH_PROCESSOR __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#endif
#endif
#ifndef SIG_FOR_EACH_PROCESSOR
#define SIG_FOR_EACH_PROCESSOR
#endif

/* Eight numbers that are added and multiplied at once, in one register or in several ones, depending on the processor.
 */
typedef double sig_eight __attribute__((vector_size(64)));
/* Eight numbers at any place in memory. */
typedef double sig_eight_in_memory __attribute__((vector_size(64), aligned(8), may_alias));

/* Triangle of a matrix in a system of equations: lower with ones on its diagonal (UNIT), lower or upper; T: transposed.
 */
typedef enum { SIG_LOWER_UNIT, SIG_LOWER, SIG_UPPER, SIG_LOWER_UNIT_T, SIG_LOWER_T, SIG_UPPER_T } sig_triangle;

/* y += sum_j t_j a_j over n columns of length m. */
void sig_add_columns(int m, int n, const double *restrict a, ptrdiff_t lda, const double *restrict t,
                     double *restrict y);

/* products_j = a_j' x for n columns of length m. */
void sig_column_products(int m, int n, const double *a, ptrdiff_t lda, const double *x, double *products);

/* Returns the place i of the largest |x_i|, the first one if there are several; NaN counts as the largest. n > 0. */
int sig_place_of_largest(int n, const double *x);

/* b = T^-1 b in place, for n_rhs columns. */
void sig_solve_triangle(sig_triangle kind, int n, int n_rhs, const double *a, ptrdiff_t lda, double *b, ptrdiff_t ldb);

#endif
