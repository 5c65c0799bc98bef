/* SPDX-License-Identifier: BSD-3-Clause */
#include "unit.h"

#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Lock for making and freeing models and contexts, which only one thread at a time may do. */
static pthread_mutex_t making = PTHREAD_MUTEX_INITIALIZER;

fmi3Status unit_say(const unit_t *unit, fmi3Status status, fmi3String message) {
  static const char *const categories[] = {"logStatusOK", "logStatusWarning", "logStatusDiscard", "logStatusError",
                                           "logStatusFatal"};
  if (unit->log) unit->log(unit->environment, status, categories[status], message);
  return status;
}

/* Returns the path of a file in the folder of resources, whose name may end with a slash. The caller frees it; it is
 * null without memory. */
static char *path_of(fmi3String resources, const char *name) {
  const size_t n = strlen(resources);
  const char *const slash = n > 0 && resources[n - 1] == '/' ? "" : "/";
  char *const path = malloc(n + strlen(name) + 2);
  if (path) sprintf(path, "%s%s%s", resources, slash, name);
  return path;
}

/* Reads the table of outputs: `signorom outputs 1`, the token, the number of nodes and the nodes, the number of outputs
 * and a line for each of them: kind (a number of output_kind), entry, component. Returns false if the table has another
 * form, the token is another one, a number is out of range or memory is missing. Node numbers are not checked. */
static bool read_table(unit_t *unit, FILE *file, fmi3String token) {
  char found[65];
  if (fscanf(file, "signorom outputs 1 %64s %d", found, &unit->n_nodes) != 2 || strcmp(found, token) != 0) return false;
  if (unit->n_nodes < 0 || unit->n_nodes > unit->sizes.n_nodes) return false;
  unit->nodes = calloc((size_t)unit->n_nodes + 1, sizeof *unit->nodes);
  if (!unit->nodes) return false;
  for (int i = 0; i < unit->n_nodes; i++)
    if (fscanf(file, "%d", &unit->nodes[i]) != 1) return false;
  if (fscanf(file, "%d", &unit->n_outputs) != 1 || unit->n_outputs < 0 || unit->n_outputs > 1000000) return false;
  unit->outputs = calloc((size_t)unit->n_outputs + 1, sizeof *unit->outputs);
  if (!unit->outputs) return false;
  for (int i = 0; i < unit->n_outputs; i++) {
    int kind, entry, component;
    if (fscanf(file, "%d %d %d", &kind, &entry, &component) != 3) return false;
    const int n_entries = kind == OUTPUT_DISPLACEMENT ? unit->n_nodes : unit->n_entries;
    const int n_components = kind == OUTPUT_MOMENT ? unit->n_moments : unit->sizes.n_dimensions;
    if (kind < OUTPUT_AREA || kind > OUTPUT_INSIDE || entry < 0 || component < 0 || component >= n_components)
      return false;
    if (kind <= OUTPUT_DISPLACEMENT && entry >= n_entries) return false;
    unit->outputs[i] = (output_t){(output_kind)kind, entry, component};
  }
  return true;
}

/* Allocates the arrays of numbers, filled with zeros. Returns false without memory. */
static bool make_room(unit_t *unit) {
  const size_t n_parameters = (size_t)unit->sizes.n_parameters, n_outputs = (size_t)unit->n_outputs;
  const size_t per_entry = 1 + (size_t)unit->sizes.n_dimensions + (size_t)unit->n_moments;
  const size_t n_room = (size_t)unit->sizes.n_contacts + (size_t)unit->n_entries * per_entry +
                        (size_t)unit->n_nodes * (size_t)unit->sizes.n_dimensions;
  unit->starts = calloc(n_parameters + 1, sizeof(double));
  unit->inputs = calloc(n_parameters + 1, sizeof(double));
  unit->values = calloc(n_outputs + 1, sizeof(double));
  unit->gradient = calloc(n_parameters * n_outputs + 1, sizeof(double));
  unit->room = calloc((n_parameters + 1) * n_room + 1, sizeof(double));
  unit->memory = calloc(2 * (size_t)unit->n_memory + 1, sizeof(double));
  unit->stepped = calloc(n_parameters + 1, sizeof(double));
  return unit->starts && unit->inputs && unit->values && unit->gradient && unit->room && unit->memory && unit->stepped;
}

