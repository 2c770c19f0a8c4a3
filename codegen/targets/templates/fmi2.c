/* $name for programs that know FMI 2.0, Co-Simulation. */
#include <stddef.h>

#ifndef fmi2Functions_h
/* the words of the standard that are used here, if its own header does not come first */
typedef void *fmi2Component;
typedef void *fmi2ComponentEnvironment;
typedef void *fmi2FMUstate;
typedef unsigned int fmi2ValueReference;
typedef double fmi2Real;
typedef int fmi2Boolean;
typedef const char *fmi2String;
typedef char fmi2Byte;
typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef enum { fmi2ModelExchange, fmi2CoSimulation } fmi2Type;
typedef struct {
    void (*logger)(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String, ...);
    void *(*allocateMemory)(size_t, size_t);
    void (*freeMemory)(void *);
    void (*stepFinished)(fmi2ComponentEnvironment, fmi2Status);
    fmi2ComponentEnvironment componentEnvironment;
} fmi2CallbackFunctions;
#ifdef _WIN32
#define FMI2_Export __declspec(dllexport)
#else
#define FMI2_Export __attribute__((visibility("default")))
#endif
#endif

typedef struct {
    fmi2CallbackFunctions call;
    char *name;
} Host;

#include "fmi-instance.h"

/* Sentences have no % in them, which would ask for more. */
static void say(const fmi2CallbackFunctions *call, fmi2String name, fmi2String sentence) {
    if (call->logger) call->logger(call->componentEnvironment, name, fmi2Error, "logStatusError", sentence);
}

static void complain(const Instance *self, const char *sentence) { say(&self->host.call, self->host.name, sentence); }

static fmi2Status status(int done) { return done ? fmi2OK : fmi2Error; }

FMI2_Export fmi2String fmi2GetTypesPlatform(void) { return "default"; }

FMI2_Export fmi2String fmi2GetVersion(void) { return "2.0"; }

/* Errors are always told, and nothing else is. */
FMI2_Export fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[]) {
    (void)c, (void)on, (void)n, (void)categories;
    return fmi2OK;
}

FMI2_Export fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
    const fmi2CallbackFunctions *call, fmi2Boolean visible, fmi2Boolean logging) {
    Instance *self = NULL;
    (void)resources, (void)visible, (void)logging;
    if (!call || !name || !guid) return NULL;
    if (type != fmi2CoSimulation) say(call, name, "$name is for Co-Simulation only");
    else if (strcmp(guid, "$token") != 0) say(call, name, "the model description is not that of this library");
    else if (!(self = calloc(1, sizeof *self)) || !(self->host.name = malloc(strlen(name) + 1))) {
        say(call, name, "there is no memory for another instance");
        free(self), self = NULL;
    }
    if (!self) return NULL;
    self->host.call = *call;
    strcpy(self->host.name, name);
    reset(&self->now);
    return self;
}

FMI2_Export void fmi2FreeInstance(fmi2Component c) {
    if (c) free(((Instance *)c)->host.name);
    free(c);
}

FMI2_Export fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean tolerant, fmi2Real tolerance, fmi2Real start,
    fmi2Boolean ends, fmi2Real stop) {
    (void)tolerant, (void)tolerance, (void)ends, (void)stop;
    start_at(c, start);
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    (void)c;
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2ExitInitializationMode(fmi2Component c) { return status(begin(c)); }

FMI2_Export fmi2Status fmi2Terminate(fmi2Component c) {
    ((Instance *)c)->now.running = 0;
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2Reset(fmi2Component c) {
    reset(&((Instance *)c)->now);
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference references[], size_t n,
    fmi2Real values[]) {
    return status(get(c, references, n, values));
}

FMI2_Export fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference references[], size_t n,
    const fmi2Real values[]) {
    return status(set(c, references, n, values));
}

FMI2_Export fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) { return status(keep(c, state)); }

FMI2_Export fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    ((Instance *)c)->now = *(State *)state;
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) {
    (void)c;
    if (state) free(*state), *state = NULL;
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size) {
    (void)c, (void)state;
    *size = SAVED;
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    return status(serialize(c, state, bytes, size));
}

FMI2_Export fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size,
    fmi2FMUstate *state) {
    return status(deserialize(c, bytes, size, state));
}

FMI2_Export fmi2Status fmi2DoStep(fmi2Component c, fmi2Real from, fmi2Real size, fmi2Boolean forgets) {
    (void)forgets;
    return status(step(c, from, size));
}
