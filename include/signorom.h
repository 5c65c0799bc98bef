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
 * Every call that can fail returns a signorom_code. A call returns SIGNOROM_BAD_ARGUMENT (null, if it returns a text)
 * where the model or the context is null or was not made successfully. Only signorom_model_message and signorom_message
 * return the reason for one that was not made successfully. A model keeps the message of a failed signorom_open, a
 * context the message of the last failed call with it; other calls with a model leave no message.
 * There are no global variables. Several threads may use one model if each thread has its own context; only one thread
 * at a time may use a context. Only one thread of the process at a time may make or free models and contexts. Numbers
 * of nodes, contacts and clusters count from 0. Arrays belong to the caller, texts to the model or the context. Calls
 * that read a model, stresses, imposed strains or contact fields leave out an array whose pointer is null, unless they
 * say that this is an error. For all other calls a null array is an error, unless they say that it may be null. */
#ifndef SIGNOROM_H
#define SIGNOROM_H

#include <stddef.h>

/* Version of this header. signorom_version() returns the version of the library that the program loaded. */
#define SIGNOROM_VERSION "0.1.0"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct signorom_model signorom_model;
typedef struct signorom_context signorom_context;

typedef enum {
  SIGNOROM_OK = 0,
  SIGNOROM_NO_ANSWER = 1,    /* no answer at this point, or the model does not have what the call asks for */
  SIGNOROM_BAD_ARGUMENT = 2, /* a null pointer, a wrong number or size, or no answer before this call */
  SIGNOROM_BAD_MODEL = 3,    /* the file is missing, damaged, no model or of a newer version, or the model
                                cannot answer */
  SIGNOROM_NO_MEMORY = 4     /* no memory for the handle, which is null then; so there is no message */
} signorom_code;

/* How the contact problem of an answer was solved. The methods 1 to 3 belong to the reduced problem of a hyper-reduced
 * model. The method 4 is exact where the elastic constants do not depend on the parameters; otherwise the responses of
 * the bodies are interpolated over these constants. */
typedef enum {
  SIGNOROM_METHOD_NONE = 0, /* there is no answer */
  SIGNOROM_METHOD_ACTIVE_SET = 1,
  SIGNOROM_METHOD_BLOCK_PIVOTING = 2,
  SIGNOROM_METHOD_LEMKE = 3,
  SIGNOROM_METHOD_CONDENSED = 4 /* the model solved the full-order problem, condensed to its contacts */
} signorom_method;

typedef enum {
  SIGNOROM_TEXT_TITLE = 0,
  SIGNOROM_TEXT_LENGTH_UNIT = 1, /* unit of displacements, gaps and coordinates */
  SIGNOROM_TEXT_FORCE_UNIT = 2,  /* unit of multipliers */
  SIGNOROM_TEXT_CODE_VERSION = 3,
  SIGNOROM_TEXT_DECK = 4,        /* deck of the training with all defaults, YAML */
  SIGNOROM_TEXT_DESCRIPTION = 5, /* the text that `signorom describe` prints */
  SIGNOROM_TEXT_STRESS_UNIT = 6, /* unit of stresses and pressures; empty where the model keeps no mesh */
  SIGNOROM_TEXT_AREA_UNIT = 7,   /* unit of contact areas; empty where the model keeps no mesh */
  SIGNOROM_TEXT_KIND = 8,        /* kind of the reduced model: condensed, interpolated, tied,
                                    inelastic or hhr */
  SIGNOROM_TEXT_VERDICT = 9      /* verdict of the validation on forces and fields; begins with "NOT accepted" if the
                                    model is not good enough; empty before a validation */
} signorom_text_kind;

/* Where the displacement of a node comes from. */
typedef enum {
  SIGNOROM_DISPLACEMENT_NONE = 0,
  SIGNOROM_DISPLACEMENT_BY_MODES = 1,
  SIGNOROM_DISPLACEMENT_EXACT = 2 /* without modes, under the contact forces of the answer; as exact as the method 4 */
} signorom_displacement_source;

