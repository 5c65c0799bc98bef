/* SPDX-License-Identifier: BSD-3-Clause */
/* Answers of a trained Signorom model (model.h5) without mesh, deck, MPI or PETSc: link with -lsignorom_online.
 *
 *     signorom_model *model;
 *     signorom_context *context;
 *     if (signorom_open("model.h5", &model)) { puts(signorom_model_message(model)); ... }
 *     if (signorom_create_context(model, &context)) { ... }
 *     double point[2] = {170.0, 3.2}; // values of the parameters, in their order and units
 *     signorom_answer answer = SIGNOROM_ANSWER;
 *     if (signorom_query(context, point, &answer)) { puts(signorom_message(context)); ... }
 *     signorom_get_multipliers(context, multipliers);
 *     signorom_free_context(context);
 *     signorom_close(model);
 *
 * Every call that can fail returns a signorom_code; the sentence that belongs to the last failure is kept in the model
 * or in the context. There are no global variables. Threads may share a model, each with a context of its own; a
 * context belongs to one thread at a time. Models and contexts are made and freed by one thread at a time in the
 * process. Numbers of nodes, contacts and clusters count from 0. Arrays belong to the caller, texts to the model. */
#ifndef SIGNOROM_H
#define SIGNOROM_H

#include <stddef.h>

/* Version of this header. signorom_version() tells that of the library that the program found when it started. */
#define SIGNOROM_VERSION "0.1.0"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct signorom_model signorom_model;
typedef struct signorom_context signorom_context;

typedef enum {
  SIGNOROM_OK = 0,
  SIGNOROM_NO_ANSWER = 1,    /* no solution at this point, or a term of the model has no finite value there */
  SIGNOROM_BAD_ARGUMENT = 2, /* a null pointer, a number out of its range, nothing asked yet */
  SIGNOROM_BAD_MODEL = 3,    /* missing, damaged, foreign or newer file, or a model that cannot answer */
  SIGNOROM_NO_MEMORY = 4     /* the handle is null: there is nowhere to keep a sentence */
} signorom_code;

typedef enum {
  SIGNOROM_METHOD_NONE = 0,
  SIGNOROM_METHOD_ACTIVE_SET = 1,
  SIGNOROM_METHOD_BLOCK_PIVOTING = 2,
  SIGNOROM_METHOD_LEMKE = 3,
  SIGNOROM_METHOD_CONDENSED = 4 /* the full-order problem condensed to its contacts, which the model holds: exact */
} signorom_method;

typedef enum {
  SIGNOROM_TEXT_TITLE = 0,
  SIGNOROM_TEXT_LENGTH_UNIT = 1, /* of displacements, gaps and coordinates */
  SIGNOROM_TEXT_FORCE_UNIT = 2,  /* of multipliers */
  SIGNOROM_TEXT_CODE_VERSION = 3,
  SIGNOROM_TEXT_DECK = 4,        /* effective deck of the training, YAML */
  SIGNOROM_TEXT_DESCRIPTION = 5, /* what `signorom describe` prints */
  SIGNOROM_TEXT_STRESS_UNIT = 6, /* of stresses and pressures; empty where the model answers no fields */
  SIGNOROM_TEXT_AREA_UNIT = 7,   /* of contact areas; likewise */
  SIGNOROM_TEXT_KIND = 8         /* of the reduced model: condensed, interpolated, tied or hhr */
} signorom_text_kind;

/* Where the displacement of a node comes from. */
typedef enum {
  SIGNOROM_DISPLACEMENT_NONE = 0,
  SIGNOROM_DISPLACEMENT_BY_MODES = 1,
  SIGNOROM_DISPLACEMENT_EXACT = 2 /* but for rounding, under the contact forces of the answer */
} signorom_displacement_source;

/* The members of this structure never change: what later versions count has functions of its own. */
typedef struct {
  int n_parameters;
  int n_clusters;
  int n_contacts; /* multipliers in all */
  int n_nodes;
  int n_dimensions;
  int n_dofs; /* n_dimensions * n_nodes */
  int n_training_points;
  int has_full_order_multipliers;  /* 1: a point without reduced solution is answered */
  int has_full_order_displacement; /* 1: its displacement is exact too, else that of the reduced basis */
} signorom_sizes;

/* What is known of an answer. Set `size` before the call: `signorom_answer answer = SIGNOROM_ANSWER;`. Later versions
 * append members; a program that was compiled with an older header says so by its smaller size, and they are not
 * written. An answer of zeros is one of the first version, whose members end with n_solutions. */
