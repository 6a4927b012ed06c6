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
SLOW_STUDIES = sorted((HOME / "benchmarks" / "slow").glob("*.yaml"))
"""Studies that once took a minute to check; one is refused, one is valid."""
SHIPPED_STUDIES = [
    *sorted(HOME.glob("studies/*.yaml")),
    *sorted(HOME.glob("bearingsim/bench/scenes/*.yaml")),
    *SLOW_STUDIES,
]
Tree = Any


class Position(NamedTuple):
    """Position in a tree: the mapping or list that contains an entry, and its key or index."""

    parent: Any
    key: Any

    @property
    def value(self) -> Tree:
        """Value of the entry."""
        return self.parent[self.key]


def read(text: str) -> Tree:
    """Parse a file into a tree with scalars as written."""
    return yaml.load(text, yaml.BaseLoader)


class _Dumper(yaml.SafeDumper):
    """Dumper that omits the quotes of scalars where YAML allows."""

    yaml_implicit_resolvers: dict = {}  # noqa: RUF012 (as in PyYAML)


def to_text(tree: Tree) -> str:
    """Return the text of a tree."""
    return yaml.dump(tree, Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=110)


def positions(tree: Tree) -> Iterator[Position]:
    """Yield all entries of a tree."""
    entries = tree.items() if isinstance(tree, dict) else enumerate(tree) if isinstance(tree, list) else ()
    for key, value in entries:
        yield Position(tree, key)
        yield from positions(value)


def mappings(tree: Tree) -> list[dict]:
    """List all mappings of a tree, the root first."""
    return [tree, *(position.value for position in positions(tree) if isinstance(position.value, dict))]


# Changes of the tree of a study, some of which copy from the tree of another study


def block_of_another(tree: Tree, other: Tree, random: Random) -> None:
    """Copy a block of another study."""
    key = random.choice([key for key in other if key != "study"])
    tree[key] = deepcopy(other[key])


def entry_elsewhere(tree: Tree, other: Tree, random: Random) -> None:
    """Move an entry to another block of its study."""
    position = random.choice(list(positions(tree)))
    value = position.value
    del position.parent[position.key]
    random.choice(mappings(tree))[str(position.key)] = value


def entry_of_another(tree: Tree, other: Tree, random: Random) -> None:
    """Copy an entry of another study into any block."""
    position = random.choice([position for position in positions(other) if isinstance(position.parent, dict)])
    random.choice(mappings(tree))[position.key] = deepcopy(position.value)


def value_elsewhere(tree: Tree, other: Tree, random: Random) -> None:
    """Replace a value or block by another of either study."""
    source = random.choice(list(positions(random.choice((tree, other)))))
    target = random.choice(list(positions(tree)))
    target.parent[target.key] = deepcopy(source.value)


def same_key(tree: Tree, other: Tree, random: Random) -> None:
    """Copy the value of the same key or path from another study."""
    pairs = [
        (target, source)
        for target in positions(tree)
        for source in positions(other)
        if target.key == source.key and isinstance(target.key, str)
    ]
    target, source = random.choice([pair for pair in pairs if pair[0].key != "study"] or pairs)
    target.parent[target.key] = deepcopy(source.value)


def swept_instead(tree: Tree, other: Tree, random: Random) -> None:
    """Turn a value of the base into a sweep, or a swept value into one of the base."""
    sweep = tree.setdefault("sweep", {})
    if not isinstance(sweep, dict):
        return
    swept_paths = [path for path, values in sweep.items() if isinstance(values, list) and values]
    scalars = [(path, value) for path, value in scalars_of(tree) if path.partition(".")[0] not in STUDY_KEYS]
    if swept_paths and random.random() < 0.5:
        path = random.choice(swept_paths)
        tree[path.partition(".")[0] if random.random() < 0.5 else path] = random.choice(sweep.pop(path))
    elif scalars:
        path, value = random.choice(scalars)
        other_values = [other_value for other_path, other_value in scalars_of(other) if other_path == path]
        sweep[path] = [value, *other_values, *other_values]


STUDY_KEYS = ("study", "sweep", "quick", "figures", "uncertainty", "accuracy", "record")


def scalars_of(tree: Tree, prefix: str = "") -> list[tuple[str, str]]:
    """List the scalars of nested mappings with their paths."""
    scalars = []
    for key, value in tree.items():
        if isinstance(value, dict):
            scalars += scalars_of(value, f"{prefix}{key}.")
        elif isinstance(value, str):
            scalars.append((f"{prefix}{key}", value))
    return scalars


def renamed_key(tree: Tree, other: Tree, random: Random) -> None:
    """Rename a key or path to another one."""
    names = [position.key for position in (*positions(tree), *positions(other)) if isinstance(position.key, str)]
    position = random.choice([position for position in positions(tree) if isinstance(position.parent, dict)])
    position.parent[random.choice(names)] = position.parent.pop(position.key)


def emptied(tree: Tree, other: Tree, random: Random) -> None:
    """Empty or delete a block."""
    position = random.choice(list(positions(tree)))
    if random.random() < 0.5 and not isinstance(position.value, str):
        position.parent[position.key] = type(position.value)()
    else:
        del position.parent[position.key]


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


def crossed_mutants(count: int, seed: int) -> Iterator[tuple[str, Tree]]:
    """Yield ``count`` mutants of the shipped studies with their changes, after the unchanged slow studies."""
    random = Random(seed)
    yield from ((f"unchanged {path.stem}", read(path.read_text())) for path in SLOW_STUDIES[:count])
    for number in range(count - len(SLOW_STUDIES)):
        source, other = random.choice(SHIPPED_STUDIES), random.choice(SHIPPED_STUDIES)
        change = CHANGES[number % len(CHANGES)]
        tree = read(source.read_text())
        change(tree, read(other.read_text()), random)
        yield f"{change.__name__} {source.stem} {other.stem}", tree


def write_crossed(folder: Path, count: int, seed: int) -> Iterator[tuple[str, Path]]:
    """Write the mutants into a folder, with a link to the scans that they use; yield change and file."""
    (folder / "scans").symlink_to(HOME / "studies" / "scans")
    for number, (name, tree) in enumerate(crossed_mutants(count, seed)):
        path = folder / f"crossed-{number}.yaml"
        path.write_text(to_text(tree), encoding="utf-8")
        yield name, path