/* The members of this structure never change. Later versions give further numbers by functions of their own. */
typedef struct {
  int n_parameters;
  int n_clusters;
  int n_contacts; /* number of multipliers (contact forces) of the model: one per contact; with friction the
                     tangential forces come behind them, and count as contacts in all calls */
  int n_nodes;
  int n_dimensions;
  int n_dofs; /* n_dimensions * n_nodes */
  int n_training_points;
  int has_full_order_multipliers;  /* 1: the model is hyper-reduced and has the full-order operator, which answers where
                                      the reduced problem has no solution; or its kind is condensed, interpolated or
                                      tied */
  int has_full_order_displacement; /* 1: an answer by the method condensed has SIGNOROM_DISPLACEMENT_EXACT at all nodes;
                                      0: in a hyper-reduced model its displacement is that of the reduced basis, in
                                      other models signorom_get_displacement_sources says what each node has */
} signorom_sizes;

/* An answer at one point. Set `size` before the call: `signorom_answer answer = SIGNOROM_ANSWER;`. Later versions
 * append members. A program that was compiled with an older header gives its smaller size here, and the library does
 * not write the members beyond it. A single structure filled with zeros counts as one of the first version, whose last
 * member is n_solutions; in an array of several answers the size must be set. */
typedef struct {
  size_t size;           /* sizeof(signorom_answer) */
  int code;              /* SIGNOROM_OK or SIGNOROM_NO_ANSWER */
  int method;            /* signorom_method */
  int cluster;           /* cluster that the choice selected; the full-order operator may have answered in its place */
  int n_modes;           /* number of reduced coordinates of this cluster */
  int n_domain_contacts; /* number of contacts in its reduced integration domain; in a model that is not
                            hyper-reduced, number of all contacts */
  int n_active;          /* number of these contacts that are closed, that is, carry a force or are tied */
  int n_iterations;      /* number of linear solves and pivots */
  int is_inside_box;     /* 1: the point lies in the trained box; outside, an answer is an extrapolation */
  /* Distance to the nearest training point, with each side of the box scaled to 1; NaN where a parameter is NaN. */
  double distance;
  /* Largest violation of the contact conditions of the dense problem that was solved, relative to the terms of its row.
   * It measures rounding only; DBL_MAX where nothing was solved. The error of the model is in the validation, which the
   * description shows. */
  double residual;
  /* Number of different solutions of the reduced problem that two starts found; 0 without an answer. With 2 the contact
   * conditions of the reduced problem do not determine the answer, and the contact forces are less reliable. Where the
   * model has the full-order operator (has_full_order_multipliers), the answer is the solution whose forces on all
   * contacts have the smaller energy, else the one whose start was the nearest training point. */
  int n_solutions;
  /* Bound of the error of the contact forces: |f - f_full| <= bound [sqrt(force * length)]. f holds the forces of all
   * contacts, and the norm is that of the energy that they store in the bodies. relative_bound is the bound divided by
   * the size of f, or by a thousandth of the largest size in training where that is larger; from 0 to 1e-12 it means an
   * exact answer. SIGNOROM_NO_BOUND: the model cannot give a bound, or, for relative_bound only, all these sizes are 0.
   * DBL_MAX: the error may be of any size. Without an answer this may be the bound for which the model refused one. */
  double bound;
  double relative_bound;
  /* Bound of the error of the displacement: |u - u_full| <= displacement_bound in the norm of the stiffness. Rigid
   * motions of bodies that only contact holds are left out. relative_displacement_bound is the bound divided by the
   * size of u, or by a thousandth of the largest size in training where that is larger. Strains and stresses have an
   * error of this relative size in the mean square over the part. Where the stiffness does not depend on the
   * parameters, the bound is the error itself. SIGNOROM_NO_BOUND and DBL_MAX mean the same as above. */
  double displacement_bound;
  double relative_displacement_bound;
  /* Number of independent rigid motions of bodies that only contact holds which no contact force holds at this point;
   * 0 without such bodies or without an answer. If it is not 0, the displacement and the gaps of these bodies are one
   * of many possible; forces and stresses are not affected. */
  int n_free_motions;
  /* Estimate of the error of the contact forces, relative to their size, where materials yield or creep: how far the
   * forces moved when the laws of the materials were asked at all points, over the size of the forces after that. It is
   * an estimate and no bound. SIGNOROM_NO_BOUND: the model gives no estimate, or there is no answer. */
  double error_estimate;
} signorom_answer;

