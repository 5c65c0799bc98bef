/* SPDX-License-Identifier: BSD-3-Clause */
/* Reads a gmsh file, format 1.0, 2.0, 2.1, 2.2, 4.0 or 4.1, ASCII or (from 2.0) binary, into flat arrays: its mesh, or
 * its nodal fields. Never trusts the file. */
#ifndef SIG_GMSH_READER_H
#define SIG_GMSH_READER_H

#include <stddef.h>
#include <stdint.h>

typedef struct sig_gmsh sig_gmsh;

/* Status of sig_gmsh_read. */
enum { SIG_GMSH_OK = 0, SIG_GMSH_INVALID = 1, SIG_GMSH_UNREADABLE = 2, SIG_GMSH_NO_MEMORY = 3 };

enum { SIG_GMSH_MESSAGE_SIZE = 512 };

/* Reads the mesh in the file at `path` (`length` characters). *mesh must be freed with sig_gmsh_free whatever the
 * status; it may be null when out of memory. SIG_GMSH_INVALID: sig_gmsh_message has the sentence.
 * SIG_GMSH_UNREADABLE: sizes[0] of sig_gmsh_sizes is errno. */
int sig_gmsh_read(const char *path, size_t length, sig_gmsh **mesh);

/* Reads the mesh in a gmsh file from bytes in memory, which are not kept. Status and *mesh are as for sig_gmsh_read. */
int sig_gmsh_parse(const char *bytes, size_t n_bytes, sig_gmsh **mesh);

/* Gives the error message of SIG_GMSH_INVALID as a null-terminated sentence. *line is 1-based. It is 0 in a binary
 * file, where the sentence names the byte, and for a fault without a place, such as a node number that occurs twice. */
void sig_gmsh_message(const sig_gmsh *mesh, char message[SIG_GMSH_MESSAGE_SIZE], int *line);

/* Returns the FNV-1a hash of the file's bytes. */
uint64_t sig_gmsh_hash(const sig_gmsh *mesh);

/* Gives sizes[5]: n_nodes, n_elements, n_element_nodes, n_memberships, n_groups. */
void sig_gmsh_sizes(const sig_gmsh *mesh, int sizes[5]);

/* Gives tags[n_nodes] and coordinates[3 * n_nodes] (x y z of each node in turn), in the file's order. */
void sig_gmsh_nodes(const sig_gmsh *mesh, int *tags, double *coordinates);

/* Gives the elements, in the file's order: gmsh types[n_elements], tags[n_elements], places[2 *
 * n_elements] (line and column, 1-based, 0 in a binary file), offsets[n_elements + 1], nodes[n_element_nodes] (0-based,
 * in gmsh's order within the element). */
void sig_gmsh_elements(const sig_gmsh *mesh, int *types, int *tags, int *places, int *offsets, int *nodes);

/* Gives the memberships: element `elements[m]` belongs to group `groups[m]`. Each element belongs to a group at least.
 * Both arrays are 0-based and of size n_memberships; elements ascend. */
void sig_gmsh_memberships(const sig_gmsh *mesh, int *elements, int *groups);

/* Gives dimension, tag and name of group i, 0 <= i < n_groups. It is a physical group, or (*is_entity is 1) a geometric
 * entity with elements that are in no physical group. The name is empty where the file gives none; it exists as long as
 * the mesh. */
void sig_gmsh_group(const sig_gmsh *mesh, int i, int *n_dim, int *tag, int *is_entity, const char **name,
                    size_t *name_length);

/* Reads the $NodeData sections of a file, and $Nodes if it has them; all other sections are skipped. A mesh is not
 * needed. sig_gmsh_sizes and sig_gmsh_nodes give the nodes (n_nodes is 0 without $Nodes). Status and *fields are as
 * for sig_gmsh_read. */
int sig_gmsh_read_fields(const char *path, size_t length, sig_gmsh **fields);

/* Returns the number of $NodeData sections; 0 if there are none, which is no error. */
int sig_gmsh_n_fields(const sig_gmsh *fields);

/* Describes field i, 0 <= i < n_fields: the number of components of a value, the number of nodes with a value, and the
 * name. The name exists as long as the fields. */
void sig_gmsh_field(const sig_gmsh *fields, int i, int *n_components, int *n_values, const char **name,
                    size_t *name_length);

/* Gives the values of a field in the file's order: tags[n_values] are node numbers, values[n_values] is the first
 * component at each node. */
void sig_gmsh_field_values(const sig_gmsh *fields, int i, int *tags, double *values);

/* Frees a result of sig_gmsh_read, sig_gmsh_parse or sig_gmsh_read_fields, which may be null. */
void sig_gmsh_free(sig_gmsh *mesh);

#endif
