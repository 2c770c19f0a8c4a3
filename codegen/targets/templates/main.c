/* Reads samples as CSV from standard input and writes estimates as CSV: cc main.c $name.c -lm && ./a.out < samples.csv
 *
 * The first line names the columns; $columns must be among them, one sample every $period.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "$name.h"

enum { N_INPUTS = $n_input, LONGEST_LINE = 4096, MOST_COLUMNS = 256 };

static const char *const COLUMNS[N_INPUTS] = {$column_strings};

/* The next field of a line, which ends there. */
static char *field(char **rest) {
    char *begin = *rest, *end = begin ? strpbrk(begin, ",\r\n") : NULL;
    *rest = end && *end == ',' ? end + 1 : NULL;
    if (end) *end = '\0';
    return begin;
}

/* Which input each column is, or -1; 0 if one is missing. */
static int read_names(char *line, int which[MOST_COLUMNS]) {
    int found = 0, column, i;
    for (column = 0; column < MOST_COLUMNS; ++column) {
        const char *name = field(&line);
        which[column] = -1;
        for (i = 0; name && i < N_INPUTS; ++i)
            if (strcmp(name, COLUMNS[i]) == 0) which[column] = i, ++found;
    }
    return found == N_INPUTS;
}

/* The numbers of a line; 0 if one is missing. */
static int read_sample(char *line, const int which[MOST_COLUMNS], ${prefix}_input *input) {
    double numbers[N_INPUTS];
    int found = 0, column;
    for (column = 0; column < MOST_COLUMNS && line; ++column) {
        char *text = field(&line), *end = text;
        if (which[column] < 0) continue;
        numbers[which[column]] = strtod(text, &end);
        found += end != text;
    }
    if (found != N_INPUTS) return 0;
$read
    return 1;
}

int main(void) {
    static char line[LONGEST_LINE];
    static int which[MOST_COLUMNS];
    ${prefix}_state state;
    ${prefix}_input input;
    ${prefix}_estimate estimate;
    const ${prefix}_params *params = &${prefix}_defaults;
    long number = 1, begun = 0;
    if (!fgets(line, sizeof line, stdin) || !read_names(line, which)) {
        fputs("the first line must name the columns $columns\n", stderr);
        return 2;
    }
    puts("$header,status");
    while (fgets(line, sizeof line, stdin)) {
        int status;
        ++number;
        if (!read_sample(line, which, &input)) {
            fprintf(stderr, "line %ld is no sample\n", number);
            return 2;
        }
        status = begun ? ${prefix}_step(&state, params, &input, &estimate)
                       : ${prefix}_init(&state, params, &input, &estimate);
        if (status == ${PREFIX}_FAILED) {
            fprintf(stderr, "line %ld: the observer failed\n", number);
            return 1;
        }
        begun = 1;
$print
        printf("%d\n", status);
    }
    return 0;
}