#define SIGNOROM_NO_BOUND (-1.0)

/* Start value of a signorom_answer. (Versions of clang-format differ about such macros.) */
/* clang-format off */
#define SIGNOROM_ANSWER \
  { sizeof(signorom_answer), 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, \
    SIGNOROM_NO_BOUND, SIGNOROM_NO_BOUND, SIGNOROM_NO_BOUND, SIGNOROM_NO_BOUND, 0, SIGNOROM_NO_BOUND }
/* clang-format on */

/* Returns the version of the library, "major.minor.patch". A library has all functions, structures and numbers of the
 * earlier libraries with the same major version (before 1.0.0: with the same minor version). */
const char *signorom_version(void);

/* Reads a model from a file. The call sets `*model` even when it fails, so that signorom_model_message can tell the
 * reason; only SIGNOROM_NO_MEMORY leaves it null. SIGNOROM_BAD_ARGUMENT: `path` or `model` is null. SIGNOROM_BAD_MODEL:
 * the file cannot be read or the model cannot answer. Always close the model, also after a failure. */
int signorom_open(const char *path, signorom_model **model);
/* Returns the reason why signorom_open failed, as a text that exists as long as the model. It is empty after a success,
 * and null where the model is null. */
const char *signorom_model_message(const signorom_model *model);
/* Frees a model and its texts. Free its contexts first. A null pointer is allowed. */
void signorom_close(signorom_model *model);

/* Gives the sizes of a model. SIGNOROM_BAD_ARGUMENT: `sizes` is null. */
int signorom_get_sizes(const signorom_model *model, signorom_sizes *sizes);
/* Returns a text of the model; `kind` is a signorom_text_kind. The text lives as long as the model: do not free it. The
 * result is null where there is no such kind. */
const char *signorom_text(const signorom_model *model, int kind);
/* Gives name, unit and trained range of parameter i, which counts from 0. Any of the pointers behind i may be null.
 * SIGNOROM_BAD_ARGUMENT: i is out of range. */
int signorom_get_parameter(const signorom_model *model, int i, const char **name, const char **unit, double *minimum,
                           double *maximum);
/* Gives the nodes of one side of the contacts. Side 0 is the one that carries the contact forces: the first surface of
 * the entry in the deck, or the second one where rows of mortar contact belong to it. Side 1 is the other one. The
 * nodes of contact i are the entries starts[i] ... starts[i + 1] - 1 of the other arrays. Ask for starts [n_contacts +
 * 1] first: its last entry is the length n of the other arrays. tags [n] are the node tags of the mesh file;
 * coordinates [n][n_dimensions] are the places of the nodes; weights [n] are the shares of the contact's force on each
 * node, which sum up to 1 and may be negative. On side 0 the force and the multiplier of a contact belong to its first
 * node. Where this first node is in the middle of a side of a face with six or eight nodes, the corners at both ends of
 * this side have the share -1/3 each. On side 1 a rigid obstacle has no node, and neighboring contacts may share nodes.
 * Any array may be null. SIGNOROM_BAD_ARGUMENT: `side` is neither 0 nor 1. */
int signorom_get_contact_nodes(const signorom_model *model, int side, int *starts, int *tags, double *weights,
                               double *coordinates);
/* Gives the areas of the contacts [n_contacts]; in plane models they are lengths. Contact pressure = contact force /
 * area. The area of a tangential force is 0. */
int signorom_get_contact_areas(const signorom_model *model, double *areas);
/* Gives for each contact force the contact whose force it is [n_contacts], counted from 0: itself for a normal force;
 * and the force on the first surface that the deck's entry names where the multiplier is 1 [n_contacts][n_dimensions]:
 * a unit vector (its sum over the nodes; mortar rows of curved surfaces may give a little less). Either array may be
 * null. SIGNOROM_BAD_ARGUMENT: the model is null, or its file, of an earlier program, does not name its contacts. */
