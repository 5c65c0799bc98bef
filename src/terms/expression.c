/* SPDX-License-Identifier: BSD-3-Clause */
/* Calls muParser through its C interface, which throws no exceptions: an error sets a flag, and reading the flag clears
   it. */
#include "signorom/expression.h"

#include <ctype.h>
#include <math.h>
#include <muParserDLL.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The error codes of muParser that `explain` compares with, also as ends of a range; muParser's C header does not name
   them. */
enum {
  MUP_UNEXPECTED_OPERATOR = 0,
  MUP_UNASSIGNABLE_TOKEN = 1,
  MUP_UNEXPECTED_END = 2,
  MUP_UNEXPECTED_PARENTHESIS = 7,
  MUP_MISSING_PARENTHESIS = 11,
  MUP_TOO_MANY_ARGUMENTS = 14,
  MUP_TOO_FEW_ARGUMENTS = 15
};

/* e^2, t0, e / (1 - cos k) and k / (e^2 - t0) for e = 0.1, of src/contact/obstacle_gap.f90 */
static const double wave_start = 0.01, wave_end = 0.002, wave_height = 0.050975268970648836,
                    wave_number = 358.00805906085446;

struct sig_expression {
  muParserHandle_t parser;
  double *values; /* values of the variables; muParser keeps pointers to them */
  int *places;    /* of each name: place of its value among the caller's values */
  bool *is_used;  /* of each name: whether it occurs in the text; null until it is asked for */
  int n_names;
};

/* Where to describe an error: variables of the caller of sig_expression_create. */
typedef struct {
  int *position;
  char *token, *message;
  size_t size;
} complaint_t;

/* How far a sphere is below the plane through its top, at the distance s from its axis, s^2 = a^2 + b^2 + c^2: see
   src/contact/obstacle_gap.f90. As a text muParser would take powers for it, at each of many places. */
static double sphere_depth(double a, double b, double c, double radius) {
  const double squared = a * a + b * b + c * c, rest = radius * radius - squared;
  if (rest > wave_start * radius * radius) return squared / (radius + sqrt(rest));
  const double after_end = rest / (radius * radius) - wave_end;
  if (after_end < 0) return radius;
  return radius * (1 - wave_height * (1 - cos(wave_number * after_end)));
}

static void put(char *target, size_t size, const char *text) { snprintf(target, size, "%s", text ? text : ""); }

/* Finds an assignment (a single '='), by which an expression could change a variable; muParser cannot forbid them. */
static const char *find_assignment(const char *text) {
  for (const char *c = text; *c; c++) {
    if (*c != '=') continue;
    if (c[1] == '=')
      c++;
    else if (c == text || !strchr("<>!=", c[-1]))
      return c;
  }
  return NULL;
}

static int explain(muParserHandle_t parser, const complaint_t *complaint) {
  int code = mupGetErrorCode(parser);
  *complaint->position = mupGetErrorPos(parser);
  put(complaint->token, complaint->size, mupGetErrorToken(parser)); /* the next call of muParser reuses its buffer */
  for (size_t n = strlen(complaint->token); n > 0 && complaint->token[n - 1] == ' '; n--)
    complaint->token[n - 1] = '\0';
  const char *token = complaint->token;
  if (code == MUP_UNASSIGNABLE_TOKEN && (isalpha((unsigned char)token[0]) || token[0] == '_'))
    return SIG_EXPRESSION_UNKNOWN_NAME;
  if (code >= MUP_UNEXPECTED_OPERATOR && code <= MUP_UNEXPECTED_PARENTHESIS && code != MUP_UNEXPECTED_END) {
    snprintf(complaint->message, complaint->size, "'%s' is not expected", token);
    return SIG_EXPRESSION_SYNTAX;
  }
  *complaint->position = -1;
  if (code == MUP_UNEXPECTED_END)
    put(complaint->message, complaint->size, "the expression ends too early");
  else if (code == MUP_MISSING_PARENTHESIS)
    put(complaint->message, complaint->size, "a parenthesis is not closed");
  else if (code == MUP_TOO_MANY_ARGUMENTS || code == MUP_TOO_FEW_ARGUMENTS)
    snprintf(complaint->message, complaint->size, "'%s' has too %s arguments", token,
             code == MUP_TOO_MANY_ARGUMENTS ? "many" : "few");
  else
    put(complaint->message, complaint->size, mupGetErrorMsg(parser));
  if (strncmp(complaint->message, "Internal error", strlen("Internal error")) == 0)
    put(complaint->message, complaint->size,
        "the expression cannot be understood; look for an operator without a number behind it");
  return SIG_EXPRESSION_SYNTAX;
}

