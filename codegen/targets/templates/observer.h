/* $label: $sentence
 *
 * Written by hillobs $version. Samples come every $period; all numbers are $real.
 * Nothing here allocates memory or keeps any: the caller owns every struct, and one state is one observer.
 */
#ifndef ${PREFIX}_H
#define ${PREFIX}_H

#ifdef __cplusplus
extern "C" {
#endif

#define ${PREFIX}_VERSION "$version"
/* of the equations, with the period and the units: what has the same computes the same */
#define ${PREFIX}_GRAPH "$graph"
/* from sample to sample, in $period_unit */
#define ${PREFIX}_PERIOD $period_literal
/* RK4 steps from sample to sample; 0 if it moves at samples only */
#define ${PREFIX}_SUBSTEPS $substeps

typedef $real ${prefix}_real;

/* what init and step return */
enum {
    ${PREFIX}_OK = 0,
    ${PREFIX}_FAILED = 1, /* a number is not finite or beyond its limits: state and estimate are as they were */
    ${PREFIX}_LIMITED = 2 /* done, and a limit was active: see the last members of the estimate */
};

/* where the observer is; to be set by init, to be kept by the caller, to be copied at will */
typedef struct {
$state
} ${prefix}_state;

/* its numbers */
typedef struct {
$params
} ${prefix}_params;

/* one sample of what is measured */
typedef struct {
$input
} ${prefix}_input;

/* what it makes of the samples until now */
typedef struct {
$estimate
} ${prefix}_estimate;

/* the numbers that were exported */
extern const ${prefix}_params ${prefix}_defaults;

/* Begins at the first sample. */
int ${prefix}_init(${prefix}_state *state, const ${prefix}_params *params, const ${prefix}_input *first,
    ${prefix}_estimate *estimate);

/* Goes on to the next sample, one period after the last. */
int ${prefix}_step(${prefix}_state *state, const ${prefix}_params *params, const ${prefix}_input *input,
    ${prefix}_estimate *estimate);

#ifdef __cplusplus
}
#endif

#endif
