/* SPDX-License-Identifier: BSD-3-Clause */
/* Expressions of named variables (muParser). A handle belongs to one thread. */
#ifndef SIG_EXPRESSION_H
#define SIG_EXPRESSION_H

#include <stddef.h>

/* Reasons why a text is not a valid expression. The Fortran side makes the message. */
enum {
  SIG_EXPRESSION_OK = 0,
  SIG_EXPRESSION_NO_MEMORY = 1,
  SIG_EXPRESSION_BAD_NAME = 2,     /* a variable's name is no identifier or belongs to muParser */
  SIG_EXPRESSION_UNKNOWN_NAME = 3, /* `token` is this name */
  SIG_EXPRESSION_SYNTAX = 4,       /* `message` is a sentence about it */
  SIG_EXPRESSION_SEVERAL = 5       /* "a, b": more than one value */
};

typedef struct sig_expression sig_expression;

/* Compiles a text of `text_length` bytes over `n_names` variables, whose names stand in `names` as consecutive fields
   of `name_width` bytes padded with blanks. places[i] is the 0-based place of the value of name i in the `values` of
   sig_expression_evaluate, which may have values of other names, too. Returns a code from above. On SIG_EXPRESSION_OK
   *expression must be freed; else it is NULL, *position is the 0-based place in the text (-1 unknown), and `token` and
   `message` are null-terminated texts of at most `size` bytes. */
int sig_expression_create(const char *text, size_t text_length, const char *names, size_t name_width, int n_names,
                          const int *places, sig_expression **expression, int *position, char *token, char *message,
                          size_t size);

/* Computes the value of the expression for `values`; the places of sig_expression_create say which value belongs to
 * which name. Returns 1 when the result is finite, else 0. */
int sig_expression_evaluate(sig_expression *expression, const double *values, double *result);

/* Returns 1 when name `i` (0-based) occurs in the text, whatever its value, else 0. */
int sig_expression_uses(sig_expression *expression, int i);

void sig_expression_free(sig_expression *expression);

#endif