int signorom_get_force_directions(const signorom_model *model, int *contacts, double *directions);
/* Gives the entries of the deck's contact section: their number (0 in files of earlier programs), the number of
 * components of a moment (3, or 1 in plane and axisymmetric models), and the entry that each contact belongs to
 * [n_contacts], counted from 0. Any pointer may be null. Ask for the number first: where it is 0, the call does not
 * write the array. */
int signorom_get_contact_entries(const signorom_model *model, int *n_entries, int *n_moments, int *entries);
/* Returns the names of the two surfaces of an entry (from 0) of the deck's contact section, such as "lower - upper";
 * null where there is no such entry. */
const char *signorom_contact_entry_name(const signorom_model *model, int entry);
/* Sums the forces of all contacts [n_contacts] over each entry of the deck's contact section. The results are the area
 * that touches [n_entries], that is, of the contacts whose force is above 1e-12 of the largest one; the resultant force
 * on the first surface that the entry names [n_entries][n_dimensions]; and its moment about the origin of the
 * coordinates [n_entries][n_moments], on the undeformed mesh. Where n_entries is 0, nothing is written. In plane models
 * the moment is x F_y - y F_x, and all results are per unit thickness. In axisymmetric models the results are sums over
 * the full turn of the components in the half plane r, z: F_r, F_z and r F_z - z F_r. Where a force is not a number,
 * the results of its entry are not numbers either. SIGNOROM_BAD_ARGUMENT: one of the arrays is null. Several threads
 * may share the model. */
int signorom_get_resultants(const signorom_model *model, const double *multipliers, double *areas, double *forces,
                            double *moments);
/* Gives for each node its tag in the mesh file [n_nodes] and its coordinates [n_nodes][n_dimensions]; either array may
 * be null. SIGNOROM_BAD_ARGUMENT: the model keeps no nodes. */
int signorom_get_nodes(const signorom_model *model, int *tags, double *coordinates);
/* Says for each node [n_nodes] where its displacement comes from, as a signorom_displacement_source. This holds for
 * answers by the reduced model itself. Where the full-order operator of a hyper-reduced model answers (method
 * condensed), has_full_order_displacement says whether the displacements of all nodes are exact. */
int signorom_get_displacement_sources(const signorom_model *model, int *sources);
/* Gives the number of contacts of the reduced integration domain of a cluster and, unless `contacts` is null, their
 * numbers in ascending order. In a model that is not hyper-reduced these are all contacts. SIGNOROM_BAD_ARGUMENT: there
 * is no such cluster. */
int signorom_get_domain_contacts(const signorom_model *model, int cluster, int *n, int *contacts);
/* Gives the cluster that is the second choice at a point [n_parameters]: the one of the nearest cell of another
 * cluster, or the one with the second most votes of the forest. Clusters count from 0; -1 where there is only one.
 * SIGNOROM_BAD_ARGUMENT: a pointer is null. */
int signorom_get_next_cluster(const signorom_model *model, const double *point, int *cluster);

/* Makes a context for queries. The call sets `*context` even when it fails, so that signorom_message can tell the
 * reason; only SIGNOROM_NO_MEMORY leaves it null. SIGNOROM_BAD_ARGUMENT: the model or `context` is null, or
 * signorom_open failed. SIGNOROM_BAD_MODEL: an expression of the model is not valid. Make and free contexts one at a
 * time, under a lock or before the threads start; other threads may query meanwhile. Always free a context; the model
 * must stay open as long as it exists. */
int signorom_create_context(const signorom_model *model, signorom_context **context);
/* Returns the message of the last failed call with the context; a later success does not clear it. It is empty if no
 * call failed, and null where the context is null. The text is valid until the next failed call with the context, or
 * until the context is freed. */
const char *signorom_message(const signorom_context *context);
/* Frees a context. A null pointer is allowed. */
void signorom_free_context(signorom_context *context);

/* Computes the answer at a point [n_parameters], which may lie outside of the trained box. `answer` may be null. The
 * first queries make the work arrays of the context. Later queries allocate only temporary arrays, which they free
 * (with several clusters: as long as the same cluster answers). The functions signorom_get_... with a context and
 * signorom_differentiate give the details of the last answer; they return SIGNOROM_BAD_ARGUMENT where the last query
 * gave no answer or was refused. SIGNOROM_NO_ANSWER: the message says why, and `answer` is written, too.
 * SIGNOROM_BAD_ARGUMENT: the point is null, or the size of the answer is not set; `answer` is not written. */
