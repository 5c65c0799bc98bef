/* SPDX-License-Identifier: BSD-3-Clause */
#include <limits.h>
#include <string.h>

#include "gmsh_content.h"

/* Reads a text in quotes, and appends it to the list of names. */
static bool scan_quoted(sig_gmsh *mesh, size_t *name_at, size_t *name_length) {
  sig_scanner *s = &mesh->scanner;
  if (!sig_scan_expect(s, "\"")) return false;
  const size_t start = s->at;
  while (s->at < s->size && s->bytes[s->at] != '"' && s->bytes[s->at] != '\n' && s->bytes[s->at] != '\0') s->at++;
  if (s->at >= s->size || s->bytes[s->at] != '"')
    return sig_scan_fail(s, start, "a text of $NodeData has no closing quote");
  *name_length = s->at++ - start;
  *name_at = mesh->names.n;
  if (*name_length == 0) return true;
  char *name = sig_list_add(s, &mesh->names, *name_length, 1);
  if (name == NULL) return false;
  memcpy(name, s->bytes + start, *name_length);
  return true;
}

static bool scan_count(sig_scanner *s, size_t min_bytes, const char *things, int64_t *count) {
  return sig_scan_word_int(s, count) && sig_scan_check_count(s, *count, min_bytes, things);
}

/* Reads the head of $NodeData: texts, of which the first is the name; numbers; whole numbers: step, components, nodes.
 */
static bool scan_header(sig_gmsh *mesh, sig_gmsh_field_record *field, int64_t *n_values) {
  sig_scanner *s = &mesh->scanner;
  int64_t count, number;
  double ignored;
  size_t name_at, name_length;
  if (!scan_count(s, 2, "texts", &count)) return false;
  for (int64_t i = 0; i < count; i++) {
    if (!scan_quoted(mesh, &name_at, &name_length)) return false;
    if (i > 0) continue;
    field->name_at = name_at;
    field->name_length = name_length;
  }
  if (!scan_count(s, 2, "numbers", &count)) return false;
  for (int64_t i = 0; i < count; i++)
    if (!sig_scan_any_real(s, &ignored)) return false;
  if (!scan_count(s, 2, "whole numbers", &count)) return false;
  if (count < 3) return sig_scan_fail(s, s->at, "$NodeData has %lld whole numbers; it needs 3", (long long)count);
  for (int64_t i = 0; i < count; i++) {
    if (!sig_scan_word_int(s, &number)) return false;
    if (i == 1 && (number < 1 || number > 9))
      return sig_scan_fail(s, s->at, "$NodeData has %lld components; there may be 1 to 9", (long long)number);
    if (i == 1) field->n_components = (int)number;
    if (i == 2) *n_values = number;
  }
  return true;
}

/* Reads the number of one node and the components of its value. */
static bool scan_value(sig_scanner *s, int n_components, int *tag, double *value) {
  int64_t number;
  double component;
  const size_t at = sig_scan_here(s);
  if (!sig_scan_int(s, &number)) return false;
  if (number < 0 || number > INT_MAX)
    return sig_scan_fail(s, at, "$NodeData has %lld as a node number; it must be between 0 and %d", (long long)number,
                         INT_MAX);
  *tag = (int)number;
  for (int i = 0; i < n_components; i++) {
    if (!sig_scan_any_real(s, &component)) return false;
    if (i == 0) *value = component;
  }
  return true;
}

bool sig_gmsh_scan_node_data(sig_gmsh *mesh) {
  sig_scanner *s = &mesh->scanner;
  sig_gmsh_field_record field = {.first_value = mesh->field_tags.n};
  int64_t n_values = 0;
  const bool is_binary = s->is_binary;
  s->is_binary = false; /* the header is text also in a binary file */
  const bool has_header = scan_header(mesh, &field, &n_values);
  s->is_binary = is_binary;
  if (!has_header || !sig_scan_check_count(s, n_values, 4, "nodes")) return false;
  if (n_values > INT_MAX) return sig_scan_fail(s, s->at, "$NodeData has more nodes than this program can number");
  if (is_binary) sig_scan_skip_line(s);
  sig_gmsh_field_record *record = sig_list_add(s, &mesh->fields, 1, sizeof *record);
  if (record == NULL) return false;
  *record = field;
  record->n_values = (size_t)n_values;
  if (n_values == 0) return true;
  int *tags = sig_list_add(s, &mesh->field_tags, (size_t)n_values, sizeof *tags);
  double *values = sig_list_add(s, &mesh->field_values, (size_t)n_values, sizeof *values);
  if (tags == NULL || values == NULL) return false;
  for (int64_t i = 0; i < n_values; i++)
    if (!scan_value(s, field.n_components, &tags[i], &values[i])) return false;
  return true;
}
