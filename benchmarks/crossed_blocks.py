"""Seeded mutations of study files that move parts between blocks of the same study or of two studies.

Unlike changes of characters, which mostly end at a syntax error, these mutants are valid YAML, and so reach later
stages: wrong paths, values with other units, sweeps of other studies.
"""

from collections.abc import Callable, Iterator
from copy import deepcopy
from pathlib import Path
from random import Random
from typing import Any, NamedTuple

import yaml

HOME = Path(__file__).resolve().parents[1]
SLOW = sorted((HOME / "benchmarks" / "slow").glob("*.yaml"))
"""Studies that once took a minute to check; one is refused, one is valid."""
SHIPPED = [*sorted(HOME.glob("studies/*.yaml")), *sorted(HOME.glob("bearingsim/bench/scenes/*.yaml")), *SLOW]
Tree = Any


class Place(NamedTuple):
    """Position in a tree: the mapping or list that contains an entry, and its key or index."""

    holder: Any
    key: Any

    @property
    def value(self) -> Tree:
        """Value of the entry."""
        return self.holder[self.key]


def read(text: str) -> Tree:
    """Parse a file into a tree with scalars as written."""
    return yaml.load(text, yaml.BaseLoader)


class _Dumper(yaml.SafeDumper):
    """Dumper that omits the quotes of scalars where YAML allows."""

    yaml_implicit_resolvers: dict = {}  # noqa: RUF012 (as in PyYAML)


def written(tree: Tree) -> str:
    """Return the text of a tree."""
    return yaml.dump(tree, Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=110)


def places(tree: Tree) -> Iterator[Place]:
    """Yield all entries of a tree."""
    entries = tree.items() if isinstance(tree, dict) else enumerate(tree) if isinstance(tree, list) else ()
    for key, value in entries:
        yield Place(tree, key)
        yield from places(value)


def mappings(tree: Tree) -> list[dict]:
    """List all mappings of a tree, the root first."""
    return [tree, *(place.value for place in places(tree) if isinstance(place.value, dict))]


# Changes of the tree of a study, some of which copy from the tree of another study


def block_of_another(tree: Tree, other: Tree, random: Random) -> None:
    """Copy a block of another study."""
    key = random.choice([key for key in other if key != "study"])
    tree[key] = deepcopy(other[key])


def entry_elsewhere(tree: Tree, other: Tree, random: Random) -> None:
    """Move an entry to another block of its study."""
    place = random.choice(list(places(tree)))
    value = place.value
    del place.holder[place.key]
    random.choice(mappings(tree))[str(place.key)] = value


def entry_of_another(tree: Tree, other: Tree, random: Random) -> None:
    """Copy an entry of another study into any block."""
    place = random.choice([place for place in places(other) if isinstance(place.holder, dict)])
    random.choice(mappings(tree))[place.key] = deepcopy(place.value)


def value_elsewhere(tree: Tree, other: Tree, random: Random) -> None:
    """Replace a value or block by another of either study."""
    source, target = random.choice(list(places(random.choice((tree, other))))), random.choice(list(places(tree)))
    target.holder[target.key] = deepcopy(source.value)


def same_key(tree: Tree, other: Tree, random: Random) -> None:
    """Copy the value of the same key or path from another study."""
    shared = [(a, b) for a in places(tree) for b in places(other) if a.key == b.key and isinstance(a.key, str)]
    target, source = random.choice([pair for pair in shared if pair[0].key != "study"] or shared)
    target.holder[target.key] = deepcopy(source.value)


def swept_instead(tree: Tree, other: Tree, random: Random) -> None:
    """Turn a value of the base into a sweep, or a swept value into one of the base."""
    sweep = tree.setdefault("sweep", {})
    if not isinstance(sweep, dict):
        return
    swept = [path for path, values in sweep.items() if isinstance(values, list) and values]
    scalars = [(path, value) for path, value in scalars_of(tree) if path.partition(".")[0] not in NO_CASE]
    if swept and random.random() < 0.5:
        path = random.choice(swept)
        tree[path.partition(".")[0] if random.random() < 0.5 else path] = random.choice(sweep.pop(path))
    elif scalars:
        path, value = random.choice(scalars)
        others = [found for where, found in scalars_of(other) if where == path]
        sweep[path] = [value, *others, *others]


NO_CASE = ("study", "sweep", "quick", "figures", "uncertainty", "accuracy", "record")


def scalars_of(tree: Tree, prefix: str = "") -> list[tuple[str, str]]:
    """List the scalars of nested mappings with their paths."""
    found = []
    for key, value in tree.items():
        if isinstance(value, dict):
            found += scalars_of(value, f"{prefix}{key}.")
        elif isinstance(value, str):
            found.append((f"{prefix}{key}", value))
    return found


def renamed_key(tree: Tree, other: Tree, random: Random) -> None:
    """Rename a key or path to another one."""
    names = [place.key for place in (*places(tree), *places(other)) if isinstance(place.key, str)]
    place = random.choice([place for place in places(tree) if isinstance(place.holder, dict)])
    place.holder[random.choice(names)] = place.holder.pop(place.key)


def emptied(tree: Tree, other: Tree, random: Random) -> None:
    """Empty or delete a block."""
    place = random.choice(list(places(tree)))
    if random.random() < 0.5 and not isinstance(place.value, str):
        place.holder[place.key] = type(place.value)()
    else:
        del place.holder[place.key]


Change = Callable[[Tree, Tree, Random], None]
CHANGES: tuple[Change, ...] = (
    block_of_another,
    entry_elsewhere,
    entry_of_another,
    value_elsewhere,
    same_key,
    swept_instead,
    renamed_key,
    emptied,
)


def crossed(count: int, seed: int) -> Iterator[tuple[str, Tree]]:
    """Yield ``count`` mutants of the shipped studies with their changes, after the unchanged slow studies."""
    random = Random(seed)
    yield from ((f"unchanged {path.stem}", read(path.read_text())) for path in SLOW[:count])
    for number in range(count - len(SLOW)):
        source, other = random.choice(SHIPPED), random.choice(SHIPPED)
        change = CHANGES[number % len(CHANGES)]
        tree = read(source.read_text())
        change(tree, read(other.read_text()), random)
        yield f"{change.__name__} {source.stem} {other.stem}", tree


def write_crossed(folder: Path, count: int, seed: int) -> Iterator[tuple[str, Path]]:
    """Write the mutants into a folder, with a link to the scans that they use; yield change and file."""
    (folder / "scans").symlink_to(HOME / "studies" / "scans")
    for number, (name, tree) in enumerate(crossed(count, seed)):
        path = folder / f"crossed-{number}.yaml"
        path.write_text(written(tree), encoding="utf-8")
        yield name, path
