"""The key of a library: all that determines its bytes and nothing else."""

import sys
from pathlib import Path

from compilers import BUILD, DESCRIPTION, SOURCE, finish, python
from hillobs.codegen import cache, toolchain
from hillobs.codegen.toolchain import build


def test_the_key_changes_with_all_that_determines_the_bytes(monkeypatch):
    def key(source=SOURCE, description=DESCRIPTION):
        monkeypatch.setattr(cache, "obtain", lambda order, *rest, **more: order.key)
        return build(source, description)

    keys = [key(), key(SOURCE + "\n"), key(description={"names": ["y"], "size": 1})]
    changes = [
        (toolchain, "FLAGS", (*toolchain.FLAGS, "-g")),
        (toolchain, "ABI", 99),
        (toolchain, "_package_version", lambda name: "9.9"),
        (toolchain, "features", lambda: ["avx1024"]),
        (toolchain.platform, "machine", lambda: "riscv64"),
        (toolchain.platform, "libc_ver", lambda: ("glibc", "9.9")),
        (toolchain, "find_compiler", lambda: other_compiler),
    ]
    other_compiler = toolchain.Compiler(("g++",), "gcc", "g++ 99", Path(sys.executable))
    for module, name, value in changes:
        with monkeypatch.context() as patch:
            patch.setattr(module, name, value)
            keys.append(key())
    with monkeypatch.context() as patch:
        patch.setenv("CPATH", "/elsewhere")
        keys.append(key())
    assert len(set(keys)) == len(keys) == 11
    assert key() == keys[0]


def test_the_key_does_not_change_with_path_user_and_hash_seed(tmp_path):
    build(SOURCE, DESCRIPTION)
    name = next(cache.cache_folder().glob("*.json")).name
    for seed in ("0", "1"):
        env = {
            "PYTHONHASHSEED": seed,
            "HILLOBS_CACHE": str(tmp_path / seed),
            "USER": seed,
            "LC_ALL": "de_DE.UTF-8",
            "TZ": "Asia/Tokyo",
        }
        assert finish(python(BUILD, env=env, cwd="/"))[0] == 0
        assert (tmp_path / seed / name).exists()


def test_another_compiler_under_the_same_name_builds_again(fake):
    fake('exec $real "$@"', version="1.0")
    first = build(SOURCE, DESCRIPTION)
    fake('exec $real "$@"', version="1.1")
    second = build(SOURCE, DESCRIPTION)
    fake('exec  $real "$@"', version="1.1")
    third = build(SOURCE, DESCRIPTION)
    assert len({path.name[:64] for path in (first, second, third)}) == 3
