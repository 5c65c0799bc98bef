/* SPDX-License-Identifier: BSD-3-Clause */
/* An instance of a unit: a model with a context of its own, its inputs, and the outputs that belong to them. */
#ifndef SIGNOROM_UNIT_H
#define SIGNOROM_UNIT_H

#include "fmi3.h"
#include "signorom.h"

/* What an output is; `entry` and `component` say of which contact of the deck or node, and which direction. */
typedef enum { OUTPUT_AREA, OUTPUT_FORCE, OUTPUT_MOMENT, OUTPUT_DISPLACEMENT, OUTPUT_BOUND, OUTPUT_INSIDE } output_kind;

typedef struct {
  output_kind kind;
  int entry;
  int component;
} output_t;

typedef struct {
  signorom_model *model;
  signorom_context *context;
  signorom_sizes sizes;
  int n_entries, n_moments;
  int n_outputs;
  output_t *outputs;
  int n_nodes;
  int *nodes;       /* that displacements are asked of, counted from 0; [n_nodes] */
  double *starts;   /* middle of the box, [n_parameters] */
  double *inputs;   /* [n_parameters] */
  double *values;   /* outputs at these inputs where is_current, [n_outputs] */
  double *gradient; /* where has_gradient, [n_parameters][n_outputs] */
  double *room;     /* for one answer: multipliers, areas, forces, moments, displacements, and their derivatives */
  bool is_current, has_gradient;
  double time;
  fmi3InstanceEnvironment environment;
  fmi3LogMessageCallback log;
} unit_t;

/* Value references: 0 is the time, then inputs, then outputs. */
static inline bool is_input(const unit_t *unit, fmi3ValueReference reference) {
  return reference >= 1 && reference <= (unsigned)unit->sizes.n_parameters;
}
static inline bool is_output(const unit_t *unit, fmi3ValueReference reference) {
  return reference > (unsigned)unit->sizes.n_parameters &&
         reference - 1 - (unsigned)unit->sizes.n_parameters < (unsigned)unit->n_outputs;
}

/* Opens the model and the table of outputs of a folder of resources. Null where this fails; the log says why. */
unit_t *unit_create(fmi3String token, fmi3String resources, fmi3InstanceEnvironment environment,
                    fmi3LogMessageCallback log);
void unit_free(unit_t *unit);
/* Inputs at their start values. */
void unit_reset(unit_t *unit);
/* Outputs at the present inputs. fmi3Discard where the model has no answer; then there are no values. */
fmi3Status unit_evaluate(unit_t *unit);
/* Derivatives of the outputs at the present inputs. fmi3Discard where there are none. */
fmi3Status unit_differentiate(unit_t *unit);
/* Hands a sentence on, and returns the status. */
fmi3Status unit_say(const unit_t *unit, fmi3Status status, fmi3String message);

#endif