/* Finds whether the answers of the model depend on earlier ones: its memory has more numbers than the time and the
 * parameters. */
static void find_memory(unit_t *unit) {
  signorom_get_history(unit->model, &unit->n_given, NULL, NULL);
  signorom_get_memory_size(unit->model, &unit->n_memory);
  unit->remembers = unit->n_memory > unit->n_given + 1;
}

/* Opens resources/model.h5 and makes a context. Returns false after a failure; the log has the reason if there was
 * memory. */
static bool open_model(unit_t *unit, fmi3String resources) {
  char *const path = path_of(resources, "model.h5");
  if (!path) return false;
  pthread_mutex_lock(&making);
  int code = signorom_open(path, &unit->model);
  if (code)
    unit_say(unit, fmi3Error, signorom_model_message(unit->model));
  else if ((code = signorom_create_context(unit->model, &unit->context)))
    unit_say(unit, fmi3Error, signorom_message(unit->context));
  pthread_mutex_unlock(&making);
  free(path);
  if (code) return false;
  signorom_get_sizes(unit->model, &unit->sizes);
  signorom_get_contact_entries(unit->model, &unit->n_entries, &unit->n_moments, NULL);
  find_memory(unit);
  return true;
}

/* Reads resources/outputs.txt by read_table. Returns false after a failure, with a message in the log. */
static bool open_table(unit_t *unit, fmi3String token, fmi3String resources) {
  char *const path = path_of(resources, "outputs.txt");
  FILE *const file = path ? fopen(path, "r") : NULL;
  const bool is_read = file && read_table(unit, file, token);
  if (!is_read) unit_say(unit, fmi3Error, "resources/outputs.txt is missing, damaged or of another FMU");
  if (file) fclose(file);
  free(path);
  return is_read;
}

unit_t *unit_create(fmi3String token, fmi3String resources, fmi3InstanceEnvironment environment,
                    fmi3LogMessageCallback log) {
  unit_t *const unit = calloc(1, sizeof *unit);
  if (!unit) return NULL;
  unit->environment = environment;
  unit->log = log;
  if (!token || !resources)
    unit_say(unit, fmi3Error, "the instantiation token or the path of the resources is missing");
  else if (open_model(unit, resources) && open_table(unit, token, resources)) {
    if (make_room(unit)) {
      for (int i = 0; i < unit->sizes.n_parameters; i++) {
        double minimum, maximum;
        signorom_get_parameter(unit->model, i, NULL, NULL, &minimum, &maximum);
        unit->starts[i] = minimum + (maximum - minimum) / 2;
      }
      unit_reset(unit);
      return unit;
    }
    unit_say(unit, fmi3Error, "there is no memory for the FMU");
  }
  unit_free(unit);
  return NULL;
}

void unit_free(unit_t *unit) {
  if (!unit) return;
  pthread_mutex_lock(&making);
  if (unit->context) signorom_free_context(unit->context);
  if (unit->model) signorom_close(unit->model);
  pthread_mutex_unlock(&making);
  free(unit->nodes);
  free(unit->outputs);
  free(unit->starts);
  free(unit->inputs);
  free(unit->values);
  free(unit->gradient);
  free(unit->room);
  free(unit->memory);
  free(unit->stepped);
  free(unit);
}

void unit_reset(unit_t *unit) {
  memcpy(unit->inputs, unit->starts, (size_t)unit->sizes.n_parameters * sizeof(double));
  unit->is_current = false;
  unit->has_gradient = false;
  unit->has_stepped = false;
  if (!unit->remembers) return;
  /* nothing has happened yet */
  memset(unit->values, 0, (size_t)unit->n_outputs * sizeof(double));
  for (int i = 0; i < unit->n_outputs; i++) unit->values[i] = unit->outputs[i].kind == OUTPUT_INSIDE;
  unit->is_current = true;
}

/* Places in `room` of the arrays of one answer, or of n derivatives: first the multipliers of all n, then the areas of
 * all n, and so on. */
typedef struct {
  double *multipliers, *areas, *forces, *moments, *displacement;
} parts_t;

