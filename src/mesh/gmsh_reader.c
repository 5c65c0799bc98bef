/* SPDX-License-Identifier: BSD-3-Clause */
#include "signorom/gmsh_reader.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "gmsh_content.h"
#include "signorom/checksum.h"
#include "signorom/file_system.h"
#include "signorom/system.h"

/* How gmsh writes a file in a format that we read. */
#define WRITE_ANEW "write the mesh in format 4.1: gmsh part.msh -save -format msh41 -o new.msh"

/* Reads the integer 1 of a binary file, and so finds the byte order of its numbers. */
static bool scan_byte_order(sig_scanner *s) {
  int64_t one;
  if (!sig_scan_int(s, &one)) return false;
  s->is_swapped = one == 0x01000000;
  if (one != 1 && !s->is_swapped)
    return sig_scan_fail(s, s->at - 4, "$MeshFormat lacks the 1 that tells the byte order");
  return true;
}

/* Reads $MeshFormat: version, file type, size of size_t. In a binary file the integer 1 follows, which shows the byte
 * order. */
static bool scan_format(sig_gmsh *mesh) {
  sig_scanner *s = &mesh->scanner;
  double version;
  int64_t is_binary, data_size;
  const size_t at = sig_scan_here(s);
  if (!sig_scan_real(s, &version)) return false;
  if (!sig_scan_word_int(s, &is_binary) || !sig_scan_word_int(s, &data_size)) return false;
  const double known[] = {2.0, 2.1, 2.2, 4.0, 4.1};
  for (size_t i = 0; i < sizeof known / sizeof known[0]; i++)
    if (version == known[i]) mesh->version = (int)(10 * known[i] + 0.5);
  if (mesh->version == 0) return sig_scan_fail(s, at, "gmsh format %.1f is not supported; " WRITE_ANEW, version);
  if (is_binary != 0 && is_binary != 1)
    return sig_scan_fail(s, at, "the file type in $MeshFormat must be 0 (text) or 1 (binary)");
  if (is_binary == 0) return true;
  /* the size of a real number before format 4.1, which is 8 on all machines */
  if (data_size != 8 && (data_size != 4 || mesh->version != 41))
    return sig_scan_fail(s, at, "the data size in $MeshFormat is %lld; binary files need 8 (4.1: 8 or 4)",
                         (long long)data_size);
  s->has_short_sizes = data_size == 4;
  sig_scan_skip_line(s);
  s->is_binary = true;
  return scan_byte_order(s);
}

/* Skips a section that we do not need, whatever bytes it has, up to its end mark. */
static bool skip_section(sig_scanner *s) {
  const size_t length = strlen(s->section);
  for (; s->at < s->size; s->at++) {
    const char *mark = memchr(s->bytes + s->at, '$', s->size - s->at);
    if (mark == NULL) break;
    s->at = (size_t)(mark - s->bytes);
    if (s->size - s->at >= length + 4 && memcmp(mark + 1, "End", 3) == 0 && memcmp(mark + 4, s->section, length) == 0)
      return true;
  }
  s->at = s->size;
  return sig_scan_fail(s, s->size, "the file ends inside $%s; it was cut off or is not complete", s->section);
}

static bool starts_with(const sig_scanner *s, const char *word) {
  return s->size - s->at >= strlen(word) && strncmp(s->bytes + s->at, word, strlen(word)) == 0;
}

/* Reads `$Name` at the current place into `name`. */
static bool scan_section_name(sig_scanner *s, char *name, size_t room) {
  size_t n = 0;
  const size_t at = sig_scan_here(s);
  for (s->at++; s->at < s->size && n + 1 < room; s->at++) {
    const char letter = s->bytes[s->at];
    if (!((letter >= 'a' && letter <= 'z') || (letter >= 'A' && letter <= 'Z'))) break;
    name[n++] = letter;
  }
  name[n] = '\0';
  if (n == 0) return sig_scan_fail(s, at, "a section without a name");
  return true;
}