typedef struct {
  size_t size; /* sizeof(signorom_answer) */
  int code;    /* SIGNOROM_OK or SIGNOROM_NO_ANSWER */
  int method;  /* signorom_method */
  int cluster;
  int n_modes;           /* reduced coordinates of this cluster */
  int n_domain_contacts; /* multipliers in its reduced integration domain */
  int n_active;          /* of them, those in contact */
  int n_iterations;      /* linear solves and pivots */
  int is_inside_box;     /* 1: the point lies in the trained box; outside, an answer is an extrapolation */
  /* to the nearest training point, the sides of the box taken as 1 */
  double distance;
  /* largest violation of the contact conditions of the dense problem that was solved, relative to the terms of its row:
   * rounding. It says nothing of the model's error: see the validation in the description. */
  double residual;
  /* Solutions of the reduced problem that two starts found; 0 without an answer. 2: its contact conditions do not
   * determine the answer. The one that violates the full contact problem less was taken where the model holds the
   * full-order operator (has_full_order_multipliers), else that of the nearest training point. Contact forces are less
   * reliable there. */
  int n_solutions;
  /* Certificate: |f - f_full| <= bound, f the contact forces of all contacts, in the norm of the energy that they store
   * in the bodies; [sqrt(force * length)]. The relative one is divided by the size of f, at least a thousandth of the
   * largest in training; at most 1e-12 means exact. SIGNOROM_NO_BOUND: the model cannot give one. */
  double bound;
  double relative_bound;
  /* The same of the displacement: |u - u_full| <= displacement_bound in the norm of the stiffness, without rigid
   * motions of bodies that only contact holds; divided by the size of u, at least a thousandth of the largest in
   * training. SIGNOROM_NO_BOUND: the model cannot give one. */
  double displacement_bound;
  double relative_displacement_bound;
} signorom_answer;

#define SIGNOROM_NO_BOUND (-1.0)

/* Start value of a signorom_answer. */
#define SIGNOROM_ANSWER                                                                                                \
  {                                                                                                                    \
    sizeof(signorom_answer), 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, SIGNOROM_NO_BOUND, SIGNOROM_NO_BOUND, SIGNOROM_NO_BOUND, \
        SIGNOROM_NO_BOUND                                                                                              \
  }

/* Version of the library, "major.minor.patch". Libraries of one major version (before 1.0.0: of one minor version) have
 * all functions, structures and numbers of the earlier ones. */
const char *signorom_version(void);

/* Reads a model. `*model` is set even on a failure, so that signorom_model_message can be asked; close it all the same.
 */
int signorom_open(const char *path, signorom_model **model);
const char *signorom_model_message(const signorom_model *model);
void signorom_close(signorom_model *model);

int signorom_get_sizes(const signorom_model *model, signorom_sizes *sizes);
/* Null where there is none. */
const char *signorom_text(const signorom_model *model, int kind);
/* Any of the pointers may be null. */
int signorom_get_parameter(const signorom_model *model, int i, const char **name, const char **unit, double *minimum,
                           double *maximum);
/* Nodes of one side of the contacts: side 0 is the first one, which carries the contact forces, 1 the second one. Those
 * of contact i are the entries starts[i] ... starts[i + 1] - 1 of the other arrays; ask for starts [n_contacts + 1]
 * first, its last entry is their length n. tags [n] are those of the mesh file, weights [n] the share of the contact's
 * force on each node, which may be negative and sums up to 1, coordinates [n][n_dimensions] its place. On side 0 the
 * first node of each contact is the one that its force and its multiplier belong to; in the middle of a side of a face
 * with six or eight nodes the corners at both ends bear -1/3 each. On side 1 a rigid obstacle has no node, and
 * neighboring contacts may share nodes. Any pointer may be null. */
int signorom_get_contact_nodes(const signorom_model *model, int side, int *starts, int *tags, double *weights,
                               double *coordinates);
/* Areas [n_contacts], in plane models lengths: contact pressure = contact force / area. */
int signorom_get_contact_areas(const signorom_model *model, double *areas);
/* Contacts of the deck: their number (0 in files of earlier programs), the number of components of a moment (3, or 1 in
 * plane and axisymmetric models), and which of them each contact belongs to [n_contacts], from 0. Any pointer may be
 * null; ask for the number first: without entries nothing is written to the array. */
