    ${prefix}_state one = *state, other;
    ${prefix}_state *from = &one, *to = &other;
    int i;
    for (i = 0; i < ${PREFIX}_SUBSTEPS; ++i) {
        ${prefix}_state *passed = from;
        const ${prefix}_real at = (${prefix}_real)i;
        const ${prefix}_real *arg[$n_arg] = {&at, (const ${prefix}_real *)params, (const ${prefix}_real *)from,
            (const ${prefix}_real *)input};
        ${prefix}_real *res[$n_res] = {(${prefix}_real *)to};
        ${prefix}_advance(arg, res, 0, 0, 0);
        from = to;
        to = passed;
    }
    return ${prefix}_keep(${PREFIX}_PERIOD, from, state, params, input, estimate);
