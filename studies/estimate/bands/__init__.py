"""How sure estimates are: from noise, and from numbers that are known only so well."""
