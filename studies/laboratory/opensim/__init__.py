"""OpenSim models read as XML, with no OpenSim at hand: bodies, joints, muscles and the polynomials of their paths."""
