    for (; i < ${PREFIX}_SUBSTEPS; ++i) {
        const ${prefix}_real at = (${prefix}_real)i;
        const ${prefix}_real *arg[$n_arg] = {&at, (const ${prefix}_real *)params, (const ${prefix}_real *)state,
            (const ${prefix}_real *)input, motion[i % 2]};
        ${prefix}_real *res[$n_res] = {motion[(i + 1) % 2]};
        ${prefix}_advance(arg, res, 0, 0, 0);
    }
