"""How commands read, speak and end."""
