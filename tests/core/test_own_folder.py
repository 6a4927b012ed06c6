"""Compiled code is kept where nobody else can put any: another user's files are planted, and are not run."""

import os
import pickle
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from bearingsim import own_folder as trust
from bearingsim.core import jit
from bearingsim.own_folder import Distrusted, own_folder

SOMEONE = 65534
ADD = "from bearingsim.core import jit; assert jit.add(1.0, 2.0) == 3.0; print(jit._CACHE)"
as_root = pytest.mark.skipif(
    not hasattr(os, "getuid") or os.getuid() != 0, reason="only root can make files of another user"
)


@pytest.fixture
def shared() -> Iterator[Path]:
    """A folder like the temporary one: all may write, and none may rename what is another's."""
    folder = Path(tempfile.mkdtemp(prefix="shared-"))
    folder.chmod(0o1777)
    yield folder
    shutil.rmtree(folder)


def by_someone(do: Callable[[], object]) -> None:
    """Let another user do something."""
    child = os.fork()
    if child == 0:
        try:
            os.setgid(SOMEONE)
            os.setuid(SOMEONE)
            os.umask(0)
            do()
        except BaseException as error:
            print(error, file=sys.stderr)
            os._exit(1)
        os._exit(0)
    assert os.waitpid(child, 0)[1] == 0


class Planted:
    """Makes a file as it is unpickled."""

    def __init__(self, file: Path) -> None:
        self.file = file

    def __reduce__(self) -> tuple:
        return os.system, (f"touch {self.file}",)


