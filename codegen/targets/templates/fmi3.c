/* $name for programs that know FMI 3.0, Co-Simulation. */
#include <stddef.h>

#ifndef fmi3Functions_h
/* the words of the standard that are used here, if its own header does not come first */
#include <stdbool.h>
#include <stdint.h>
typedef void *fmi3Instance;
typedef void *fmi3InstanceEnvironment;
typedef void *fmi3FMUState;
typedef uint32_t fmi3ValueReference;
typedef double fmi3Float64;
typedef bool fmi3Boolean;
typedef const char *fmi3String;
typedef uint8_t fmi3Byte;
typedef enum { fmi3OK, fmi3Warning, fmi3Discard, fmi3Error, fmi3Fatal } fmi3Status;
typedef void (*fmi3LogMessageCallback)(fmi3InstanceEnvironment, fmi3Status, fmi3String, fmi3String);
typedef void (*fmi3IntermediateUpdateCallback)(fmi3InstanceEnvironment, fmi3Float64, fmi3Boolean, fmi3Boolean,
    fmi3Boolean, fmi3Boolean, fmi3Boolean *, fmi3Float64 *);
#ifdef _WIN32
#define FMI3_Export __declspec(dllexport)
#else
#define FMI3_Export __attribute__((visibility("default")))
#endif
#endif

typedef struct {
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log;
} Host;

#include "fmi-instance.h"

static void say(const Host *host, fmi3String sentence) {
    if (host->log) host->log(host->environment, fmi3Error, "logStatusError", sentence);
}

static void complain(const Instance *self, const char *sentence) { say(&self->host, sentence); }

static fmi3Status status(int done) { return done ? fmi3OK : fmi3Error; }

FMI3_Export fmi3String fmi3GetVersion(void) { return "3.0"; }

/* Errors are always told, and nothing else is. */
FMI3_Export fmi3Status fmi3SetDebugLogging(fmi3Instance c, fmi3Boolean on, size_t n, const fmi3String categories[]) {
    (void)c, (void)on, (void)n, (void)categories;
    return fmi3OK;
}

FMI3_Export fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources,
    fmi3Boolean visible, fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early,
    const fmi3ValueReference intermediate[], size_t n, fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
    fmi3IntermediateUpdateCallback update) {
    Host host;
    Instance *self = NULL;
    host.environment = environment, host.log = log;
    (void)name, (void)resources, (void)visible, (void)logging, (void)early, (void)intermediate, (void)n, (void)update;
    if (!token || strcmp(token, "$token") != 0) say(&host, "the model description is not that of this library");
    else if (events) say(&host, "$name has no event mode");
    else if (!(self = calloc(1, sizeof *self))) say(&host, "there is no memory for another instance");
    if (!self) return NULL;
    self->host = host;
    reset(&self->now);
    return self;
}

FMI3_Export void fmi3FreeInstance(fmi3Instance c) { free(c); }

FMI3_Export fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean tolerant, fmi3Float64 tolerance,
    fmi3Float64 start, fmi3Boolean ends, fmi3Float64 stop) {
    (void)tolerant, (void)tolerance, (void)ends, (void)stop;
    start_at(c, start);
    return fmi3OK;
}

FMI3_Export fmi3Status fmi3ExitInitializationMode(fmi3Instance c) { return status(begin(c)); }

FMI3_Export fmi3Status fmi3Terminate(fmi3Instance c) {
    ((Instance *)c)->now.running = 0;
    return fmi3OK;
}

FMI3_Export fmi3Status fmi3Reset(fmi3Instance c) {
    reset(&((Instance *)c)->now);
    return fmi3OK;
}

FMI3_Export fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference references[], size_t n,
    fmi3Float64 values[], size_t n_values) {
    return status(n == n_values ? get(c, references, n, values) : refuse(c, "every variable is one number"));
}

FMI3_Export fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference references[], size_t n,
    const fmi3Float64 values[], size_t n_values) {
    return status(n == n_values ? set(c, references, n, values) : refuse(c, "every variable is one number"));
}

FMI3_Export fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState *state) { return status(keep(c, state)); }

FMI3_Export fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState state) {
    ((Instance *)c)->now = *(State *)state;
    return fmi3OK;
}

FMI3_Export fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *state) {
    (void)c;
    if (state) free(*state), *state = NULL;
    return fmi3OK;
}

FMI3_Export fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState state, size_t *size) {
    (void)c, (void)state;
    *size = SAVED;
    return fmi3OK;
}

FMI3_Export fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState state, fmi3Byte bytes[], size_t size) {
    return status(serialize(c, state, bytes, size));
}

FMI3_Export fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte bytes[], size_t size,
    fmi3FMUState *state) {
    return status(deserialize(c, bytes, size, state));
}

FMI3_Export fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 from, fmi3Float64 size, fmi3Boolean forgets,
    fmi3Boolean *events, fmi3Boolean *ended, fmi3Boolean *early, fmi3Float64 *last) {
    const int done = step(c, from, size);
    (void)forgets;
    *events = *ended = *early = 0;
    *last = ((Instance *)c)->now.values.time;
    return status(done);
}
