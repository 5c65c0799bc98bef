/* SPDX-License-Identifier: BSD-3-Clause */
/* Functions of FMI 3.0 that the FMU does not need but must have: modes in which nothing happens, and continuous
 * states, event indicators, variables of other types, clocks and partitions, of which it has none. */
#include "unit.h"

/* Begin or end of a mode: the function does nothing. */
#define MODE(name)                                                                                                     \
  FMI3_EXPORT fmi3Status name(fmi3Instance instance) { return fmi3OK; }
MODE(fmi3ExitInitializationMode)
MODE(fmi3EnterEventMode)
MODE(fmi3Terminate)
MODE(fmi3EnterConfigurationMode)
MODE(fmi3ExitConfigurationMode)
MODE(fmi3EnterContinuousTimeMode)
MODE(fmi3EnterStepMode)
MODE(fmi3EvaluateDiscreteStates)

/* The FMU has no variable of the type: an empty list is accepted, any other one is an error. */
static fmi3Status refuse(fmi3Instance instance, size_t n) {
  return n == 0 ? fmi3OK : unit_say(instance, fmi3Error, "this FMU has no variable of this type");
}

#define GET_AND_SET(suffix, type)                                                                                      \
  FMI3_EXPORT fmi3Status fmi3Get##suffix(fmi3Instance instance, const fmi3ValueReference references[], size_t n,       \
                                         type values[], size_t n_values) {                                             \
    return refuse(instance, n);                                                                                        \
  }                                                                                                                    \
  FMI3_EXPORT fmi3Status fmi3Set##suffix(fmi3Instance instance, const fmi3ValueReference references[], size_t n,       \
                                         const type values[], size_t n_values) {                                       \
    return refuse(instance, n);                                                                                        \
  }
GET_AND_SET(Float32, float)
GET_AND_SET(Int8, int8_t)
GET_AND_SET(UInt8, uint8_t)
GET_AND_SET(Int16, int16_t)
GET_AND_SET(UInt16, uint16_t)
GET_AND_SET(Int32, int32_t)
GET_AND_SET(UInt32, uint32_t)
GET_AND_SET(Int64, int64_t)
GET_AND_SET(UInt64, uint64_t)
GET_AND_SET(String, fmi3String)

FMI3_EXPORT fmi3Status fmi3SetBoolean(fmi3Instance instance, const fmi3ValueReference references[], size_t n,
                                      const fmi3Boolean values[], size_t n_values) {
  return refuse(instance, n);
}

FMI3_EXPORT fmi3Status fmi3GetBinary(fmi3Instance instance, const fmi3ValueReference references[], size_t n,
                                     size_t sizes[], const uint8_t *values[], size_t n_values) {
  return refuse(instance, n);
}

FMI3_EXPORT fmi3Status fmi3SetBinary(fmi3Instance instance, const fmi3ValueReference references[], size_t n,
                                     const size_t sizes[], const uint8_t *const values[], size_t n_values) {
  return refuse(instance, n);
}

FMI3_EXPORT fmi3Status fmi3GetClock(fmi3Instance instance, const fmi3ValueReference references[], size_t n,
                                    bool values[]) {
  return refuse(instance, n);
}

FMI3_EXPORT fmi3Status fmi3SetClock(fmi3Instance instance, const fmi3ValueReference references[], size_t n,
                                    const bool values[]) {
  return refuse(instance, n);
}

/* Intervals and shifts of clocks. Arguments: references, their number, then arrays, which are not changed. */
#define CLOCKS(name, ...)                                                                                              \
  FMI3_EXPORT fmi3Status name(fmi3Instance instance, const fmi3ValueReference references[], size_t n, __VA_ARGS__) {   \
    return refuse(instance, n);                                                                                        \
  }
CLOCKS(fmi3GetIntervalDecimal, double first[], int qualifiers[])
CLOCKS(fmi3GetIntervalFraction, uint64_t first[], uint64_t resolutions[], int qualifiers[])
CLOCKS(fmi3GetShiftDecimal, double first[])
CLOCKS(fmi3GetShiftFraction, uint64_t first[], uint64_t resolutions[])
CLOCKS(fmi3SetIntervalDecimal, const double first[])
CLOCKS(fmi3SetIntervalFraction, const uint64_t first[], const uint64_t resolutions[])
CLOCKS(fmi3SetShiftDecimal, const double first[])
CLOCKS(fmi3SetShiftFraction, const uint64_t first[], const uint64_t resolutions[])

