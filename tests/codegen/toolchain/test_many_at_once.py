"""Processes and threads that start cold at once compile once."""

import threading
from pathlib import Path

import pytest

from compilers import BUILD, DESCRIPTION, SOURCE, finish, python
from hillobs.codegen.toolchain import build


@pytest.mark.parametrize("count", [2, 8])
def test_processes_that_start_cold_at_once(folder, count):
    processes = [python(BUILD) for _ in range(count)]
    results = [finish(process) for process in processes]
    assert {(code, err) for code, _, err in results} == {(0, "")}
    assert {out.split()[0] for _, out, _ in results} == {str(next(folder.glob("*.so")))}
    assert sum(int(out.split()[1]) for _, out, _ in results) == 1
    assert {out.split()[2] for _, out, _ in results} == {"8.0"}
    assert sorted(path.suffix for path in folder.iterdir()) == [".cpp", ".json", ".lock", ".so"]


def test_threads_that_start_cold_at_once(folder, compiled):
    paths = []
    threads = [threading.Thread(target=lambda: paths.append(build(SOURCE, DESCRIPTION))) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(paths) == 8
    assert len(set(paths)) == 1
    assert len(compiled) == 1
    assert sorted(path.suffix for path in folder.iterdir()) == [".cpp", ".json", ".lock", ".so"]


def test_threads_without_a_cache_share_one_private_folder(folder):
    folder.write_text("a file")
    program = """
        import threading, warnings
        warnings.simplefilter("always")
        paths = []
        run = lambda: paths.append(toolchain.build(SOURCE, DESCRIPTION))
        threads = [threading.Thread(target=run) for _ in range(8)]
        [thread.start() for thread in threads]
        [thread.join() for thread in threads]
        print(len(paths), len(set(paths)), len(compiled), twice(paths[0]), paths[0].parent)
    """
    code, out, err = finish(python(program))
    assert code == 0
    assert out.split()[:4] == ["8", "1", "1", "8.0"]
    assert err.count("CacheWarning") == 1
    assert not Path(out.split()[4]).exists()
