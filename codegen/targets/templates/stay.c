    return ${prefix}_keep(${PREFIX}_PERIOD, state, state, params, input, estimate);