@pytest.fixture(scope="module")
def compiled(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """The files of a cache that holds ``jit.add``."""
    cache = tmp_path_factory.mktemp("cache")
    add_in(cache)
    return {str(file.relative_to(cache / "bearingsim")): file.read_bytes() for file in cache.rglob("*.nb?")}


def add_in(cache: Path, **more: str) -> subprocess.CompletedProcess:
    """Add two numbers in a process of its own."""
    environment = os.environ | {"BEARINGSIM_CACHE": str(cache)} | more
    done = subprocess.run([sys.executable, "-c", ADD], capture_output=True, text=True, env=environment)
    assert done.returncode == 0, done.stderr
    return done


def plant(compiled: dict[str, bytes], cache: Path, file: Path) -> None:
    """Write compiled code whose indices make a file as they are read."""
    for name, content in compiled.items():
        target = cache / name
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(pickle.dumps(Planted(file)) if target.suffix == ".nbi" else content)


def test_what_is_planted_is_run_if_the_folder_is_trusted(compiled: dict[str, bytes], tmp_path: Path) -> None:
    """So the others below would see it."""
    plant(compiled, tmp_path / "bearingsim", tmp_path / "run")
    (tmp_path / "bearingsim" / jit.source_digest()).chmod(0o700)
    add_in(tmp_path)
    assert (tmp_path / "run").exists()


def foreign_folder(shared: Path, make: Callable[[Path], None]) -> None:
    by_someone(lambda: make(shared / "bearingsim"))


def foreign_digest(shared: Path, make: Callable[[Path], None]) -> None:
    (shared / "bearingsim").mkdir()
    (shared / "bearingsim").chmod(0o777)
    by_someone(lambda: make(shared / "bearingsim"))


def foreign_link(shared: Path, make: Callable[[Path], None]) -> None:
    by_someone(lambda: make(shared / "theirs"))
    by_someone(lambda: (shared / "bearingsim").symlink_to(shared / "theirs"))


def own_link(shared: Path, make: Callable[[Path], None]) -> None:
    by_someone(lambda: make(shared / "theirs"))
    (shared / "bearingsim").symlink_to(shared / "theirs")


def open_folder(shared: Path, make: Callable[[Path], None]) -> None:
    """All is this user's, but the folder above lets others rename it."""
    shared.chmod(0o777)
    make(shared / "bearingsim")


@as_root
@pytest.mark.parametrize("planted", [foreign_folder, foreign_digest, foreign_link, own_link, open_folder])
@pytest.mark.parametrize("names", ["BEARINGSIM_CACHE", "XDG_CACHE_HOME"])
def test_what_another_user_planted_is_not_run(
    shared: Path, compiled: dict[str, bytes], planted: Callable, names: str
) -> None:
    planted(shared, lambda cache: plant(compiled, cache, shared / "run"))
    done = add_in(Path(), **{"BEARINGSIM_CACHE": "", names: str(shared)})
    assert not (shared / "run").exists()
    assert not Path(done.stdout.strip()).is_relative_to(shared)
    (line,) = done.stderr.splitlines()
    assert line.startswith(f"bearingsim: compiled code is cached in {Path(done.stdout.strip()).parent}: ")
    assert str(shared) in line


@as_root
def test_a_name_in_the_temporary_folder_that_another_made_first_is_left(
    shared: Path, compiled: dict[str, bytes]
) -> None:
    """Then the folder is one that passes with the process."""
    first = shared / f"bearingsim-{os.getuid()}"
    by_someone(lambda: plant(compiled, first / "bearingsim", shared / "run"))
    done = add_in(Path("/dev/null"), TMPDIR=str(shared))
    assert not (shared / "run").exists()
    assert Path(done.stdout.strip()).parts[len(shared.parts)] not in ("bearingsim", first.name)
    assert [path.name for path in shared.iterdir()] == [first.name]


@as_root
def test_without_any_place_nothing_is_kept(shared: Path) -> None:
    shared.chmod(0o777)
    done = add_in(shared, TMPDIR=str(shared))
    assert done.stdout.strip() == "None"
    assert done.stderr.startswith("bearingsim: compiled code is not cached")
    assert list(shared.iterdir()) == []


@as_root
def test_a_link_of_another_user_is_followed_to_what_is_trusted_only(shared: Path, tmp_path: Path) -> None:
    """And nothing is made where one leads that leads nowhere."""
    by_someone(lambda: (shared / "link").symlink_to(tmp_path))
    assert own_folder(shared / "link", "mine") == tmp_path / "mine"
    by_someone(lambda: (shared / "loose").symlink_to(tmp_path / "new"))
    with pytest.raises(Distrusted, match="another user's link"):
        own_folder(shared / "loose", "mine")
    assert not (tmp_path / "new").exists()


def test_folders_are_made_for_this_user_alone(tmp_path: Path) -> None:
    before = os.umask(0)
    try:
        folder = own_folder(tmp_path / "a", "b", "c")
    finally:
        os.umask(before)
    assert [path.stat().st_mode & 0o777 for path in (folder, *folder.parents[:2])] == [0o700] * 3


@pytest.fixture
def among_others(monkeypatch: pytest.MonkeyPatch) -> None:
    """This user's group has other members."""
    monkeypatch.setattr(trust, "_is_own_group", lambda group: False)


@pytest.mark.usefixtures("among_others")
def test_an_own_folder_that_the_group_could_write_in_is_closed_but_not_the_code_that_lies_there(
    tmp_path: Path,
) -> None:
    for name in ("bearingsim", "bearingsim/code"):
        (tmp_path / name).mkdir()
    (tmp_path / "bearingsim").chmod(0o775)
    assert own_folder(tmp_path, "bearingsim", "code") == tmp_path / "bearingsim/code"
    assert (tmp_path / "bearingsim").stat().st_mode & 0o777 == 0o755
    (tmp_path / "bearingsim/code").chmod(0o775)
    with pytest.raises(Distrusted, match=r"others can write in .*/code"):
        own_folder(tmp_path, "bearingsim", "code")


@pytest.mark.usefixtures("among_others")
def test_a_folder_above_that_the_group_can_write_in_is_not_trusted(tmp_path: Path) -> None:
    tmp_path.chmod(0o775)
    with pytest.raises(Distrusted, match="`chmod go-w`"):
        own_folder(tmp_path, "bearingsim", "code")


def test_a_private_group_is_nobody_else(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where each user has a group of the same name, files are often made for the group to write."""
    import grp
    import pwd

    own = pwd.struct_passwd(("me", "x", os.getuid(), 77, "", "", ""))
    monkeypatch.setattr(pwd, "getpwuid", lambda user: own)
    monkeypatch.setattr(pwd, "getpwall", lambda: [own])
    for members, private in ([], True), (["me"], True), (["me", "you"], False):
        monkeypatch.setattr(grp, "getgrgid", lambda group, m=members: grp.struct_group(("me", "x", group, m)))
        trust._is_own_group.cache_clear()
        assert trust._is_own_group(77) is private
        assert not trust._is_own_group(78)
    trust._is_own_group.cache_clear()
