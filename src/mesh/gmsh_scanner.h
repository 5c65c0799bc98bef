/* SPDX-License-Identifier: BSD-3-Clause */
/* Reads tokens of a .msh file, text or binary, and never reads outside of its bytes. Private to the gmsh reader. A
 * function of type bool returns false after a failure, which the scanner records. */
#ifndef SIG_GMSH_SCANNER_H
#define SIG_GMSH_SCANNER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "signorom/gmsh_reader.h"

typedef struct {
  const char *bytes; /* the file's bytes; behind them stands a null, which `size` does not count */
  size_t size;
  size_t at;            /* next byte to read */
  bool is_binary;       /* the data between the section marks is binary */
  bool is_swapped;      /* binary numbers have the byte order that this machine has not */
  bool has_short_sizes; /* a binary size has 4 bytes: a 32-bit machine wrote the file */
  const char *section;  /* for messages; static text or owned by the caller */
  char message[SIG_GMSH_MESSAGE_SIZE];
  int line; /* line of the failure in a text file; 0 in a binary file, and for a failure without a place */
  bool is_out_of_memory;
} sig_scanner;

/* Place of a failure that has no place in the file. */
#define SIG_SCAN_NOWHERE SIZE_MAX

/* Records a failure at byte `at`, unless there is one already, and returns false. */
bool sig_scan_fail(sig_scanner *scanner, size_t at, const char *format, ...);

/* Read a whole number: 4 bytes (int), or 8 or 4 bytes (size) in a binary file, a word in a text file. */
bool sig_scan_int(sig_scanner *scanner, int64_t *value);
bool sig_scan_size(sig_scanner *scanner, int64_t *value);

/* Reads a real number; fails if it is infinite or NaN. */
bool sig_scan_real(sig_scanner *scanner, double *value);

/* Reads a real number, which may also be infinite or NaN. */
bool sig_scan_any_real(sig_scanner *scanner, double *value);

/* Reads a whole number that is written as text even in a binary file. */
bool sig_scan_word_int(sig_scanner *scanner, int64_t *value);

/* Reads such a number, behind which a quote may stand. */
bool sig_scan_quoted_int(sig_scanner *scanner, int64_t *value);

/* Checks a number of things that need at least `min_bytes` each. It fails if the number is negative or the rest of the
 * file is too short for them. `things` is their name for the message.
 */
bool sig_scan_check_count(sig_scanner *scanner, int64_t count, size_t min_bytes, const char *things);

/* Returns the byte at which the next token starts, for messages; skips blanks in text. */
size_t sig_scan_here(sig_scanner *scanner);

/* Skips blanks and line ends. */
void sig_scan_skip_space(sig_scanner *scanner);

/* Skips the rest of the line and its end. */
void sig_scan_skip_line(sig_scanner *scanner);

/* Skips blanks and line ends, then reads exactly `word`. */
bool sig_scan_expect(sig_scanner *scanner, const char *word);

/* Returns a block of zeros for `count` things of `size` bytes; records a failure when out of memory. */
void *sig_scan_allocate(sig_scanner *scanner, size_t count, size_t size);

#endif
