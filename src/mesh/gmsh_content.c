/* SPDX-License-Identifier: BSD-3-Clause */
#include "gmsh_content.h"

#include <stdlib.h>
#include <string.h>

static const sig_gmsh_element_type element_types[] = {
    {1, 1, 2, true, "2-node line"},
    {2, 2, 3, true, "3-node triangle"},
    {3, 2, 4, true, "4-node quadrilateral"},
    {4, 3, 4, true, "4-node tetrahedron"},
    {5, 3, 8, true, "8-node hexahedron"},
    {6, 3, 6, true, "6-node prism"},
    {7, 3, 5, true, "5-node pyramid"},
    {8, 1, 3, true, "3-node line"},
    {9, 2, 6, true, "6-node triangle"},
    {10, 2, 9, true, "9-node quadrilateral"},
    {11, 3, 10, true, "10-node tetrahedron"},
    {12, 3, 27, true, "27-node hexahedron"},
    {13, 3, 18, true, "18-node prism"},
    {14, 3, 14, true, "14-node pyramid"},
    {15, 0, 1, true, "point"},
    {16, 2, 8, true, "8-node quadrilateral"},
    {17, 3, 20, true, "20-node hexahedron"},
    {18, 3, 15, true, "15-node prism"},
    {19, 3, 13, true, "13-node pyramid"},
    {21, 2, 10, false, "10-node triangle"},
    {26, 1, 4, false, "4-node line"},
    {29, 3, 20, false, "20-node tetrahedron"},
    {36, 2, 16, false, "16-node quadrilateral"},
    {92, 3, 64, false, "64-node hexahedron"},
};

const sig_gmsh_element_type *sig_gmsh_find_type(int64_t type) {
  for (size_t i = 0; i < sizeof element_types / sizeof element_types[0]; i++)
    if (element_types[i].type == type) return &element_types[i];
  return NULL;
}

void *sig_list_add(sig_scanner *scanner, sig_list *list, size_t more, size_t item_size) {
  if (list->n + more > list->room) {
    const size_t room = list->n + more > 2 * list->room ? list->n + more + 64 : 2 * list->room;
    void *items = realloc(list->items, room * item_size);
    if (items == NULL) {
      scanner->is_out_of_memory = true;
      (void)sig_scan_fail(scanner, scanner->at, "out of memory");
      return NULL;
    }
    list->items = items;
    list->room = room;
  }
  char *added = (char *)list->items + list->n * item_size;
  memset(added, 0, more * item_size);
  list->n += more;
  return added;
}

int sig_gmsh_group_row(sig_gmsh *mesh, int n_dim, int tag, bool is_entity) {
  int *head = &mesh->group_heads[((unsigned)tag * 8 + (unsigned)n_dim * 2 + is_entity) % SIG_GMSH_N_HEADS];
  const sig_gmsh_group_record *groups = mesh->groups.items;
  for (int i = *head - 1; i >= 0; i = groups[i].next)
    if (groups[i].n_dim == n_dim && groups[i].tag == tag && groups[i].is_entity == is_entity) return i;
  sig_gmsh_group_record *group = sig_list_add(&mesh->scanner, &mesh->groups, 1, sizeof *group);
  if (group == NULL) return -1;
  *group = (sig_gmsh_group_record){.n_dim = n_dim, .tag = tag, .is_entity = is_entity, .next = *head - 1};
  *head = (int)mesh->groups.n;
  return *head - 1;
}