int signorom_get_contact_entries(const signorom_model *model, int *n_entries, int *n_moments, int *entries);
/* The two surfaces of an entry, as in "lower - upper"; null where there is no such entry. */
const char *signorom_contact_entry_name(const signorom_model *model, int entry);
/* What the forces of all contacts [n_contacts] come to on each entry: area that touches [n_entries], resultant on the
 * first surface [n_entries][n_dimensions], and its moment about the origin of the coordinates [n_entries][n_moments],
 * on the undeformed mesh; in plane models x F_y - y F_x, and all of it per unit thickness. Axisymmetric models: sums
 * over the full turn of what acts in the half plane r, z: F_r, F_z and r F_z - z F_r. Where a force is not a number,
 * its entry has none either. Threads may share the model. */
int signorom_get_resultants(const signorom_model *model, const double *multipliers, double *areas, double *forces,
                            double *moments);
/* Tags of the mesh file [n_nodes] and coordinates [n_nodes][n_dimensions]; either may be null. */
int signorom_get_nodes(const signorom_model *model, int *tags, double *coordinates);
/* Which nodes have displacements [n_nodes], as signorom_displacement_source: those of an answer by the reduced model
 * itself. With has_full_order_displacement an answer by the method condensed has exact ones everywhere. */
int signorom_get_displacement_sources(const signorom_model *model, int *sources);
/* Contacts of the reduced integration domain: their number, and (unless null) which, ascending. */
int signorom_get_domain_contacts(const signorom_model *model, int cluster, int *n, int *contacts);
/* The cluster that would answer next at a point [n_parameters]: that of the nearest cell of another one, or the one
 * with the second most votes of the forest; -1 where there is one cluster only. */
int signorom_get_next_cluster(const signorom_model *model, const double *point, int *cluster);

/* `*context` is set even on a failure. Create it before the threads that use it; the model must outlive it.
 */
int signorom_create_context(const signorom_model *model, signorom_context **context);
const char *signorom_message(const signorom_context *context);
void signorom_free_context(signorom_context *context);

/* Answers at a point [n_parameters]. After the first ones it allocates nothing (with several clusters: while one of
 * them answers). The getters below tell more of it. */
int signorom_query(signorom_context *context, const double *point, signorom_answer *answer);
/* Answers at n points [n][n_parameters]; `answers` [n] and `multipliers` [n][n_contacts] may be null; the size of the
 * first answer holds for all, and the call writes it to each. A point without an answer does not stop it: its code says
 * so, its multipliers are 0, and the call returns SIGNOROM_NO_ANSWER. */
int signorom_query_many(signorom_context *context, int n, const double *points, signorom_answer *answers,
                        double *multipliers);

/* Where the answers at n points go; null pointers want none. Where a point has no answer, and a node no displacement,
 * numbers are not a number. Set `size` before the call: `signorom_arrays arrays = SIGNOROM_ARRAYS;`. */
typedef struct {
  size_t size;              /* sizeof(signorom_arrays) */
  signorom_answer *answers; /* [n]; the size of the first one holds for all */
  double *multipliers;      /* [n][n_contacts] */
  /* As in signorom_get_resultants; all three or none, and only with multipliers. */
  double *areas;        /* [n][n_entries] */
  double *forces;       /* [n][n_entries][n_dimensions] */
  double *moments;      /* [n][n_entries][n_moments] */
  int n_nodes;          /* chosen ones, with displacement only */
  const int *nodes;     /* [n_nodes] */
  double *displacement; /* [n][n_nodes][n_dimensions] */
} signorom_arrays;

#define SIGNOROM_ARRAYS                                                                                                \
  { sizeof(signorom_arrays), NULL, NULL, NULL, NULL, NULL, 0, NULL, NULL }

/* Answers at n points [n][n_parameters]. A point without an answer does not stop it: the call then returns
 * SIGNOROM_NO_ANSWER. */
int signorom_query_arrays(signorom_context *context, int n, const double *points, const signorom_arrays *arrays);

/* Contact forces of the domain [n_domain_contacts], or of all contacts [n_contacts]: outside the domain, the
 * non-negative combination of the training answers that fits best. */
