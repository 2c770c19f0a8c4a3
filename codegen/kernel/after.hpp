// End of what CasADi wrote.
#pragma GCC diagnostic pop
