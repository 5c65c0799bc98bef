/* SPDX-License-Identifier: BSD-3-Clause */
/* Shares the vertices of a graph out to parts of equal weight with few edges between them (METIS, k-way). */
#ifndef SIG_PARTITION_H
#define SIG_PARTITION_H

/* Partitions a graph. The neighbors of vertex i are neighbors[offsets[i] .. offsets[i + 1] - 1], 0-based, with each
 * edge in both directions and no vertex its own neighbor; weights[n_vertices] > 0. The result is part[n_vertices], 0 <=
 * part < n_parts. The same seed gives the same parts. No part is empty where n_vertices >= n_parts. With fewer than 4
 * n_parts vertices, or where METIS leaves a part empty, the parts are runs of consecutive vertices of about equal
 * number. Returns 0, or nonzero when METIS fails (out of memory). */
int sig_partition_graph(int n_vertices, const int *offsets, const int *neighbors, const int *weights, int n_parts,
                        int seed, int *part);

#endif
