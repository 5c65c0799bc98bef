/* SPDX-License-Identifier: BSD-3-Clause */
#include <limits.h>
#include <stdlib.h>
#include <string.h>

#include "gmsh_content.h"

/* Reads a number from `min` to `max` that fits an int; `scan` reads it in the form that the file has. */
static bool scan_bounded(sig_scanner *scanner, bool (*scan)(sig_scanner *, int64_t *), int64_t min, int64_t max,
                         const char *what, int *value) {
  int64_t number;
  const size_t at = sig_scan_here(scanner);
  if (!scan(scanner, &number)) return false;
  if (number < min || number > max)
    return sig_scan_fail(scanner, at, "$%s has %lld as %s; it must be between %lld and %lld", scanner->section,
                         (long long)number, what, (long long)min, (long long)max);
  *value = (int)number;
  return true;
}

/* Reads the number of a node or an element. gmsh counts from 1, other programs from 0. */
static bool scan_number(sig_scanner *scanner, bool (*scan)(sig_scanner *, int64_t *), const char *what, int *number) {
  return scan_bounded(scanner, scan, 0, INT_MAX, what, number);
}

static bool scan_tag(sig_scanner *scanner, bool (*scan)(sig_scanner *, int64_t *), const char *what, int *tag) {
  return scan_bounded(scanner, scan, 1, INT_MAX, what, tag);
}

/* Reads a physical tag. gmsh writes it as a negative number if the orientation of the entity is reversed. */
static bool scan_physical_tag(sig_scanner *scanner, int *tag) {
  if (!scan_bounded(scanner, sig_scan_int, -INT_MAX, INT_MAX, "a physical tag", tag)) return false;
  *tag = abs(*tag);
  return true;
}

/* Gives a name, which stands from byte `start` to the current place, to a physical group. */
static bool set_name(sig_gmsh *mesh, int n_dim, int tag, size_t start, const sig_gmsh_group_record *name) {
  sig_scanner *s = &mesh->scanner;
  const int row = sig_gmsh_group_row(mesh, n_dim, tag, false);
  if (row < 0) return false;
  sig_gmsh_group_record *group = (sig_gmsh_group_record *)mesh->groups.items + row;
  if (group->name_length > 0)
    return sig_scan_fail(s, start, "physical group %d (dimension %d) has two names", tag, n_dim);
  group->name_at = name->name_at;
  group->name_length = name->name_length;
  group->is_of_any_dimension = name->is_of_any_dimension;
  return true;
}

/* Reads the numbers of a line of $PhysicalNames: dimension and tag; the tag alone in format 2.0. A name without a
 * dimension, or with the dimension -1, is one of groups of any dimension. */
static bool scan_name_numbers(sig_gmsh *mesh, int *n_dim, int *tag) {
  sig_scanner *s = &mesh->scanner;
  const sig_scanner before = *s;
  if (mesh->version == 20) {
    *n_dim = -1;
    if (!scan_tag(s, sig_scan_quoted_int, "a physical tag", tag)) return false;
    sig_scan_skip_space(s);
    if (s->at < s->size && s->bytes[s->at] == '"') return true;
    s->at = before.at;
  }
  return scan_bounded(s, sig_scan_word_int, -1, 3, "a dimension", n_dim) &&
         scan_tag(s, sig_scan_quoted_int, "a physical tag", tag);
}

/* Reads a line of $PhysicalNames: dimension, tag, "name". What other programs write behind the name is skipped. */
static bool scan_name(sig_gmsh *mesh) {
  sig_scanner *s = &mesh->scanner;
  int n_dim, tag;
  if (!scan_name_numbers(mesh, &n_dim, &tag) || !sig_scan_expect(s, "\"")) return false;
  const size_t start = s->at;
  while (s->at < s->size && s->bytes[s->at] != '"' && s->bytes[s->at] != '\n' && s->bytes[s->at] != '\0') s->at++;
  if (s->at >= s->size || s->bytes[s->at] != '"')
    return sig_scan_fail(s, start, "a physical name has no closing quote");
  const size_t length = s->at - start;
  sig_scan_skip_line(s);
  if (length == 0) return true; /* as without a name */
  const sig_gmsh_group_record named = {
      .name_at = mesh->names.n, .name_length = length, .is_of_any_dimension = n_dim < 0};
  char *name = sig_list_add(s, &mesh->names, length, 1);
  if (name == NULL) return false;
  memcpy(name, s->bytes + start, length);
  if (n_dim >= 0) return set_name(mesh, n_dim, tag, start, &named);
  for (n_dim = 0; n_dim < 4; n_dim++)
    if (!set_name(mesh, n_dim, tag, start, &named)) return false;
  return true;
}

