"""The truth of a run: what is simulated, with what moves it and what controls it."""
