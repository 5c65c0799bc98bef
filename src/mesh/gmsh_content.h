/* SPDX-License-Identifier: BSD-3-Clause */
/* The content of a .msh file, while it is read and afterwards. Private to the gmsh reader. */
#ifndef SIG_GMSH_CONTENT_H
#define SIG_GMSH_CONTENT_H

#include "gmsh_scanner.h"

/* A list that grows. All items have the same type, which the comment at the declaration of the list names. */
typedef struct {
  void *items;
  size_t n, room; /* number of items, and number for which there is memory */
} sig_list;

/* Appends `more` items of zeros and returns the first of them. Returns null when out of memory; the scanner records
 * the failure then.
 */
void *sig_list_add(sig_scanner *scanner, sig_list *list, size_t more, size_t item_size);

typedef struct {
  int type, n_dim, n_nodes;
  bool is_supported;
  const char *name;
} sig_gmsh_element_type;

/* Returns the element type with this number of gmsh; null if the number is unknown. */
const sig_gmsh_element_type *sig_gmsh_find_type(int64_t type);

/* A physical group, or a geometric entity whose elements are in no physical group. name_length is 0 if $PhysicalNames
 * has no name for it. */
typedef struct {
  int n_dim, tag;
  bool is_entity;
  bool has_members;            /* some element belongs to it */
  bool is_of_any_dimension;    /* the file gives the name without a dimension, as format 2.0 does */
  size_t name_at, name_length; /* place and length of the name in `names` of sig_gmsh */
  int next;                    /* row of the next group with the same place in `group_heads`, -1 = none */
} sig_gmsh_group_record;

/* Groups are looked up by a table of chains. */
enum { SIG_GMSH_N_HEADS = 1024 };

/* A geometric entity of format 4.0 or 4.1 with the groups it belongs to. */
typedef struct {
  int n_dim, tag;
  size_t first_group, n_groups; /* its groups in `entity_groups` of sig_gmsh */
} sig_gmsh_entity;

/* An element of the file. */
typedef struct {
  int type, tag;
  size_t at;         /* its first byte in the file, for messages */
  int line, column;  /* its line and column, from 1; 0 in a binary file */
  size_t first_node; /* its first node in element_nodes */
} sig_gmsh_element;

/* The values at nodes of one section $NodeData: n_values entries from first_value on of `field_tags` and `field_values`
 * of sig_gmsh. Entry i of both lists belongs to the same node. */
typedef struct {
  size_t name_at, name_length; /* place and length of the name in `names` of sig_gmsh */
  size_t first_value, n_values;
  int n_components;
} sig_gmsh_field_record;

/* An element of a group: the numbers of the element and of the group, both 0-based. */
typedef struct {
  int element, group;
} sig_gmsh_member;

struct sig_gmsh {
  sig_scanner scanner;
  int version;   /* 20, 21, 22, 40 or 41 */
  uint64_t hash; /* checksum of the file's bytes */
  int n_nodes;
  int *node_tags;
  double *coordinates;
  bool has_nodes, has_elements;
  bool is_for_fields;     /* true: only $NodeData and $Nodes are read; false: the mesh is read, without $NodeData */
  sig_list elements;      /* sig_gmsh_element */
  sig_list element_nodes; /* int64_t: node tags; 0-based nodes after the whole file has been read */
  sig_list members;       /* sig_gmsh_member */
  sig_list groups;        /* sig_gmsh_group_record */
  int group_heads[SIG_GMSH_N_HEADS]; /* first row of each chain of groups, counted from 1; 0 = none */
  sig_list entities;                 /* sig_gmsh_entity */
  sig_list entity_groups;            /* int: rows of groups */
  sig_list names;                    /* char */
  sig_list fields;                   /* sig_gmsh_field_record */
  sig_list field_tags;               /* int: node numbers */
  sig_list field_values;             /* double: the first component */
};

/* Returns the row of a physical group, or of an entity (is_entity), in `groups`; a new one gets a new row. -1 when out
 * of memory. */
int sig_gmsh_group_row(sig_gmsh *mesh, int n_dim, int tag, bool is_entity);

/* Read the content of one section, without the marks at its begin and end. They return false after a failure, which the
 * scanner records. */
bool sig_gmsh_scan_names(sig_gmsh *mesh);
bool sig_gmsh_scan_entities(sig_gmsh *mesh);
bool sig_gmsh_scan_nodes(sig_gmsh *mesh);
bool sig_gmsh_scan_elements(sig_gmsh *mesh);
bool sig_gmsh_scan_node_data(sig_gmsh *mesh);

#endif
