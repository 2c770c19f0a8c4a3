"""`python -m hillobs` and the command `hillobs`."""

from .studies.cli.stopping import stoppable


def main() -> None:
    """Run the command line and exit, see `studies.cli.main`; a signal ends it at any moment, see `stoppable`."""
    stoppable(_command_line)


def _command_line() -> None:
    from .studies.cli.main import main as command_line  # takes a while, in which a signal may come

    command_line()


if __name__ == "__main__":
    main()
