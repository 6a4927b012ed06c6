"""README in the metadata of a built package: its text without links and pictures, which lie in the source only."""

import re
from pathlib import Path
from typing import Any

from hatchling.metadata.plugin.interface import MetadataHookInterface

PICTURE = re.compile(r"!\[[^]]*\]\([^)]*\)\n+(?:\*[^*]+\*\n+)?")  # with its caption
RELATIVE_LINK = re.compile(r"\[([^]]*)\]\((?![a-z]+:)[^)]*\)")
NOTE = "\nThe pages and pictures lie in `docs/` of the source distribution, `bearingsim-*.tar.gz`.\n"


def without_relative_links(text: str) -> str:
    """Remove pictures with their captions from a Markdown text, and the targets of links within the source."""
    return RELATIVE_LINK.sub(r"\1", PICTURE.sub("", text))


class ReadmeHook(MetadataHookInterface):
    """Hook of hatchling that sets the field `readme`."""

    def update(self, metadata: dict[str, Any]) -> None:
        """Set the field `readme`."""
        text = without_relative_links((Path(self.root) / "README.md").read_text(encoding="utf-8"))
        metadata["readme"] = {"content-type": "text/markdown", "text": text + NOTE}
