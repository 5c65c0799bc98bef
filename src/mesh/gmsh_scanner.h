/* SPDX-License-Identifier: BSD-3-Clause */
/* Reads tokens of a .msh file, text or binary, without ever leaving its bytes. Private to the gmsh reader. */
#ifndef SIG_GMSH_SCANNER_H
#define SIG_GMSH_SCANNER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "signorom/gmsh_reader.h"

typedef struct {
  const char *bytes; /* followed by a null that does not count */
  size_t size;
  size_t at;           /* next byte to read */
  bool is_binary;      /* of the data between the section marks */
  const char *section; /* for messages; static text or owned by the caller */
  char message[SIG_GMSH_MESSAGE_SIZE];
  int line; /* of the message; 0 where it names a byte */
  bool is_out_of_memory;
} sig_scanner;

/* A failure that has no place in the file. */
#define SIG_SCAN_NOWHERE SIZE_MAX

/* Records the first failure, at byte `at`, and returns false. */
bool sig_scan_fail(sig_scanner *scanner, size_t at, const char *format, ...);

/* A whole number: 4 (int) or 8 (size) bytes in binary files, a word in text. */
bool sig_scan_int(sig_scanner *scanner, int64_t *value);
bool sig_scan_size(sig_scanner *scanner, int64_t *value);
bool sig_scan_real(sig_scanner *scanner, double *value);

/* The same, whatever the number is: infinite or none, too. */
bool sig_scan_any_real(sig_scanner *scanner, double *value);

/* A whole number written in words even in a binary file. */
bool sig_scan_word_int(sig_scanner *scanner, int64_t *value);

/* A number of things that take at least `min_bytes` each; more than the rest of the file can hold is a failure. */
bool sig_scan_check_count(sig_scanner *scanner, int64_t count, size_t min_bytes, const char *things);

/* Where the next token starts, for messages; passes blanks in text. */
size_t sig_scan_here(sig_scanner *scanner);

/* Passes blanks and line ends. */
void sig_scan_skip_space(sig_scanner *scanner);

/* Passes the rest of the line, its end included. */
void sig_scan_skip_line(sig_scanner *scanner);

/* Passes blanks and line ends, then exactly `word`. */
bool sig_scan_expect(sig_scanner *scanner, const char *word);

/* Room for `count` things of `size` bytes, zeroed; records a failure when out of memory. */
void *sig_scan_allocate(sig_scanner *scanner, size_t count, size_t size);

#endif
