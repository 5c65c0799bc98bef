/* SPDX-License-Identifier: BSD-3-Clause */
/* The functions of FMI 3.0 that the FMU supports. Its outputs are functions of its inputs at the same time, so there
 * are no states and no events; those of a model that remembers (friction, materials that yield or creep) are functions
 * of all steps so far. */
#include "unit.h"

#include <stdlib.h>
#include <string.h>

FMI3_EXPORT const char *fmi3GetVersion(void) { return "3.0"; }

FMI3_EXPORT fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean is_on, size_t n_categories,
                                           const fmi3String categories[]) {
  (void)instance, (void)is_on, (void)n_categories, (void)categories;
  return fmi3OK;
}

FMI3_EXPORT fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources,
                                                      fmi3Boolean is_visible, fmi3Boolean is_logging,
                                                      fmi3InstanceEnvironment environment, fmi3LogMessageCallback log) {
  (void)name, (void)is_visible, (void)is_logging;
  unit_t *const unit = unit_create(token, resources, environment, log);
  if (!unit || !unit->remembers) return unit;
  unit_say(unit, fmi3Error, "the model remembers: this FMU is for co-simulation alone, which goes step by step");
  unit_free(unit);
  return NULL;
}

FMI3_EXPORT fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources,
                                                     fmi3Boolean is_visible, fmi3Boolean is_logging,
                                                     fmi3Boolean has_event_mode, fmi3Boolean may_return_early,
                                                     const fmi3ValueReference required[], size_t n_required,
                                                     fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                                     fmi3OtherCallback update) {
  (void)name, (void)is_visible, (void)is_logging, (void)has_event_mode, (void)may_return_early, (void)required,
      (void)n_required, (void)update;
  return unit_create(token, resources, environment, log);
}

FMI3_EXPORT void fmi3FreeInstance(fmi3Instance instance) { unit_free(instance); }

FMI3_EXPORT fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean has_tolerance,
                                                   fmi3Float64 tolerance, fmi3Float64 start, fmi3Boolean has_stop,
                                                   fmi3Float64 stop) {
  (void)has_tolerance, (void)tolerance, (void)has_stop, (void)stop;
  ((unit_t *)instance)->time = start;
  return fmi3OK;
}

FMI3_EXPORT fmi3Status fmi3Reset(fmi3Instance instance) {
  unit_reset(instance);
  return fmi3OK;
}

FMI3_EXPORT fmi3Status fmi3SetTime(fmi3Instance instance, fmi3Float64 time) {
  ((unit_t *)instance)->time = time;
  return fmi3OK;
}

/* The inputs at the end of the step are set already. If the model has no answer there, last_time is the start of the
 * step, and the time of the instance does not change. */
FMI3_EXPORT fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 point, fmi3Float64 step, fmi3Boolean is_final,
                                  fmi3Boolean *needs_events, fmi3Boolean *terminates, fmi3Boolean *is_early,
                                  fmi3Float64 *last_time) {
  (void)is_final;
  unit_t *const unit = instance;
  *needs_events = *terminates = *is_early = false;
  *last_time = point;
  const fmi3Status status = unit_step(unit, point + step);
  if (status != fmi3OK) return status;
  unit->time = *last_time = point + step;
  return fmi3OK;
}

FMI3_EXPORT fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference references[], size_t n_references,
                                      const fmi3Float64 values[], size_t n_values) {
  unit_t *const unit = instance;
  if (n_references != n_values) return unit_say(unit, fmi3Error, "each reference needs one value");
  for (size_t i = 0; i < n_references; i++)
    if (!is_input(unit, references[i]) || (unit->remembers && references[i] == (unsigned)unit->n_given + 1))
      return unit_say(unit, fmi3Error, "a variable that is no input cannot be set");
  for (size_t i = 0; i < n_references; i++) {
    double *const input = &unit->inputs[references[i] - 1];
    if (*input == values[i]) continue;
    if (unit->has_stepped && references[i] <= (unsigned)unit->n_given)
      return unit_say(unit, fmi3Error, "a parameter stays as it is from the first step on: the model remembers");
    *input = values[i];
    if (!unit->remembers) unit->is_current = unit->has_gradient = false;
  }
  return fmi3OK;
}