bool sig_gmsh_scan_names(sig_gmsh *mesh) {
  int64_t count;
  if (!sig_scan_word_int(&mesh->scanner, &count)) return false;
  if (!sig_scan_check_count(&mesh->scanner, count, 7, "names")) return false;
  for (int64_t i = 0; i < count; i++)
    if (!scan_name(mesh)) return false;
  return true;
}

/* Reads the physical tags of the present entity. */
static bool scan_entity_groups(sig_gmsh *mesh, int n_dim) {
  sig_scanner *s = &mesh->scanner;
  int64_t count;
  if (!sig_scan_size(s, &count) || !sig_scan_check_count(s, count, 2, "physical tags")) return false;
  for (int64_t i = 0; i < count; i++) {
    int tag;
    if (!scan_physical_tag(s, &tag)) return false;
    int *row = sig_list_add(s, &mesh->entity_groups, 1, sizeof *row);
    if (row == NULL) return false;
    *row = sig_gmsh_group_row(mesh, n_dim, tag, false);
    if (*row < 0) return false;
  }
  return true;
}

/* Reads an entity: tag, box (a point of format 4.1: its place), physical tags, bounding entities. */
static bool scan_entity(sig_gmsh *mesh, int n_dim) {
  sig_scanner *s = &mesh->scanner;
  const size_t first_group = mesh->entity_groups.n;
  int tag;
  double bound;
  if (!scan_bounded(s, sig_scan_int, INT_MIN, INT_MAX, "an entity tag", &tag)) return false;
  for (int i = 0; i < (n_dim == 0 && mesh->version > 40 ? 3 : 6); i++)
    if (!sig_scan_real(s, &bound)) return false;
  if (!scan_entity_groups(mesh, n_dim)) return false;
  sig_gmsh_entity *entity = sig_list_add(s, &mesh->entities, 1, sizeof *entity);
  if (entity == NULL) return false;
  *entity = (sig_gmsh_entity){n_dim, tag, first_group, mesh->entity_groups.n - first_group};
  if (n_dim == 0) return true;
  int64_t count, bounding;
  if (!sig_scan_size(s, &count) || !sig_scan_check_count(s, count, 2, "bounding entities")) return false;
  for (int64_t i = 0; i < count; i++)
    if (!sig_scan_int(s, &bounding)) return false;
  return true;
}

static int compare_entities(const void *first, const void *second) {
  const sig_gmsh_entity *a = first, *b = second;
  if (a->n_dim != b->n_dim) return a->n_dim < b->n_dim ? -1 : 1;
  return (a->tag > b->tag) - (a->tag < b->tag);
}

bool sig_gmsh_scan_entities(sig_gmsh *mesh) {
  int64_t counts[4];
  for (int n_dim = 0; n_dim < 4; n_dim++)
    if (!sig_scan_size(&mesh->scanner, &counts[n_dim])) return false;
  for (int n_dim = 0; n_dim < 4; n_dim++) {
    if (!sig_scan_check_count(&mesh->scanner, counts[n_dim], 8, "entities")) return false;
    for (int64_t i = 0; i < counts[n_dim]; i++)
      if (!scan_entity(mesh, n_dim)) return false;
  }
  if (mesh->entities.n > 0) qsort(mesh->entities.items, mesh->entities.n, sizeof(sig_gmsh_entity), compare_entities);
  return true;
}

static bool start_nodes(sig_gmsh *mesh, int64_t count) {
  sig_scanner *s = &mesh->scanner;
  if (mesh->has_nodes) return sig_scan_fail(s, s->at, "the file has two $Nodes sections");
  if (!sig_scan_check_count(s, count, 4, "nodes")) return false;
  if (count > INT_MAX / 4)
    return sig_scan_fail(s, s->at, "%lld nodes are more than this program can number", (long long)count);
  mesh->node_tags = sig_scan_allocate(s, (size_t)count, sizeof *mesh->node_tags);
  mesh->coordinates = sig_scan_allocate(s, (size_t)count * 3, sizeof *mesh->coordinates);
  mesh->n_nodes = (int)count;
  mesh->has_nodes = true;
  return mesh->node_tags != NULL && mesh->coordinates != NULL;
}

static bool scan_point(sig_scanner *s, double *coordinates) {
  return sig_scan_real(s, coordinates) && sig_scan_real(s, coordinates + 1) && sig_scan_real(s, coordinates + 2);
}