static int define_names(sig_expression *expression, const char *names, size_t name_width,
                        const complaint_t *complaint) {
  char *name = malloc(name_width + 1);
  if (!name) return SIG_EXPRESSION_NO_MEMORY;
  int code = SIG_EXPRESSION_OK;
  for (int i = 0; i < expression->n_names && code == SIG_EXPRESSION_OK; i++) {
    size_t length = name_width;
    const char *field = names + (size_t)i * name_width;
    while (length > 0 && field[length - 1] == ' ') length--;
    memcpy(name, field, length);
    name[length] = '\0';
    mupDefineVar(expression->parser, name, &expression->values[i]);
    if (mupError(expression->parser)) {
      put(complaint->token, complaint->size, name);
      code = SIG_EXPRESSION_BAD_NAME;
    }
  }
  free(name);
  return code;
}

/* Compiles the text by one evaluation with all values 1: muParser compiles and finds errors at the first evaluation. */
static int compile(sig_expression *expression, const char *text, const complaint_t *complaint) {
  const char *assignment = find_assignment(text);
  if (assignment) {
    *complaint->position = (int)(assignment - text);
    put(complaint->message, complaint->size, "'=' is not expected ('==' compares)");
    return SIG_EXPRESSION_SYNTAX;
  }
  mupSetExpr(expression->parser, text);
  if (mupError(expression->parser)) return explain(expression->parser, complaint);
  int n_values = 0;
  mupEvalMulti(expression->parser, &n_values);
  if (mupError(expression->parser)) return explain(expression->parser, complaint);
  return n_values == 1 ? SIG_EXPRESSION_OK : SIG_EXPRESSION_SEVERAL;
}

static int build(sig_expression *expression, const char *text, size_t text_length, const char *names, size_t name_width,
                 const complaint_t *complaint) {
  char *copy = malloc(text_length + 1);
  expression->parser = mupCreate(muBASETYPE_FLOAT);
  int code = SIG_EXPRESSION_NO_MEMORY;
  if (copy && expression->parser) {
    memcpy(copy, text, text_length);
    copy[text_length] = '\0';
    mupDefineConst(expression->parser, "_pi",
                   3.14159265358979323846); /* the constant of muParser 2.3.3 ends after 12 decimals */
    mupDefineFun4(expression->parser, "_sphere_depth", sphere_depth, 1);
    for (int i = 0; i < expression->n_names; i++) expression->values[i] = 1.0;
    code = define_names(expression, names, name_width, complaint);
    if (code == SIG_EXPRESSION_OK) code = compile(expression, copy, complaint);
  }
  free(copy);
  return code;
}

static int keep_places(sig_expression *expression, int n_names, const int *places) {
  expression->n_names = n_names;
  expression->values = malloc(((size_t)n_names + 1) * sizeof *expression->values);
  expression->places = malloc(((size_t)n_names + 1) * sizeof *expression->places);
  if (!expression->values || !expression->places) return 0;
  if (n_names > 0) memcpy(expression->places, places, (size_t)n_names * sizeof *places);
  return 1;
}

int sig_expression_create(const char *text, size_t text_length, const char *names, size_t name_width, int n_names,
                          const int *places, sig_expression **expression, int *position, char *token, char *message,
                          size_t size) {
  complaint_t complaint = {.position = position, .token = token, .message = message, .size = size};
  *position = -1;
  token[0] = message[0] = '\0';
  *expression = NULL;
  if (memchr(text, '\0', text_length)) {
    put(message, size, "the expression contains a NUL byte");
    return SIG_EXPRESSION_SYNTAX;
  }
  sig_expression *own = calloc(1, sizeof *own);
  if (!own) return SIG_EXPRESSION_NO_MEMORY;
  int code = SIG_EXPRESSION_NO_MEMORY;
  if (keep_places(own, n_names, places)) code = build(own, text, text_length, names, name_width, &complaint);
  if (code == SIG_EXPRESSION_OK)
    *expression = own;
  else
    sig_expression_free(own);
  return code;
}

int sig_expression_evaluate(sig_expression *expression, const double *values, double *result) {
  for (int i = 0; i < expression->n_names; i++) expression->values[i] = values[expression->places[i]];
  *result = mupEval(expression->parser);
  bool is_failed = mupError(expression->parser);
  return !is_failed && isfinite(*result);
}

// Finds for all names at once whether they occur, because muParser reads the whole text again for each such call.
static bool find_used(sig_expression *expression) {
  expression->is_used = calloc((size_t)expression->n_names + 1, sizeof *expression->is_used);
  if (!expression->is_used) return false;
  const int n_used = mupGetExprVarNum(expression->parser);
  for (int k = 0; k < n_used; k++) {
    const muChar_t *name = NULL;
    muFloat_t *value = NULL;
    mupGetExprVar(expression->parser, (unsigned)k, &name, &value);
    if (value >= expression->values && value < expression->values + expression->n_names)
      expression->is_used[value - expression->values] = true;
  }
  return true;
}

int sig_expression_uses(sig_expression *expression, int i) {
  return (expression->is_used || find_used(expression)) && expression->is_used[i];
}

void sig_expression_free(sig_expression *expression) {
  if (!expression) return;
  if (expression->parser) mupRelease(expression->parser);
  free(expression->is_used);
  free(expression->places);
  free(expression->values);
  free(expression);
}