static parts_t parts_of(const unit_t *unit, double *room, int n) {
  parts_t parts;
  parts.multipliers = room;
  parts.areas = parts.multipliers + (size_t)n * (size_t)unit->sizes.n_contacts;
  parts.forces = parts.areas + (size_t)n * (size_t)unit->n_entries;
  parts.moments = parts.forces + (size_t)n * (size_t)unit->n_entries * (size_t)unit->sizes.n_dimensions;
  parts.displacement = parts.moments + (size_t)n * (size_t)unit->n_entries * (size_t)unit->n_moments;
  return parts;
}

/* Returns the value of an output in answer i, or its derivative i; the certificates, the estimate and is_inside_box
 * come from `answer` and are 0 if it is null, as for derivatives. */
static double value_of(const unit_t *unit, const parts_t *parts, output_t output, int i,
                       const signorom_answer *answer) {
  const int n_dimensions = unit->sizes.n_dimensions;
  const int entry = i * unit->n_entries + output.entry, node = i * unit->n_nodes + output.entry;
  switch (output.kind) {
  case OUTPUT_AREA:
    return parts->areas[entry];
  case OUTPUT_FORCE:
    return parts->forces[entry * n_dimensions + output.component];
  case OUTPUT_MOMENT:
    return parts->moments[entry * unit->n_moments + output.component];
  case OUTPUT_DISPLACEMENT:
    return parts->displacement[node * n_dimensions + output.component];
  case OUTPUT_BOUND:
    return answer ? answer->relative_bound : 0;
  case OUTPUT_DISPLACEMENT_BOUND:
    return answer ? answer->relative_displacement_bound : 0;
  case OUTPUT_ESTIMATE:
    return answer ? answer->error_estimate : 0;
  case OUTPUT_INSIDE:
    return answer ? answer->is_inside_box : 0;
  }
  return 0;
}

/* Sets the outputs to those of the last answer of the context. Returns false with a message of the context where a node
 * has no displacement. */
static bool take_answer(unit_t *unit, const signorom_answer *answer) {
  const parts_t parts = parts_of(unit, unit->room, 1);
  if (signorom_get_multipliers(unit->context, parts.multipliers) ||
      (unit->n_nodes > 0 &&
       signorom_get_displacement_at(unit->context, unit->n_nodes, unit->nodes, parts.displacement)))
    return false;
  signorom_get_resultants(unit->model, parts.multipliers, parts.areas, parts.forces, parts.moments);
  for (int i = 0; i < unit->n_outputs; i++) unit->values[i] = value_of(unit, &parts, unit->outputs[i], 0, answer);
  unit->is_current = true;
  unit->has_gradient = false;
  if (!answer->is_inside_box)
    unit_say(unit, fmi3Warning, "the inputs lie outside of the trained box: the outputs are an extrapolation");
  return true;
}

fmi3Status unit_evaluate(unit_t *unit) {
  if (unit->is_current) return fmi3OK;
  signorom_answer answer = SIGNOROM_ANSWER;
  if (signorom_query(unit->context, unit->inputs, &answer) || !take_answer(unit, &answer))
    return unit_say(unit, fmi3Discard, signorom_message(unit->context));
  return fmi3OK;
}

/* Asks the context at the time and with the tables of `state`. */
static int advance(unit_t *unit, const double *state, signorom_answer *answer) {
  return signorom_advance(unit->context, state[unit->n_given], state + unit->n_given + 1, answer);
}

fmi3Status unit_step(unit_t *unit, double time) {
  if (!unit->remembers) return unit_evaluate(unit);
  signorom_answer answer = SIGNOROM_ANSWER;
  if (!unit->has_stepped && signorom_start(unit->context, unit->inputs))
    return unit_say(unit, fmi3Error, signorom_message(unit->context));
  const size_t n_memory = (size_t)unit->n_memory;
  double *const before = unit->memory + n_memory;
  signorom_get_memory(unit->context, before);
  unit->inputs[unit->n_given] = time;
  const int code = advance(unit, unit->inputs, &answer);
  if (code == SIGNOROM_BAD_ARGUMENT) return unit_say(unit, fmi3Error, signorom_message(unit->context));
  if (code || !take_answer(unit, &answer)) {
    unit_say(unit, fmi3Discard, signorom_message(unit->context));
    signorom_set_memory(unit->context, before);
    return fmi3Discard;
  }
  memcpy(unit->memory, before, n_memory * sizeof(double));
  memcpy(unit->stepped, unit->inputs, (size_t)unit->sizes.n_parameters * sizeof(double));
  unit->has_stepped = true;
  return fmi3OK;
}

