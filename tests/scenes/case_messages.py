"""Cases of an NF308, and the messages on invalid ones."""

from typing import Any

import pytest
from pydantic import ValidationError

from bearingsim.config import Case

SLOT = {"shape": "rectangular", "length": "3 mm", "width": "0.8 mm", "depth": "50 um"}
INNER, ON_ROLLER = SLOT | {"race": "inner"}, SLOT | {"race": "roller"}


def case(**fields: Any) -> Case:
    return Case.model_validate({"bearing": "nf308", "speed": "1800 rpm", "load": "150 N"} | fields)


def messages(**fields: Any) -> list[str]:
    with pytest.raises(ValidationError) as caught:
        case(**fields)
    return [error["msg"] for error in caught.value.errors()]
