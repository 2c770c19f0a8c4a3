"""The hand-written C++ around the generated functions."""
