"""Whether a recording and the numbers of its muscles can be believed."""