static bool scan_section_content(sig_gmsh *mesh, const char *name) {
  sig_scanner *s = &mesh->scanner;
  if (mesh->version == 10 && strcmp(name, "NOD") == 0) return sig_gmsh_scan_nodes(mesh);
  if (mesh->version == 10 && strcmp(name, "ELM") == 0) return sig_gmsh_scan_elements(mesh);
  if (strcmp(name, "MeshFormat") == 0) return sig_scan_fail(s, s->at, "the file has two $MeshFormat sections");
  if (mesh->is_for_fields && strcmp(name, "NodeData") == 0) return sig_gmsh_scan_node_data(mesh);
  if (mesh->is_for_fields && strcmp(name, "Nodes") != 0) return skip_section(s);
  if (strcmp(name, "PartitionedEntities") == 0)
    return sig_scan_fail(s, s->at,
                         "the mesh is partitioned; write it without partitions: echo 'Merge \"part.msh\"; "
                         "UnpartitionMesh;' > whole.geo; gmsh whole.geo -save -format msh41 -o whole.msh (with a "
                         "Merge for each file, if there are several)");
  if (strcmp(name, "PhysicalNames") == 0) return sig_gmsh_scan_names(mesh);
  if (strcmp(name, "Nodes") == 0) return sig_gmsh_scan_nodes(mesh);
  if (strcmp(name, "Elements") == 0) return sig_gmsh_scan_elements(mesh);
  if (strcmp(name, "Entities") != 0 || mesh->version < 40) return skip_section(s);
  if (mesh->entities.n > 0 || mesh->has_elements)
    return sig_scan_fail(s, s->at, "$Entities must stand once, before $Elements");
  return sig_gmsh_scan_entities(mesh);
}

static bool scan_section(sig_gmsh *mesh) {
  sig_scanner *s = &mesh->scanner;
  char name[64], end_mark[72];
  if (!scan_section_name(s, name, sizeof name)) return false;
  s->section = name;
  (void)snprintf(end_mark, sizeof end_mark, "%s%s",
                 strcmp(name, "NOD") == 0 || strcmp(name, "ELM") == 0 ? "$END" : "$End", name);
  sig_scan_skip_line(s);
  bool is_good = scan_section_content(mesh, name);
  if (is_good) {
    sig_scan_skip_space(s);
    if (s->at < s->size && s->bytes[s->at] != '$')
      is_good = sig_scan_fail(s, s->at, "$%s has more lines than its first one says", name);
    else
      is_good = sig_scan_expect(s, end_mark);
  }
  s->section = "";
  return is_good;
}

/* Takes names without a dimension from the groups that have no elements. */
static void forget_unused_names(sig_gmsh *mesh) {
  sig_gmsh_group_record *groups = mesh->groups.items;
  for (size_t i = 0; i < mesh->groups.n; i++)
    if (groups[i].is_of_any_dimension && !groups[i].has_members) groups[i].name_length = 0;
}

/* Passes $MeshFormat, before which only comments may stand. Format 1.0 has no such section. */
static bool find_format(sig_gmsh *mesh) {
  sig_scanner *s = &mesh->scanner;
  const char *mark = "$MeshFormat", *comments = "$Comments";
  sig_scan_skip_space(s);
  while (starts_with(s, comments)) {
    s->section = comments + 1;
    if (!skip_section(s)) return false;
    sig_scan_skip_line(s);
    sig_scan_skip_space(s);
  }
  if (starts_with(s, "$NOD")) {
    mesh->version = 10;
    return true;
  }
  if (!starts_with(s, mark))
    return sig_scan_fail(s, s->at,
                         "not a gmsh mesh file: it does not start with $MeshFormat; meshes of other programs "
                         "become one by signorom-post convert");
  s->at += strlen(mark);
  return true;
}

static bool scan_file(sig_gmsh *mesh) {
  sig_scanner *s = &mesh->scanner;
  if (!find_format(mesh)) return false;
  s->section = "MeshFormat";
  if (mesh->version == 0 && (!scan_format(mesh) || !sig_scan_expect(s, "$EndMeshFormat"))) return false;
  for (;;) {
    sig_scan_skip_space(s);
    if (s->at >= s->size) break;
    if (s->bytes[s->at] != '$') return sig_scan_fail(s, s->at, "text outside of the sections; a section starts with $");
    if (!scan_section(mesh)) return false;
  }
  forget_unused_names(mesh);
  if (!mesh->is_for_fields && (!mesh->has_nodes || !mesh->has_elements))
    return sig_scan_fail(s, s->size, "the file has no $%s section; it was cut off or is not complete",
                         mesh->has_nodes ? "Elements" : "Nodes");
  return true;
}

typedef struct {
  int tag, node;
} sig_numbered_node;

static int compare_numbered(const void *first, const void *second) {
  const sig_numbered_node *a = first, *b = second;
  return (a->tag > b->tag) - (a->tag < b->tag);
}