static bool scan_nodes_2(sig_gmsh *mesh) {
  sig_scanner *s = &mesh->scanner;
  int64_t count;
  if (!sig_scan_word_int(s, &count) || !start_nodes(mesh, count)) return false;
  if (s->is_binary) sig_scan_skip_line(s);
  for (int i = 0; i < mesh->n_nodes; i++)
    if (!scan_number(s, sig_scan_int, "a node number", &mesh->node_tags[i]) ||
        !scan_point(s, mesh->coordinates + 3 * (size_t)i))
      return false;
  return true;
}

/* Reads the dimension and the tag of the entity of a block; format 4.0 has the tag first. */
static bool scan_block_entity(sig_gmsh *mesh, int *n_dim, int *tag) {
  sig_scanner *s = &mesh->scanner;
  if (mesh->version == 40 && !scan_bounded(s, sig_scan_int, INT_MIN, INT_MAX, "an entity tag", tag)) return false;
  if (!scan_bounded(s, sig_scan_int, 0, 3, "a dimension", n_dim)) return false;
  return mesh->version == 40 || scan_bounded(s, sig_scan_int, INT_MIN, INT_MAX, "an entity tag", tag);
}

/* Reads the place of a node, and skips the n_parameters that follow it. */
static bool scan_place(sig_scanner *s, int n_parameters, double *coordinates) {
  double parameter;
  if (!scan_point(s, coordinates)) return false;
  for (int i = 0; i < n_parameters; i++)
    if (!sig_scan_real(s, &parameter)) return false;
  return true;
}

/* Reads a block of nodes: all numbers, then all coordinates; in format 4.0 each number before its coordinates. *n_done
 * is the number of nodes that have been read, before and after the call. */
static bool scan_node_block(sig_gmsh *mesh, int *n_done) {
  sig_scanner *s = &mesh->scanner;
  int n_dim, entity, is_parametric;
  int64_t count;
  if (!scan_block_entity(mesh, &n_dim, &entity)) return false;
  if (!scan_bounded(s, sig_scan_int, 0, 1, "the mark of parametric nodes", &is_parametric) || !sig_scan_size(s, &count))
    return false;
  if (count < 0 || count > mesh->n_nodes - *n_done)
    return sig_scan_fail(s, s->at, "the blocks of $Nodes do not fit the %d nodes that it announces", mesh->n_nodes);
  const bool is_in_turn = mesh->version == 40;
  for (int i = *n_done; !is_in_turn && i < *n_done + (int)count; i++)
    if (!scan_number(s, sig_scan_size, "a node number", &mesh->node_tags[i])) return false;
  for (int i = *n_done; i < *n_done + (int)count; i++) {
    if (is_in_turn && !scan_number(s, sig_scan_int, "a node number", &mesh->node_tags[i])) return false;
    if (!scan_place(s, is_parametric ? n_dim : 0, mesh->coordinates + 3 * (size_t)i)) return false;
  }
  *n_done += (int)count;
  return true;
}

/* Reads the numbers of blocks and of things in them, then in format 4.1 the lowest and the highest number of a thing.
 */
static bool scan_block_counts(sig_gmsh *mesh, int64_t *n_blocks, int64_t *count) {
  sig_scanner *s = &mesh->scanner;
  int64_t limit;
  if (!sig_scan_size(s, n_blocks) || !sig_scan_size(s, count)) return false;
  return mesh->version == 40 || (sig_scan_size(s, &limit) && sig_scan_size(s, &limit));
}

static bool scan_nodes_4(sig_gmsh *mesh) {
  sig_scanner *s = &mesh->scanner;
  int64_t n_blocks, count;
  if (!scan_block_counts(mesh, &n_blocks, &count)) return false;
  if (!sig_scan_check_count(s, n_blocks, 4, "blocks") || !start_nodes(mesh, count)) return false;
  int n_done = 0;
  for (int64_t i = 0; i < n_blocks; i++)
    if (!scan_node_block(mesh, &n_done)) return false;
  if (n_done < mesh->n_nodes)
    return sig_scan_fail(s, s->at, "$Nodes announces %d nodes, its blocks hold %d", mesh->n_nodes, n_done);
  return true;
}

bool sig_gmsh_scan_nodes(sig_gmsh *mesh) { return mesh->version < 40 ? scan_nodes_2(mesh) : scan_nodes_4(mesh); }

