"""Words and bytes of others: quoted, read, written whole, or refused with a sentence."""