/* Returns the node numbers of the file in ascending order; null when out of memory or when a number occurs twice. */
static sig_numbered_node *sort_nodes(sig_gmsh *mesh) {
  sig_scanner *s = &mesh->scanner;
  const size_t n = (size_t)mesh->n_nodes;
  sig_numbered_node *sorted = sig_scan_allocate(s, n, sizeof *sorted);
  if (sorted == NULL) return NULL;
  for (size_t i = 0; i < n; i++) sorted[i] = (sig_numbered_node){.tag = mesh->node_tags[i], .node = (int)i};
  qsort(sorted, n, sizeof *sorted, compare_numbered); /* never null, even without nodes */
  for (size_t i = 1; i < n; i++) {
    if (sorted[i].tag != sorted[i - 1].tag) continue;
    (void)sig_scan_fail(s, SIG_SCAN_NOWHERE, "node number %d occurs twice", sorted[i].tag);
    free(sorted);
    return NULL;
  }
  return sorted;
}

/* Replaces the node numbers of the elements by 0-based nodes. */
static bool resolve_nodes(sig_gmsh *mesh) {
  sig_numbered_node *sorted = sort_nodes(mesh);
  if (sorted == NULL) return false;
  bool is_good = true;
  const sig_gmsh_element *elements = mesh->elements.items;
  int64_t *nodes = mesh->element_nodes.items;
  for (size_t i = 0, e = 0; i < mesh->element_nodes.n && is_good; i++) {
    while (e + 1 < mesh->elements.n && elements[e + 1].first_node <= i) e++;
    const sig_numbered_node key = {.tag = nodes[i] >= 0 && nodes[i] <= INT_MAX ? (int)nodes[i] : -1};
    const sig_numbered_node *found = bsearch(&key, sorted, (size_t)mesh->n_nodes, sizeof key, compare_numbered);
    if (found == NULL)
      is_good = sig_scan_fail(&mesh->scanner, elements[e].at, "element %d has node %lld, which $Nodes lacks",
                              elements[e].tag, (long long)nodes[i]);
    else
      nodes[i] = found->node;
  }
  free(sorted);
  return is_good;
}

/* Finds the lines and columns of all elements; the elements are in the order of the file. */
static void find_places(sig_gmsh *mesh) {
  const sig_scanner *s = &mesh->scanner;
  if (s->is_binary) return;
  sig_gmsh_element *elements = mesh->elements.items;
  int line = 1;
  size_t start = 0;
  for (size_t i = 0, at = 0; i < mesh->elements.n; i++) {
    for (; at < elements[i].at; at++) {
      if (s->bytes[at] != '\n') continue;
      line++;
      start = at + 1;
    }
    elements[i].line = line;
    elements[i].column = (int)(elements[i].at - start) + 1;
  }
}

static int parse(const char *bytes, size_t n_bytes, bool is_for_fields, sig_gmsh **mesh) {
  *mesh = calloc(1, sizeof **mesh);
  char *copy = malloc(n_bytes + 1);
  if (*mesh == NULL || copy == NULL) {
    free(copy);
    return SIG_GMSH_NO_MEMORY;
  }
  if (n_bytes > 0) memcpy(copy, bytes, n_bytes);
  copy[n_bytes] = '\0';
  (*mesh)->is_for_fields = is_for_fields;
  sig_scanner *s = &(*mesh)->scanner;
  s->bytes = copy;
  s->size = n_bytes;
  (*mesh)->hash = sig_fnv1a(bytes, n_bytes, SIG_FNV1A_SEED);
  const bool is_good = scan_file(*mesh) && (is_for_fields || resolve_nodes(*mesh));
  if (is_good) find_places(*mesh);
  s->bytes = NULL;
  free(copy);
  if (is_good) return SIG_GMSH_OK;
  return s->is_out_of_memory ? SIG_GMSH_NO_MEMORY : SIG_GMSH_INVALID;
}

int sig_gmsh_parse(const char *bytes, size_t n_bytes, sig_gmsh **mesh) { return parse(bytes, n_bytes, false, mesh); }

static int read_file(const char *path, size_t length, bool is_for_fields, sig_gmsh **mesh) {
  char *bytes = NULL;
  size_t n_bytes = 0;
  const int code = sig_read_file(path, length, &bytes, &n_bytes);
  if (code == 0) {
    const int status = parse(bytes, n_bytes, is_for_fields, mesh);
    sig_free(bytes);
    return status;
  }
  *mesh = calloc(1, sizeof **mesh);
  if (*mesh == NULL) return SIG_GMSH_NO_MEMORY;
  (*mesh)->n_nodes = code;
  return SIG_GMSH_UNREADABLE;
}