int signorom_query(signorom_context *context, const double *point, signorom_answer *answer);
/* Computes the answers at n points [n][n_parameters]. `answers` [n] and `multipliers` [n][n_contacts] may be null. The
 * size in the first answer holds for all answers, and the call writes it to each of them. With friction and a history
 * the points are states in their order: one whose parameters differ from those before, or whose time is not later,
 * begins a history. A point without an answer
 * does not stop the call: its code is SIGNOROM_NO_ANSWER, its multipliers are NaN, and the call returns
 * SIGNOROM_NO_ANSWER. Afterwards the last answer of the context is that of the last point; there is none if n is 0, if
 * the last point has none or if the call is refused. SIGNOROM_BAD_ARGUMENT, without any query: n < 0, the points are
 * null, or the size of the first answer is not set. */
int signorom_query_many(signorom_context *context, int n, const double *points, signorom_answer *answers,
                        double *multipliers);

/* Histories. If the deck of a model has a section history, the parameters of the model are those of the deck, then the
 * time, then the tables of the time: a point of signorom_query is a state, with all these values. The functions below
 * take the first n_given values, the parameters of the deck, and follow the time. */

/* Gives the number of parameters without time and tables, the number of times of the deck's steps (0: the model has no
 * history) and these times [n_times]. Any pointer may be null. */
int signorom_get_history(const signorom_model *model, int *n_given, int *n_times, double *times);
/* Gives the states at a point [n_given]: at each time of the deck's steps the parameters, the time and the values of
 * the tables [n_times][n_parameters], as signorom_query_arrays takes them. Without a history it copies the point.
 * SIGNOROM_BAD_ARGUMENT: a pointer is null, or a table is not valid at the point (the message says which). */
int signorom_get_states(signorom_context *context, const double *parameters, double *states);
/* Begins a history at the time 0 for a point [n_given]. SIGNOROM_BAD_ARGUMENT: the parameters are null, the model has
 * no history, or a table is not valid at the point. */
int signorom_start(signorom_context *context, const double *parameters);
/* Answers the next time of the history that signorom_start began; it need not be a time of the deck's steps. `tables`
 * are values of all tables at this time, in the order of the parameters of the model, such as measured ones; null:
 * those of the model's tables. `answer`, SIGNOROM_NO_ANSWER and the last answer of the context are as for
 * signorom_query. SIGNOROM_BAD_ARGUMENT: no history has begun, the time is not later than the one before, or the size
 * of the answer is not set; `answer` is not written. */
int signorom_advance(signorom_context *context, double time, const double *tables, signorom_answer *answer);
/* Gives the number of numbers that the next time of a history depends on: the last time, the parameters, and what
 * contacts with friction and materials that yield or creep remember. It is 0 where the model has no history. */
int signorom_get_memory_size(const signorom_model *model, int *n);
/* Gives these numbers. They are of use to signorom_set_memory alone, with the same file. SIGNOROM_BAD_ARGUMENT: no
 * history has begun, or its last time has no answer. */
int signorom_get_memory(signorom_context *context, double *memory);
/* Goes back to where signorom_get_memory gave these numbers, in this or another context: signorom_advance goes on from
 * there, with the same answers as then. The context has no last answer afterwards. Derivatives of later answers take
 * what is remembered as given: they leave out what the parameters changed before. SIGNOROM_BAD_ARGUMENT: the numbers
 * are not possible; then no history has begun. */
int signorom_set_memory(signorom_context *context, const double *memory);
/* Gives the point of the last answer [n_parameters]; after signorom_advance this is the state. */
int signorom_get_point(const signorom_context *context, double *point);

/* The caller's arrays for the answers at n points; a null pointer leaves an array out. In all arrays but `answers`,
 * numbers are NaN where a point has no answer or a node no displacement; but the resultants of an entry without
 * contacts (all its pairs are inert) are always 0. Set `size` before the call: `signorom_arrays arrays =
 * SIGNOROM_ARRAYS;`. */
