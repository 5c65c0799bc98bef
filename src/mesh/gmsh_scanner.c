/* SPDX-License-Identifier: BSD-3-Clause */
#include "gmsh_scanner.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int line_of(const sig_scanner *scanner, size_t at) {
  int line = 1;
  for (size_t i = 0; i < at && i < scanner->size; i++) line += scanner->bytes[i] == '\n';
  return line;
}

bool sig_scan_fail(sig_scanner *scanner, size_t at, const char *format, ...) {
  if (scanner->message[0] != '\0') return false;
  va_list arguments;
  va_start(arguments, format);
  const int n = vsnprintf(scanner->message, sizeof scanner->message, format, arguments);
  va_end(arguments);
  if (at == SIG_SCAN_NOWHERE) return false;
  if (!scanner->is_binary)
    scanner->line = line_of(scanner, at);
  else if (n > 0 && (size_t)n < sizeof scanner->message)
    (void)snprintf(scanner->message + n, sizeof scanner->message - (size_t)n, " (at byte %zu)", at);
  return false;
}

static bool fail_truncated(sig_scanner *scanner) {
  return sig_scan_fail(scanner, scanner->size, "the file ends inside $%s; it was cut off or is not complete",
                       scanner->section);
}

/* Copies the printable beginning of the next word, for a message. */
static void show_word(const sig_scanner *scanner, char shown[32]) {
  size_t n = 0;
  for (size_t i = scanner->at; i < scanner->size && n < 24 && !isspace((unsigned char)scanner->bytes[i]); i++)
    shown[n++] = isprint((unsigned char)scanner->bytes[i]) ? scanner->bytes[i] : '?';
  shown[n] = '\0';
}

static bool fail_not_a_number(sig_scanner *scanner, const char *what) {
  char shown[32];
  show_word(scanner, shown);
  return sig_scan_fail(scanner, scanner->at, "$%s has '%s' where %s must stand", scanner->section, shown, what);
}

void sig_scan_skip_space(sig_scanner *scanner) {
  while (scanner->at < scanner->size && isspace((unsigned char)scanner->bytes[scanner->at])) scanner->at++;
}

size_t sig_scan_here(sig_scanner *scanner) {
  if (!scanner->is_binary) sig_scan_skip_space(scanner);
  return scanner->at;
}

void sig_scan_skip_line(sig_scanner *scanner) {
  while (scanner->at < scanner->size && scanner->bytes[scanner->at] != '\n') scanner->at++;
  if (scanner->at < scanner->size) scanner->at++;
}

/* Ends a word before white space or the character `stop`. It is an error if the word ends at the end of the file,
 * because a part of it may be missing. */
static bool finish_word(sig_scanner *scanner, const char *end, char stop, const char *what) {
  const size_t at = (size_t)(end - scanner->bytes);
  if (at == scanner->at) return fail_not_a_number(scanner, what);
  if (at >= scanner->size) return fail_truncated(scanner);
  if (!isspace((unsigned char)*end) && *end != stop) return fail_not_a_number(scanner, what);
  scanner->at = at;
  return true;
}

static bool scan_int_until(sig_scanner *scanner, char stop, int64_t *value) {
  sig_scan_skip_space(scanner);
  if (scanner->at >= scanner->size) return fail_truncated(scanner);
  char *end;
  errno = 0;
  const long long number = strtoll(scanner->bytes + scanner->at, &end, 10);
  if (errno == ERANGE) return fail_not_a_number(scanner, "a whole number of reasonable size");
  *value = number;
  return finish_word(scanner, end, stop, "a whole number");
}

bool sig_scan_word_int(sig_scanner *scanner, int64_t *value) { return scan_int_until(scanner, ' ', value); }

bool sig_scan_quoted_int(sig_scanner *scanner, int64_t *value) { return scan_int_until(scanner, '"', value); }

/* Copies the bytes of a number, in the order of this machine. */
static bool scan_bytes(sig_scanner *scanner, void *value, size_t n) {
  if (scanner->size - scanner->at < n) return fail_truncated(scanner);
  const char *bytes = scanner->bytes + scanner->at;
  for (size_t i = 0; i < n; i++) ((char *)value)[i] = bytes[scanner->is_swapped ? n - 1 - i : i];
  scanner->at += n;
  return true;
}

bool sig_scan_int(sig_scanner *scanner, int64_t *value) {
  if (!scanner->is_binary) return sig_scan_word_int(scanner, value);
  int32_t number = 0;
  if (!scan_bytes(scanner, &number, sizeof number)) return false;
  *value = number;
  return true;
}

bool sig_scan_size(sig_scanner *scanner, int64_t *value) {
  if (!scanner->is_binary) return sig_scan_word_int(scanner, value);
  if (scanner->has_short_sizes) return sig_scan_int(scanner, value);
  return scan_bytes(scanner, value, sizeof *value);
}

bool sig_scan_any_real(sig_scanner *scanner, double *value) {
  if (scanner->is_binary) return scan_bytes(scanner, value, sizeof *value);
  sig_scan_skip_space(scanner);
  if (scanner->at >= scanner->size) return fail_truncated(scanner);
  char *end;
  *value = strtod(scanner->bytes + scanner->at, &end);
  return finish_word(scanner, end, ' ', "a number");
}

bool sig_scan_real(sig_scanner *scanner, double *value) {
  const size_t at = sig_scan_here(scanner);
  if (!sig_scan_any_real(scanner, value)) return false;
  if (!isfinite(*value)) return sig_scan_fail(scanner, at, "$%s has a number that is not finite", scanner->section);
  return true;
}

bool sig_scan_check_count(sig_scanner *scanner, int64_t count, size_t min_bytes, const char *things) {
  if (count < 0)
    return sig_scan_fail(scanner, scanner->at, "$%s announces %lld %s", scanner->section, (long long)count, things);
  if ((uint64_t)count > (scanner->size - scanner->at) / min_bytes)
    return sig_scan_fail(
        scanner, scanner->at,
        "$%s announces %lld %s, for which the file is too short; it was cut off, or the number is wrong",
        scanner->section, (long long)count, things);
  return true;
}

bool sig_scan_expect(sig_scanner *scanner, const char *word) {
  const size_t length = strlen(word);
  sig_scan_skip_space(scanner);
  const size_t rest = scanner->size - scanner->at;
  if (rest < length && strncmp(scanner->bytes + scanner->at, word, rest) == 0) return fail_truncated(scanner);
  if (rest < length || strncmp(scanner->bytes + scanner->at, word, length) != 0) {
    char shown[32];
    show_word(scanner, shown);
    return sig_scan_fail(scanner, scanner->at, "found '%s' where %s must stand", shown, word);
  }
  scanner->at += length;
  return true;
}

void *sig_scan_allocate(sig_scanner *scanner, size_t count, size_t size) {
  void *block = calloc(count > 0 ? count : 1, size);
  if (block == NULL) {
    scanner->is_out_of_memory = true;
    (void)sig_scan_fail(scanner, scanner->at, "out of memory");
  }
  return block;
}