int sig_gmsh_read(const char *path, size_t length, sig_gmsh **mesh) { return read_file(path, length, false, mesh); }

int sig_gmsh_read_fields(const char *path, size_t length, sig_gmsh **fields) {
  return read_file(path, length, true, fields);
}

void sig_gmsh_message(const sig_gmsh *mesh, char message[SIG_GMSH_MESSAGE_SIZE], int *line) {
  memcpy(message, mesh->scanner.message, SIG_GMSH_MESSAGE_SIZE);
  *line = mesh->scanner.line;
}

uint64_t sig_gmsh_hash(const sig_gmsh *mesh) { return mesh->hash; }

void sig_gmsh_sizes(const sig_gmsh *mesh, int sizes[5]) {
  sizes[0] = mesh->n_nodes;
  sizes[1] = (int)mesh->elements.n;
  sizes[2] = (int)mesh->element_nodes.n;
  sizes[3] = (int)mesh->members.n;
  sizes[4] = (int)mesh->groups.n;
}

void sig_gmsh_nodes(const sig_gmsh *mesh, int *tags, double *coordinates) {
  const size_t n = (size_t)mesh->n_nodes;
  if (n == 0) return;
  memcpy(tags, mesh->node_tags, n * sizeof *tags);
  memcpy(coordinates, mesh->coordinates, 3 * n * sizeof *coordinates);
}

void sig_gmsh_elements(const sig_gmsh *mesh, int *types, int *tags, int *places, int *offsets, int *nodes) {
  const sig_gmsh_element *elements = mesh->elements.items;
  const int64_t *element_nodes = mesh->element_nodes.items;
  for (size_t i = 0; i < mesh->elements.n; i++) {
    types[i] = elements[i].type;
    tags[i] = elements[i].tag;
    places[2 * i] = elements[i].line;
    places[2 * i + 1] = elements[i].column;
    offsets[i] = (int)elements[i].first_node;
  }
  offsets[mesh->elements.n] = (int)mesh->element_nodes.n;
  for (size_t i = 0; i < mesh->element_nodes.n; i++) nodes[i] = (int)element_nodes[i];
}

void sig_gmsh_memberships(const sig_gmsh *mesh, int *elements, int *groups) {
  const sig_gmsh_member *members = mesh->members.items;
  for (size_t i = 0; i < mesh->members.n; i++) {
    elements[i] = members[i].element;
    groups[i] = members[i].group;
  }
}

void sig_gmsh_group(const sig_gmsh *mesh, int i, int *n_dim, int *tag, int *is_entity, const char **name,
                    size_t *name_length) {
  const sig_gmsh_group_record *group = (const sig_gmsh_group_record *)mesh->groups.items + i;
  *n_dim = group->n_dim;
  *tag = group->tag;
  *is_entity = group->is_entity;
  *name = mesh->names.items == NULL ? "" : (const char *)mesh->names.items + group->name_at;
  *name_length = group->name_length;
}

int sig_gmsh_n_fields(const sig_gmsh *fields) { return (int)fields->fields.n; }

static const sig_gmsh_field_record *field_record(const sig_gmsh *fields, int i) {
  return (const sig_gmsh_field_record *)fields->fields.items + i;
}

void sig_gmsh_field(const sig_gmsh *fields, int i, int *n_components, int *n_values, const char **name,
                    size_t *name_length) {
  const sig_gmsh_field_record *field = field_record(fields, i);
  *n_components = field->n_components;
  *n_values = (int)field->n_values;
  *name = fields->names.items == NULL ? "" : (const char *)fields->names.items + field->name_at;
  *name_length = field->name_length;
}

void sig_gmsh_field_values(const sig_gmsh *fields, int i, int *tags, double *values) {
  const sig_gmsh_field_record *field = field_record(fields, i);
  if (field->n_values == 0) return;
  memcpy(tags, (const int *)fields->field_tags.items + field->first_value, field->n_values * sizeof *tags);
  memcpy(values, (const double *)fields->field_values.items + field->first_value, field->n_values * sizeof *values);
}

void sig_gmsh_free(sig_gmsh *mesh) {
  if (mesh == NULL) return;
  free(mesh->node_tags);
  free(mesh->coordinates);
  free(mesh->elements.items);
  free(mesh->element_nodes.items);
  free(mesh->members.items);
  free(mesh->groups.items);
  free(mesh->entities.items);
  free(mesh->entity_groups.items);
  free(mesh->names.items);
  free(mesh->fields.items);
  free(mesh->field_tags.items);
  free(mesh->field_values.items);
  free(mesh);
}