typedef struct {
  size_t size;              /* sizeof(signorom_arrays) */
  signorom_answer *answers; /* [n]; the size of the first one holds for all */
  double *multipliers;      /* [n][n_contacts] */
  /* Resultants as in signorom_get_resultants. Give all three arrays or none of them, and only together with
   * multipliers. */
  double *areas;        /* [n][n_entries] */
  double *forces;       /* [n][n_entries][n_dimensions] */
  double *moments;      /* [n][n_entries][n_moments] */
  int n_nodes;          /* number of nodes that the caller chooses; only together with displacement */
  const int *nodes;     /* [n_nodes] */
  double *displacement; /* [n][n_nodes][n_dimensions] */
} signorom_arrays;

/* clang-format off */
#define SIGNOROM_ARRAYS \
  { sizeof(signorom_arrays), NULL, NULL, NULL, NULL, NULL, 0, NULL, NULL }
/* clang-format on */

/* Computes the answers at n points [n][n_parameters] and fills the arrays of the structure. A point without an answer
 * does not stop the call, which then returns SIGNOROM_NO_ANSWER. The size in the first answer and the last answer of
 * the context are as for signorom_query_many. SIGNOROM_BAD_ARGUMENT, without any query: n < 0, `points` or `arrays` is
 * null, a size is not set, areas, forces, moments and multipliers are not given as the structure demands, or
 * displacement is given and `nodes` is null or n_nodes or a node is out of range. */
int signorom_query_arrays(signorom_context *context, int n, const double *points, const signorom_arrays *arrays);

/* Gives the contact forces of the last answer on the contacts of the cluster's domain [n_domain_contacts], in the order
 * of signorom_get_domain_contacts. */
int signorom_get_domain_multipliers(const signorom_context *context, double *multipliers);
/* Gives the contact forces of the last answer on all contacts [n_contacts]. Where the reduced problem of a
 * hyper-reduced model answers, the forces outside of the domain are the non-negative combination of the training
 * solutions that fits the answer best; they are 0 if no contact of the domain has a force. A contact outside of the
 * domain loses its force where the displacement opens it more than the force weighs, both relative to their sizes in
 * training; where it opens less, the force stays. No contact loses its force in models that have bounds without the
 * full-order operator, nor in models with bodies that only contact holds. With such bodies, all forces are then changed
 * so that they balance the loads, if that is possible. After that, open contacts do lose their forces where the
 * full-order operator bounds the error (certificate.max_error of the deck), if the others can balance the loads. */
int signorom_get_multipliers(const signorom_context *context, double *multipliers);
/* Gives the reduced coordinates of the last answer, in the unit of lengths: [n_modes] of that signorom_answer, which
 * differs between clusters and may be 0. Where the full-order operator answered, they are the coordinates of the
 * cluster that the choice selected, under the forces of the operator; NaN if these coordinates do not exist. */
int signorom_get_coordinates(const signorom_context *context, double *coordinates);
/* Gives the displacement of all nodes in the last answer [n_nodes][n_dimensions]; NaN for a node whose displacement the
 * model does not give (reduction.displacement of the deck). SIGNOROM_NO_ANSWER: the model gives contact forces only. */
int signorom_get_displacement(const signorom_context *context, double *displacement);
/* Gives the displacement of the n nodes that the caller chooses, in the last answer [n][n_dimensions].
 * SIGNOROM_NO_ANSWER: one of them has no displacement, or the model gives contact forces only; the array is not
 * written then. SIGNOROM_BAD_ARGUMENT: n < 0, a pointer is null, a node does not exist, or the last query gave no
 * answer. */
int signorom_get_displacement_at(signorom_context *context, int n, const int *nodes, double *displacement);

/* Fields. A model keeps its mesh if its deck has `reduction: {fields: true}`. Then it also gives fields, unless its
 * kind is tied: a tied model has only the mesh. */

/* Gives the number of cells, of nodes of all cells together, of regions, of facets of the surfaces that carry the
 * contact forces, and of nodes of all these facets together. They are 0 where the model keeps no mesh. Any pointer may
 * be null. */
