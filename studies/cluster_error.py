"""What is wrong with a cluster."""


class ClusterError(RuntimeError):
    """A cluster cannot be used or was lost; the message says what to do."""