int signorom_get_domain_multipliers(const signorom_context *context, double *multipliers);
int signorom_get_multipliers(const signorom_context *context, double *multipliers);
/* Reduced coordinates [n_modes]. */
int signorom_get_coordinates(const signorom_context *context, double *coordinates);
/* Displacement of all nodes [n_nodes][n_dimensions], not a number where a node has none; or of chosen ones
 * [n][n_dimensions], SIGNOROM_NO_ANSWER where one of them has none. SIGNOROM_NO_ANSWER where the model answers contact
 * forces only. */
int signorom_get_displacement(const signorom_context *context, double *displacement);
int signorom_get_displacement_at(signorom_context *context, int n, const int *nodes, double *displacement);

/* Fields. A model answers them whose deck has `reduction: {fields: true}`; others have no cells here, and the calls
 * return SIGNOROM_NO_ANSWER. */

/* Numbers of cells, of nodes of all cells together, of regions, of facets of the surfaces that carry the contact
 * forces, of nodes of all these together. 0 where the model keeps no mesh. Any pointer may be null. */
int signorom_get_field_sizes(const signorom_model *model, int *n_cells, int *n_cell_nodes, int *n_regions,
                             int *n_facets, int *n_facet_nodes);
/* Cells: nodes of cell i are nodes[starts[i]] ... nodes[starts[i + 1] - 1], from 0, in gmsh's order; starts
 * [n_cells + 1], nodes [n_cell_nodes], regions [n_cells], from 0 (-1: none). Any pointer may be null. */
int signorom_get_cells(const signorom_model *model, int *starts, int *nodes, int *regions);
/* Null where there is no such region. */
const char *signorom_region_name(const signorom_model *model, int region);
/* Facets: starts [n_facets + 1], nodes [n_facet_nodes], and the contact of the deck that each belongs to [n_facets].
 * Any pointer may be null. */
int signorom_get_contact_facets(const signorom_model *model, int *starts, int *nodes, int *contacts);
/* Stresses of the last answer: means of the cells [n_cells][6] and their von Mises stress [n_cells]; smoothed at the
 * nodes [n_nodes][6] and [n_nodes]. Components are xx, yy, zz, xy, yz, xz; in axisymmetry x = r, y = z, and zz is the
 * hoop stress. Any pointer may be null. The first of the next three calls computes all fields of an answer. */
int signorom_get_stresses(signorom_context *context, double *stress, double *von_mises, double *nodal_stress,
                          double *nodal_von_mises);
/* What temperatures and swelling impose, as means of the cells [n_cells][6]; components of the tensor. */
int signorom_get_imposed_strains(signorom_context *context, double *strain);
/* At the nodes: force of the other body [n_nodes][n_dimensions], contact pressure and gap [n_nodes] (not a number
 * off the contacts), status [n_nodes]: 0 no contact, 1 open, 2 closed. Of the cells [n_cells]: 0 no contact at their
 * nodes, 1 open, 2 closed, 3 closed at some nodes. Any pointer may be null. */
int signorom_get_contact_fields(signorom_context *context, double *force, double *pressure, double *gap, int *status,
                                int *cell_status);

/* Derivatives of the last answer with respect to each parameter, while contacts that push stay closed and open ones
 * stay open. A contact that touches without a force (n_grazing of them) may do either: then, and at a kink of an
 * expression of the deck, the derivative towards larger values (direction 1) is not the one towards smaller values
 * (direction -1), and is_one_sided [n_parameters] is 1. Both pointers may be null. Models of the kinds condensed,
 * interpolated and tied have derivatives. A hyper-reduced model that keeps the full-order operator has those of that
 * operator: of the full-order solution, not of its own answer. SIGNOROM_NO_ANSWER without that operator, where a load
 * jumps at the point (whole_edges), and where the forces are not unique. It costs about a query per parameter. */
int signorom_differentiate(signorom_context *context, int direction, int *n_grazing, int *is_one_sided);
/* Of the contact forces [n_parameters][n_contacts]. */
int signorom_get_multiplier_gradient(signorom_context *context, double *gradient);
/* Of the resultants and their moments on each entry, as in signorom_get_resultants: [n_parameters][n_entries]
 * [n_dimensions] and [n_parameters][n_entries][n_moments]. */
int signorom_get_resultant_gradient(signorom_context *context, double *forces, double *moments);
/* Of the displacement of chosen nodes [n_parameters][n][n_dimensions]; SIGNOROM_NO_ANSWER where one of them has none.
 */
int signorom_get_displacement_gradient_at(signorom_context *context, int n, const int *nodes, double *gradient);

#ifdef __cplusplus
}
#endif
#endif
