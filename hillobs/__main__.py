"""`python -m hillobs` and the command `hillobs`."""

from .studies.cli.main import main

if __name__ == "__main__":
    main()
