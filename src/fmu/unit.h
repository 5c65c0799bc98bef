/* SPDX-License-Identifier: BSD-3-Clause */
/* An instance of an FMU (functional mock-up unit): a model with its own context, the inputs, and the outputs at these
 * inputs. */
#ifndef SIGNOROM_UNIT_H
#define SIGNOROM_UNIT_H

#include "fmi3.h"
#include "signorom.h"

/* What an output is: area, force or moment of a contact of the deck, displacement of a node, certificates (the
 * relative_bound and the relative_displacement_bound of the answer), its error_estimate, or whether the inputs are
 * inside of the box. `entry` is the contact, or the place of the node in `nodes`; `component` is the direction. Both
 * count from 0; outputs that have none do not use them. */
typedef enum {
  OUTPUT_AREA,
  OUTPUT_FORCE,
  OUTPUT_MOMENT,
  OUTPUT_DISPLACEMENT,
  OUTPUT_BOUND,
  OUTPUT_DISPLACEMENT_BOUND,
  OUTPUT_ESTIMATE,
  OUTPUT_INSIDE
} output_kind;

typedef struct {
  output_kind kind;
  int entry;
  int component;
} output_t;

typedef struct {
  signorom_model *model;
  signorom_context *context;
  signorom_sizes sizes;
  int n_entries, n_moments; /* contacts of the deck; components of a moment */
  int n_outputs;
  output_t *outputs;
  int n_nodes;
  int *nodes;       /* nodes whose displacements are outputs, counted from 0; [n_nodes] */
  double *starts;   /* middle of the box, [n_parameters] */
  double *inputs;   /* [n_parameters] */
  double *values;   /* outputs at these inputs, valid if is_current; [n_outputs] */
  double *gradient; /* derivatives of the outputs, valid if has_gradient; [n_parameters][n_outputs] */
  double *room;     /* work space: multipliers, areas, forces, moments, displacements of an answer, or derivatives */
  bool is_current, has_gradient;
  double time;
  /* Of a model with a history whose answers depend on earlier ones (remembers), as with friction or materials that
   * yield or creep. Its outputs are those of the last step. The first n_given inputs are parameters, which stay as they
   * are from the first step on; then come the time, which is that of the steps, and the tables. */
  bool remembers, has_stepped;
  int n_given;
  int n_memory;
  double *memory;  /* memory of the context before the last step, [n_memory]; then room for as much */
  double *stepped; /* inputs of the last step; [n_parameters] */
  fmi3InstanceEnvironment environment;
  fmi3LogMessageCallback log;
} unit_t;

/* The value reference of the time is 0; those of the inputs follow, then those of the outputs. */
static inline bool is_input(const unit_t *unit, fmi3ValueReference reference) {
  return reference >= 1 && reference <= (unsigned)unit->sizes.n_parameters;
}
static inline bool is_output(const unit_t *unit, fmi3ValueReference reference) {
  return reference > (unsigned)unit->sizes.n_parameters &&
         reference - 1 - (unsigned)unit->sizes.n_parameters < (unsigned)unit->n_outputs;
}

/* Opens the model (model.h5) and the table of outputs (outputs.txt) in the folder `resources`, and sets the inputs to
 * their start values. The token in the table must be `token`. Returns null after a failure; the log has the reason,
 * but not always if memory is missing. unit_free frees the instance. */
unit_t *unit_create(fmi3String token, fmi3String resources, fmi3InstanceEnvironment environment,
                    fmi3LogMessageCallback log);
/* Closes the model and frees the instance; null is allowed. */
void unit_free(unit_t *unit);
/* Sets the inputs to their start values, so that the outputs must be computed again, and where the model remembers
 * begins its history again. The time stays. */
void unit_reset(unit_t *unit);
/* Goes to a time with the present inputs. Where the model remembers, this is the next time of its history; after a
 * failure (fmi3Discard: the model has no answer) another step may be tried from the same state. fmi3Error: the time is
 * not later, or a table of the parameters is not valid. */
fmi3Status unit_step(unit_t *unit, double time);
/* The state of an instance: its time and inputs, and where the model remembers the outputs and the memory. unit_save
 * returns a copy for unit_restore that the caller frees; null without memory. `old` is one of these or null, and is
 * used again. */
double *unit_save(unit_t *unit, double *old);
fmi3Status unit_restore(unit_t *unit, const double *state);
/* Computes the outputs at the present inputs, unless they are known. fmi3Discard: the model has no answer, or no
 * displacement of a node; then there are no values. Inputs outside of the trained box give fmi3OK and a warning in the
 * log. Where the model remembers, the outputs are those of the last step, and zeros before the first one. */
fmi3Status unit_evaluate(unit_t *unit);
/* Computes the derivatives of the outputs with respect to the inputs at the present inputs, towards larger inputs,
 * unless they are known; where the model remembers, those of the last step with respect to its tables. Those of areas
 * are 0, as areas change in steps; so are those of the kinds from OUTPUT_BOUND on, which are not used. fmi3Discard:
 * there is no answer, or it or the displacement of a node of `nodes` has no derivatives. */
fmi3Status unit_differentiate(unit_t *unit);
/* Gives a message to the log of the importer, and returns the status. */
fmi3Status unit_say(const unit_t *unit, fmi3Status status, fmi3String message);

#endif