static bool scan_type(sig_scanner *s, const sig_gmsh_element_type **type) {
  int64_t number;
  const size_t at = sig_scan_here(s);
  if (!sig_scan_int(s, &number)) return false;
  *type = sig_gmsh_find_type(number);
  if (*type == NULL)
    return sig_scan_fail(s, at,
                         "elements of gmsh type %lld are not supported; lines, triangles, quadrilaterals, tetrahedra, "
                         "hexahedra, prisms and pyramids of the first and the second order are supported",
                         (long long)number);
  if (!(*type)->is_supported)
    return sig_scan_fail(
        s, at,
        "the mesh has a %s, which is not supported; supported are lines, triangles, quadrilaterals, tetrahedra, "
        "hexahedra, prisms and pyramids of the first and the second order%s",
        (*type)->name, number > 20 ? " (set Mesh.ElementOrder = 2)" : "");
  return true;
}

/* Appends an element, whose nodes come next in the file. */
static bool scan_element_nodes(sig_gmsh *mesh, const sig_gmsh_element_type *type, int tag, size_t at) {
  sig_scanner *s = &mesh->scanner;
  const size_t n = (size_t)type->n_nodes, first_node = mesh->element_nodes.n;
  int64_t *nodes = sig_list_add(s, &mesh->element_nodes, n, sizeof *nodes);
  if (nodes == NULL) return false;
  for (size_t i = 0; i < n; i++)
    if (!(mesh->version < 41 ? sig_scan_int(s, &nodes[i]) : sig_scan_size(s, &nodes[i]))) return false;
  sig_gmsh_element *element = sig_list_add(s, &mesh->elements, 1, sizeof *element);
  if (element == NULL) return false;
  *element = (sig_gmsh_element){.type = type->type, .tag = tag, .at = at, .first_node = first_node};
  return mesh->element_nodes.n < INT_MAX ||
         sig_scan_fail(s, at, "the mesh has more elements than this program can number");
}

/* Adds the last element to the group in this row. */
static bool add_membership(sig_gmsh *mesh, int row) {
  sig_scanner *s = &mesh->scanner;
  if (row < 0) return false;
  ((sig_gmsh_group_record *)mesh->groups.items)[row].has_members = true;
  sig_gmsh_member *member = sig_list_add(s, &mesh->members, 1, sizeof *member);
  if (member == NULL) return false;
  *member = (sig_gmsh_member){(int)mesh->elements.n - 1, row};
  return mesh->members.n < INT_MAX ||
         sig_scan_fail(s, s->at, "the mesh has more elements than this program can number");
}

/* Reads the tags of an element of format 2: physical group, entity (0 where the file has none); those of partitions
 * are skipped. */
static bool scan_tags_2(sig_scanner *s, int64_t n_tags, int *physical, int *entity) {
  int64_t partition;
  *physical = 0;
  *entity = 0;
  if (!sig_scan_check_count(s, n_tags, 2, "tags of an element")) return false;
  if (n_tags > 0 && !scan_physical_tag(s, physical)) return false;
  if (n_tags > 1 && !scan_bounded(s, sig_scan_int, INT_MIN, INT_MAX, "an entity tag", entity)) return false;
  for (int64_t i = 2; i < n_tags; i++)
    if (!sig_scan_int(s, &partition)) return false;
  return true;
}

/* Adds the last element to its physical group; to its entity where it has none. */
static bool add_to_group_2(sig_gmsh *mesh, int n_dim, int physical, int entity) {
  const bool is_entity = physical == 0;
  return add_membership(mesh, sig_gmsh_group_row(mesh, n_dim, is_entity ? entity : physical, is_entity));
}

/* Reads an element of format 1.0: number, type, physical group, entity, number of nodes, nodes. */
static bool scan_element_1(sig_gmsh *mesh) {
  sig_scanner *s = &mesh->scanner;
  const size_t at = sig_scan_here(s);
  const sig_gmsh_element_type *type;
  int tag, physical, entity, n_nodes;
  if (!scan_number(s, sig_scan_int, "an element number", &tag) || !scan_type(s, &type)) return false;
  if (!scan_physical_tag(s, &physical) || !scan_bounded(s, sig_scan_int, INT_MIN, INT_MAX, "an entity tag", &entity) ||
      !scan_bounded(s, sig_scan_int, type->n_nodes, type->n_nodes, "the number of nodes of an element", &n_nodes))
    return false;
  return scan_element_nodes(mesh, type, tag, at) && add_to_group_2(mesh, type->n_dim, physical, entity);
}

