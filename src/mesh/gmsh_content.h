/* SPDX-License-Identifier: BSD-3-Clause */
/* What a .msh file holds, while it is read and after. Private to the gmsh reader. */
#ifndef SIG_GMSH_CONTENT_H
#define SIG_GMSH_CONTENT_H

#include "gmsh_scanner.h"

/* A list that grows; items are of one type, named where the list is declared. */
typedef struct {
  void *items;
  size_t n, room;
} sig_list;

/* Appends `more` zeroed items and returns the first of them; null and a recorded failure when out of memory. */
void *sig_list_add(sig_scanner *scanner, sig_list *list, size_t more, size_t item_size);

typedef struct {
  int type, n_dim, n_nodes;
  bool is_supported;
  const char *name;
} sig_gmsh_element_type;

/* Null where the number is unknown. */
const sig_gmsh_element_type *sig_gmsh_find_type(int64_t type);

/* A physical group; name_length is 0 where $PhysicalNames has no name for it. */
typedef struct {
  int n_dim, tag;
  size_t name_at, name_length; /* in the names of sig_gmsh */
} sig_gmsh_group_record;

/* A geometric entity of format 4.1 with the groups it belongs to. */
typedef struct {
  int n_dim, tag;
  size_t first_group, n_groups; /* in entity_groups of sig_gmsh */
} sig_gmsh_entity;

/* An element of at least one group, as the file has it. */
typedef struct {
  int type, tag;
  size_t at;         /* where in the file, for messages */
  int line, column;  /* the same, 1-based; 0 in a binary file */
  size_t first_node; /* in element_nodes */
} sig_gmsh_element;

/* Values at nodes, of one $NodeData; what it holds of a node stands in one row of each list. */
typedef struct {
  size_t name_at, name_length; /* in the names of sig_gmsh */
  size_t first_value, n_values;
  int n_components;
} sig_gmsh_field_record;

/* Element and group, both 0-based. */
typedef struct {
  int element, group;
} sig_gmsh_member;

struct sig_gmsh {
  sig_scanner scanner;
  int version;   /* 22 or 41 */
  uint64_t hash; /* of the file's bytes */
  int n_nodes;
  int *node_tags;
  double *coordinates;
  bool has_nodes, has_elements;
  bool is_for_fields;     /* $NodeData and $Nodes are read and nothing else; a mesh has no $NodeData */
  sig_list elements;      /* sig_gmsh_element */
  sig_list element_nodes; /* int64_t: node tags, then 0-based nodes once the whole file is read */
  sig_list members;       /* sig_gmsh_member */
  sig_list groups;        /* sig_gmsh_group_record */
  sig_list entities;      /* sig_gmsh_entity */
  sig_list entity_groups; /* int: rows of groups */
  sig_list names;         /* char */
  sig_list fields;        /* sig_gmsh_field_record */
  sig_list field_tags;    /* int: node numbers */
  sig_list field_values;  /* double: the first component */
};

/* Row of the group, made if it is new; -1 when out of memory. */
int sig_gmsh_group_row(sig_gmsh *mesh, int n_dim, int tag);

/* The contents of one section, without its marks. */
bool sig_gmsh_scan_names(sig_gmsh *mesh);
bool sig_gmsh_scan_entities(sig_gmsh *mesh);
bool sig_gmsh_scan_nodes(sig_gmsh *mesh);
bool sig_gmsh_scan_elements(sig_gmsh *mesh);
bool sig_gmsh_scan_node_data(sig_gmsh *mesh);

#endif