FMI3_EXPORT fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, bool *needs_update, bool *terminates,
                                                bool *nominals_change, bool *values_change, bool *has_next_event,
                                                fmi3Float64 *next_event) {
  *needs_update = *terminates = *nominals_change = *values_change = *has_next_event = false;
  *next_event = 0;
  return fmi3OK;
}

FMI3_EXPORT fmi3Status fmi3CompletedIntegratorStep(fmi3Instance instance, bool is_final, bool *enters_event_mode,
                                                   bool *terminates) {
  *enters_event_mode = *terminates = false;
  return fmi3OK;
}

#define NUMBER(name)                                                                                                   \
  FMI3_EXPORT fmi3Status name(fmi3Instance instance, size_t *n) {                                                      \
    *n = 0;                                                                                                            \
    return fmi3OK;                                                                                                     \
  }
NUMBER(fmi3GetNumberOfContinuousStates)
NUMBER(fmi3GetNumberOfEventIndicators)

#define STATES(name, type)                                                                                             \
  FMI3_EXPORT fmi3Status name(fmi3Instance instance, type values[], size_t n) {                                        \
    return n == 0 ? fmi3OK : unit_say(instance, fmi3Error, "this FMU has no states and no event indicators");          \
  }
STATES(fmi3SetContinuousStates, const fmi3Float64)
STATES(fmi3GetContinuousStateDerivatives, fmi3Float64)
STATES(fmi3GetEventIndicators, fmi3Float64)
STATES(fmi3GetContinuousStates, fmi3Float64)
STATES(fmi3GetNominalsOfContinuousStates, fmi3Float64)

/* The following functions are not supported. modelDescription.xml lists the dependencies of the variables, and it does
 * not announce the other functions (canSerializeFMUState, maxOutputDerivativeOrder, ScheduledExecution). */
FMI3_EXPORT fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState state, size_t *size) {
  *size = 0;
  return unit_say(instance, fmi3Error, "this FMU cannot serialize its state");
}

FMI3_EXPORT fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState state, uint8_t bytes[], size_t n) {
  return unit_say(instance, fmi3Error, "this FMU cannot serialize its state");
}

FMI3_EXPORT fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const uint8_t bytes[], size_t n,
                                               fmi3FMUState *state) {
  return unit_say(instance, fmi3Error, "this FMU cannot serialize its state");
}

FMI3_EXPORT fmi3Status fmi3GetOutputDerivatives(fmi3Instance instance, const fmi3ValueReference references[], size_t n,
                                                const int32_t orders[], fmi3Float64 values[], size_t n_values) {
  return n == 0 ? fmi3OK : unit_say(instance, fmi3Error, "this FMU has no derivatives with respect to time");
}

FMI3_EXPORT fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance instance, fmi3ValueReference reference,
                                                           size_t *n) {
  *n = 0;
  return unit_say(instance, fmi3Error, "the dependencies of variables are listed in modelDescription.xml");
}

FMI3_EXPORT fmi3Status fmi3GetVariableDependencies(fmi3Instance instance, fmi3ValueReference reference,
                                                   size_t elements[], fmi3ValueReference independents[],
                                                   size_t independent_elements[], int kinds[], size_t n) {
  return unit_say(instance, fmi3Error, "the dependencies of variables are listed in modelDescription.xml");
}

FMI3_EXPORT fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String resources,
                                                           fmi3Boolean is_visible, fmi3Boolean is_logging,
                                                           fmi3InstanceEnvironment environment,
                                                           fmi3LogMessageCallback log, fmi3OtherCallback update,
                                                           fmi3OtherCallback lock, fmi3OtherCallback unlock) {
  if (log) log(environment, fmi3Error, "logStatusError", "this FMU has no scheduled execution");
  return NULL;
}

FMI3_EXPORT fmi3Status fmi3ActivateModelPartition(fmi3Instance instance, fmi3ValueReference clock, fmi3Float64 time) {
  return unit_say(instance, fmi3Error, "this FMU has no scheduled execution");
}
