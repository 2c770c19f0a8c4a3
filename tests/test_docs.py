"""The README's Python runs as printed, and its commands are those that exist."""

import re

import pytest
from click.testing import CliRunner

from hillobs.studies.cli.main import commands
from places import ROOT

README = (ROOT / "README.md").read_text(encoding="utf-8")


def test_the_python_examples_run(capsys: pytest.CaptureFixture[str]) -> None:
    code = "\n".join(re.findall(r"```python\n(.*?)```", README, re.DOTALL))
    exec(compile(code, "README.md", "exec"), {})  # noqa: S102  the README is ours
    assert capsys.readouterr().out.strip().endswith("conforms")


def test_the_commands_exist() -> None:
    used = set(re.findall(r"^    hillobs (\w+)", README, re.MULTILINE))
    assert used <= set(commands.list_commands(None))
    assert "Observers for a pair" in CliRunner().invoke(commands, ["--help"]).output


def test_the_links_lead_somewhere() -> None:
    for target in re.findall(r"\]\((?!http)([^)#]+)\)", README):
        assert (ROOT / target).exists(), target
