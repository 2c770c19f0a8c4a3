"""Which coordinates some sensors determine."""
