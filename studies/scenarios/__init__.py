"""The scenarios that come with hillobs."""
