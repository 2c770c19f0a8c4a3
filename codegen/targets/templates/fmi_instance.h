/* One $name that a simulation program asks for, whatever the version of FMI.
 *
 * Host is what the version keeps of the program.
 */
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "$name.h"

/* value references count the numbers of Values */
enum {
    FIRST_PARAM = 1,
    FIRST_ESTIMATE = FIRST_PARAM + $n_params,
    FIRST_INPUT = FIRST_ESTIMATE + $n_estimate,
    N_VALUES = FIRST_INPUT + $n_input
};

/* a sample that is this part of a period from the end of a step is at the end: times are sums of rounded steps */
#define ROUNDING (1e-3 * ${PREFIX}_PERIOD)

typedef struct {
    double time;
    ${prefix}_params params;
    ${prefix}_estimate estimate;
    ${prefix}_input input;
} Values;

/* all that a step changes: a copy of it is the past */
typedef struct {
    Values values;
    ${prefix}_state observer;
    double start;
    double taken; /* samples; the next one is due at start + taken * period */
    int running;
} State;

typedef struct {
    State now;
    Host host;
} Instance;

/* bytes of a saved state; they begin with the equations that its numbers mean something to */
enum { SAVED = sizeof ${PREFIX}_GRAPH + sizeof(State) };

/* Tells the program what went wrong. */
static void complain(const Instance *self, const char *sentence);

static int refuse(const Instance *self, const char *sentence) {
    complain(self, sentence);
    return 0;
}

static void reset(State *state) {
    memset(state, 0, sizeof *state);
    state->values.params = ${prefix}_defaults;
}

/* The number behind a value reference, or null. */
static double *number(State *state, unsigned int reference) {
    return reference < N_VALUES ? (double *)&state->values + reference : NULL;
}

static int get(Instance *self, const unsigned int references[], size_t n, double values[]) {
    size_t i;
    for (i = 0; i < n; ++i) {
        const double *found = number(&self->now, references[i]);
        if (!found) return refuse(self, "there is no variable with this value reference");
        values[i] = *found;
    }
    return 1;
}

static int settable(unsigned int reference) {
    return (reference >= FIRST_PARAM && reference < FIRST_ESTIMATE) ||
           (reference >= FIRST_INPUT && reference < N_VALUES);
}

static int set(Instance *self, const unsigned int references[], size_t n, const double values[]) {
    size_t i;
    for (i = 0; i < n; ++i) {
        if (!settable(references[i])) return refuse(self, "there is no input or parameter with this value reference");
        *number(&self->now, references[i]) = values[i];
    }
    return 1;
}

/* Takes the samples that are due before `end`$at_end. */
static int advance(Instance *self, double end) {
    State *now = &self->now;
    Values *v = &now->values;
    for (; now->start + now->taken * ${PREFIX}_PERIOD < end $sign ROUNDING; ++now->taken) {
        const int status = now->taken > 0 ? ${prefix}_step(&now->observer, &v->params, &v->input, &v->estimate)
                                          : ${prefix}_init(&now->observer, &v->params, &v->input, &v->estimate);
        if (status == ${PREFIX}_FAILED) return refuse(self, "a number is not finite or beyond its limits");
    }
    v->time = end;
    return 1;
}

static void start_at(Instance *self, double time) { self->now.start = self->now.values.time = time; }

/* Outputs are those of a first sample, if there can be one with the inputs so far; it is taken by the first step. */
static int begin(Instance *self) {
    ${prefix}_state unused;
    Values *v = &self->now.values;
    ${prefix}_init(&unused, &v->params, &v->input, &v->estimate);
    self->now.running = 1;
    return advance(self, self->now.start);
}

static int step(Instance *self, double from, double size) {
    if (!self->now.running) return refuse(self, "a step was asked for before the initialization or after the end");
    if (!(fabs(from - self->now.values.time) < ROUNDING))
        return refuse(self, "a step must begin where the last one ended");
    if (!(size >= 0 && size < HUGE_VAL)) return refuse(self, "the size of a step must be a finite number, 0 or more");
    return advance(self, from + size);
}

/* Room for a state, unless there is some. */
static int made(const Instance *self, void **state) {
    if (!*state) *state = malloc(sizeof(State));
    return *state ? 1 : refuse(self, "there is no memory for another state");
}

static int keep(const Instance *self, void **state) {
    if (!made(self, state)) return 0;
    memcpy(*state, &self->now, sizeof(State));
    return 1;
}

static int serialize(const Instance *self, const void *state, void *bytes, size_t size) {
    if (size < SAVED) return refuse(self, "the array is too small for a state");
    memcpy(bytes, ${PREFIX}_GRAPH, sizeof ${PREFIX}_GRAPH);
    memcpy((char *)bytes + sizeof ${PREFIX}_GRAPH, state, sizeof(State));
    return 1;
}

static int deserialize(const Instance *self, const void *bytes, size_t size, void **state) {
    if (size != SAVED || memcmp(bytes, ${PREFIX}_GRAPH, sizeof ${PREFIX}_GRAPH) != 0)
        return refuse(self, "these bytes are no state of this $name");
    if (!made(self, state)) return 0;
    memcpy(*state, (const char *)bytes + sizeof ${PREFIX}_GRAPH, sizeof(State));
    return 1;
}
