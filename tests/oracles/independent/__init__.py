"""Plant, controller, three observers, noise and measures in plain NumPy and SciPy: the oracle of the tests.

Written from the equations alone; imports nothing of the package under test and shares no code with it.
"""
