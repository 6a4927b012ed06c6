"""Advice on words of the field that are no keys: it is correct, and precedes suggestions."""

import re
from pathlib import Path

import pytest

from bearingsim.catalogue import LAWS, METHODS, MODELS, SHAPES
from bearingsim.config import CHANNELS, FEATURES
from bearingsim.config.vocabulary import EXPLANATIONS, advice
from bearingsim.study import StudyError, load_study
from bearingsim.study.diagnose import STUDY_KEYS
from bearingsim.study.paths import all_paths
from tests.scenes.study_text import BASE, Write

PATHS = set(all_paths())
KEYS = {path.rpartition(".")[2] for path in PATHS} | set(STUDY_KEYS)
NAMES = {*PATHS, *KEYS, *MODELS, *METHODS, *SHAPES, *CHANNELS, *FEATURES, "auto", "density", *LAWS["damping"]}
ALL = list(dict.fromkeys(EXPLANATIONS.values()))


def quoted(sentence: str) -> list[str]:
    return re.findall(r"`([^`]+)`", sentence)


def test_no_word_of_the_vocabulary_is_a_key() -> None:
    own = NAMES - set(SHAPES)  # a `spall` is a shape of defects, and no key
    assert set(EXPLANATIONS) & (own | {name.lower() for name in own}) == set()
    assert all(word == word.lower().replace("-", "_").replace(" ", "_") for word in EXPLANATIONS)


@pytest.mark.parametrize("sentence", ALL)
def test_names_in_advice_exist(sentence: str) -> None:
    assert len(sentence) <= 110
    for name in quoted(sentence):
        command = name.startswith(("bearingsim ", "results."))
        assert command or ":" in name or name in NAMES or name == "check", name


@pytest.mark.parametrize(
    "sentence", [sentence for sentence in ALL if any(": " in name for name in quoted(sentence))]
)
def test_entries_in_advice_are_valid(write: Write, sentence: str) -> None:
    """With the named model, and the shaft that an unbalance needs."""
    written = {name.partition(":")[0]: name for name in quoted(sentence) if ": " in name}
    if "roller_profile" in written:
        pytest.skip("of a bearing: below")
    if "unbalance" in written:
        written["shaft"] = "shaft: {stiffness: 1e8 N/m, mass: 1 kg}"
    if "tolerance" in written:
        written["method"] = "method: dop853"
    base = "\n".join(line for line in BASE.splitlines() if line.partition(":")[0] not in written)
    text = base + "\n" + "\n".join(written.values()) + "\n"
    assert load_study(write(text)).cases()


def test_profile_is_a_key_of_the_bearing(write: Write) -> None:
    own = Path(__file__).parents[2] / "configs/bearings/nf308.yaml"
    text = own.read_text() + "\nroller_profile: {shape: crowned, drop: 5 um}\n"
    assert "`roller_profile: {shape: crowned, drop: 5 um}`" in EXPLANATIONS["crown"]
    path = write(BASE.replace("nf308", "own.yaml") + "model: spatial\n")
    (path.parent / "own.yaml").write_text(text)
    assert load_study(path).cases()[0].bearing.roller_profile.shape == "crowned"


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ("contact_angle: 15 deg", "unknown key `contact_angle` (all models have contact angle 0"),
        ("slip: 1 %", "unknown key `slip` (slip is a result, not an input"),
        ("rows: 2", "unknown key `rows` (every bearing has a single row of elements)"),
        ("outer_speed: 100 rpm", "unknown key `outer_speed` (only the inner ring rotates, at `speed`"),
        ("Outer-Speed: 100 rpm", "unknown key `Outer-Speed` (only the inner ring rotates, at `speed`"),
        ("speed: {inner: 1800 rpm, outer: 1 rpm}", "speed: expected one speed such as `1800 rpm`, got a mapping"),
        ("bearing: {element: tapered}", "expected `roller` or `ball`, got `tapered` (elements are cylindrical"),
        ("sweep: {bearing.contact_angle: [1 deg]}", "no such path `bearing.contact_angle` (all models have"),
        ("bracket_stiffness: 1e7 N/m", "unknown key `bracket_stiffness` (`bracket_stiffness` is a key of `rig`)"),
        ("temperature: 50 C", "unknown key `temperature` (`temperature` is a key of `contact.damping`)"),
        ("rig: {speed: 1 rpm}", "rig: unknown key `speed` (`speed` is a key of the study)"),
        ("width: 1 mm", "(`width` is a key of `bearing`, `defect` and `rig.ring.section`)"),
        ("damping: none", "`damping` is a key of `contact`, `shaft`, `bearing.flanges` and `rig.ring`)"),
        ("sweep: {chi: [1 s/m]}", "no such path `chi` (`chi` is a key of `contact.damping`)"),
        ("bearing: 6204", "no bearing `6204` (available: 6203, 6205, 6309, nf308, "),
    ],
)
def test_another_quantity_is_not_suggested(write: Write, lines: str, message: str) -> None:
    key = lines.partition(":")[0]
    base = "\n".join(line for line in BASE.splitlines() if not line.startswith(f"{key}:"))
    with pytest.raises(StudyError) as caught:
        load_study(write(f"{base}\n{lines}\n"))
    assert message in str(caught.value)
    assert "did you mean" not in str(caught.value)


def test_contact_angle_is_answered_with_advice(write: Write) -> None:
    path = write(BASE.replace("nf308", "{element: ball, contact_angle: 15 deg}"))
    with pytest.raises(
        StudyError, match=r"bearing: unknown key `contact_angle` \(all models have contact angle 0"
    ):
        load_study(path)


def test_advice_precedes_similar_words() -> None:
    assert advice("imbalance", ["unbalance"]) == EXPLANATIONS["imbalance"]
    assert advice("unbalanc", ["unbalance"]) == "did you mean `unbalance`?"
    assert advice("quark", ["unbalance"]) == ""