static bool scan_element_2(sig_gmsh *mesh, const sig_gmsh_element_type *type, int64_t n_tags) {
  sig_scanner *s = &mesh->scanner;
  const size_t at = sig_scan_here(s);
  int tag, physical, entity;
  if (!scan_number(s, sig_scan_int, "an element number", &tag)) return false;
  if (type == NULL && (!scan_type(s, &type) || !sig_scan_int(s, &n_tags))) return false;
  if (!scan_tags_2(s, n_tags, &physical, &entity) || !scan_element_nodes(mesh, type, tag, at)) return false;
  return add_to_group_2(mesh, type->n_dim, physical, entity);
}

static bool scan_elements_2(sig_gmsh *mesh) {
  sig_scanner *s = &mesh->scanner;
  int64_t count;
  if (!sig_scan_word_int(s, &count) || !sig_scan_check_count(s, count, 6, "elements")) return false;
  if (s->is_binary) sig_scan_skip_line(s);
  for (int64_t n_done = 0; n_done < count;) {
    if (!s->is_binary) {
      if (!(mesh->version == 10 ? scan_element_1(mesh) : scan_element_2(mesh, NULL, 0))) return false;
      n_done++;
      continue;
    }
    const sig_gmsh_element_type *type;
    int n_follow;
    int64_t n_tags;
    if (!scan_type(s, &type)) return false;
    if (!scan_bounded(s, sig_scan_int, 1, count - n_done, "the number of elements in a block", &n_follow)) return false;
    if (!sig_scan_int(s, &n_tags)) return false;
    for (int i = 0; i < n_follow; i++)
      if (!scan_element_2(mesh, type, n_tags)) return false;
    n_done += n_follow;
  }
  return true;
}

/* Adds the last element, of dimension n_dim, to the physical groups of its entity; to the entity itself where this has
 * none. */
static bool add_to_groups(sig_gmsh *mesh, const sig_gmsh_entity *key, int n_dim) {
  const sig_gmsh_entity *entity = NULL;
  if (mesh->entities.n > 0)
    entity = bsearch(key, mesh->entities.items, mesh->entities.n, sizeof *key, compare_entities);
  if (entity == NULL || entity->n_groups == 0)
    return add_membership(mesh, sig_gmsh_group_row(mesh, n_dim, key->tag, true));
  const int *rows = (const int *)mesh->entity_groups.items + entity->first_group;
  for (size_t i = 0; i < entity->n_groups; i++)
    if (!add_membership(mesh, rows[i])) return false;
  return true;
}

static bool scan_element_block(sig_gmsh *mesh, int64_t *n_done, int64_t n_announced) {
  sig_scanner *s = &mesh->scanner;
  sig_gmsh_entity key;
  const sig_gmsh_element_type *type;
  int64_t count;
  if (!scan_block_entity(mesh, &key.n_dim, &key.tag) || !scan_type(s, &type) || !sig_scan_size(s, &count)) return false;
  if (count < 0 || count > n_announced - *n_done)
    return sig_scan_fail(s, s->at, "the blocks of $Elements do not fit the %lld elements that it announces",
                         (long long)n_announced);
  for (int64_t i = 0; i < count; i++) {
    const size_t at = sig_scan_here(s);
    int tag;
    if (!scan_number(s, mesh->version == 40 ? sig_scan_int : sig_scan_size, "an element number", &tag)) return false;
    if (!scan_element_nodes(mesh, type, tag, at) || !add_to_groups(mesh, &key, type->n_dim)) return false;
  }
  *n_done += count;
  return true;
}

static bool scan_elements_4(sig_gmsh *mesh) {
  sig_scanner *s = &mesh->scanner;
  int64_t n_blocks, count, n_done = 0;
  if (!scan_block_counts(mesh, &n_blocks, &count)) return false;
  if (!sig_scan_check_count(s, n_blocks, 4, "blocks") || !sig_scan_check_count(s, count, 4, "elements")) return false;
  for (int64_t i = 0; i < n_blocks; i++)
    if (!scan_element_block(mesh, &n_done, count)) return false;
  if (n_done < count)
    return sig_scan_fail(s, s->at, "$Elements announces %lld elements, its blocks hold %lld", (long long)count,
                         (long long)n_done);
  return true;
}

bool sig_gmsh_scan_elements(sig_gmsh *mesh) {
  sig_scanner *s = &mesh->scanner;
  if (mesh->has_elements) return sig_scan_fail(s, s->at, "the file has two $Elements sections");
  mesh->has_elements = true;
  return mesh->version < 40 ? scan_elements_2(mesh) : scan_elements_4(mesh);
}
