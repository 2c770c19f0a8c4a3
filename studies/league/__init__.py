"""Every observer, with several sets of gains, in every situation: who estimates what how well, and at what cost."""
