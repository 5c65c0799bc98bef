/* SPDX-License-Identifier: BSD-3-Clause */
/* The part of the C interface of the Functional Mock-up Interface (FMI) 3.0 that the FMU needs, after the text of the
 * standard (https://fmi-standard.org/docs/3.0). An FMU is a functional mock-up unit. */
#ifndef SIGNOROM_FMI3_H
#define SIGNOROM_FMI3_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define FMI3_EXPORT __attribute__((visibility("default")))

typedef void *fmi3Instance;
typedef void *fmi3InstanceEnvironment;
typedef void *fmi3FMUState;
typedef uint32_t fmi3ValueReference;
typedef double fmi3Float64;
typedef bool fmi3Boolean;
typedef const char *fmi3String;

typedef enum { fmi3OK = 0, fmi3Warning = 1, fmi3Discard = 2, fmi3Error = 3, fmi3Fatal = 4 } fmi3Status;

typedef void (*fmi3LogMessageCallback)(fmi3InstanceEnvironment, fmi3Status, fmi3String category, fmi3String message);
/* Stands for all callbacks that the FMU never calls. */
typedef void (*fmi3OtherCallback)(void);

#endif