FMI3_EXPORT fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference references[], size_t n_references,
                                      fmi3Float64 values[], size_t n_values) {
  unit_t *const unit = instance;
  if (n_references != n_values) return unit_say(unit, fmi3Error, "each reference needs one value");
  for (size_t i = 0; i < n_references; i++) {
    if (references[i] == 0)
      values[i] = unit->time;
    else if (is_input(unit, references[i]))
      values[i] = unit->inputs[references[i] - 1];
    else if (!is_output(unit, references[i]))
      return unit_say(unit, fmi3Error, "there is no such variable");
    else {
      const fmi3Status status = unit_evaluate(unit);
      if (status != fmi3OK) return status;
      values[i] = unit->values[references[i] - 1 - (unsigned)unit->sizes.n_parameters];
    }
  }
  return fmi3OK;
}

FMI3_EXPORT fmi3Status fmi3GetBoolean(fmi3Instance instance, const fmi3ValueReference references[], size_t n_references,
                                      fmi3Boolean values[], size_t n_values) {
  if (n_references != n_values) return unit_say(instance, fmi3Error, "each reference needs one value");
  for (size_t i = 0; i < n_references; i++) {
    double value;
    const fmi3Status status = fmi3GetFloat64(instance, &references[i], 1, &value, 1);
    if (status != fmi3OK) return status;
    values[i] = value != 0;
  }
  return fmi3OK;
}

/* Computes sensitivity = A seed, or A' seed if is_adjoint, where A [n_unknowns][n_knowns] holds the derivatives d
 * unknown / d known. fmi3Error: an unknown is not an area, force, moment or displacement, or a known is not an input.
 * Other failures are those of unit_differentiate. */
static fmi3Status multiply(unit_t *unit, const fmi3ValueReference unknowns[], size_t n_unknowns,
                           const fmi3ValueReference knowns[], size_t n_knowns, const fmi3Float64 seed[],
                           fmi3Float64 sensitivity[], bool is_adjoint) {
  const unsigned n_inputs = (unsigned)unit->sizes.n_parameters;
  for (size_t i = 0; i < n_unknowns; i++) {
    if (!is_output(unit, unknowns[i])) return unit_say(unit, fmi3Error, "only outputs have derivatives");
    if (unit->outputs[unknowns[i] - 1 - n_inputs].kind >= OUTPUT_BOUND)
      return unit_say(unit, fmi3Error, "the certificate and is_inside_box have no derivatives");
  }
  for (size_t k = 0; k < n_knowns; k++)
    if (!is_input(unit, knowns[k]) || (unit->remembers && knowns[k] <= (unsigned)unit->n_given + 1))
      return unit_say(unit, fmi3Error, "derivatives are with respect to inputs");
  const fmi3Status status = unit_differentiate(unit);
  if (status != fmi3OK) return status;
  memset(sensitivity, 0, (is_adjoint ? n_knowns : n_unknowns) * sizeof *sensitivity);
  for (size_t i = 0; i < n_unknowns; i++)
    for (size_t k = 0; k < n_knowns; k++) {
      const double slope = unit->gradient[(knowns[k] - 1) * (unsigned)unit->n_outputs + unknowns[i] - 1 - n_inputs];
      sensitivity[is_adjoint ? k : i] += slope * seed[is_adjoint ? i : k];
    }
  return fmi3OK;
}

FMI3_EXPORT fmi3Status fmi3GetDirectionalDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[],
                                                    size_t n_unknowns, const fmi3ValueReference knowns[],
                                                    size_t n_knowns, const fmi3Float64 seed[], size_t n_seed,
                                                    fmi3Float64 sensitivity[], size_t n_sensitivity) {
  if (n_seed != n_knowns || n_sensitivity != n_unknowns)
    return unit_say(instance, fmi3Error, "the seed or the sensitivity has another length than its variables");
  return multiply(instance, unknowns, n_unknowns, knowns, n_knowns, seed, sensitivity, false);
}

FMI3_EXPORT fmi3Status fmi3GetAdjointDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[],
                                                size_t n_unknowns, const fmi3ValueReference knowns[], size_t n_knowns,
                                                const fmi3Float64 seed[], size_t n_seed, fmi3Float64 sensitivity[],
                                                size_t n_sensitivity) {
  if (n_seed != n_unknowns || n_sensitivity != n_knowns)
    return unit_say(instance, fmi3Error, "the seed or the sensitivity has another length than its variables");
  return multiply(instance, unknowns, n_unknowns, knowns, n_knowns, seed, sensitivity, true);
}

FMI3_EXPORT fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *state) {
  double *const numbers = unit_save(instance, *state);
  if (!numbers) return unit_say(instance, fmi3Error, "there is no memory for the state");
  *state = numbers;
  return fmi3OK;
}

FMI3_EXPORT fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState state) {
  return unit_restore(instance, state);
}

FMI3_EXPORT fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *state) {
  (void)instance;
  free(*state);
  *state = NULL;
  return fmi3OK;
}
