"""Marks of an editor in study files: yaml-language-server with the schema of studies.

    python -m benchmarks.editor --csv docs/data/editor.csv

Each study lies beside the schema, as `bearingsim new` writes it. A typing error, a missing unit and a wrong swept
path must be marked in their line, and nothing in the template and the shipped studies. Without the server and npm,
which fetches it, nothing is tried.
"""

import argparse
import csv
import json
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from bearingsim.shipped import shipped_studies
from bearingsim.study import NEW_STUDY, SCHEMA_COMMENT, SCHEMA_FILE, schema_text

SERVER = "yaml-language-server"
VERSION = "1.25.0"
BASE = """\
study: edited
bearing: nf308
speed: 1800 rpm
load: 150 N
defect: {shape: rectangular, length: 12 mm, width: 0.8 mm, depth: 0.05 mm}
sweep:
  defect.width: [0.4 mm, 0.8 mm]
"""
MISTAKES = {
    "typing error in a key": ("speed:", "sped:"),
    "typing error in a section": ("depth: 0.05", "dept: 0.05"),
    "typing error in a word": ("rectangular", "rectangluar"),
    "missing unit": ("150 N", "150"),
    "wrong unit": ("1800 rpm", "1800 mm"),
    "missing unit in the sweep": ("0.4 mm", "0.4"),
    "wrong swept path": ("defect.width:", "defect.widht:"),
}
"""Changes of the base study, each of which an editor must mark in its line."""


class Mark(NamedTuple):
    """Mark in a file; line: counted from 1."""

    line: int
    message: str


class Editor:
    """Client of the language server."""

    def __init__(self, command: list[str], root: Path) -> None:
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        capabilities = {"workspace": {"configuration": True}}
        options = {"processId": None, "rootUri": root.as_uri(), "capabilities": capabilities}
        self._send("initialize", options, number=1)
        self._wait(lambda message: message.get("id") == 1)
        self._send("initialized", {})

    def marks(self, path: Path) -> list[Mark]:
        """Return the marks in a file."""
        uri = path.as_uri()
        document = {"uri": uri, "languageId": "yaml", "version": 1, "text": path.read_text(encoding="utf-8")}
        self._send("textDocument/didOpen", {"textDocument": document})
        message = self._wait(
            lambda message: (
                message.get("method") == "textDocument/publishDiagnostics" and message["params"]["uri"] == uri
            )
        )
        return [Mark(1 + d["range"]["start"]["line"], d["message"]) for d in message["params"]["diagnostics"]]

    def close(self) -> None:
        """End the server."""
        self.process.kill()
        self.process.wait()

    def _wait(self, is_answer: Any) -> Mapping[str, Any]:
        """Return the first answer; meanwhile answer requests for the configuration."""
        while not is_answer(message := self._receive()):
            if message.get("method") == "workspace/configuration":
                values = [
                    {"schemaStore": {"enable": False}, "validate": True} if item.get("section") == "yaml" else {}
                    for item in message["params"]["items"]
                ]
                self._write({"jsonrpc": "2.0", "id": message["id"], "result": values})
            elif "id" in message and "method" in message:
                self._write({"jsonrpc": "2.0", "id": message["id"], "result": None})
        return message

    def _send(self, method: str, params: Mapping[str, Any], number: int | None = None) -> None:
        head = {} if number is None else {"id": number}
        self._write({"jsonrpc": "2.0", **head, "method": method, "params": params})

    def _write(self, message: Mapping[str, Any]) -> None:
        body = json.dumps(message).encode()
        assert self.process.stdin is not None
        self.process.stdin.write(b"Content-Length: %d\r\n\r\n%s" % (len(body), body))
        self.process.stdin.flush()

    def _receive(self) -> Mapping[str, Any]:
        assert self.process.stdout is not None
        length = 0
        while line := self.process.stdout.readline().strip():
            name, _, value = line.decode().partition(":")
            length = int(value) if name.lower() == "content-length" else length
        if not length:
            raise EOFError("the language server has ended")
        message: Mapping[str, Any] = json.loads(self.process.stdout.read(length))
        return message


def server() -> list[str] | None:
    """Return the command of the server, or None without it and npm."""
    if shutil.which(SERVER):
        return [SERVER, "--stdio"]
    fetch = ["npm", "exec", "--yes", f"--package={SERVER}@{VERSION}", "--", SERVER, "--stdio"]
    return fetch if shutil.which("npm") and shutil.which("node") else None


def studies() -> Iterator[tuple[str, str, int]]:
    """Yield name, text and the line to be marked (0: none) of each study."""
    yield "template", NEW_STUDY, 0
    for name, path in shipped_studies().items():
        yield name, SCHEMA_COMMENT + path.read_text(encoding="utf-8"), 0
    for name, (right, wrong) in MISTAKES.items():
        text = SCHEMA_COMMENT + BASE.replace(right, wrong)
        yield name, text, next(i for i, line in enumerate(text.splitlines(), 1) if wrong in line)


def main() -> None:
    """Try all studies; exit code 1 if any is marked wrongly."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--csv", type=Path, required=True)
    arguments = parser.parse_args()
    command = server()
    if command is None:
        print(f"skipped: neither {SERVER} nor npm is on PATH")
        return
    rows = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name).resolve()
        (folder / SCHEMA_FILE).write_text(schema_text(), encoding="utf-8")
        editor = Editor(command, folder)
        try:
            for number, (study, text, line) in enumerate(studies()):
                path = folder / f"{number}.yaml"
                path.write_text(text, encoding="utf-8")
                marks = editor.marks(path)
                lines = {mark.line for mark in marks}
                is_right = line in lines if line else not lines
                texts = "; ".join(f"{mark.line}: {mark.message}" for mark in marks)
                rows.append((study, line or "", "yes" if is_right else "NO", texts))
                print(*rows[-1], sep=" | ")
        finally:
            editor.close()
    with arguments.csv.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file, lineterminator="\n").writerows(
            [("study", "wrong line", "marked there only if wrong", "marks"), *rows]
        )
    sys.exit(any(row[2] == "NO" for row in rows))


if __name__ == "__main__":
    main()
