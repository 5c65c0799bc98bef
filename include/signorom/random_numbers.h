/* SPDX-License-Identifier: BSD-3-Clause */
/* Random numbers that a seed repeats on every machine: splitmix64 (Steele, Lea and Flood, OOPSLA 2014). A state is any
   number; each call moves it on. */
#ifndef SIGNOROM_RANDOM_NUMBERS_H
#define SIGNOROM_RANDOM_NUMBERS_H

#include <stdint.h>

/* Returns a random number in [0, 1), a multiple of 2**-53. */
double sig_random_fraction(uint64_t *state);

/* Returns a random whole number in 0 .. n - 1, n > 0. */
int sig_random_below(uint64_t *state, int n);

#endif