int signorom_get_field_sizes(const signorom_model *model, int *n_cells, int *n_cell_nodes, int *n_regions,
                             int *n_facets, int *n_facet_nodes);
/* Gives the cells. The nodes of cell i are nodes[starts[i]] ... nodes[starts[i + 1] - 1], counted from 0, in gmsh's
 * order. The arrays are starts [n_cells + 1], nodes [n_cell_nodes] and regions [n_cells], counted from 0 (-1: no
 * region). Any array may be null. SIGNOROM_NO_ANSWER: the model keeps no mesh. */
int signorom_get_cells(const signorom_model *model, int *starts, int *nodes, int *regions);
/* Returns the name of a region, which counts from 0; null where there is no such region. */
const char *signorom_region_name(const signorom_model *model, int region);
/* Gives the facets of the surfaces that carry the contact forces. The nodes of facet i are nodes[starts[i]] ...
 * nodes[starts[i + 1] - 1], counted from 0. The arrays are starts [n_facets + 1], nodes [n_facet_nodes], and contacts
 * [n_facets], the entry (from 0) of the deck's contact section that each facet belongs to. Any array may be null.
 * SIGNOROM_NO_ANSWER: the model keeps no mesh. */
int signorom_get_contact_facets(const signorom_model *model, int *starts, int *nodes, int *contacts);
/* Gives the stresses of the last answer: the means over the cells [n_cells][6] and their von Mises stress [n_cells],
 * and the smoothed stresses at the nodes [n_nodes][6] with their von Mises stress [n_nodes]. The components are xx, yy,
 * zz, xy, yz, xz. In axisymmetric models x = r and y = z, and zz is the hoop stress. Any array may be null. After a
 * query the first of this call and the next five computes all fields; the others copy them. All of them return
 * SIGNOROM_NO_ANSWER where the model gives no fields, or where the point is not possible for a material: an elastic
 * constant or an imposed strain has no finite value, or Hooke's matrix is not finite. */
int signorom_get_stresses(signorom_context *context, double *stress, double *von_mises, double *nodal_stress,
                          double *nodal_von_mises);
/* Gives the strains that temperatures and swelling impose at the point of the last answer, as means over the cells
 * [n_cells][6], in the order of signorom_get_stresses. Shears are tensor components (half the change of the angle).
 * Errors as for signorom_get_stresses. */
int signorom_get_imposed_strains(signorom_context *context, double *strain);
/* Gives the contact fields of the last answer. At the nodes: the force of the other body [n_nodes][n_dimensions],
 * contact pressure (0 off the contacts) and gap after the displacement (NaN off the contacts) [n_nodes], and the status
 * [n_nodes]: 0 no contact, 1 open, 2 closed, 4 tied. In the cells: the status [n_cells]: 0 no contact at their nodes, 1
 * open, 2 closed, 3 some nodes open and others not, 4 all nodes tied; nodes without a contact do not count. Any array
 * may be null. Errors as for signorom_get_stresses. */
int signorom_get_contact_fields(signorom_context *context, double *force, double *pressure, double *gap, int *status,
                                int *cell_status);
/* Gives the fields of friction of the last answer, all at the nodes, for their own surface, so that they are opposite
 * on both surfaces: friction over area, and slip since the last time [n_nodes][n_dimensions]; and the status [n_nodes]:
 * 0 no contact, 1 open, 2 sticks, 3 slips (also closed without friction), 4 tied. Any array may be null. Errors as for
 * signorom_get_stresses; SIGNOROM_NO_ANSWER also where the model has no friction. */
int signorom_get_friction_fields(signorom_context *context, double *traction, double *slip, int *status);
/* Gives the plastic strains of the last answer: the accumulated equivalent strain [n_cells] and the tensor [n_cells][6]
 * as means over the cells, in the order of signorom_get_stresses, shears as tensor components; and the smoothed
 * equivalent strain at the nodes [n_nodes]. They are 0 in regions without plasticity. The stresses of
 * signorom_get_stresses leave them out. Any array may be null. Errors as for signorom_get_stresses; SIGNOROM_NO_ANSWER
 * also where no material of the model has plasticity. */