double *unit_save(unit_t *unit, double *old) {
  const size_t n = (size_t)unit->sizes.n_parameters, n_memory = (size_t)unit->n_memory;
  const size_t n_outputs = (size_t)unit->n_outputs;
  double *const state = old ? old : malloc((2 + 2 * n + n_outputs + 2 * n_memory) * sizeof(double));
  if (!state) return NULL;
  state[0] = unit->time;
  state[1] = unit->has_stepped;
  double *place = state + 2;
  memcpy(place, unit->inputs, n * sizeof(double));
  memcpy(place += n, unit->stepped, n * sizeof(double));
  memcpy(place += n, unit->values, n_outputs * sizeof(double));
  memcpy(place += n_outputs, unit->memory, n_memory * sizeof(double));
  if (unit->has_stepped) signorom_get_memory(unit->context, place + n_memory);
  return state;
}

fmi3Status unit_restore(unit_t *unit, const double *state) {
  const size_t n = (size_t)unit->sizes.n_parameters, n_memory = (size_t)unit->n_memory;
  const double *place = state + 2;
  unit->time = state[0];
  unit->has_stepped = state[1] != 0;
  memcpy(unit->inputs, place, n * sizeof(double));
  unit->is_current = unit->remembers;
  unit->has_gradient = false;
  if (!unit->remembers) return fmi3OK;
  memcpy(unit->stepped, place += n, n * sizeof(double));
  memcpy(unit->values, place += n, (size_t)unit->n_outputs * sizeof(double));
  memcpy(unit->memory, place += unit->n_outputs, n_memory * sizeof(double));
  if (unit->has_stepped && signorom_set_memory(unit->context, place + n_memory))
    return unit_say(unit, fmi3Error, signorom_message(unit->context));
  return fmi3OK;
}

/* Asks the context for the answer whose outputs are known: the last one may be that of other inputs, and derivatives
 * through a history take what is remembered as given. Returns whether there is none. */
static int ask_again(unit_t *unit) {
  if (!unit->remembers) return signorom_query(unit->context, unit->inputs, NULL);
  return signorom_set_memory(unit->context, unit->memory) || advance(unit, unit->stepped, NULL);
}

fmi3Status unit_differentiate(unit_t *unit) {
  if (unit->has_gradient) return fmi3OK;
  const fmi3Status status = unit_evaluate(unit);
  if (status != fmi3OK) return status;
  if (unit->remembers && !unit->has_stepped)
    return unit_say(unit, fmi3Discard, "there are no derivatives before the first step");
  const int n = unit->sizes.n_parameters;
  const parts_t parts = parts_of(unit, unit->room, n);
  /* areas change only in steps, when a contact opens or closes, so their derivatives are 0 */
  memset(parts.areas, 0, (size_t)n * (size_t)unit->n_entries * sizeof(double));
  if (ask_again(unit) || signorom_differentiate(unit->context, 1, NULL, NULL) ||
      signorom_get_resultant_gradient(unit->context, parts.forces, parts.moments) ||
      (unit->n_nodes > 0 &&
       signorom_get_displacement_gradient_at(unit->context, unit->n_nodes, unit->nodes, parts.displacement)))
    return unit_say(unit, fmi3Discard, signorom_message(unit->context));
  for (int k = 0; k < n; k++)
    for (int i = 0; i < unit->n_outputs; i++) {
      const double value = value_of(unit, &parts, unit->outputs[i], k, NULL);
      if (isnan(value))
        return unit_say(unit, fmi3Discard,
                        "a displacement has no derivative: no contact force holds its body at these inputs");
      unit->gradient[k * unit->n_outputs + i] = value;
    }
  unit->has_gradient = true;
  return fmi3OK;
}