int signorom_get_plastic_strains(signorom_context *context, double *strain, double *tensor, double *nodal_strain);
/* Gives the creep strains of the last answer, as signorom_get_plastic_strains. SIGNOROM_NO_ANSWER also where no
 * material of the model creeps. */
int signorom_get_creep_strains(signorom_context *context, double *strain, double *tensor, double *nodal_strain);

/* Computes the derivatives of the last answer with respect to each parameter. After signorom_advance with null tables
 * those with respect to a parameter of the deck or the time contain what the tables of the model change with it; for
 * all other states of a history each value stands for itself. The derivatives are those where closed contacts with a
 * force stay closed and open ones stay open. n_grazing contacts touch without a force and may do either. With such
 * contacts, or at a kink of an expression of the deck, the derivative towards larger values (direction 1) may differ
 * from the one towards smaller values (direction -1); is_one_sided [n_parameters] is 1 for the parameters where it
 * does. Both directions give the derivative with respect to the parameter; -1 does not change the sign. n_grazing and
 * is_one_sided may be null. Models of the kinds condensed, interpolated and tied have derivatives, those of the kind
 * inelastic have none (SIGNOROM_NO_ANSWER). A hyper-reduced
 * model that keeps the full-order operator gives the derivatives of the full-order solution, and not those of its own
 * answer. The call returns SIGNOROM_NO_ANSWER if the model is hyper-reduced and has no such operator, or if this
 * operator has no answer at the point; if a load (whole_edges) or an expression jumps, has no finite slope or has no
 * value on this side of the point; if the forces are not unique; if contacts that touch without a force leave no
 * solution beside the point; and if beside the point the loads move a body that no contact force holds here
 * (n_free_motions of the answer). It returns SIGNOROM_BAD_ARGUMENT for another direction. It costs about one query per
 * parameter.
 * With friction, contacts that stick go on sticking, and those that slip go on slipping. n_grazing counts also contacts
 * that have the largest force of friction without slip, as where loads are held. The derivatives with respect to the
 * parameters of the deck contain what these change at all times before. They build on those of the time before: call
 * this function after each signorom_advance from the first one on, in the same direction where is_one_sided is 1. A
 * time without derivatives with respect to the time or a table alone does not matter to later times. The other values
 * of a state, the time and the tables, change at their own time alone. SIGNOROM_NO_ANSWER also if the derivatives of an
 * earlier time are missing, or if beside the point a contact with friction closes that touches without a force. */
int signorom_differentiate(signorom_context *context, int direction, int *n_grazing, int *is_one_sided);
/* Gives the derivatives of the contact forces [n_parameters][n_contacts]. This call and the next three return
 * SIGNOROM_BAD_ARGUMENT unless signorom_differentiate succeeded after the last query. */
int signorom_get_multiplier_gradient(signorom_context *context, double *gradient);
/* Gives the derivatives of the resultant forces [n_parameters][n_entries][n_dimensions] and of their moments
 * [n_parameters][n_entries][n_moments], as defined at signorom_get_resultants. */
int signorom_get_resultant_gradient(signorom_context *context, double *forces, double *moments);
/* Gives the derivatives of the displacement of the n nodes that the caller chooses
 * [n_parameters][n][n_dimensions], NaN for what moves with a body that no contact force holds beside the point: its
 * displacement is one of many. Where displacements come from modes (signorom_get_displacement_sources), the relative
 * error of the derivatives is often larger than that of the displacement: see the next call. SIGNOROM_NO_ANSWER: the
 * model cannot differentiate the displacement of a node; the message tells more. SIGNOROM_BAD_ARGUMENT: n < 0, a
 * pointer is null, a node does not exist, or signorom_differentiate did not succeed after the last query. */
int signorom_get_displacement_gradient_at(signorom_context *context, int n, const int *nodes, double *gradient);
/* Gives the relative error of the derivative of the displacement with respect to each parameter [n_parameters]: a bound
 * of the error in the norm of the stiffness over the size of the derivative, which counts as at least a thousandth of
 * the largest displacement in training over the range of the parameter. -1: not known, as wherever the displacement
 * itself has no bound. */
int signorom_get_displacement_gradient_errors(signorom_context *context, double *errors);

#ifdef __cplusplus
}
#endif
#endif
